"""Numbers that mean something: bumps and blades are resolved, or the study is refused or marked.

Truth: a time step many times finer; counts of steps by hand; the limits of the input themselves.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from hpcrub import studies
from hpcrub.commands import run as cli
from hpcrub.config import resolution
from hpcrub.config.schema import Config, load_runs
from hpcrub.model.casing import noise_left, smoothed
from hpcrub.model.reduction import mistuned_modes
from hpcrub.runs.findings import not_resolved, not_settled
from hpcrub.setup import input_files, plausibility
from hpcrub.setup.problem import build_problem
from hpcrub.studies import open_result
from tests.program import ROOT, TINY, swept


def told(config, word=""):
    """Warnings of a configuration that hold a word."""
    lines = studies.run_of(config).study.warnings(config, build_problem(config))
    return [line for line in lines if word in line]


@pytest.mark.parametrize("path", sorted((ROOT / "inputs").glob("*.yaml")), ids=lambda p: p.stem)
def test_inputs_that_come_along_keep_their_step_and_are_resolved(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    for config in map(input_files.with_tables, load_runs(path)):
        assert config.step == config.time.step_s
        few = path.stem == "reduction" and config.reduction.n_modes < 3 * config.disk.n_blades
        study = studies.run_of(config).study
        if study.integrates and not few:  # which shows what few modes do
            found = study.warnings(config, build_problem(config))
            # which thin rings of inputs/ring*.yaml show; what the paper's rule leaves out, and a
            # run-up, too
            true = "overtaken waves: ", "not resolved: transients decay with a time constant"
            true = *true, "gain of speed: "
            if config.aero.exists or config.casing.vibrates:  # a wave with little damping
                true = *true, "not steady: transients decay within"
            assert [line for line in found if not line.startswith(true)] == []


def test_overtaken_waves_that_are_not_followed_are_named():
    first, more = told(Config(casing={"ring": {"thickness_mm": 2}}), "overtaken waves")
    assert "(n = 2 to 8)" in first
    assert "the waves n = 9 to 18, which are not followed (casing.ring.waves)" in more
    (only,) = told(Config(casing={"ring": {"thickness_mm": 20, "waves": [3, 4]}}), "overtaken")
    assert "the waves n = 2, which are not followed" in only


SINGLE = {"study": "time_response", "speeds.from_hz": 34, "speeds.to_hz": 34}
RING = {"casing.ring.thickness_mm": 20.0}
MARKED = [
    # 2,000 rpm as Hz: tips at 2π·2000·0.5 = 6,283 m/s; a clearance in micrometres
    ({"speeds.from_hz": 2000.0, "speeds.to_hz": 2000.0}, "tips run at 6,283 m/s, faster"),
    ({"casing.clearance_mm": 250.0}, "the clearance is 50 % of the tips' radius"),
    ({"casing.ring.thickness_mm": 2000.0}, "ring.thickness_mm is 2000, where casings around"),
    (RING | {"casing.ring.width_mm": 0.1}, "have 5 to 1,000"),
    # of 1 µs, amplitudes doubled with every halving of the step: 17, 20, 40, 81 mm
    ({"casing.growth_time_s": 1e-6}, "not resolved: the casing grows within"),
    ({"reduction.n_modes": 12, "casing.n_bumps": 3}, "is 12, fewer than 2 for each blade, 24"),
    # four bumps pass at 142 Hz, the first family vibrates below 94 Hz
    ({"reduction.n_modes": 24}, "fewer than 3 for each blade, 36"),
    (SINGLE | {"history.duration_s": 0.4}, "s, history.duration_s is 0.4; motions that do not"),
]
UNMARKED = [
    {},
    SINGLE | {"steady_state.max_time_s": 0.5},  # without effect there
    {"reduction.n_modes": 13, "casing.n_bumps": 3},  # of which whole families are kept: 24
    {"reduction.n_modes": 36},
    # all there are
    {"reduction.n_modes": 18, "disk.n_blades": 3, "disk.blade.n_elements": 1},
]


@pytest.mark.parametrize(("keys", "words"), [*MARKED, *((keys, "") for keys in UNMARKED)])
def test_what_is_mistaken_or_not_resolved_is_told(keys, words):
    lines = [line for line in told(Config().replace(keys)) if not line.startswith("overtaken")]
    assert [words in line for line in lines].count(True) == bool(words)
    assert words or lines == []


@pytest.mark.parametrize(("order", "slope"), [(7, None), (8, "0.032")])
def test_a_casing_whose_slope_matters_beside_friction_is_marked(order, slope):
    """b = A cos nθ, A = 2 mm, has the slope nA/R on the radius of 500 mm."""
    wave = {"casing.harmonics": [{"order": order, "amplitude_mm": 2.0}], "forcing.engine_order": 8}
    found = told(Config().replace(wave), "steep casing")
    assert len(found) == len(list(not_resolved(found))) == bool(slope)  # the verdict says it, too
    assert all(f"slope of up to {slope} would add" in line for line in found)


SLOWEST = {  # what damps the slowest motion of all, by its damping ratio
    "disk": lambda ratio: {"material.damping_ratio": ratio},
    "air": lambda ratio: {"aero.influence": [{"blades": 0, "damping_ratio": ratio}]},
    "casing": lambda ratio: {"casing.modes": [
        {"waves": 2, "frequency_hz": 50.0, "modal_mass_kg": 100.0, "damping_ratio": ratio}]},
}  # fmt: skip


@pytest.mark.parametrize("slowest", ["air", "casing"])
def test_a_transient_that_nothing_damps_is_marked(slowest):
    config = Config().replace(SLOWEST[slowest](0.0))
    assert told(config, "transients never decay, steady_state.max_time_s")
    up = config.replace({"study": "run_up"})
    assert not told(up, "transients")  # which waits for no steady motion


@pytest.mark.parametrize("slowest", SLOWEST)
@pytest.mark.parametrize(("first_check", "share"), [(0.4, "37 %"), (0.73, "16 %"), (1.3, "")])
def test_a_transient_that_the_first_check_does_not_outlast_is_marked(first_check, share, slowest):
    """exp(-t/0.4 s) of it is left; one at 1.4 time constants was called steady 14 % too low."""
    config = Config().replace({"steady_state.rule": "last_window"})
    omega = np.sqrt(build_problem(config).reduced.tuned_eigenvalues[0])
    omega = 2 * np.pi * 50.0 if slowest == "casing" else omega
    config = config.replace(SLOWEST[slowest](float(1.0 / (0.4 * omega))) | {
        "steady_state.first_check_s": first_check, "steady_state.max_time_s": 4.0,
    })  # fmt: skip
    found = told(config, "transients")
    assert len(found) == bool(share)
    assert all(f"leaves up to {share}" in line for line in found)
    assert len(list(not_resolved(found))) == bool(share)  # the verdict says it, too


@pytest.mark.parametrize(
    ("keys", "seconds"),  # a bump's 1/e width: a fifth of its pitch
    [
        ({"speeds.to_hz": 10_000.0, "speeds.step_hz": 100}, 0.2 / 4 / 10_000),
        ({"casing.n_bumps": 300}, 0.2 / 300 / 35.5),
        ({"casing.n_bumps": 300, "casing.bump_width": 0.05}, 0.1 / 300 / 35.5),
        # only the tip of the bump, a Gaussian, reaches beyond the clearance
        ({"casing.clearance_mm": 1.25 * np.exp(-0.01)}, 0.1 * 0.2 / 4 / 35.5),
    ],
)
def test_the_step_follows_the_bumps(keys, seconds):
    config = Config().replace(keys)
    assert config.step == pytest.approx(min(seconds / 32, 3.3e-5), rel=1e-9)
    assert config.replace({"time.step_s": 1e-9}).step == 1e-9


def test_the_step_follows_harmonics():
    """A cosine counts as the Gaussian bump of its height from trough to crest and its curvature."""
    keys = {"order": 40, "amplitude_mm": 0.5}
    config = Config(casing={"harmonics": [keys], "clearance_mm": 0.0})
    # 2 a exp(-(phi/w)²) of the curvature a n² has w = 2/n, and is half as high at w sqrt(ln 2)
    seconds = 2 * 2 / 40 * np.sqrt(np.log(2)) / (2 * np.pi * 35.5)
    assert resolution.bump_time(config) == pytest.approx(seconds, rel=1e-6)
    assert config.step == pytest.approx(min(seconds / 32, 3.3e-5), rel=1e-6)
    assert config.step < 2e-5
    half = config.replace({"casing.clearance_mm": 0.25})
    seconds *= np.sqrt(np.log(4 / 3) / np.log(2))
    assert resolution.bump_time(half) == pytest.approx(seconds, rel=1e-6)
    out_of_reach = config.replace({"casing.clearance_mm": 0.51})
    assert resolution.bump_time(out_of_reach) == np.inf


@pytest.mark.parametrize("height", [0.05, 0.6, 5.0])
@pytest.mark.parametrize("clearance", [0.0, 0.65])
def test_a_narrow_bump_keeps_its_step_beside_a_harmonic(height, clearance):
    """The bump's own, as long as its flank is steeper than anything else; not much longer then."""
    bumps = {"n_bumps": 3, "bump_height_mm": height, "bump_width": 2.5e-3}
    wave = {"harmonics": [{"order": 1, "amplitude_mm": 0.8}], "clearance_mm": clearance}
    alone = Config(casing=bumps | {"clearance_mm": 0.0})
    both = Config(casing=bumps | wave)
    assert 0.8 < both.step / alone.step < 1.2


