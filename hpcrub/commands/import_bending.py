"""The folder of `hpcrub import model --second-order`: one blade, and the same blade bent."""

from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model.imported import bending, neutral
from hpcrub.model.imported.assembly import PAIRING
from hpcrub.model.imported.bent_blades import MOST
from hpcrub.model.imported.neutral import NeutralModel
from hpcrub.model.imported.readers.text import columns
from hpcrub.results import model_file

COLUMNS = "x", "y", "z", "ux", "uy", "uz"


def with_second_order(model: NeutralModel, folder: Path, length: float) -> NeutralModel:
    """A model with the second order of its blades, which `folder` tells.

    It holds model files of one blade alone, `blade.h5`, and of the same blade bent into its modes,
    `forwards_1.h5`, `backwards_1.h5`, and so on, and `bent_1.csv`, ..., with the displacements of
    all nodes forwards: x, y, z, ux, uy, uz. length: unit of these tables [m]. Raises InputError.
    """
    blade = _blade(folder / "blade.h5")
    shapes = []
    for number in range(1, MOST + 2):
        if not (table := folder / f"bent_{number}.csv").exists():
            break
        both = (_blade(folder / f"{way}_{number}.h5") for way in ("forwards", "backwards"))
        shapes.append(bending.BentShape(_moved(table, blade, length), *both))
    if not shapes:
        raise InputError(f"--second-order: there is no {folder / 'bent_1.csv'}")
    return bending.onto(model, blade, bending.of_blade(blade, shapes))


def _blade(path: Path) -> NeutralModel:
    model = neutral.from_arrays(model_file.read(path))
    if model.kind != "disk" or model.n_blades != 1:
        raise InputError(
            f"{path}: one blade alone is expected, a model of kind disk with one blade; import it "
            "without --sectors and --reduce, its deck also as --blade"
        )
    return model


def _moved(path: Path, blade: Any, length: float) -> Any:
    """Displacements of all nodes of the blade (n_nodes, 3) [m] from a table of places."""
    from scipy.spatial import cKDTree  # slow to import, and needed by imports only

    values = length * columns(path, COLUMNS)
    placed = np.flatnonzero(np.isfinite(blade.nodes).all(axis=1))
    own = np.intersect1d(placed, blade.dof[:, 0])  # held nodes need not be told
    apart, nearest = cKDTree(values[:, :3]).query(blade.nodes[own])
    worst = int(apart.argmax())
    if not apart[worst] <= PAIRING * np.abs(blade.nodes[placed]).max():
        x, y, z = 1e3 * blade.nodes[own[worst]]
        raise InputError(
            f"{path}: no row for the node at {x:.6g}, {y:.6g}, {z:.6g} mm, the nearest is "
            f"{1e3 * apart[worst]:.3g} mm away; is the table in the units of --table-units, and in "
            "the axes of the model file, about z?"
        )
    moved = np.zeros_like(blade.nodes)
    moved[own] = values[nearest, 3:]
    return moved
