"""Quantities of every speed of a sweep, each declared once: name, unit, meaning, value at rest.

A class of quantities is a dataclass derived from `Quantities`, with a field of the function
`quantity` for each array. Result files, figures and reports take names and units from there.
"""

import dataclasses
from typing import Any, NamedTuple, Self

import numpy as np


class Quantity(NamedTuple):
    """One quantity of a speed, as it stands in result files."""

    name: str  # of its dataset, with the unit
    units: str
    description: str
    dtype: str = "f8"
    at_rest: float = 0.0  # value where no blade can touch the casing


def quantity(*of_quantity: Any, **more: Any) -> Any:
    """Field of a class of `Quantities`; arguments as for `Quantity`."""
    return dataclasses.field(metadata={"quantity": Quantity(*of_quantity, **more)})


class Quantities:
    """Arrays with a row for every speed, and further `Quantities` as parts."""

    @classmethod
    def declared(cls) -> dict[str, Quantity]:
        """Return {field: Quantity} of the arrays, without those of parts."""
        fields: Any = dataclasses.fields(cls)  # type: ignore[arg-type]  # subclasses are dataclasses
        return {f.name: f.metadata["quantity"] for f in fields if "quantity" in f.metadata}

    @classmethod
    def empty_arrays(cls, n: int, **shapes: tuple[int, ...]) -> dict[str, Any]:
        """Return {field: array} of n speeds that are not integrated yet: NaN, and 0 for codes.

        shapes: {field: shape of the quantity at one speed}, () by default.
        """
        return {
            field: np.full((n, *shapes.get(field, ())), np.nan if of.dtype == "f8" else 0, of.dtype)
            for field, of in cls.declared().items()
        }

    @property
    def parts(self) -> list["Quantities"]:
        """Further quantities that belong to these."""
        return [part for part in vars(self).values() if isinstance(part, Quantities)]

    def by_name(self) -> dict[str, np.ndarray]:
        """Return {name of the dataset: array} of all quantities, those of the parts included."""
        own = {of.name: getattr(self, field) for field, of in self.declared().items()}
        for part in self.parts:
            own |= part.by_name()
        return own

    def take(self, speeds: Any, other: Self) -> None:
        """Copy the values at some speeds (an index) from another result (self is modified)."""
        new = other.by_name()
        for name, values in self.by_name().items():
            values[speeds] = new[name][speeds]

    def rest(self, speeds: Any) -> None:
        """Write the values at rest at some speeds (an index), without those of the parts."""
        for field, of in self.declared().items():
            getattr(self, field)[speeds] = of.at_rest