def test_bumps_as_a_measured_profile_need_about_the_step_of_bumps():
    angle = np.arange(720) / 2
    height = 1.25 * np.exp(-((((angle + 45) % 90 - 45) / 9) ** 2))
    config = Config(casing={"profile_deg": angle.tolist(), "profile_mm": (-height).tolist()})
    assert resolution.bump_time(config) == pytest.approx(resolution.bump_time(Config()), rel=0.15)
    assert config.casing.outline.orders == (4, 8, 12, 16, 20, 24)
    assert config.casing.main_order == 4


def test_a_casing_without_equal_bumps_needs_an_engine_order(tmp_path, capfd):
    path = tmp_path / "input.yaml"
    waves = "[{order: 2, amplitude_mm: 0.3}, {order: 3, amplitude_mm: 0.2}]"
    path.write_text(f"{TINY}casing: {{harmonics: {waves}}}\noutput: {tmp_path}/out.h5\n")
    assert cli.main([str(path), "--dry-run"]) == 2
    words = "forcing.engine_order: a casing without equal bumps does not say"
    assert words in capfd.readouterr().err
    config = load_runs(path)[0]
    assert config.replace({"forcing.engine_order": 5}).engine_order == 5
    assert Config.from_yaml("casing: {harmonics: [{order: 3, amplitude_mm: 1}]}").engine_order == 3
    assert Config.from_yaml("casing: {n_bumps: 6}").engine_order == 6


