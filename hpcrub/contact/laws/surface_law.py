"""Base class of the laws of planar disks and of disks in three dimensions, with a surface."""

from typing import Any

import numpy as np

from hpcrub.contact.arrays import Bank
from hpcrub.contact.jit import compiled
from hpcrub.contact.laws.surfaces import Surface
from hpcrub.contact.passes import predict


class SurfaceLaw:
    """A law whose points meet a surface, `hard.Hard` or `surfaces.Coated`."""

    surface: Surface

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor and penetrations, then the surface's `advance_clock`."""
        deepest = predict(lanes, bank, step, n_active)
        return bank.law.surface.advance_clock(lanes, bank.law.surface, deepest)

    def memory(self, lane: int) -> Any:
        """Memory of the surface; see `protocols.Law`."""
        return self.surface.memory(lane)

    def remember(self, lane: int, memory: Any) -> None:
        """Restore the memory of the surface (modified)."""
        self.surface.remember(lane, memory)
