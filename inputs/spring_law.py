"""A contact law of one's own: behind the clearance the casing is a linear spring, without friction.

`inputs/own_law.yaml` uses it; `hpcrub.contact.protocols.Law` says what every method has to do.
The force is that of the penetration p at the end of the step, N = k p for p > 0, of points that do
not move each other. A unit force moves a point out by W = R·gain·Rᵀ in a step, so that without
contact force it would be at p + W N, and N = k (p + W N)/(1 + k W).
"""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import any_lane, larger, load, store
from hpcrub.contact.passes import predict
from hpcrub.contact.tables import columns


class Spring(NamedTuple):
    """Springs of C contact points (padded) in L lanes."""

    stiffness: np.ndarray  # k/(1 + k W) (C, L) [N/m]

    k = 1e7  # [N/m]

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes, bank, step, n_active):
        """Corrector, predictor and penetrations."""
        return predict(lanes, bank, step, n_active)

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes, bank, step, deepest):
        """Forces of the springs that are pressed."""
        state, law, n = bank.state, bank.law, 0
        n_points = law.stiffness.shape[0]
        for i in range(n_points):
            depth = load(lanes, state.penetration, i)
            if any_lane(depth > 0.0):
                store(state.multiplier, i, larger(depth, 0.0) * load(lanes, law.stiffness, i))
                state.active[n] = i
                n += 1
        return n

    @staticmethod
    def per_lane():
        """All arrays have a column for each lane."""
        return Spring._fields

    @classmethod
    def allocate(cls, modes, scene, grid, width):
        """No springs yet."""
        return cls(stiffness=np.zeros((columns(modes.normal).shape[1], width)))

    @classmethod
    def loads(cls, modes, scene):
        """Modal forces of unit normal forces, which push the points away from the casing."""
        return -columns(modes.normal)

    def fill(self, bank, lane, modes, scene) -> None:
        """Springs of the points in a lane, by its step."""
        W = modes.normal**2 @ bank.scheme.gain[:, lane]
        self.stiffness[: len(W), lane] = self.k / (1.0 + self.k * W)

    def forces_on_points(self, multiplier, scene) -> tuple:
        """The multipliers are the normal forces."""
        normal = multiplier[:, : len(scene.interface.angle)]
        return normal, 0.0 * normal, normal[:, :0]

    def memory(self, lane) -> None:
        """Springs remember nothing."""

    def remember(self, lane, memory) -> None:
        """Nothing is to be remembered."""

    def steps_touched(self, lane) -> np.ndarray:
        """Contacts are not counted."""
        return np.zeros(0)
