"""Sweeps of an input, and the studies that start from the results of others.

Truth: the strain energy of a blade on the full finite-element model.
"""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hpcrub import plot, studies
from hpcrub.commands import run as cli
from hpcrub.config import parts
from hpcrub.config import schema as config
from hpcrub.contact import status
from hpcrub.errors import InputError
from hpcrub.model.reduction import mistuned_modes
from hpcrub.plot.pictures import draw
from hpcrub.ranks.runlog import RunLog, Work
from hpcrub.response import history
from hpcrub.response.sweep import Motion, run_sweep
from hpcrub.runs import result_files
from hpcrub.setup.problem import build_model, build_problem
from hpcrub.studies import energy, open_result
from tests.program import TINY, error_lines

RUNS = "runs: [{material.damping_ratio: 5e-3}, {material.damping_ratio: 4e-3, output: low.h5}]\n"


@pytest.fixture(scope="module")
def family(tmp_path_factory):
    """Folder with the results of a sweep over two dampings, 6 samples on two levels."""
    folder = tmp_path_factory.mktemp("family")
    text = TINY.replace("samples: 2", "samples: 6").replace("step: 1", "step: 2") + RUNS
    (folder / "input.yaml").write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert cli.main(["input.yaml"]) == 0
    return folder


@pytest.fixture
def folder(family, monkeypatch):
    monkeypatch.chdir(family)
    return family


def compute(text, name):
    Path(f"{name}.yaml").write_text(f"{text}\noutput: {name}.h5\n")
    assert cli.main([f"{name}.yaml", "--overwrite"]) == 0
    return open_result(f"{name}.h5")


PHYSICS = "\n".join(line for line in TINY.splitlines() if "mistuning" not in line)
HIGH = "results/input/damping_ratio=0.005.h5"


def test_a_sweep_is_one_file_each(folder):
    for name in ("family", "percentiles", "amplitudes", "running", "errors"):
        assert (folder / "results" / "input" / f"{name}.png").exists()
    a, b = open_result(HIGH), open_result("low.h5")
    assert config.differences(a.config, b.config) == [
        "material.damping_ratio: 0.005 in the file, 0.004 asked for"
    ]
    np.testing.assert_array_equal(a.read("samples/deviation"), b.read("samples/deviation"))
    a.close()
    b.close()


def test_a_family_of_one_pattern_has_no_statistics(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    keys = (
        TINY[: TINY.index("mistuning")]
        + f"mistuning: {{pattern_unit: gpa, pattern: {[209.0, 211.0] * 6}}}\n"
    )
    Path("pattern.yaml").write_text(keys + RUNS)
    assert cli.main(["pattern.yaml"]) == 0
    pictures = sorted(p.name for p in Path("results/pattern").glob("*.png"))
    assert pictures == ["damping_ratio=0.005.png", "family.png"]


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ("4", "runs: 4 is not a list of 1 to 1000 runs"),
        ("[]", "is not a list of 1 to"),
        ("[3]", "runs: 3 does not replace keys"),
        ("[{casing.n_bump: 3}]", "casing.n_bump: unknown key; did you mean casing.n_bumps?"),
        ("[{study.x: 3}]", "study.x: study is not a section"),
        ("[{casing.n_bumps: 3}, {casing: {n_bumps: 3}}]", "two runs have the output"),
    ],
)
def test_wrong_sweeps(tmp_path, sweep, message):
    path = tmp_path / "input.yaml"
    path.write_text(f"study: contact\nruns: {sweep}\n")
    with pytest.raises(InputError) as caught:
        config.load_runs(path)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (
            "{time.scheme: central_difference, time.step_s: 2.0e-4, time.steps_per_bump_width: 1}",
            "the stability limit",
        ),
        ("{output: there.h5}", "there.h5 exists: --resume goes on with it"),
        ("{study: energy, sources: [nowhere.h5]}", "nowhere.h5 does not exist"),
        ("{mistuning.samples: 1.0e+12}", "not enough"),
    ],
)
def test_all_runs_of_a_sweep_are_checked_before_the_first(
    tmp_path, monkeypatch, capfd, second, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text(TINY + f"runs: [{{casing.n_bumps: 3}}, {second}]")
    result_files.lay_out("there.h5", studies.run_of(config.Config.from_yaml(TINY)))
    assert cli.main(["a.yaml"]) == 2
    assert message in capfd.readouterr().err
    assert not (tmp_path / "results").exists()


def test_a_run_of_a_sweep_may_start_from_the_one_before(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    second = "{study: energy, sources: [first.h5], energy.samples: 1, output: second.h5}"
    (tmp_path / "a.yaml").write_text(TINY + f"runs: [{{output: first.h5}}, {second}]")
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    open_result("second.h5").close()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("study: energy", "0 result files given, energy needs 1"),
        ("study: energy\nsources: [nothing.h5]", "nothing.h5 does not exist"),
        ("study: energy\nsources: [input.yaml]", "is not an HDF5 file"),
        (f"study: energy\nsources: [{HIGH}]", "reduction.n_modes: 12 in the file, 60 asked for; "),
        (
            f"study: energy\nsources: [{HIGH}]\nenergy: {{samples: 13}}\n{PHYSICS}",
            "more than the 12 finished",
        ),
    ],
)
def test_sources_are_checked(folder, capfd, text, message):
    (folder / "wrong.yaml").write_text(text)
    assert cli.main(["wrong.yaml"]) == 2
    assert message in capfd.readouterr().err


