"""Sweeps of an input, and the studies that start from the results of others.

Truth: Wilson's interval and Spearman's correlation as scipy has them, the strain energy of a blade
on the full finite-element model.
"""

import re
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import yaml
from scipy import stats

from hpcrub import plot
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
from hpcrub.results.layout import DONE
from hpcrub.studies import cross, energy, files
from hpcrub.studies.files import open_result
from hpcrub.studies.problem import build_problem
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
    keys = TINY[: TINY.index("mistuning")] + f"mistuning: {{pattern_gpa: {[209.0, 211.0] * 6}}}\n"
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


def test_a_sweep_needs_a_file_name_too(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("output: '.'\nruns: [{casing.n_bumps: 3}]")
    with pytest.raises(InputError, match=r"output: '\.' is not a file name"):
        config.load_runs(path)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (
            "{time.scheme: central_difference, time.step_s: 1.0e-4, time.steps_per_bump_width: 1}",
            "the stability limit",
        ),
        ("{output: there.h5}", "there.h5 exists: --resume goes on with it"),
        ("{study: cross, sources: [nowhere.h5]}", "nowhere.h5 does not exist"),
        ("{mistuning.samples: 1.0e+12}", "not enough"),
    ],
)
def test_all_runs_of_a_sweep_are_checked_before_the_first(
    tmp_path, monkeypatch, capfd, second, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text(TINY + f"runs: [{{casing.n_bumps: 3}}, {second}]")
    files.lay_out("there.h5", config.Config.from_yaml(TINY))
    assert cli.main(["a.yaml"]) == 2
    assert message in capfd.readouterr().err
    assert not (tmp_path / "results").exists()


def test_a_run_of_a_sweep_may_start_from_the_one_before(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    second = "{study: cross, sources: [first.h5], output: second.h5}"
    (tmp_path / "a.yaml").write_text(TINY + f"runs: [{{output: first.h5}}, {second}]")
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    open_result("second.h5").close()


def test_cross(folder):
    file = compute(f"study: cross\nsources: [{HIGH}]", "cross")
    contact, linear = file.read("contact"), file.read("linear")
    for level in range(2):
        above = int((contact[level] > linear[level]).sum())
        assert file.read("share", level) == above / 6
        interval = stats.binomtest(above, 6).proportion_ci(method="wilson")
        assert file.read("share_interval", level) == pytest.approx(list(interval))
        rank = stats.spearmanr(contact[level], linear[level]).statistic
        assert file.read("rank_correlation", level) == pytest.approx(rank)
    assert (folder / "cross.png").exists()


def test_density_lies_where_the_samples_are():
    """Its mean and its moments about it, for skewed A_nl, are those of samples and kernel."""
    random = np.random.default_rng(2)
    linear = random.normal(1.2, 0.05, 300)
    contact = linear + random.exponential(0.1, 300)
    found = {name: values for name, _, values in cross._density(0, contact, linear)}
    x, y, weight = found["grid_contact"][:, None], found["grid_linear"], found["density"]
    weight = weight / weight.sum()
    mean = np.sum(weight * x), np.sum(weight * y)
    assert mean == pytest.approx([contact.mean(), linear.mean()], rel=1e-3)
    spread = [np.sum(weight * a * b) for a, b in ((x - mean[0], x - mean[0]),
              (x - mean[0], y - mean[1]), (y - mean[1], y - mean[1]))]  # fmt: skip
    wider = np.cov(contact, linear)[[0, 0, 1], [0, 1, 1]] * (1 + 300 ** (-2 / 6))  # by the kernel
    assert spread == pytest.approx(wider, rel=0.02)


def test_rank_interval_covers_as_often_as_it_says():
    random = np.random.default_rng(3)
    true = 6 / np.pi * np.arcsin(0.6 / 2)  # Spearman's correlation of normal pairs
    hits = 0
    for _ in range(400):
        x, y = random.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], 80).T
        low, high = cross.rank_interval(stats.spearmanr(x, y).statistic, 80)
        hits += low <= true <= high
    assert 0.91 < hits / 400 < 0.985