def test_the_step_follows_the_blades():
    """First bending of a clamped beam: 3.516 sqrt(E I / (rho A)) / l^2."""
    config = Config().replace({"disk.blade.thickness_mm": 100.0, "casing.clearance_mm": 2.0})
    omega = 3.516 * np.sqrt(210e9 / 7800 / 12) * 0.1 / 0.3**2
    assert config.step == pytest.approx(2 * np.pi / omega / 40, rel=1e-3)


GRAZED = {
    "disk.n_blades": 6, "disk.blade.n_elements": 1, "disk.blade.thickness_mm": 26,
    "disk.blade.lean_deg": -17, "disk.tip_radius_mm": 367, "reduction.n_modes": 36,
    "material.damping_ratio": 0.14, "contact.friction": 0.5, "forcing.engine_order": 1,
    "casing.profile_deg": [30 * k for k in range(12)],
    "casing.profile_mm": [
        -3.73, -2.29, -0.24, 1.81, 3.42, 4.1, 3.66, 2.29, 0.24, -1.88, -3.49, -4.17
    ],
    "casing.growth_time_s": 0.002, "steady_state.first_check_s": 0.1,
    "speeds.from_hz": 165, "speeds.to_hz": 165,
}  # fmt: skip


def test_a_graze_gets_the_step_that_it_needs():
    """30 µm beyond the clearance of a casing of 4 mm: it had the step of 200 µm, and 20 % less."""
    config = Config().replace(GRAZED)
    clearance = 1e3 * config.casing.outline.highest - 0.03
    amplitudes = []
    for steps in (32, 200):
        keys = {"casing.clearance_mm": clearance, "time.steps_per_bump_width": steps}
        amplitudes.append(swept(config.replace(keys)).amplitude[0])
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=0.05)


