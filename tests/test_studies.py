"""Studies other than contact, each on a tiny case: what they compute, store and draw.

Truth: closed forms of the casing and of a tuned disk, brute force over speeds for linear peaks,
the binomial coverage of an interval, and that ranks and interruptions change nothing.
"""

import h5py
import numpy as np
import pytest
from conftest import ROOT, load, run

from hpcrub import cli, config, inspect, plot, storage, studies
from hpcrub.linear import travelling_load_response
from hpcrub.mistuning import stiffness_deviation
from hpcrub.plot.__main__ import main as plot_main
from hpcrub.reduction import mistuned_modes
from hpcrub.storage import ResultFile
from hpcrub.study import build_model


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def compute(name, *overrides):
    """Run inputs/NAME.yaml with overrides in the current folder; returns its open ResultFile."""
    arguments = [str(ROOT / "inputs" / f"{name}.yaml"), "--output", f"{name}.h5"]
    for override in overrides:
        arguments += ["--set", override]
    assert cli.main(arguments) == 0
    return ResultFile.open(f"{name}.h5")


def test_every_study_has_an_input_and_a_figure():
    for name in studies.STUDIES:
        inputs = [load(path) for path in (ROOT / "inputs").glob("*.yaml")]
        assert name in {cfg.study for cfg in inputs}
        assert any(name in entry.studies for entry in plot.FIGURES.values())


def test_modes_of_the_tuned_disk_come_in_pairs(folder):
    file = compute("modal")
    for kind in ("full", "reduced"):
        family = file.read(f"{kind}/frequencies_hz")[:12]
        diameters = file.read(f"{kind}/nodal_diameters")[:12]
        # a cyclic disk: 0 and N/2 diameters once, all others twice, with equal frequencies
        assert sorted(diameters) == [0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6]
        for d in range(1, 6):
            pair = family[diameters == d]
            assert pair[0] == pytest.approx(pair[1], rel=1e-9)
        assert (family.min(), family.max()) == pytest.approx((90.1, 93.2), abs=0.05)  # the paper
    # Rayleigh: a reduced model is never softer
    full, reduced = file.read("full/frequencies_hz"), file.read("reduced/frequencies_hz")
    assert (reduced >= full[: len(reduced)] * (1 - 1e-9)).all()
    shapes = file.read("shapes")
    assert np.hypot(shapes[..., 0], shapes[..., 1]).max(axis=1) == pytest.approx(1.0)
    inner = file.read("spokes")[:, 0]
    assert (shapes[:, inner] == 0.0).all()  # clamped
    assert plot_main(["modal.h5", "--figure", "animation", "--mode", "4"]) == 0
    assert (folder / "modal_animation.gif").stat().st_size > 10_000
    assert plot_main(["modal.h5", "--figure", "animation", "--mode", "400"]) == 2


def test_casing(folder):
    file = compute("casing", "casing.n_bumps=3")
    gap, angle = file.read("gap_m"), file.read("angle_rad")
    assert gap.min() == pytest.approx(0.25e-3 - 1.25e-3)
    assert angle[gap < gap.min() + 1e-12] == pytest.approx(np.arange(4) * 2 * np.pi / 3)
    assert file.read("growth")[[0, -1]] == pytest.approx([0.0, 1.0])
    assert (folder / "casing.png").stat().st_size > 10_000
    assert plot_main(["casing.h5", "--format", "svg", "--out", "pictures"]) == 0
    assert (folder / "pictures" / "casing.svg").exists()


def test_linear_amplification_is_that_of_a_fine_search(folder):
    overrides = "linear.n_diameters=[2, 5]", "mistuning.half_range_percent=[0, 3]"
    file = compute("linear", *overrides, "mistuning.samples=3")
    amplification = file.read("amplification")
    assert amplification[0] == pytest.approx(1.0, abs=1e-12)  # no mistuning
    cfg = file.config
    reduced = build_model(cfg)[1]
    for d, n_diameters in enumerate((2, 5)):
        speeds = np.linspace(85, 99, 70001) / n_diameters
        peak = [
            np.abs(
                travelling_load_response(
                    mistuned_modes(reduced, deviation), 0.005, 1.0, n_diameters,
                    reduced.contact_angle, speeds,
                )
            ).max()
            for deviation in (np.zeros(12), stiffness_deviation(2020, 1, 2, 12, 0.03))
        ]  # fmt: skip
        assert amplification[1, d, 2] == pytest.approx(peak[1] / peak[0], rel=1e-4)


