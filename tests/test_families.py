"""Sweeps of an input, and the studies that start from the results of others.

Truth: Wilson's interval and Spearman's correlation as scipy has them, the strain energy of a blade
on the full finite-element model, and branches that were made by hand.
"""

from pathlib import Path

import numpy as np
import pytest
from conftest import TINY
from scipy import stats

from hpcrub import cli, config, parts, plot, storage
from hpcrub.errors import InputError
from hpcrub.layout import NOT_STEADY, STEADY
from hpcrub.reduction import mistuned_modes
from hpcrub.runlog import RunLog, Work
from hpcrub.storage import ResultFile
from hpcrub.studies import branches, cross, energy
from hpcrub.study import build_problem
from hpcrub.sweep import Motion, run_sweep

SWEEP = "sweep: [{material.damping_ratio: 5e-3}, {material.damping_ratio: 4e-3, output: low.h5}]\n"


@pytest.fixture(scope="module")
def family(tmp_path_factory):
    """Folder with the results of a sweep over two dampings, 6 samples on two levels."""
    folder = tmp_path_factory.mktemp("family")
    text = TINY.replace("samples: 2", "samples: 6").replace("step: 1", "step: 2") + SWEEP
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
    return ResultFile.open(f"{name}.h5")


HIGH = "results/input/damping_ratio=0.005.h5"


def test_a_sweep_is_one_file_each(folder):
    for name in ("family", "percentiles", "amplitudes", "running", "errors"):
        assert (folder / "results" / "input" / f"{name}.png").stat().st_size > 10_000
    a, b = ResultFile.open(HIGH), ResultFile.open("low.h5")
    assert config.differences(a.config, b.config) == [
        "material.damping_ratio: 0.005 in the file, 0.004 asked for"
    ]
    np.testing.assert_array_equal(a.read("samples/deviation"), b.read("samples/deviation"))
    a.close()
    b.close()
    (picture,) = plot.draw([HIGH, "low.h5"], "percentiles", "elsewhere", "pdf")
    assert picture.name == "percentiles.pdf"
    with pytest.raises(InputError, match="for the study linear"):
        plot.draw(["low.h5"], "linear")


def test_a_family_of_one_pattern_has_no_statistics(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    keys = TINY[: TINY.index("mistuning")] + f"mistuning: {{pattern_gpa: {[209.0, 211.0] * 6}}}\n"
    Path("pattern.yaml").write_text(keys + SWEEP)
    assert cli.main(["pattern.yaml"]) == 0
    pictures = sorted(p.name for p in Path("results/pattern").glob("*.png"))
    assert pictures == ["damping_ratio=0.005.png", "family.png"]


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ("4", "sweep: 4 is not a list of 1 to 1000 runs"),
        ("[]", "is not a list of 1 to"),
        ("[3]", "sweep: 3 does not replace keys"),
        ("[{casing.n_bump: 3}]", "casing.n_bump: unknown key; did you mean casing.n_bumps?"),
        ("[{study.x: 3}]", "study.x: study is not a section"),
        ("[{casing.n_bumps: 3}, {casing: {n_bumps: 3}}]", "two runs have the output"),
    ],
)
def test_wrong_sweeps(tmp_path, sweep, message):
    path = tmp_path / "input.yaml"
    path.write_text(f"study: contact\nsweep: {sweep}\n")
    with pytest.raises(InputError) as caught:
        config.load_runs(path)
    assert message in str(caught.value)


