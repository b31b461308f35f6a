"""Studies of one blade: of a rod whose motion is published, and of a solid blade on its foot.

Truth: a clamped rod before an elastic stop (Vadcard, Batailly, Thouverez 2022), and that a blade
without neighbours has no nodal diameters, no localisation, and one amplification for all loads.
"""

import numpy as np
import pytest

from evidence.truth.hexahedra import sector_arrays
from evidence.validation import clamped_rod as rod
from hpcrub.config.schema import Config
from hpcrub.results import model_file
from hpcrub.setup import imported
from hpcrub.studies import open_result, run_of
from tests.program import computed, refusal, run_here

FIRST_HZ = 9980.921  # of 20 elements; of the rod itself, sqrt(E/rho) / 4 L, it is 9978.36 Hz
BRIEF = """\
disk: {model: blade.h5}
reduction: {n_modes: 6}
casing: {n_bumps: 4, clearance_mm: 0.02, bump_height_mm: 0.06, growth_time_s: 0.002}
speeds: {from_hz: 400, to_hz: 414, step_hz: 2}
time: {step_s: 4e-6}
steady_state: {first_check_s: 0.02, max_time_s: 0.02}
mistuning: {half_range_percent: [4], samples: 2, checked_samples: 0, tuned_runs: 1}
convergence: {step: 1}
linear: {n_diameters: [1, 3]}
"""


@pytest.fixture
def blade(folder):
    """The working folder, with the model file of one solid blade and its piece of the disk."""
    arrays = sector_arrays(lean=0.6) | {"kind": np.array("disk")}
    for name in ("n_sectors", "low", "high"):
        del arrays[name]
    model_file.write("blade.h5", arrays)
    return folder


def read(text):
    return imported.resolved(Config.from_yaml(text))


def run(folder, study, *options):
    return open_result(computed(folder, f"study: {study}\n{BRIEF}", "--overwrite", *options))


def test_history_of_a_rod_has_the_published_displacement(folder):
    """With the usual records, 21 a period, it is 3e-3 too small."""
    model_file.write("rod.h5", rod.arrays())
    keys = rod.keys("rod.h5", 4.0, FIRST_HZ) | {"output": "rod_history.h5"}
    (folder / "rod.yaml").write_text(Config(**keys).to_yaml())
    assert run_here("rod.yaml", folder=folder) == 0
    with open_result(folder / "rod_history.h5") as file:
        radial = file.read("radial_m", 0)
        assert len(radial) == file.read("time_s").size
    last = np.abs(radial[-2000:]).max()
    assert 1e3 * last == pytest.approx(0.21730, rel=1e-3)


def test_one_blade_is_mistuned_in_its_frequency_alone(blade):
    with run(blade, "linear") as file:
        amplification = file.read("amplification")[0]
    np.testing.assert_allclose(amplification[0], amplification[1], rtol=1e-3)  # no neighbours
    with run(blade, "modal") as file:
        assert not file.read("reduced/nodal_diameters").any()
    with run(blade, "contact") as file:
        assert (file.read("samples/localisation") == 0.0).all()
        assert (file.read("samples/peak_amplitude_m") > 0.0).all()


def test_what_one_blade_cannot_have_is_refused(blade):
    assert "n_blades: 1 goes with disk.model" in refusal(Config.from_yaml, "disk: {n_blades: 1}")
    patterns = read("study: patterns\n" + BRIEF)
    assert "it has one blade, and patterns are of several" in refusal(run_of(patterns).checked)
    text = BRIEF.replace("half_range_percent: [4], samples: 2, ", "%s, ")
    for keys, words in (
        ("pattern: [1, 2]", "2 values given for the 1 blade of disk.model"),
        ("pattern: [2000], pattern_unit: hz", "the frequency of one blade deviates from no mean"),
    ):
        assert words in refusal(read, text % keys)
