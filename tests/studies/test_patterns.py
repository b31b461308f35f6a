"""Patterns of blade types: beside all disks of all patterns, after a stop."""

import shutil

import h5py
import numpy as np
import pytest

from hpcrub import plot
from hpcrub.response.linear import linear_peak
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Verdict
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_problem
from hpcrub.statistics.necklaces import compare
from hpcrub.studies import open_result
from hpcrub.studies.patterns import STUDY as PATTERNS
from hpcrub.studies.patterns import Rounds, in_letters
from tests.plot.drawn import lines
from tests.program import BRIEF, computed, contents, datasets, load, run_here, swept
from tests.studies.common import refused_study

N = 192
TEXT = (
    BRIEF.replace("samples: 2", f"samples: {N}").replace("[2, 4]", "[2]")
    + """\
study: patterns
patterns: {types_percent: [3, -3], percentile: 90, kept: 2, contact_samples: 2}
disk: {n_blades: 6}
"""
)
REFUSED = {
    "mistuning.half_range_percent=[1, 2]": "a study of patterns is of one level",
    "mistuning.intentional_percent=[1, -1]": "are what is searched for",
    "patterns.contact_samples=300": "patterns.contact_samples: more than mistuning.samples",
    "patterns.types_percent=[1]": "patterns.types_percent",
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Folder with the results, and the amplifications of all disks with every pattern."""
    folder = tmp_path_factory.mktemp("patterns")
    words = contents(computed(folder, TEXT))["types"]
    config = load(folder / "study.yaml")
    problem = build_problem(config)

    def size(own):
        modes = modes_of(config, problem, own)
        face, order = problem.reduced.interface, config.engine_order
        return linear_peak(modes, config.damping, config.forcing.amplitude, order, face, 6)[0]

    every = np.array([
        [size(np.choose(word + 1, [0.0, 0.03, -0.03]) + deviation(config, 0, s)) for s in range(N)]
        for word in words
    ])  # fmt: skip
    return folder, config, every / size(np.zeros(6))


def test_what_is_left_is_among_the_best_of_all_disks_of_all_patterns(found):
    folder, _, every = found
    here = contents(folder / "one.h5")
    n, words = here["n_disks"], here["types"]
    assert [in_letters(word) for word in words[:3]] == ["no pattern", "AAAAAB", "AAAABB"]
    assert in_letters(words[-1]) == "ABBBBB"
    assert "AB x 3" in map(in_letters, words)
    for p in range(len(words)):
        np.testing.assert_allclose(here["amplification"][p, : n[p]], every[p, : n[p]], rtol=1e-9)
        assert np.isnan(here["amplification"][p, n[p] :]).all()
    left = np.flatnonzero(n[1:] == N) + 1
    known, low = compare(every[1:], 90.0)
    assert 2 <= len(left) < 8
    assert n.sum() < 0.7 * every.size
    best = left[np.argmin(here["percentile"][left])]
    assert low[best - 1] <= 0.0  # not worse than the best of all, as far as all disks tell
    np.testing.assert_allclose(here["percentile"][left], known[left - 1], rtol=1e-9)


def test_the_best_are_computed_in_contact(found):
    folder, config, _ = found
    here = contents(folder / "one.h5")
    seen = np.isfinite(here["contact_amplitude_m"]).all(axis=1)
    assert seen[0]
    assert np.count_nonzero(seen) == 3
    p = np.flatnonzero(seen)[-1]
    own = np.choose(here["types"][p], [0.03, -0.03]) + deviation(config, 0, 1)
    assert here["contact_amplitude_m"][p, 1] == swept(config, own).amplitude.max()


def test_disks_in_contact_that_are_lost_or_move_too_far_are_told(found):
    folder, *_ = found
    shutil.copy(folder / "one.h5", folder / "lost.h5")
    with open_result(folder / "lost.h5", mode="r+") as file:
        size = file.read("contact_amplitude_m")
        seen = np.flatnonzero(np.isfinite(size).all(axis=1))
        size[seen[0]], size[seen[1]] = np.nan, 0.2  # m: tips of half a metre radius
        file.write({"contact_amplitude_m": size, "deepest_m": np.where(size > 0.1, 1.0, 0.0)}, ())
        lines = Verdict.of(PATTERNS.findings(file)).lines
    assert "2 of 6 disks have no result" in lines[0]
    assert "outside small displacements, 200 mm" in lines[0]
    assert "2 of 6 disks cut through the coating" in lines[0]


@pytest.mark.long
def test_a_stop_changes_no_bit(found):
    folder, *_ = found
    first = datasets(folder / "one.h5")
    shutil.copy(folder / "one.h5", folder / "two.h5")
    with h5py.File(folder / "two.h5", "r+") as file:  # as if it had been stopped on its way
        for name in ("amplification", "least_damping_ratio", "contact_amplitude_m"):
            file[name][3:] = np.nan
        for name in ("status", "contact_status"):
            file[name][3:] = 0
    assert run_here("study.yaml", "--output", "two.h5", "--resume", folder=folder) == 0
    assert datasets(folder / "two.h5") == first


AIR = """\
mistuning: {half_range_percent: [0.5], samples: 64}
aero:
  influence:
    - {blades: 0, damping_ratio: %s}
    - {blades: 1, damping_ratio: 0.002, frequency_shift: 0.0024}
    - {blades: -1, damping_ratio: -0.002, frequency_shift: -0.0021}
"""  # a wave of one diameter has its mean less 0.0045 sin 60°; no pattern moves the mean


@pytest.mark.parametrize(("own", "stays"), [(0.003, True), (-0.001, False)])
@pytest.mark.long
def test_where_the_tuned_disk_flutters_patterns_have_amplitudes_and_say_so(
    tmp_path, capsys, own, stays
):
    base = TEXT.replace("contact_samples: 2", "contact_samples: 0")
    base = "".join(line for line in base.splitlines(True) if not line.startswith("mistuning"))
    here, out = contents(computed(tmp_path, base + AIR % own)), capsys.readouterr().out
    flutter = here["least_damping_ratio"] <= 0.0
    seen = np.isfinite(here["least_damping_ratio"])
    assert flutter[0].all()
    assert np.isnan(here["amplification"][flutter]).all()
    assert (here["amplification"][seen & ~flutter] > 0.1).all()
    assert "without a pattern infinite (flutter)" in out
    assert ("disks of the best pattern flutter" in out) != stays
    assert ("Verdict: not usable: 64 of 64 disks" in out) != stays
    with ResultFile(tmp_path / "one.h5") as file:
        known, left = here["percentile"], Rounds(file).left
        triangles = [line for line in lines(plot.patterns(file)[1]) if len(line) == 1][1::2]
    np.testing.assert_array_equal(np.array(triangles)[:, 0, 0], known[[*left, 0]])
    assert np.isinf(known[0])


@pytest.mark.parametrize("override", REFUSED)
def test_what_cannot_be_searched_is_refused(folder, override, capsys):
    assert REFUSED[override] in refused_study(folder, TEXT, override, capsys)
