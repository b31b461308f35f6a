"""Second order of a blade: CalculiX bends it into its modes; what solid elements say exactly.

CalculiX: a static step with geometric nonlinearity moves all nodes in proportion to a mode, and the
next one stores the stiffness about it. Any amplitude gives the same, for this stiffness is a
polynomial of second degree in the displacements.

`python -m evidence.second_order` holds a straight blade of CalculiX's against the theory of beams.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from evidence import calculix
from evidence.calculix import Mesh
from evidence.rotor67.mesh import PLACES
from hpcrub.model.imported import assembly, bending, neutral
from hpcrub.model.imported.bent_blades import BentBlades
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cartesian
from hpcrub.model.imported.neutral import NeutralModel
from hpcrub.model.imported.readers import calculix as reader
from hpcrub.model.imported.readers.rows import Lists

N_BENT = 3
LARGEST = 1.0  # displacement [mm]
LIMIT = 1e-3  # of the difference from a beam


def by_calculix(
    mesh: Mesh, read: Callable[[Path], NeutralModel], folder: Path
) -> tuple[NeutralModel, BentBlades]:
    """One blade alone by CalculiX, and its second order.

    mesh: its blade elements are the blade, its set root is held; read: function from the path of a
    deck, whose matrices CalculiX has written, to a model of this blade.
    """

    def solved(name, steps):
        path = folder / f"{name}.inp"
        calculix.solve(path, mesh, steps, blade=True)
        return read(path)

    blade = solved("held", calculix.held(mesh.sets["root"]) + calculix.STEP + calculix.STORE)
    shapes = []
    for number, moved in enumerate(modes(blade, N_BENT), 1):
        forwards = solved(f"bent_{number}_forwards", bent(mesh, moved))
        backwards = solved(f"bent_{number}_backwards", bent(mesh, -moved))
        shapes.append(bending.BentShape(1e-3 * moved, forwards, backwards))
    return blade, bending.of_blade(blade, shapes)


def modes(blade: NeutralModel, n_modes: int) -> np.ndarray:
    """First modes of a blade: displacements x, y, z (n_modes, n, 3), LARGEST at most [mm]."""
    alone = assembly.assemble(blade)
    phi = lowest_modes(alone.stiffness[0].tocsc(), alone.mass.tocsc(), n_modes)[1]
    moved = np.where(alone.row[..., None] >= 0, phi[alone.row], 0.0)  # (n, 3, n_modes)
    moved = to_cartesian(np.nan_to_num(alone.nodes), moved).transpose(2, 0, 1)
    return moved * (LARGEST / np.linalg.norm(moved, axis=2).max(axis=1))[:, None, None]


def bent(mesh: Mesh, moved: np.ndarray) -> str:
    """Steps that store the stiffness about displacements of all nodes (n, 3) [mm], root held."""
    root = mesh.sets["root"]
    free = np.setdiff1d(np.unique(mesh.elements[mesh.blade_elements]), root)
    rows = [f"{n + 1}, {d}, {d}, {moved[n, d - 1]:.12e}\n" for n in free for d in (1, 2, 3)]
    state = calculix.held(root) + calculix.STATIC + "*BOUNDARY\n" + "".join(rows) + calculix.END
    return state + calculix.PERTURBED + calculix.held(root, ", OP=NEW") + calculix.STORE


def beam(length: float = 400.0, width: float = 6.0, height: float = 10.0, n: int = 32) -> Mesh:
    """A straight blade along x of elements with 20 nodes, from x = 100 [mm].

    Two by two in its section: one alone has shapes that strain none of its integration points.
    """
    at = np.array(list(np.ndindex(2 * n + 1, 5, 5)))
    corners = 2 * np.array(list(np.ndindex(n, 2, 2)))
    cells = corners[:, None] + PLACES[:, [2, 0, 1]]
    number = np.ravel_multi_index(np.moveaxis(cells, 2, 0), (2 * n + 1, 5, 5))
    used, elements = np.unique(number, return_inverse=True)
    nodes = at[used] * [length / (2 * n), width / 4, height / 4] + [100.0, -width / 2, -height / 2]
    x, outer = nodes[:, 0], np.isin(at[used][:, 1:], (0, 4)).all(axis=1)
    sets = {"root": np.flatnonzero(x == x.min()), "tip": np.flatnonzero((x == x.max()) & outer)}
    return Mesh(nodes, elements.reshape(-1, 20), sets, np.arange(len(cells)))


def straight(folder: Path) -> float:
    """Largest difference from u_r = -1/2 int w'^2 dx of the modes of `beam`, relative."""

    def read(path):
        arrays = reader.read(path, Lists("TIP"))
        return neutral.from_arrays(arrays | {"units": np.array("mm t s")})

    mesh = beam()
    blade, told = by_calculix(mesh, read, folder)
    alone = assembly.assemble(blade)
    phi = lowest_modes(alone.stiffness[0].tocsc(), alone.mass.tocsc(), N_BENT)[1]
    moved = np.where(alone.row[..., None] >= 0, phi[alone.row], 0.0)
    moved = to_cartesian(np.nan_to_num(alone.nodes), moved)[:, 1:]
    x, which = np.unique(np.round(alone.nodes[:, 0], 9), return_inverse=True)
    mean = np.stack([moved[which == k].mean(axis=0) for k in range(len(x))])  # (x, y and z, p)
    slope = CubicSpline(x, mean)(np.linspace(x[0], x[-1], 2001), 1)
    exact = np.trapezoid(np.einsum("kdb,kdc->kbc", slope, slope), dx=np.ptp(x) / 2000, axis=0)
    return float(np.abs(told.tips[:, 0].mean(axis=0) - exact).max() / np.abs(exact).max())


def main(argv: list[str] | None = None) -> int:
    """Hold a straight blade against the theory of beams; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.second_order", description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("build/second_order"))
    folder = parser.parse_args(argv).folder
    folder.mkdir(parents=True, exist_ok=True)
    error = straight(folder)
    print(f"shortening of a straight blade, beside that of a beam: {error:.1e} (at most {LIMIT:g})")
    return int(not error <= LIMIT)


if __name__ == "__main__":
    raise SystemExit(main())
