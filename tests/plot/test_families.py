"""What tells several result files from each other: words, order, the reference.

Truth: the words a reader expects.
"""

from pathlib import Path
from types import SimpleNamespace

import pytest
from matplotlib.ticker import EngFormatter

from hpcrub.config.schema import load_runs
from hpcrub.plot.families import labels, ordered, reference


def family(tmp_path, *sweep):
    """Stand-ins for the result files of a sweep."""
    path = tmp_path / "input.yaml"
    path.write_text("study: contact\nruns:\n" + "".join(f"  - {{{keys}}}\n" for keys in sweep))
    return [
        SimpleNamespace(config=c, path=Path(c.output), attributes={"time_step_s": c.step})
        for c in load_runs(path)
    ]


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        (("time.step_s: 1e-5", "time.step_s: 1e-6", "time.step_s: 2e-5", "time.step_s: 2e-6"),
         ("step 1 µs", "step 2 µs", "step 10 µs", "step 20 µs")),
        (("reduction.n_modes: 120", "reduction.n_modes: 36"), ("modes 36", "modes 120")),
        (("casing.n_bumps: 10", "casing.n_bumps: 3, speeds.from_hz: 9"),
         ("$n_d$ = 3", "$n_d$ = 10")),
        (("casing.clearance_mm: 0.25", "casing.clearance_mm: 0.2, casing.bump_height_mm: 1.2"),
         ("clearance 0.20 mm, bump height 1.20 mm", "clearance 0.25 mm, bump height 1.25 mm")),
        (("material.density_kg_m3: 8e3", "material.density_kg_m3: 7.8e3"),
         ("density 7800.0 kg/m³", "density 8000.0 kg/m³")),
        (("time.scheme: central_difference", "disk.blade.lean_deg: -50", "contact.friction: 0.15",
          "contact.friction: 0.2", "disk.n_blades: 9", "steady_state.min_correlation: 0.9"),
         ("blades 9", "lean -50.00°", "scheme central difference", "min correlation 0.90",
          "reference", "friction 0.20")),
        (("casing.n_bumps: 4",), ("n_bumps=4",)),
    ],
)  # fmt: skip
def test_a_family_is_told_apart_by_quantities_in_the_order_of_their_numbers(tmp_path, sweep, words):
    assert tuple(labels(ordered(family(tmp_path, *sweep)))) == words


@pytest.mark.parametrize(
    ("sweep", "number"),
    [
        (("time.step_s: 1e-5", "time.step_s: 2e-6"), 1),
        (("reduction.n_modes: 120", "reduction.n_modes: 60"), 0),
        (("casing.clearance_mm: 0.2", "casing.clearance_mm: 0.25"), 1),
        (("time.scheme: central_difference", "disk.ring_thickness_mm: 12", "seed: 1"), None),
    ],
)
def test_the_reference_is_the_finest_or_the_default(tmp_path, sweep, number):
    sweep = sweep if number is not None else (*sweep[:2], "mistuning.seed: 2020")
    files = family(tmp_path, *sweep)
    assert reference(files) is files[2 if number is None else number]


def test_a_step_that_is_only_a_bound_does_not_tell_files_apart(tmp_path):
    """Bumps allow 44 µs: both files are computed with that, and one with less."""
    sweep = "time.step_s: 1e-4", "time.step_s: 5e-5", "time.step_s: 2e-5"
    files = family(tmp_path, *sweep)
    used = "step " + EngFormatter("s")(files[0].config.step)
    assert labels(files) == [used, used, "step 20 µs"]
