"""Studies other than contact, each on a tiny case: what they compute, store and draw.

Truth: closed forms of a tuned disk; of branches, which are motions from several initial states: the
sweep from rest, sweeps from speed to speed, whole histories that go on (how motions are told apart
is in test_coexistence.py).
"""

from pathlib import Path

import numpy as np
import pytest

from hpcrub.commands import run as cli
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response import history
from hpcrub.response.steady import localisation
from hpcrub.response.sweep import Motion, run_sweep
from hpcrub.setup.problem import build_problem
from hpcrub.studies import STUDIES, branches, open_result, time_response
from tests.program import ROOT, TINY, swept, whole


def compute(name, *overrides, options=()):
    """Run inputs/NAME.yaml with overrides in the current folder; returns its open ResultFile."""
    arguments = [str(ROOT / "inputs" / f"{name}.yaml"), "--output", f"{name}.h5", *options]
    for override in overrides:
        arguments += ["--set", override]
    assert cli.main(arguments) == 0
    return open_result(f"{name}.h5")


@pytest.fixture(scope="module")
def modal(tmp_path_factory):
    """Open result file of the modal study."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("modal"))
        with compute("modal", options=["--no-figures"]) as file:
            yield file


@pytest.mark.parametrize("kind", ["full", "reduced"])
def test_modes_of_the_tuned_disk_come_in_pairs(modal, kind):
    """Cyclic: 0 and N/2 diameters once, all others twice, with equal frequencies."""
    family = modal.read(f"{kind}/frequencies_hz")[:12]
    diameters = modal.read(f"{kind}/nodal_diameters")[:12]
    assert sorted(diameters) == [0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6]
    for d in range(1, 6):
        pair = family[diameters == d]
        assert pair[0] == pytest.approx(pair[1], rel=1e-9)
    assert (family.min(), family.max()) == pytest.approx((90.1, 93.2), abs=0.05)  # the paper


def test_resonances_are_as_wide_as_the_damping_of_their_modes(folder):
    """Twice the damping ratio: 10 % at 5 %, however the ratio is given."""
    for key in ("damping_ratio=0.05", "damping_ratios=[0.05]"):
        options = "--no-figures", "--overwrite"
        with compute("modal", f"material.{key}", options=options) as file:
            (line,) = [line for line in STUDIES["modal"].report(file) if "wide" in line]
        assert "resonances are 10 % wide" in line


QUICK = "reduction.n_modes=12", "time.step_s=2e-5", "mistuning.checked_samples=0"


@pytest.fixture(scope="module")
def response(tmp_path_factory):
    """Open result file of a time response: the tuned disk and a pattern."""
    pattern = "mistuning.pattern_unit=gpa", f"mistuning.pattern={[205, 215] * 6}"
    speed = "speeds.from_hz=33.2", "speeds.to_hz=33.2"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("response"))
        with compute("time_response", *QUICK, *speed, *pattern, "history.duration_s=0.9") as file:
            assert Path("time_response.png").exists()
            yield file


def test_a_time_response_moves_and_stays_outside_the_casing(response):
    assert len(response.read("deviation")) == 2
    assert np.abs(response.read("tangential_m")).max() > 1e-3
    assert response.read("gap_m").min() > -1e-6
    assert not response.read("point_reason").any()


@pytest.mark.parametrize("disk", [0, 1])
def test_the_checks_of_a_time_response_are_those_of_its_motion(response, disk):
    """Tip, change of amplitude and correlation of two windows, from the motion that is stored."""
    time, window, checks = (response.read(name) for name in ("time_s", "window_s", "check_s"))
    assert window == pytest.approx(3 / response.config.speeds.from_hz)
    u = response.read("tangential_m", disk)
    for check, end in enumerate(checks):
        place = (end - time) / window + 1e-9  # how many windows before the check
        before, last = u[(place > 1) & (place < 2)], u[(place > 0) & (place < 1)]
        tip = np.abs(last).max(axis=0).argmax()
        size_before, size = (np.abs(part[:, tip]).max() for part in (before, last))
        change = abs(size - size_before) / size
        assert response.read("tip", (disk, check)) == tip
        assert response.read("amplitude_change", (disk, check)) == pytest.approx(change)
        correlation = np.corrcoef(before[:, tip], last[:, tip])[0, 1]
        assert response.read("correlation", (disk, check)) == pytest.approx(correlation)


@pytest.mark.parametrize("disk", [0, 1])
def test_a_time_response_is_steady_when_its_sweep_is(response, disk):
    """By the same rule, at the same check, with the same amplitude but for what records miss."""
    config = response.config
    sweep = swept(config, response.read("deviation", disk), [config.speeds.from_hz])
    assert sweep.point_status[0] == response.read("point_status")[disk] == STEADY
    assert response.read("judged_s", disk) == pytest.approx(sweep.time[0])
    assert response.read("amplitude_m", disk) == pytest.approx(sweep.amplitude[0], rel=2e-3)
    found = time_response.first_known(response, disk)
    assert response.read("check_s")[found] == pytest.approx(sweep.time[0])


def test_interaction_map(folder):
    """Nine speeds: the tasks are a group of eight and one alone."""
    speeds = "speeds.from_hz=29", "speeds.to_hz=31", "speeds.step_hz=0.25"
    spans = "history.duration_s=0.4", "spectrum.window_s=0.2", "spectrum.max_frequency_hz=150"
    file = compute("interaction_map", *QUICK, *speeds, *spans)
    spectrum, frequencies = file.read("spectrum_m"), file.read("frequencies_hz")
    assert np.isfinite(spectrum).all()
    speeds = file.read("speeds_hz")
    # the tuned disk moves with the passing of the bumps, 4 per revolution
    for s, speed in enumerate(speeds):
        assert frequencies[spectrum[0, s].argmax()] == pytest.approx(4 * speed, abs=3)
    problem = build_problem(file.config)
    for disk, deviation in enumerate(file.read("deviation")):
        modes = mistuned_modes(problem.reduced, deviation)
        for group in (slice(0, 8), slice(8, 9)):
            time, q = whole(modes, problem.scene, speeds[group], 0.4, "time", "position")
            tips = np.abs(np.einsum("ck,rks->rsc", modes.tangential, q)).max(axis=2)
            for lane, speed in enumerate(speeds[group]):  # a history ends where it would alone
                end = history.n_records(speed, 0.4, problem.scene)
                tips[end:, lane] = 0.0
                tips[time[:, lane] < time[end - 1, lane] - 0.2, lane] = 0.0
            np.testing.assert_allclose(file.read("amplitude_m", disk)[group], tips.max(axis=0))
    assert file.read("natural_frequencies_hz")[0, 0] == pytest.approx(90.1, abs=0.1)
    assert (folder / "interaction_map.png").exists()


@pytest.mark.parametrize(
    ("failing", "words"),
    [
        (("disk.blade.lean_deg=55", "disk.blade.bow=-0.05", "contact.friction=1.5"), "jamming"),
        pytest.param(
            ("disk.spoke_thickness_mm=0.1", "contact.friction=0.5"),
            "displacements",
            marks=pytest.mark.long,
        ),
    ],
)
def test_a_history_without_a_result_says_so(folder, capfd, failing, words):
    spans = "history.duration_s=0.6", "spectrum.window_s=0.2"
    file, words = compute("time_response", *QUICK, *failing, *spans), f"diverged: {words}"
    out = capfd.readouterr().out
    assert f"tuned disk: {words}" in out
    assert "steady at" not in out
    assert "largest |u_t|" not in out
    assert file.read("point_status").tolist() == [DIVERGED]
    assert status.words(file.read("point_reason", 0)).startswith(words)
    assert np.isfinite(file.read("time_s")).all()
    for name in ("radial_m", "tangential_m", "gap_m", "force_n", "correlation"):
        assert np.isnan(file.read(name)).all()
    assert (folder / "time_response.png").exists()

    speeds = "speeds.from_hz=29", "speeds.to_hz=31", "speeds.step_hz=1"
    file = compute("interaction_map", *QUICK, *failing, *spans, *speeds)
    out = capfd.readouterr().out
    assert f"pattern: 3 of 3 points: {words}" in out
    assert " mm" not in out
    assert status.are_fatal(file.read("point_reason")).all()
    assert np.isnan(file.read("spectrum_m")).all()
    assert np.isnan(file.read("amplitude_m")).all()
    assert (folder / "interaction_map.png").exists()


def test_branches(folder, monkeypatch):
    monkeypatch.setattr(branches, "N_WINDOWS", 12)  # 60 take longer
    text = f"study: branches\nbranches: {{perturbed: 1}}\noutput: branches.h5\n{TINY}"
    Path("branches.yaml").write_text(text)
    assert cli.main(["branches.yaml"]) == 0
    file = open_result("branches.h5")
    amplitude = file.read("amplitude_m")
    assert amplitude.shape == (4, 3)
    assert np.isfinite(amplitude).all()
    problem = build_problem(file.config)
    modes = mistuned_modes(problem.reduced, file.read("deviation"))
    rest = run_sweep(modes, problem.scene, file.config.speeds.values_hz)
    np.testing.assert_array_equal(amplitude[0], rest.amplitude)
    for chain, order in ((1, [0, 1, 2]), (2, [2, 1, 0])):  # upwards and downwards, from rest
        motion = Motion.at_rest(1, len(modes.omega))
        for s in order:
            speed = file.config.speeds.values_hz[s : s + 1]
            found = run_sweep(modes, problem.scene, speed, motion=motion)
            assert amplitude[chain, s] == found.amplitude[0]
    windows, local = file.read("window_amplitude_m"), file.read("window_localisation")
    mean = windows.mean(axis=-1)
    assert windows.shape == local.shape == (4, 3, 12)
    assert np.abs(mean - amplitude).max() < 0.2 * amplitude.max()
    assert (windows.std(axis=-1) < 0.2 * mean).all()
    found = branches.label_file(file)
    np.testing.assert_array_equal(found >= 0, file.read("point_status") == STEADY)
    motion = Motion.at_rest(3, len(modes.omega))
    speeds = file.config.speeds.values_hz
    run_sweep(modes, problem.scene, speeds, motion=motion)
    largest = np.zeros((12, 3, 12))  # windows of three revolutions, speeds, tips
    for window in largest:
        for piece in history.integrate(modes, problem.scene, speeds, 3 / speeds.max(), motion):
            tips = np.abs(np.einsum("ck,rks->rsc", modes.tangential, piece.position))
            np.maximum(window, tips.max(axis=0), out=window)
    np.testing.assert_allclose(motion.time, rest.time + 12 * 3 / speeds)
    np.testing.assert_allclose(windows[0].T, largest.max(axis=2), rtol=1e-9)
    np.testing.assert_allclose(local[0].T, localisation(largest), rtol=1e-9)
    start = branches.deflection(modes, 12, 1, 3, 0.02)
    assert np.abs(modes.tangential @ start).max() == pytest.approx(0.02)
    assert Path("branches.png").exists()


def test_initial_states_share_no_random_number():
    """Neither with one another, of whatever seed and number, nor with the deviations of blades."""
    tips = np.eye(12)
    modes = Modes.planar(np.ones(12), tips, tips)
    places = [(seed, task) for seed in range(6) for task in range(6)]
    drawn = [branches.deflection(modes, 12, *place, 0.02) for place in places]
    assert np.abs(drawn).max(axis=1) == pytest.approx(0.02)
    drawn += [stiffness_deviation(seed, 0, sample, 12, 1.0) for seed, sample in places]
    drawn += [stiffness_deviation(seed, 1 + level, 0, 12, 1.0) for seed, level in places]
    shapes = np.divide(drawn, np.array(drawn)[:, :1])[:, 1:]  # whatever their sizes
    assert len(np.unique(shapes)) == shapes.size