def test_a_speed_whose_running_clearance_lets_little_in_is_marked():
    """The step of all speeds is made for a twentieth of the casing's height, at least."""
    config = Config().replace(GRAZED)
    top = 1e3 * config.casing.outline.highest
    for least, marked in ((0.01, True), (0.5, False)):
        table = [[160, top - 1.0], [170, top - least]]
        keys = {"speeds.from_hz": 160, "speeds.to_hz": 170, "casing.clearance_hz_mm": table}
        assert bool(told(config.replace(keys), "grazed")) == marked


@pytest.mark.parametrize(
    ("noise", "keys", "marked"),
    [
        (0.0, {}, ""),
        (2e-3, {}, ""),
        (8e-2, {}, "noise: smoothing over 62.8 mm takes up to 0."),
        # little of the casing reaches beyond the clearance
        (4e-3, {"casing.clearance_mm": 0.235}, "noise: smoothing over 62.8 mm takes up to 0.01"),
        # the points that were measured reach it, the smoothed ones do not
        (4e-3, {"casing.clearance_mm": 0.254}, "noise: smoothing over 62.8 mm takes up to 0.01"),
        (4e-3, {"casing.clearance_mm": 0.3}, ""),
        (2e-3, {"casing.smoothing_mm": 0}, "noise: the measured points of the casing are not"),
    ],
)
def test_noise_of_a_measurement_is_no_geometry_or_is_marked(noise, keys, marked):
    angle = np.arange(3600) / 10
    height = 0.25 * np.cos(2 * np.radians(angle))
    height += noise * np.random.default_rng(4).standard_normal(angle.size)
    points = {"profile_deg": angle.tolist(), "profile_mm": (-height).tolist(), "clearance_mm": 0}
    config = Config(casing=points, forcing={"engine_order": 2}).replace(keys)
    assert [line[: len(marked)] for line in told(config)] == [marked] * bool(marked)


@pytest.mark.parametrize(
    ("n", "noise", "smoothing", "marked"),
    [
        (720, 4e-3, 1, True),  # points every 4.4 mm
        (720, 4e-3, 8, True),
        (720, 4e-3, 16, True),
        (720, 4e-3, None, False),  # a tenth of the slope
        (720, 0.0, 1, False),
        (100, 0.0, 1, False),
        (100, 8e-3, None, True),
    ],
)
def test_noise_that_smoothing_leaves_is_marked(n, noise, smoothing, marked):
    """It is found without knowing the shape: here both are known."""
    angle = 2 * np.pi * np.arange(n) / n
    error = 1e-3 * noise * np.random.default_rng(4).standard_normal(n)
    height = 0.25e-3 * np.cos(2 * angle) + error
    points = {"profile_deg": np.degrees(angle).tolist(), "profile_mm": (-1e3 * height).tolist()}
    config = Config(casing=points | {"smoothing_mm": smoothing, "clearance_mm": 0},
                    forcing={"engine_order": 2})  # fmt: skip
    assert bool(told(config, "leaves noise from point to point")) == marked
    profile = config.casing.profile
    pairs = (tuple(zip(angle, values, strict=True)) for values in (error, height))
    own, whole = (np.std(smoothed(pair, profile.cut_off)[2]) for pair in pairs)
    if marked:
        assert noise_left(profile) == pytest.approx(own / whole, rel=0.5)
    assert (own / whole > 0.2) == marked


def test_flutter_is_told_of_every_level():
    """Twelve waves of 0.002 + 0.0022 cos(2πr/12): more mistuning leaves fewer disks in flutter."""
    keys = {"blades": 1, "damping_ratio": 0.0011}
    influence = [{"damping_ratio": 0.002}, keys, keys | {"blades": -1}]
    config = Config(aero={"influence": influence}, mistuning={"half_range_percent": [0.01, 9]})
    (line,) = told(config, "flutter without contact: ")
    low, high = (int(part.split()[-1]) for part in line.split(" at ±")[:2])
    assert low == 51
    assert high < low
    (finding,) = not_resolved([line])
    assert finding.why == "flutter without contact"
    (finding,) = not_settled(config, 3, 4, "peaks")  # no time is long enough
    assert "max_time_s" not in finding.advice
    (finding,) = not_settled(Config(), 3, 4, "peaks")
    assert "max_time_s above" in finding.advice


