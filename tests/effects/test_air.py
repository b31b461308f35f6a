"""A linear study of disks in air: which of them flutter, and what that leaves out."""

import numpy as np
import pytest

from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_model
from hpcrub.studies import open_result
from hpcrub.studies.linear import STUDY as LINEAR
from tests.program import computed, contents, load

STUDY = """\
study: linear
aero:
  influence:
    - {blades: 0, damping_ratio: 0.002}
    - {blades: 1, damping_ratio: 0.0011}
    - {blades: -1, damping_ratio: 0.0011}
linear: {n_diameters: [1]}
mistuning: {half_range_percent: [1, 4], samples: 40}
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("air")
    path = computed(folder, STUDY)
    with open_result(path) as file:
        verdict = LINEAR.verdict(file)
    return load(folder / "study.yaml"), contents(path), verdict


def test_disks_flutter_whose_dense_matrices_do(found):
    """The least stable mode of every sample, of the eigenvalues of [[0, I], [-K, -D]]."""
    config, values = found[:2]
    model = build_model(config)
    for level in (0, 1):
        for sample in range(0, 40, 7):
            modes = modes_of(config, model, deviation(config, level, sample))
            waves, zero, one = modes.waves, np.zeros((12, 12)), np.eye(12)
            K = np.diag(modes.omega[waves.rows] ** 2) + waves.stiffness
            eigenvalues = np.linalg.eigvals(np.block([[zero, one], [-K, -waves.damping]]))
            least = (-eigenvalues.real / np.abs(eigenvalues)).min()
            told = values["aero/least_damping_ratio"][level, sample]
            assert told == pytest.approx(least, abs=1e-9)
            decay = np.sort(values["aero/decay_per_s"][level, sample])
            np.testing.assert_allclose(decay, np.sort(-eigenvalues.real)[::2], atol=1e-9)


def test_without_mistuning_waves_are_as_given_and_with_it_the_least_stable_one_gains(found):
    """ζ_r = 0.002 + 0.0022 cos(2πr/12), below zero for six diameters."""
    values = found[1]
    given = 0.002 + 0.0022 * np.cos(2 * np.pi * np.arange(12) / 12)
    assert values["aero/diameters"].tolist() == [*range(7), -5, -4, -3, -2, -1]
    np.testing.assert_allclose(values["aero/given_damping_ratio"], given, atol=1e-15)
    np.testing.assert_allclose(values["aero/tuned_damping_ratio"], given, atol=1e-7)
    least = values["aero/least_damping_ratio"]
    assert (least > given.min()).all()
    assert np.median(least[1]) > np.median(least[0])


def test_a_disk_that_flutters_has_no_amplification(found):
    """Nor has any where the tuned disk does, as here."""
    values = found[1]
    assert (values["aero/least_damping_ratio"][1] > 0).any()
    assert np.isnan(values["amplification"]).all()
    assert np.isnan(values["aero/largest_amplification"]).all()


def test_flutter_of_every_level_is_in_the_verdict(found):
    """It said "usable", over a table without a line."""
    values = found[1]["aero/least_damping_ratio"]
    lost = np.count_nonzero(values <= 0.0, axis=1)
    words = [f"{n} of 40 at ±{level} %" for n, level in zip(lost, (1, 4), strict=True)]
    lines = found[2].lines
    assert lines[0].startswith("not usable: the tuned disk flutters")
    assert ", ".join(words) in " ".join(lines)


def test_a_modal_study_has_the_waves_of_the_tuned_disk(found, tmp_path, capsys):
    text = "\n".join(["study: modal", *STUDY.splitlines()[1:6], "reduction: {n_modes: 24}"])
    values = contents(computed(tmp_path, text))
    assert "least stable wave has 6 nodal diameters" in capsys.readouterr().out
    name = "aero/tuned_damping_ratio"
    np.testing.assert_allclose(values[name], found[1][name], atol=1e-9)
