"""Protocols of the kernel: members of a scene, a grid of time steps, a contact law.

Any class with these members fits, wherever it is defined: `response.scene.Scene.law` also takes the
class of a law from a notebook.
"""

# ruff: noqa: D102, E704

from typing import Any, Protocol

import numpy as np

from hpcrub.contact.arrays import Bank
from hpcrub.model.casing import CasingShape
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.damping import Damping
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import Rows


class Grid(Protocol):
    """Division of a revolution into time steps and blocks."""

    @property
    def steps_per_revolution(self) -> int:
        """Time steps of a revolution."""

    @property
    def steps_per_block(self) -> int:
        """Time steps of a block."""


class Scene(Protocol):
    """Casing, contact and load at one speed; members as in `response.scene.Scene`."""

    @property
    def interface(self) -> Interface: ...
    @property
    def damping_ratio(self) -> float | Damping: ...
    @property
    def casing(self) -> CasingShape: ...
    @property
    def clearance(self) -> float: ...
    @property
    def ramp_time(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def load(self) -> float: ...
    @property
    def load_order(self) -> int: ...
    @property
    def elastic_casing(self) -> ElasticCasing | None: ...
    @property
    def coating(self) -> Coating | None: ...
    @property
    def law(self) -> "type[Law] | None": ...
    @property
    def scheme(self) -> str: ...
    @property
    def observes_stress(self) -> bool: ...
    def at(self, speed_hz: float) -> "Scene": ...


class Law(Protocol):
    """Contact law, the forces of the casing on the tips: a NamedTuple of arrays with these methods.

    The class chooses the code when the kernel is compiled, so that no scene compiles or pays for
    another law. `laws.planar.Planar` is the law of planar disks, `laws.solid.Solid` the law of
    disks that move in three dimensions. `predict` and `forces` are compiled, and may call further
    compiled static methods of the class, by any name.
    """

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays whose last axis is the lanes, and of groups of such arrays.

        They are zero in an idle lane, and the law must give this lane no force.
        """

    @classmethod
    def allocate(cls, rows: Rows, scene: Scene, grid: Grid, width: int) -> "Law":
        """Make the arrays of the law for idle lanes."""

    @classmethod
    def loads(cls, rows: Rows, scene: Scene) -> np.ndarray:
        """Modal forces of unit multipliers (K, F), in the order of `State.multiplier`."""

    def fill(self, bank: Bank, lane: int, rows: Rows, scene: Scene) -> None:
        """Fill the arrays of a lane for its speed and step; they are zero before."""

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Scene
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces of recorded multipliers (R, F, L) [N]."""

    def steps_touched(self, lane: int) -> np.ndarray:
        """Number of steps in which each blade carried a force; (0,) if not counted."""

    def memory(self, lane: int) -> Any:
        """State from which a later run of the lane goes on, beside its motion; or None."""

    def remember(self, lane: int, memory: Any) -> None:
        """Restore a `memory`, not None, in a lane that has just been filled."""

    @staticmethod
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector of the step before, predictor and penetrations of this step.

        Returns the deepest penetration (L,) [m]. `passes.predict` serves most laws.
        """

    @staticmethod
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Multipliers of a step in which a point penetrates.

        Returns how many rows of `State.multiplier` the corrector has to apply, which `State.active`
        lists.
        """