@pytest.mark.parametrize(
    "change",
    [
        "material.damping_ratio=0.004",
        "casing.n_bumps=3",
        "speeds.to_hz=34.2",
        "time.step_s=1e-05",
    ],
)
def test_a_source_of_other_physics_is_refused(folder, capfd, change):
    (folder / "other.yaml").write_text(f"study: energy\nsources: [{HIGH}]\n{PHYSICS}")
    assert cli.main(["other.yaml", "--set", change]) == 2
    key, value = change.split("=")
    (line,) = error_lines(capfd.readouterr().err)
    assert f"{key}: " in line
    assert f" in the file, {value} asked for" in line


def test_energy(folder):
    file = compute(f"study: energy\nsources: [{HIGH}]\nenergy: {{samples: 3}}\n{PHYSICS}", "energy")
    source = open_result(HIGH)
    values = np.sort(source.read("samples/amplification"), axis=None)[::-1]
    source.close()
    np.testing.assert_array_equal(file.read("amplification"), values[:3])
    assert (file.read("point_status") > 0).all()
    deviations = file.read("deviation")
    assert (deviations[1] != deviations[2]).all()
    for sample in (1, 2):
        expected = largest_energies(file.config, deviations[sample])
        np.testing.assert_allclose(file.read("energy_j", sample), expected, rtol=1e-9)
    expected = largest_energies(file.config, np.zeros(12))
    np.testing.assert_allclose(file.read("tuned/energy_j"), expected, rtol=1e-9)
    assert (folder / "energy.png").exists()
    file.close()

    file = open_result("energy.h5", mode="r+")
    before = energy.amplification(file)
    file.write({"energy_j": np.nan, "point_reason": status.TOO_LARGE}, 1)
    np.testing.assert_array_equal(energy.amplification(file), [before[0], np.nan, before[2]])
    assert next(energy.report(file)).startswith("3 of 12 points: diverged")
    plot.energy("energy.h5")
    file.write({"tuned/energy_j": np.nan}, ())
    assert list(energy.report(file))[-1].startswith("by strain energy: not known")
    plot.energy("energy.h5")
    file.close()


def largest_energies(config, deviation):
    """Energies [J] on the full model, over the window after the steady state, (speeds, blades)."""
    problem, speeds = build_problem(config), config.speeds.values_hz
    modes = mistuned_modes(problem.reduced, deviation)
    motion = Motion.at_rest(len(speeds), len(modes.omega))
    run_sweep(modes, problem.scene, speeds, motion=motion)
    pieces = history.integrate(modes, problem.scene, speeds, 3 / speeds.max(), motion)
    q = np.concatenate([piece.position for piece in pieces])
    disk, reduced = build_model(config)
    u = np.einsum("nk,rks->rsn", reduced.basis @ modes.shapes, q)
    blades = zip(deviation, disk.blade_dof, disk.blade_stiffness, strict=True)
    found = [(1 + d) / 2 * np.einsum("rsi,ij,rsj->rs", u[:, :, n], k, u[:, :, n])
             for d, n, k in blades]  # fmt: skip
    return np.max(found, axis=1).T


def test_amplification_of_the_energy_is_largest_over_largest():
    values = {
        "tuned/energy_j": np.array([[1.0, 4.0], [np.nan, 3.0]]),
        "energy_j": np.array([[[2.0, 5.0], [6.0, 1.0]], [[0.5, np.nan], [1.0, 0.2]]]),
    }
    found = energy.amplification(SimpleNamespace(read=values.get))
    np.testing.assert_array_equal(found, [6.0 / 4.0, 1.0 / 4.0])


def test_results_whose_names_hold_numbers_share_nothing(tmp_path):
    """r_0.25 and r_0.50, without .h5: the name does not end at its first point."""
    beside, sweeps = [], []
    for name in ("r_0.25", "r_0.50.h5"):
        cfg = config.Config.from_yaml(TINY + f"output: {tmp_path / name}")
        result_files.lay_out(cfg.output, studies.run_of(cfg))
        RunLog(cfg.output, 1).end(Work(), 0)
        part = parts.cut(cfg, 1, 2).output
        (tmp_path / "a.yaml").write_text(f"output: {name}\nruns: [{{casing.n_bumps: 3}}]")
        sweeps += [run.output for run in config.load_runs(tmp_path / "a.yaml")]
        (picture,) = draw(plot.summary, [cfg.output])
        beside.append({Path(part), picture})
    assert beside[0] == {tmp_path / f"r_0.25{end}" for end in (".part-1-of-2.h5", ".png")}
    assert beside[1] == {tmp_path / f"r_0.50{end}" for end in (".part-1-of-2.h5", ".png")}
    assert sweeps == ["r_0.25/n_bumps=3.h5", "r_0.50/n_bumps=3.h5"]
    assert (tmp_path / "r_0.25.runs.jsonl").exists()
