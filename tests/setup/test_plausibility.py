"""Numbers that mean something: bumps and blades are resolved, or the study is refused or marked.

Truth: a time step many times finer; counts of steps by hand; the limits of the input themselves.
"""

import os

import numpy as np
import pytest

from hpcrub import studies
from hpcrub.commands import run as cli
from hpcrub.config import resolution
from hpcrub.config.schema import Config, load_runs
from hpcrub.errors import InputError
from hpcrub.response.sweep import run_sweep
from hpcrub.runs import memory
from hpcrub.setup import input_files, plausibility
from hpcrub.setup.disks import modes_of
from hpcrub.setup.problem import build_problem
from hpcrub.studies import open_result
from tests.program import ROOT, TINY, load


@pytest.mark.parametrize("path", sorted((ROOT / "inputs").glob("*.yaml")), ids=lambda p: p.stem)
def test_inputs_that_come_along_keep_their_step_and_are_resolved(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    for config in map(input_files.with_tables, load_runs(path)):
        assert config.step == config.time.step_s
        few = path.stem == "reduction" and config.reduction.n_modes < 3 * config.disk.n_blades
        if studies.run_of(config).study.integrates and not few:  # which shows what few modes do
            assert list(plausibility.warnings(config, build_problem(config))) == []


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
    # a crest of a cosine counts as the Gaussian bump of its height and curvature
    keys = {"order": 40, "amplitude_mm": 0.5}
    config = Config(casing={"harmonics": [keys], "clearance_mm": 0.0})
    seconds = 2 * np.sqrt(2) / 40 / (2 * np.pi * 35.5)
    assert resolution.bump_time(config) == pytest.approx(seconds, rel=1e-6)
    assert config.step == pytest.approx(min(seconds / 32, 3.3e-5), rel=1e-6)
    assert config.step < 2e-5
    # half of its height reaches beyond the clearance, which is a part √½ of the width
    half = config.replace({"casing.clearance_mm": 0.25})
    assert resolution.bump_time(half) == pytest.approx(seconds / np.sqrt(2), rel=1e-6)
    out_of_reach = config.replace({"casing.clearance_mm": 0.51})
    assert resolution.bump_time(out_of_reach) == np.inf


def test_bumps_as_a_measured_profile_need_about_the_step_of_bumps():
    angle = np.arange(720) / 2
    height = 1.25 * np.exp(-((((angle + 45) % 90 - 45) / 9) ** 2))
    config = Config(casing={"profile_deg": angle.tolist(), "profile_mm": (-height).tolist()})
    assert resolution.bump_time(config) == pytest.approx(resolution.bump_time(Config()), rel=0.15)
    assert plausibility.orders(config) == (4, 8, 12, 16, 20, 24)
    assert config.casing.main_order == 4


def test_a_casing_without_equal_bumps_needs_an_engine_order(tmp_path, capfd):
    path = tmp_path / "input.yaml"
    waves = "[{order: 2, amplitude_mm: 0.3}, {order: 3, amplitude_mm: 0.2}]"
    path.write_text(f"{TINY}casing: {{harmonics: {waves}}}\noutput: {tmp_path}/out.h5\n")
    assert cli.main([str(path), "--dry-run"]) == 2
    assert "forcing.engine_order: a casing without equal bumps does not say" in (
        capfd.readouterr().err
    )
    config = load_runs(path)[0]
    assert config.replace({"forcing.engine_order": 5}).engine_order == 5
    assert Config.from_yaml("casing: {harmonics: [{order: 3, amplitude_mm: 1}]}").engine_order == 3
    assert Config.from_yaml("casing: {n_bumps: 6}").engine_order == 6


def test_the_step_follows_the_blades():
    """First bending of a clamped beam: 3.516 sqrt(E I / (rho A)) / l^2."""
    config = Config().replace({"disk.blade.thickness_mm": 100.0, "casing.clearance_mm": 2.0})
    omega = 3.516 * np.sqrt(210e9 / 7800 / 12) * 0.1 / 0.3**2
    assert config.step == pytest.approx(2 * np.pi / omega / 40, rel=1e-3)


def test_a_step_that_is_far_too_long_changes_nothing_that_is_steady():
    """The attack: every point steady, 2.6 mm where a fine step gives 13.8 mm."""
    keys = {"material.damping_ratio": 0.05, "reduction.n_modes": 4, "speeds.to_hz": 34.4}
    found = []
    for step in (0.01, 1e-5):
        config = Config.from_yaml(TINY).replace(keys | {"time.step_s": step})
        problem = build_problem(config)
        modes = modes_of(config, problem, np.zeros(12))
        found.append(run_sweep(modes, problem.scene, config.speeds.values_hz).amplitude)
    np.testing.assert_allclose(found[0], found[1], rtol=0.03)


def test_a_graze_that_the_step_does_not_resolve_is_marked():
    """The scene: 30 µm beyond the clearance of a casing of 4 mm, whose step is made for 200 µm."""
    height = [3.73, 2.29, 0.24, -1.81, -3.42, -4.1, -3.66, -2.29, -0.24, 1.88, 3.49, 4.17]
    config = Config().replace(
        {
            "disk.n_blades": 6, "disk.blade.n_elements": 1, "disk.blade.thickness_mm": 26,
            "disk.blade.lean_deg": -17, "disk.tip_radius_mm": 367, "reduction.n_modes": 36,
            "material.damping_ratio": 0.14, "contact.friction": 0.5, "forcing.engine_order": 1,
            "casing.profile_deg": [30 * k for k in range(12)],
            "casing.profile_mm": [-h for h in height], "casing.clearance_mm": 4.14,
            "casing.growth_time_s": 0.002, "steady_state.first_check_s": 0.1,
            "speeds.from_hz": 165, "speeds.to_hz": 165,
        }
    )  # fmt: skip
    amplitudes = []
    for keys in ({}, {"time.steps_per_bump_width": 100}, {"casing.clearance_mm": 3.9}):
        changed = config.replace(keys)
        problem = build_problem(changed)
        marked = [line for line in plausibility.warnings(changed, problem) if "grazed" in line]
        assert bool(marked) == (not keys)
        modes = modes_of(changed, problem, np.zeros(6))
        amplitudes.append(run_sweep(modes, problem.scene, [165.0]).amplitude[0])
    assert abs(amplitudes[1] / amplitudes[0] - 1.0) > 0.1  # which is why


REFUSED = [
    ({"casing.growth_time_s": 20}, "casing.growth_time_s: the bumps still grow at"),
    ({"speeds.from_hz": 0.05, "speeds.to_hz": 0.05}, "steady_state.max_time_s: 0.5 s are over"),
    ({"speeds.from_hz": 1e-6, "speeds.to_hz": 1e-6}, "steady_state.max_time_s"),
    ({"disk.blade.thickness_mm": 1e-6}, "disk: the stiffnesses of its parts are too far apart"),
    ({"disk.inner_radius_mm": 199.99999999999}, "disk: the stiffnesses of its parts"),
    ({"disk.hub_radius_mm": 499.99}, "not enough memory"),
    ({"mistuning.samples": 1e12}, "not enough memory"),
    ({"output": "."}, "is a folder"),
]


@pytest.mark.parametrize(("keys", "message"), REFUSED, ids=[m[:20] for _, m in REFUSED])
@pytest.mark.parametrize("option", [[], ["--dry-run"]])
def test_what_cannot_have_a_result_is_refused_by_run_and_dry_run(
    folder, capfd, keys, message, option
):
    (folder / "a.yaml").write_text(TINY)
    if "output" in keys:
        (folder / "there.h5").mkdir()
        keys = {"output": "there.h5"}
    settings = [f"--set={key}={value}" for key, value in keys.items()]
    assert cli.main(["a.yaml", *settings, *option]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert message in line


def test_what_is_not_resolved_is_marked_in_file_and_output(folder, capfd):
    keys = "time.steps_per_bump_width=2", "time.steps_per_period=1", "time.step_s=1e-3"
    coarse = [f"--set={key}" for key in keys]
    (folder / "a.yaml").write_text(TINY)
    assert cli.main(["a.yaml", *coarse, "--set=mistuning.samples=1", "--no-figures"]) == 0
    assert "warning: not resolved: 2 time steps per bump width" in capfd.readouterr().out
    with open_result("results/a.h5") as file:
        assert "not resolved: 2 time steps per bump width" in file.attributes["warnings"]


@pytest.mark.parametrize(
    ("keys", "marked"),
    [
        ({"reduction.n_modes": 23, "casing.n_bumps": 3}, "is 23, fewer than 2 for each blade, 24"),
        ({"reduction.n_modes": 24, "casing.n_bumps": 3}, ""),
        # four bumps pass at 142 Hz, the first family vibrates below 94 Hz
        ({"reduction.n_modes": 24}, "fewer than 3 for each blade, 36"),
        ({"reduction.n_modes": 36}, ""),
        # all there are
        ({"reduction.n_modes": 18, "disk.n_blades": 3, "disk.blade.n_elements": 1}, ""),
    ],
)
def test_a_model_of_few_modes_is_marked(keys, marked):
    config = Config().replace(keys)
    lines = list(plausibility.warnings(config, build_problem(config)))
    assert [marked in line for line in lines] == [True] * bool(marked)


@pytest.fixture
def laptop(monkeypatch):
    """This machine has 16 GiB of memory."""
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 2**22, "SC_PAGE_SIZE": 2**12}.get)


@pytest.mark.parametrize(
    "text",
    [
        "mistuning: {samples: 1000000000000}",
        "disk: {n_blades: 200, blade: {n_elements: 50}}",
        "speeds: {from_hz: 1e-6, to_hz: 1e-6}",
        "time: {step_s: 1e-12}",
        "contact: {law: abradable}\ntime: {step_s: 1e-10}",
        "study: interaction_map\nhistory: {duration_s: 1000}\ntime: {step_s: 1e-9}",
    ],
)
def test_what_this_machine_cannot_hold_is_refused_before_work(laptop, text):
    with pytest.raises(InputError, match="not enough memory: this study needs .* are there"):
        memory.check(studies.run_of(Config.from_yaml(text)))


def test_the_paper_fits_a_laptop(laptop):
    memory.check(studies.run_of(load(ROOT / "inputs" / "paper_nd4.yaml")))