def test_damping(folder):
    file = compute(f"study: damping\nsources: [{HIGH}, low.h5]", "damping")
    np.testing.assert_array_equal(file.read("damping_ratio"), [0.005, 0.004])
    low = open_result("low.h5")
    values = low.read("samples/amplification", 1)
    expected, ends = np.percentile(values, 50), [values.min(), values.max()]
    low.close()
    assert file.read("contact/percentile", (1, 1, 1)) == pytest.approx(expected)
    # of six values, smallest and largest hold the median with 1 − 2·0.5⁶ = 96.9 %
    assert file.read("contact/interval", (1, 1, 1)).tolist() == ends
    assert (folder / "damping.png").exists()


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("casing: {n_bumps: 6}", "casing.n_bumps: 4 in the first, 6 in the second"),
        ("mistuning: {half_range_percent: [3, 4]}", "mistuning.half_range_percent: "),
        ("contact: {friction: 0.1}\ntime: {step_s: 3e-5}", "contact.friction: .*; time.step_s: "),
        ("forcing: {in_contact: true}", "differ in forcing.in_contact: false in the first"),
        ("material: {damping_ratios: [0.004]}", "other.h5 has material.damping_ratios"),
    ],
)
def test_dampings_are_compared_of_the_same_disks_only(folder, capfd, keys, message):
    data = yaml.safe_load(TINY) | {"study": "contact", "output": "other.h5"}
    for section, values in yaml.safe_load(keys).items():
        data[section] = data.get(section, {}) | values
    files.lay_out("other.h5", config.Config.model_validate(data))
    with h5py.File("other.h5", "r+") as file:
        file["samples/status"][...] = DONE
    (folder / "wrong.yaml").write_text(f"study: damping\nsources: [{HIGH}, other.h5]\n")
    assert cli.main(["wrong.yaml"]) == 2
    error = capfd.readouterr().err
    assert re.search(message, error)
    assert "sources: " in error
    assert not list(folder.glob("results/wrong*"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("study: cross", "0 result files given, cross needs 1"),
        ("study: cross\nsources: [nothing.h5]", "nothing.h5 does not exist"),
        ("study: cross\nsources: [input.yaml]", "is not an HDF5 file"),
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
        "disk.blade.thickness_mm=13.5",
        "material.damping_ratio=0.004",
        "reduction.n_modes=13",
        "casing.n_bumps=3",
        "contact.friction=0.1",
        "speeds.to_hz=34.2",
        "time.step_s=1e-05",
        "steady_state.max_time_s=0.6",
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
    u = np.einsum("nk,rks->rsn", problem.reduced.basis @ modes.shapes, q)
    disk = problem.disk
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


def test_figures_of_files_with_other_levels_and_percentiles(folder):
    """Twelve percentiles, more than there are markers; a colour is the same σ in every panel."""
    at = [float(p) for p in range(5, 65, 5)]
    text = TINY.replace("[2, 4], samples: 2", "[4], samples: 4")
    text = text.replace("step: 1", f"step: 2, percentiles: {at}")
    Path("wide.yaml").write_text(text)
    assert cli.main(["wide.yaml", "--output", "wide.h5", "--overwrite", "--no-figures"]) == 0
    files = [HIGH, "wide.h5"]
    panels = plot.running(files).reshape(2, 3)
    first, second = panels[:, 1]  # percentile 40 is the middle of all, and of the second only
    assert not first.axison
    wide, _ = second.get_lines()  # the line, and the estimates that are too few
    assert wide.get_color() == panels[0, 0].get_lines()[-2].get_color()  # ±4 %
    axes = plot.amplitudes(files[::-1])
    assert [len(line.get_xdata()) for line in axes.get_lines()[:1]] == [2]
    joined = [line.get_xdata() for line in axes.get_lines() if "σ" in str(line.get_label())]
    assert [len(x) for x in joined] == [1, 2]  # ±2 % is in one of the files only


def test_results_whose_names_hold_numbers_share_nothing(tmp_path):
    """r_0.25 and r_0.50, without .h5: the name does not end at its first point."""
    beside, sweeps = [], []
    for name in ("r_0.25", "r_0.50.h5"):
        cfg = config.Config.from_yaml(TINY + f"output: {tmp_path / name}")
        files.lay_out(cfg.output, cfg)
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
