"""What the laws of planar disks and of disks in three dimensions share: the surface they are of."""

from typing import Any

import numpy as np

from hpcrub.contact.arrays import Bank
from hpcrub.contact.jit import compiled
from hpcrub.contact.passes import predict
from hpcrub.contact.protocols import Surface


class SurfaceLaw:
    """A law whose points meet a surface, `hard.Hard` or `surfaces.Coated`."""

    surface: Surface

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor and penetrations; see `protocols.Law`."""
        deepest = predict(lanes, bank, step, n_active)
        return bank.law.surface.tick(lanes, bank.law.surface, deepest)

    def memory(self, lane: int) -> Any:
        """What the surface keeps; see `protocols.Law`."""
        return self.surface.memory(lane)

    def remember(self, lane: int, memory: Any) -> None:
        """Go on before a surface that has been met (modified)."""
        self.surface.remember(lane, memory)