@pytest.mark.mpi
def test_tasks_on_several_ranks_are_the_same_bits(folder):
    overrides = "--set", "mistuning.samples=60", "--set", "linear.n_diameters=[4]"
    study = ROOT / "inputs" / "linear.yaml", *overrides, "--output"
    for ranks, path in ((0, "one.h5"), (3, "three.h5")):
        code, _, err = run(ranks, *study, path, folder=folder)
        assert code == 0, err
    with h5py.File("three.h5", "r+") as file:  # as an interrupted run would leave it
        file["status"][2:] = 0
        file["amplification"][1] = np.nan
    assert run(2, *study, "three.h5", "--resume", folder=folder)[0] == 0
    with h5py.File("one.h5") as one, h5py.File("three.h5") as three:
        for name in ("amplification", "tuned/amplitude_m", "status"):
            np.testing.assert_array_equal(one[name][()], three[name][()])


def test_inspect(folder, capsys):
    compute("casing", "casing.n_bumps=5").close()
    capsys.readouterr()
    assert inspect.main(["casing.h5"]) == 0
    out = capsys.readouterr().out
    for text in ("sound, study casing", "casing.n_bumps: 5", "done: 1 of 1 tasks", "gap_m (angle"):
        assert text in out
    (folder / "casing.h5").write_bytes(b"nothing")
    assert inspect.main(["casing.h5"]) == 2


QUICK = "reduction.n_modes=12", "time.step_s=2e-5"


def test_inspect_of_a_study_too_short_for_statistics(folder, capsys):
    pattern = "mistuning: {pattern_gpa: [" + "210, " * 11 + "211]}"
    storage.lay_out("pattern.h5", config.Config.from_yaml(pattern))
    assert inspect.main(["pattern.h5"]) == 0
    assert "statistics/contact/percentile (level 1 x percentile 3 x block 0) [1] :" in (
        capsys.readouterr().out
    )


def test_time_response(folder):
    pattern = "mistuning.pattern_gpa=[205,215,205,215,205,215,205,215,205,215,205,215]"
    file = compute("time_response", *QUICK, pattern, "history.duration_s=0.6")
    assert len(file.read("deviation")) == 2
    assert np.abs(file.read("tangential_m")).max() > 1e-3
    assert file.read("gap_m").min() > -1e-6
    assert file.read("check_s")[0] == pytest.approx(0.5, abs=0.01)
    assert np.isfinite(file.read("correlation")).all()
    assert (folder / "time_response.png").stat().st_size > 10_000
    assert "one speed" in refusal("study: time_response")


def test_interaction_map(folder):
    speeds = "speeds.from_hz=29", "speeds.to_hz=31", "speeds.step_hz=1"
    spans = "history.duration_s=0.4", "spectrum.window_s=0.2", "spectrum.max_frequency_hz=150"
    file = compute("interaction_map", *QUICK, *speeds, *spans)
    spectrum, frequencies = file.read("spectrum_m"), file.read("frequencies_hz")
    assert np.isfinite(spectrum).all()
    # the tuned disk moves with the passing of the bumps, 4 per revolution
    for s, speed in enumerate((29, 30, 31)):
        assert frequencies[spectrum[0, s].argmax()] == pytest.approx(4 * speed, abs=3)
    assert file.read("natural_frequencies_hz")[0, 0] == pytest.approx(90.12, abs=0.1)
    assert (folder / "interaction_map.png").stat().st_size > 10_000


def refusal(text):
    with pytest.raises(config.InputError) as caught:
        config.Config.from_yaml(text)
    return str(caught.value)