STIFF = {
    "disk.n_blades": 2, "disk.blade.n_elements": 1, "reduction.n_modes": 12,
    "contact.law": "abradable", "contact.casing_stiffness_n_per_m": 3.85e8,
    "contact.coating": {
        "thickness_mm": 47.5, "young_gpa": 40.3, "yield_mpa": 3.54, "hardening_mpa": 0
    },
    "casing.n_bumps": 6, "casing.bump_height_mm": 0.2181, "casing.clearance_mm": 0.0,
    "speeds.from_hz": 97.55, "speeds.to_hz": 97.55,
}  # fmt: skip


def test_a_coating_that_springs_back_too_fast_for_the_step_is_marked():
    """The scene: nine runs cut 0.8 to 2.6 mm at the default step, 0.81 mm at 1 µs."""
    config = Config().replace(STIFF)
    (line,) = told(config)
    assert "a blade springs back from the casing within" in line
    config = config.replace({"time.step_s": float(line.split()[-1])})
    assert 2e-6 < config.step < 4e-6
    assert told(config) == []


def test_the_time_of_a_rebound_is_that_of_the_force_of_a_blade_on_springs():
    """Force of a blade that moves on in its first family: rms of its rate over its own, ω."""
    problem = build_problem(Config().replace(STIFF))
    stiffness, n = np.array([1e9]), 2
    modes = mistuned_modes(problem.reduced, np.zeros(n))
    tip = modes.normal[0]
    system = np.diag(modes.omega**2) + stiffness * np.outer(tip, tip)
    state = np.block([[np.zeros_like(system), np.eye(len(tip))], [-system, np.zeros_like(system)]])
    now = np.concatenate([0.0 * tip, np.where(np.arange(len(tip)) < n, tip, 0.0)])
    step, forces = expm(state * 1.7e-4), []
    for _ in range(20_000):
        now = step @ now
        forces.append([tip @ part for part in np.split(now, 2)])
    force, rate = np.sqrt(np.mean(np.square(forces), axis=0))
    found = plausibility.rebound_time(problem, stiffness)
    assert found == pytest.approx(np.pi * force / rate, rel=0.02)


REFUSED = [
    ({"casing.growth_time_s": 20}, "casing.growth_time_s: the bumps still grow at"),
    ({"speeds.from_hz": 0.05, "speeds.to_hz": 0.05}, "steady_state.max_time_s: 0.5 s are over"),
    ({"disk.blade.thickness_mm": 1e-6}, "disk: the stiffnesses of its parts are too far apart"),
    ({"disk.blade.thickness_mm": 1e-9}, "disk: the stiffnesses of its parts are too far apart"),
    ({"disk.hub_radius_mm": 499.99}, "not enough memory"),
    ({"mistuning.samples": 1e12}, "not enough memory"),
    ({"output": "."}, "is a folder"),
]


@pytest.mark.parametrize(("keys", "message"), REFUSED, ids=[m[:20] for _, m in REFUSED])
def test_what_cannot_have_a_result_is_refused_by_run_and_dry_run(folder, capfd, keys, message):
    (folder / "a.yaml").write_text(TINY)
    if "output" in keys:
        (folder / "there.h5").mkdir()
        keys = {"output": "there.h5"}
    settings = [f"--set={key}={value}" for key, value in keys.items()]
    for option in ([], ["--dry-run"]):
        assert cli.main(["a.yaml", *settings, *option]) == 2
        (line,) = capfd.readouterr().err.splitlines()
        assert message in line


@pytest.mark.parametrize("study", ["contact", "branches"])
def test_what_is_not_resolved_is_marked_in_file_and_output(folder, capfd, study):
    keys = "time.steps_per_bump_width=2", "time.steps_per_period=1", "time.step_s=1e-3"
    coarse = [f"--set={key}" for key in (*keys, f"study={study}", "mistuning.samples=1")]
    (folder / "a.yaml").write_text(TINY)
    assert cli.main(["a.yaml", *coarse, "--no-figures"]) == 0
    printed = capfd.readouterr().out
    assert "warning: not resolved: 2 time steps per bump width" in printed
    verdict = printed[printed.index("Verdict:") :]
    assert "usable." not in verdict.splitlines()[0]
    assert "not resolved: 2 time steps per bump width" in " ".join(verdict.split())
    with open_result("results/a.h5") as file:
        assert file.warnings[0].startswith("not resolved: 2 time steps per bump width")
