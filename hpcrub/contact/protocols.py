"""What the contact room asks of the scene and of the grid of time steps, wherever they are made."""

# ruff: noqa: D102, E704

from typing import Any, Protocol

from hpcrub.model.casing import CasingShape
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.damping import Damping
from hpcrub.model.interface import Interface


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
    def law(self) -> Any: ...
    @property
    def scheme(self) -> str: ...
    @property
    def observes_stress(self) -> bool: ...
    def at(self, speed_hz: float) -> "Scene": ...