def test_a_sweep_needs_a_file_name_too(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("output: '.'\nsweep: [{casing.n_bumps: 3}]")
    with pytest.raises(InputError, match=r"output: '\.' is not a file name"):
        config.load_runs(path)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        ("{time.scheme: central_difference, time.step_s: 1.0e-4}", "the stability limit"),
        ("{output: there.h5}", "there.h5 exists: --resume goes on with it"),
        ("{study: cross, sources: [nowhere.h5]}", "nowhere.h5 does not exist"),
        ("{mistuning.samples: 1.0e+12}", "not enough"),
    ],
)
def test_all_runs_of_a_sweep_are_checked_before_the_first(
    tmp_path, monkeypatch, capfd, second, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text(TINY + f"sweep: [{{casing.n_bumps: 3}}, {second}]")
    storage.lay_out("there.h5", config.Config.from_yaml(TINY))
    assert cli.main(["a.yaml"]) == 2
    assert message in capfd.readouterr().err
    assert not (tmp_path / "results").exists()


def test_a_run_of_a_sweep_may_start_from_the_one_before(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    second = "{study: cross, sources: [first.h5], output: second.h5}"
    (tmp_path / "a.yaml").write_text(TINY + f"sweep: [{{output: first.h5}}, {second}]")
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    ResultFile.open("second.h5").close()


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
    assert (folder / "cross.png").stat().st_size > 10_000


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
    low = ResultFile.open("low.h5")
    expected = np.percentile(low.read("samples/amplification", 1), 50)
    low.close()
    assert file.read("contact/percentile", (1, 1, 1)) == pytest.approx(expected)
    assert (folder / "damping.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("study: cross", "0 result files given, cross needs 1"),
        ("study: cross\nsources: [nothing.h5]", "nothing.h5 does not exist"),
        ("study: cross\nsources: [input.yaml]", "is not an HDF5 file"),
        (f"study: energy\nsources: [{HIGH}]", "in the file"),
    ],
)
def test_sources_are_checked(folder, capfd, text, message):
    (folder / "wrong.yaml").write_text(text)
    assert cli.main(["wrong.yaml"]) == 2
    assert message in capfd.readouterr().err


def test_energy(folder):
    physics = "\n".join(line for line in TINY.splitlines() if "mistuning" not in line)
    file = compute(f"study: energy\nsources: [{HIGH}]\nenergy: {{samples: 3}}\n{physics}", "energy")
    source = ResultFile.open(HIGH)
    values = np.sort(source.read("samples/amplification"), axis=None)[::-1]
    source.close()
    np.testing.assert_array_equal(file.read("amplification"), values[:3])
    assert (file.read("energy_j") > 0.0).all()
    assert (folder / "energy.png").stat().st_size > 10_000


def test_strain_energy_is_that_of_the_full_model():
    problem = build_problem(config.Config.from_yaml(TINY))
    deviation = np.linspace(-0.03, 0.03, 12)
    modes = mistuned_modes(problem.reduced, deviation)
    q = np.random.default_rng(0).standard_normal((1, len(modes.omega), 1))
    u = problem.reduced.basis @ modes.shapes @ q[0, :, 0]
    disk = problem.disk
    expected = [
        0.5 * (1 + d) * u[dof] @ k @ u[dof]
        for d, dof, k in zip(deviation, disk.blade_dof, disk.blade_stiffness, strict=True)
    ]
    stiffness = (1 + deviation)[:, None, None] * problem.reduced.blade_stiffness
    modal = modes.shapes.T @ stiffness @ modes.shapes
    assert energy.strain_energy(modal, q)[0, 0] == pytest.approx(expected)


def test_branches_made_by_hand():
    speeds = np.arange(10)
    amplitude = np.array([1.0 + 0.01 * speeds, 1.5 + 0.01 * speeds, 1.0 + 0.01 * speeds])
    local = np.array([np.full(10, 0.2), np.full(10, 0.3), np.full(10, 0.2)])
    status = np.full((3, 10), STEADY)
    amplitude[1, 6:] = amplitude[0, 6:]  # the second start falls to the first branch
    local[1, 6:] = 0.2
    status[2, 0] = NOT_STEADY
    none = np.zeros((3, 10))
    found = branches.label((amplitude, none), (local, none), status)
    np.testing.assert_array_equal(found[0], 0)
    np.testing.assert_array_equal(found[1], [1] * 6 + [0] * 4)
    assert found[2, 0] == -1
    np.testing.assert_array_equal(branches.coexisting(found), [2] * 6 + [1] * 4)
    scatter = np.full((3, 10), 0.5)  # of the windows: now the two may be one
    found = branches.label((amplitude, scatter), (local, scatter), status)
    assert found.max() == 0


def test_branches(folder):
    file = compute(f"study: branches\nbranches: {{perturbed: 1}}\n{TINY}", "branches")
    amplitude = file.read("amplitude_m")
    assert amplitude.shape == (4, 3)
    assert np.isfinite(amplitude).all()
    problem = build_problem(file.config)
    modes = mistuned_modes(problem.reduced, np.zeros(12))
    rest = run_sweep(modes, problem.scene, file.config.speeds.values_hz)
    np.testing.assert_array_equal(amplitude[0], rest.amplitude)
    assert amplitude[1, 0] == rest.amplitude[0]  # both chains begin at rest
    assert amplitude[2, -1] == rest.amplitude[-1]
    mean, scatter = file.read("mean_amplitude_m"), file.read("amplitude_scatter_m")
    assert np.abs(mean - amplitude).max() < 0.2 * amplitude.max()
    assert (scatter < 0.2 * mean).all()
    start = branches.deflection(modes, 1, 0.02)
    assert np.abs(modes.tangential @ start).max() == pytest.approx(0.02)
    assert (folder / "branches.png").stat().st_size > 10_000


def test_a_continued_steady_motion_stays(folder):
    cfg = config.Config.from_yaml(TINY.replace("max_time_s: 0.5", "max_time_s: 3.0"))
    problem = build_problem(cfg)
    modes = mistuned_modes(problem.reduced, np.zeros(12))
    motion = Motion.at_rest(1, len(modes.omega))
    first = run_sweep(modes, problem.scene, [33.3], motion=motion)
    second = run_sweep(modes, problem.scene, [33.3], motion=motion)
    assert first.point_status == second.point_status == STEADY
    assert second.amplitude == pytest.approx(first.amplitude, rel=0.01)


def test_results_whose_names_hold_numbers_share_nothing(tmp_path):
    """r_0.25 and r_0.50, without .h5: the name does not end at its first point."""
    beside, sweeps = [], []
    for name in ("r_0.25", "r_0.50.h5"):
        cfg = config.Config.from_yaml(TINY + f"output: {tmp_path / name}")
        storage.lay_out(cfg.output, cfg)
        log = RunLog(cfg.output, 1)
        log.end(Work(), 0)
        part = parts.cut(cfg, 1, 2).output
        (tmp_path / "a.yaml").write_text(f"output: {name}\nsweep: [{{casing.n_bumps: 3}}]")
        sweeps += [run.output for run in config.load_runs(tmp_path / "a.yaml")]
        file = ResultFile.open(cfg.output)
        beside.append({log.path, Path(part), plot._target([file], "summary", None, "png")})
        file.close()
    assert beside[0] == {tmp_path / f"r_0.25{end}" for end in (".log", ".part-1-of-2.h5", ".png")}
    assert beside[1] == {tmp_path / f"r_0.50{end}" for end in (".log", ".part-1-of-2.h5", ".png")}
    assert sweeps == ["r_0.25/n_bumps=3.h5", "r_0.50/n_bumps=3.h5"]
    assert (tmp_path / "r_0.25.runs.jsonl").exists()
