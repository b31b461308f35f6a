"""The arrays of `solid.Solid`, which its solvers `blades`, `groups` and `friction` work on."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.lanes import TILE, lane_arrays
from hpcrub.contact.protocols import Surface


class Work(NamedTuple):
    """Space that the solver of a group of at most P points works in; empty between steps."""

    fresh: np.ndarray  # points whose column of W `friction.turn` makes (C + TILE,) int
    slipping: np.ndarray  # of these, a tile at a time (TILE,) int
    chosen: np.ndarray  # places of the points that carry a force (P,) int
    factor: np.ndarray  # matrix of their equations (P·P, L)
    right: np.ndarray  # right sides, then the solution (P, L)
    wrong: np.ndarray  # codes of the points that are not on their line (P, L)

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return "factor", "right", "wrong"

    @classmethod
    def allocate(cls, n_points: int, most: int, width: int) -> "Work":
        """For C points (padded) in groups of at most so many."""
        return cls(
            fresh=np.zeros(n_points + TILE, dtype=np.int64),
            slipping=np.zeros(TILE, dtype=np.int64),
            chosen=np.zeros(most, dtype=np.int64),
            **lane_arrays(width, factor=most**2, right=most, wrong=most),
        )


class SolidArrays(NamedTuple):
    """N blades in G groups of at most P points, C points (padded), L lanes."""

    coupling: np.ndarray  # W_ab/W_bb of listed points a and b ((C + 1)², L), row b·(C + 1) + a
    stiffness: np.ndarray  # 1 / W_jj (C, L) [N/m]
    across: np.ndarray  # largest motion of a point by a unit force on another blade (1, L) [m/N]
    points: np.ndarray  # contact points, blade by blade (n,) int
    blade: np.ndarray  # of every contact point (n,) int
    starts: np.ndarray  # place in ``points`` of the first one of every group of blades (G + 1,) int
    way: np.ndarray  # of a point along the casing in a step, R 2π/n (C,) [m]
    friction: float
    tangential: np.ndarray  # T (K, C) [1/√kg]
    axial: np.ndarray  # A (K, C) [1/√kg]
    compliance: np.ndarray  # (3·C·C, L) normal motion of i by force b on j, row 3(j·C + i) + b
    cosine: np.ndarray  # cos β (C, L) (modified)
    sine: np.ndarray  # sin β (C, L) (modified)
    # (C, L): line of the surface (1 of a hard one) where a point carried a force in its lane's last
    # contact, -1 where others kept it from the casing, else 0 (modified)
    touching: np.ndarray
    groups: np.ndarray  # starts of the groups in ``state.active`` (G + 1,) int (modified)
    turned: np.ndarray  # whether a listed point has its column of W (C,) bool (modified)
    deepest: np.ndarray  # penetration of every blade (N, L) [m] (modified)
    work: Work  # (modified)
    touched: np.ndarray  # steps in which a blade carried a force (N, L) (modified)
    surface: Surface
