"""What the kernel asks of a scene, a grid of time steps, a contact law and a surface.

Any class that has the members fits, wherever it stands: a law of one's own may be in a notebook,
and `response.scene.Scene.law` takes its class.
"""

# ruff: noqa: D102, E704

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from hpcrub.contact.arrays import Bank
from hpcrub.model.casing import CasingShape
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.damping import Damping
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import Modes


class Grid(Protocol):
    """How a revolution is cut."""

    @property
    def steps_per_revolution(self) -> int:
        """Time steps of a revolution."""

    @property
    def steps_per_block(self) -> int:
        """Time steps of a block."""


class Scene(Protocol):
    """Casing, contact and load at one speed; members as of `response.scene.Scene`."""

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
    """Which forces the casing exerts on the tips: a NamedTuple of arrays with these methods.

    Its class chooses the code when the kernel is compiled, so that no scene compiles or pays for
    another law. `laws.planar.Planar` is the law of planar disks, `laws.solid.Solid` that of disks
    that move in three dimensions. `predict` and `forces` are compiled.
    """

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of its arrays whose last axis are the lanes, and of groups of such arrays.

        They are zero in an idle lane, which must then get no force.
        """

    @classmethod
    def allocate(cls, modes: Modes, scene: Scene, grid: Grid, width: int) -> "Law":
        """State of idle lanes."""

    @classmethod
    def loads(cls, modes: Modes, scene: Scene) -> np.ndarray:
        """Modal forces of unit multipliers (K, F), columns as `State.multiplier` but its last."""

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Scene) -> None:
        """Give a lane what depends on its speed and step; its arrays are zero before."""

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Scene
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces of recorded multipliers (R, F, L) [N]."""

    def steps_touched(self, lane: int) -> np.ndarray:
        """Steps in which every blade carried a force, (0,) if the law does not count them."""

    def memory(self, lane: int) -> Any:
        """What a later run of the lane goes on from beside its motion; None if it is nothing."""

    def remember(self, lane: int, memory: Any) -> None:
        """Give a `memory` that is not None to a lane that has just been filled."""

    @staticmethod
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector of the step before, predictor and penetrations of this one.

        Returns (L,); the deepest penetration [m]. `passes.predict` serves most laws.
        """

    @staticmethod
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Multipliers of a step in which something penetrates.

        Returns the rows of `State.multiplier` that the corrector has to apply, listed in
        `State.active`.
        """


class Coupled(Protocol):
    """What `lcp.gauss_seidel` asks of a law that calls it; members as of `laws.planar.Planar`."""

    @property
    def coupling(self) -> np.ndarray: ...
    @property
    def stiffness(self) -> np.ndarray: ...
    @property
    def bound(self) -> np.ndarray: ...
    @property
    def surface(self) -> "Surface": ...


class Surface(Protocol):
    """What the points of `Planar` and `Solid` meet: `laws.hard.Hard` or `laws.surfaces.Coated`.

    `Coated` says what every method does. A step calls the compiled static methods in this order;
    `press` is all that a planar disk needs, those after it serve a disk in three dimensions.
    """

    def fill(self, lane: int, scene: Scene, h: float, compliance: np.ndarray) -> None: ...
    def memory(self, lane: int) -> Any: ...
    def remember(self, lane: int, memory: Any) -> None: ...

    @property
    def tick(self) -> Callable[..., np.ndarray]: ...
    @property
    def meet(self) -> Callable[..., np.ndarray]: ...
    @property
    def press(self) -> Callable[..., int]: ...
    @property
    def near(self) -> Callable[..., np.ndarray]: ...
    @property
    def relieve(self) -> Callable[..., None]: ...
    @property
    def follow(self) -> Callable[..., tuple]: ...
    @property
    def line(self) -> Callable[..., tuple]: ...
    @property
    def check(self) -> Callable[..., np.ndarray]: ...
    @property
    def comply(self) -> Callable[..., None]: ...
    @property
    def despair(self) -> Callable[..., None]: ...
    @property
    def wear(self) -> Callable[..., None]: ...
    @property
    def keep(self) -> Callable[..., None]: ...
    @property
    def total(self) -> Callable[..., np.ndarray]: ...
