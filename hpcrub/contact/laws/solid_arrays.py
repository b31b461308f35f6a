"""The arrays of `solid.Solid`, which its solvers `blades`, `active_set` and `friction` work on."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.laws.bent import Bent
from hpcrub.contact.laws.small import Small
from hpcrub.contact.laws.surfaces import Surface


class SolidArrays(NamedTuple):
    """Arrays for N blades with P points each, C points in all (padded), L lanes."""

    coupling: np.ndarray  # W_ab/W_bb of listed points a and b ((C + 1)², L), row b·(C + 1) + a
    stiffness: np.ndarray  # 1 / W_jj (C, L) [N/m]
    across: np.ndarray  # largest motion of other blades' points by a unit force (C, L) [m/N]
    jams: np.ndarray  # 1 where friction in some direction would make a point jam, else 0 (1, L)
    points: np.ndarray  # contact points, blade by blade (n,) int
    blade: np.ndarray  # blade of every contact point (n,) int
    first: np.ndarray  # place in ``points`` of the first point of every blade (N + 1,) int
    way: np.ndarray  # way of a point along the casing in a step by rotation, R 2π/n (C,) [m]
    friction: float  # coefficient of friction [-]
    tangential: np.ndarray  # T (K, C) [1/√kg]
    axial: np.ndarray  # A (K, C) [1/√kg]
    # normal motion by force d of the point in place j of a blade, of that in place i, s blades on:
    # row 3·((s·P + j)·P + i) + d (3·N·P·P, L). In the dense basis all points are of one blade.
    compliance: np.ndarray
    sector: np.ndarray  # blade of every point in these terms (C,) int
    place: np.ndarray  # its place on this blade (C,) int
    n_sectors: int  # N
    n_places: int  # P
    cosine: np.ndarray  # cos β (C, L) (modified)
    sine: np.ndarray  # sin β (C, L) (modified)
    # (C, L): code of the surface's line (1 on a rigid casing) where a point carried a force in the
    # last contact of its lane, -1 where other points held it out of the casing, else 0 (modified)
    touching: np.ndarray
    turned: np.ndarray  # 1 where a listed point's column of W is filled, else 0 (C,) int (modified)
    deepest: np.ndarray  # deepest penetration of every blade (N, L) [m] (modified)
    touched: np.ndarray  # number of steps in which a blade carried a force (N, L) (modified)
    surface: Surface
    kinematics: Small | Bent
    # Work space of the solver, which no step reads from another
    fresh: np.ndarray  # places of points whose column of W `friction.turn` fills (C + 1,) int
    chosen: np.ndarray  # places of the points that carry a force (C,) int
    equations: np.ndarray  # equations of the chosen points, each with its right side (C·(C + 1), L)
    depths: np.ndarray  # solution of the equations (C, L) [m]
    undone: np.ndarray  # depth x that the force on each listed point undoes (C, L) [m]
    # depth that a trial leaves [m], then 1 + right code of a point off its line, else 0 (C, L)
    wrong: np.ndarray
