"""What is said of a worn coating, against numbers that can be had by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from evidence.truth.disk import reference_reduced, reference_scene
from hpcrub.config.schema import Config
from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.model.casing import CasingShape
from hpcrub.model.coating import Coating
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response import wear
from hpcrub.response.ensemble import Recent, Verdict
from hpcrub.response.history import Follower, integrate
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import Motion, run_sweep
from hpcrub.setup.problem import coating_of
from tests.contact.laws.test_coating import KINDS, rubbing
from tests.program import whole

COATING = Coating(5e-3, 1e9, 15e6, 2e8, 1.4e-3, 0.1)
SPEEDS = np.array([33.4, 33.9, 34.4])


def around(*waves, n_bars=960):
    phi = 2.0 * np.pi * np.arange(n_bars) / n_bars
    return 1e-3 + sum(size * np.cos(order * phi) for order, size in waves)[None]


def test_volume_and_energy_of_an_even_groove():
    """A groove of depth w on a circle: 2πRbw; (σ_Y + H w/2t) w of energy for each area."""
    volume, energy = wear.worn_away(np.full((3, 840), 1e-3), COATING, 0.5)
    assert abs(volume / (2 * np.pi * 0.5 * 0.1 * 1e-3) - 1.0) < 1e-12
    each = (15e6 + 2e8 * 1e-3 / 10e-3) * 1e-3
    assert abs(energy / (2 * np.pi * 0.5 * 0.1 * each) - 1.0) < 1e-12


def test_one_contact_node_on_a_blade_does_not_tell_the_volume():
    keys = {"law": "abradable", "coating": {"tip_area_mm2": 100}}
    config = Config(disk={"model": "any.h5"}, contact=keys)
    coating = coating_of(config, reference_reduced().interface)
    assert np.isnan(wear.worn_away(np.full((1, 840), 1e-3), coating, 0.5)).all()


def test_lobes_are_those_beyond_what_blades_at_rest_cut():
    scene = reference_scene(coating=COATING)
    at_rest = wear.cut_at_rest(scene, 1, 960)
    assert abs(at_rest.max() - COATING.kept * (1e-3 - COATING.depth_at_yield)) < 1e-15
    assert (np.diff(np.flatnonzero(at_rest == at_rest.max())) == 240).all()
    assert wear.lobes(at_rest, scene) == 0
    assert wear.lobes(at_rest + around((7, 2e-4), (9, 5e-5)), scene) == 7
    assert wear.lobes(around((4, 9e-4), (7, 1e-4)), scene) == 4
    round_ = scene._replace(casing=scene.casing._replace(bump_height=0.0))
    assert wear.lobes(around((7, 0.0)), round_) == 0
    assert wear.lobes(np.zeros((1, 960)), scene) == 0


def test_lobes_of_an_interaction_are_the_vibrations_in_a_turn():
    """Whether the two bumps have that order or not; just above the speeds f/k, not between."""
    own = 150.0  # frequency of the one blade [Hz]
    modes = Modes.planar(np.array([2.0 * np.pi * own]), np.eye(1), np.eye(1))
    cuts = Coating(5e-3, 1e8, 1e5, 2e7, 1e-4, 0.02)
    scene = Scene(
        planar_interface(np.zeros(1), 0.5), 5e-4, CasingShape(2, 0.5e-3), 0.25e-3, 0.05, 0.0,
        coating=cuts, step=2e-5, scheme="exact_modal", steady=SteadyCriteria(max_time=3.0),
    )  # fmt: skip
    speeds = own / np.array([2.85, 3.25, 3.75, 4.25, 4.75, 5.25, 5.65, 6.2, 6.65])
    worn = run_sweep(modes, scene, speeds).wear
    grows = worn.amplitude > 1e-3
    assert list(worn.lobes[grows]) == [3, 4, 5, 6, 7]
    assert set(worn.lobes[~grows]) <= {0, 2}
    assert (worn.depth[~grows] < 0.25e-3).all()
    for speed, end, n_lobes in zip(speeds[grows], worn.time[grows], worn.lobes[grows], strict=True):
        time, u = (part[..., 0].ravel()
                   for part in whole(modes, scene, [speed], end, "time", "observed"))  # fmt: skip
        turns = time > time[-1] - 20.0 / speed
        size = np.abs(np.fft.rfft(u[turns] - u[turns].mean()))
        assert size.argmax() / 20.0 == n_lobes


def test_depths_around_the_casing_are_the_largest_of_their_part():
    worn = np.zeros((2, 1008))
    worn[1, 500] = 2e-3
    even, found = wear.around(worn)
    assert not even.any()
    assert found.argmax() == 500 * wear.N_ANGLES // 1008
    assert found.max() == found.sum() == 2e-3


def test_a_run_ends_when_nothing_has_worn_for_ten_revolutions():
    rule = SimpleNamespace(verdict=None)
    rule.look = lambda *windows: rule.verdict
    followed = wear.Wearing(rule, None)
    for revolution in range(0, 40, 3):
        followed.see(1.0 + revolution, 0.1 * revolution)
        followed.keep(revolution, np.array([1.0 * revolution]))
    assert followed.growth == 12.0  # the last depth that is ten revolutions old or more
    exactly = wear.Wearing(rule, None)
    for revolution in (0, 1, 11):
        exactly.keep(revolution, np.array([1.0 * revolution]))
    assert exactly.growth == 10.0
    rule.verdict = Verdict(STEADY, np.ones(1), 1.0, 0.0, 0.0)
    still, moving = (Recent(np.full((2, 1), size), None, None) for size in (0.3, 2.0))
    assert followed.look(still, 9.0, over=False) is None
    assert followed.look(still, 9.0, over=True).status == NOT_STEADY
    for revolution in range(40, 60, 3):
        followed.see(2.0, 0.1 * revolution)
        followed.keep(revolution, np.array([39.0]))
    assert followed.growth == 0.0
    assert followed.look(moving, 9.0, over=False) is rule.verdict
    rule.verdict = None
    assert followed.look(moving, 9.0, over=False) is None
    died = followed.look(still, 9.0, over=False)
    assert (died.status, died.amplitude) == (STEADY, 0.3)
    assert (followed.largest, round(followed.time, 9)) == (40.0, 3.9)


def disk_and_scene(max_time, **changes):
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.02, 0.02, 12))
    how = {"step": 2.9e-5, "scheme": "exact_modal", "coating": COATING}
    return modes, reference_scene(steady=SteadyCriteria(max_time=max_time), **how, **changes)


def swept(max_time, selection=None, **changes):
    return run_sweep(*disk_and_scene(max_time, **changes), SPEEDS, selection=selection)


def test_a_run_ends_when_nothing_wears_and_moves_or_says_so():
    """The motion that the bumps start grows while it cuts, and dies once enough is cut."""
    whole, cut = swept(4.0), swept(0.3)
    assert (whole.point_status == STEADY).all()
    assert (whole.time < 4.0).all()
    assert (whole.wear.growth <= wear.ENDED * whole.wear.depth).all()
    assert (whole.wear.amplitude > 1e-2).all()
    assert (whole.wear.time < 0.5).all()
    assert (cut.point_status == NOT_STEADY).all()
    assert (cut.wear.depth <= whole.wear.depth).all()
    assert np.array_equal(whole.wear.around.max(axis=(1, 2)), whole.wear.depth)


def test_a_history_wears_as_the_sweep_does():
    """What is worn at the end of a history is what a sweep of its time says, bit for bit.

    But for the displacement, which the history knows of its records alone.
    """
    modes, scene = disk_and_scene(0.3)
    swept = run_sweep(modes, scene, SPEEDS[1:2])
    duration, depths = float(swept.time[0]), []
    followed = Follower(modes, scene, SPEEDS[1], duration)
    for piece in integrate(modes, scene, SPEEDS[1:2], duration):
        followed.take(piece, 0)
        depths.append(piece.worn[0].max())
    assert depths[-1] == swept.wear.depth[0] > 1e-3
    assert (np.diff(depths) >= 0.0).all()
    for name, values in vars(followed.wear).items():
        tolerance = {"rel": 2e-3} if name in ("amplitude", "time") else {"rel": 0.0, "abs": 0.0}
        assert values[0] == pytest.approx(getattr(swept.wear, name)[0], **tolerance), name
    assert followed.verdict.status == swept.point_status[0] == NOT_STEADY


@pytest.mark.parametrize("name", ["planar coated", "spatial coated", "spatial both"])
def test_a_history_goes_on_before_the_coating_it_has_worn(name):
    """In pieces that end within a turn, and after a turn: the same as at once, unless forgotten."""
    modes, scene, speed = rubbing(*KINDS[name])
    at_once = list(integrate(modes, scene, [speed], 3.0 / speed))
    expected = np.concatenate([piece.position for piece in at_once])
    for kept in (True, False):
        motion, pieces = Motion.at_rest(1, len(modes.omega)), []
        for turns in (0.5, 1.25, 1.25):
            pieces += integrate(modes, scene, [speed], turns / speed, motion)
            motion.memory[:] = motion.memory if kept else None
        found = np.concatenate([piece.position for piece in pieces])[: len(expected)]
        off = np.abs(found - expected).max() / np.abs(expected).max()
        assert (off < 1e-9) if kept else (off > 1e-3)
        assert not kept or np.ptp([part[-1].worn[0].max() for part in (pieces, at_once)]) < 1e-12
