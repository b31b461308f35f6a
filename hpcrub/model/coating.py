"""An elastic casing, and a coating on the casing that wears."""

from typing import NamedTuple

import numpy as np


class ElasticCasing(NamedTuple):
    """Spring and damper at every contact point: N = k p + d ṗ ≥ 0, p the penetration."""

    stiffness: float  # k [N/m]
    damping: float = 0.0  # d [N s/m]


class Coating(NamedTuple):
    """Abradable coating: bars of an elastic plastic material that carry pressure only.

    The plastic strain of a bar is what has been worn away. Legrand, Batailly, Magnain, Cartraud,
    Pierre (2012), section 2.3, and Batailly, Agrapart, Millecamps, Brunel (2016).
    """

    thickness: float  # t [m]
    young: float  # E [Pa]
    yield_stress: float  # σ_Y [Pa]
    hardening: float  # H [Pa]
    area: float  # area of a blade's tip, shared by its contact points [m²]
    width: float = 0.0  # axial width of the coating [m]

    @property
    def kept(self) -> float:
        """Share of a penetration beyond yield that is worn away, E/(E + H) [-]."""
        return self.young / (self.young + self.hardening)

    @property
    def depth_at_yield(self) -> float:
        """Penetration at which the new coating begins to wear, σ_Y t/E [m]."""
        return self.yield_stress * self.thickness / self.young

    @property
    def worn_through(self) -> float:
        """Worn depth at which a tip reaches the casing behind [m]; the rest is compacted."""
        return self.kept * max(0.0, self.thickness - self.depth_at_yield)

    def energy(self, worn: np.ndarray) -> np.ndarray:
        """Energy per area [J/m²] that worn depths [m] have taken, of any shape."""
        return (self.yield_stress + self.hardening * worn / (2.0 * self.thickness)) * worn

    def stiffnesses(self, area: float) -> tuple[float, float, float]:
        """Constants of a bar [m²] with force k₁ p, beyond yield k₂ p + c₀: k₁, k₂ [N/m], c₀ [N]."""
        before = self.young * area / self.thickness
        start = before * self.depth_at_yield * self.kept
        return before, before * self.hardening / (self.young + self.hardening), start
