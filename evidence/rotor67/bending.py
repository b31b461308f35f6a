"""The bent blade of rotor 67 at rest under loads: CalculiX with large displacements, and the model.

Errors of the motion of the tip along the casing's normal, to first and to second order, under loads
that hold the blade in its first mode, as a resonance does, and under a force on the tip; and what
large displacements change of the stress.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from evidence import calculix
from evidence.rotor67 import stress
from evidence.rotor67.model import Fan
from evidence.rotor67.numbers import Number
from hpcrub.model.imported import assembly
from hpcrub.model.imported.bent_blades import BentBlades
from hpcrub.model.imported.craig_bampton import factorised, lowest_modes
from hpcrub.model.imported.frames import to_cartesian
from hpcrub.model.imported.neutral import NeutralModel
from hpcrub.model.imported.stress import von_mises

MOVED = 5.0, 10.0, 18.0, 20.0  # of the tip, to first order [mm]
STRESSED = 10.0, 18.0
LARGE = "*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1.\n*CLOAD\n"
PRINT = "*NODE PRINT, NSET=NALL, FREQUENCY=1000\nU\n"
STEPS = 50  # of Newton's method, at most


class Blade(NamedTuple):
    """One blade alone, its root held, and its modes, by the signs of its second order."""

    alone: NeutralModel  # assembled, cylindrical
    bent: BentBlades
    normal: np.ndarray  # (C, 3) of the casing beside the contact points: r, theta, z
    squares: np.ndarray  # (p,) of angular frequencies
    modes: np.ndarray  # (n, p)

    @property
    def tips(self) -> np.ndarray:
        """Rows of the contact points (C, 3)."""
        return self.alone.row[self.alone.contact_node]


def blade_of(blade: NeutralModel, bent: BentBlades, normal: np.ndarray) -> Blade:
    """The parts of a Blade; blade, bent: as of `second_order.by_calculix`."""
    alone, p = assembly.assemble(blade), bent.modes.shape[2]
    squares, modes = lowest_modes(alone.stiffness[0].tocsc(), alone.mass.tocsc(), p)
    rows = alone.row[alone.contact_node]
    signs = np.sign((modes[rows] * bent.modes).sum(axis=(0, 1)))
    return Blade(alone, bent, normal, squares, modes * signs)


def at_rest(blade: Blade, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Motion of the contact points (C, 3) [m] under a load (n,) [N], to first and second order.

    w^2 s + s C s / 2 = load - force on the tips G s: the amplitudes s of the bent modes.
    """
    first = factorised(blade.alone.stiffness[0].tocsc()).solve(load)
    held = blade.modes.T @ load
    other = first - blade.modes @ (held / blade.squares)
    taken = np.einsum("kd,kdbc->bc", _on_tips(blade, load), blade.bent.tips)
    C, s = blade.bent.coupling, held / blade.squares
    for _ in range(STEPS):
        left = blade.squares * s + np.einsum("abc,b,c->a", C, s, s) / 2 + taken @ s - held
        s = s - np.linalg.solve(np.diag(blade.squares) + np.einsum("abc,c->ab", C, s) + taken, left)
    second = (other + blade.modes @ s)[blade.tips]
    second -= np.einsum("kdbc,b,c->kd", blade.bent.tips, s, s) / 2
    return first[blade.tips], second


def _on_tips(blade: Any, load: Any) -> Any:
    """Forces on the contact points (C, 3); none of a load on the modes, which bend nothing else."""
    alone = np.zeros_like(load)
    alone[blade.tips] = load[blade.tips]
    return load[blade.tips] if (alone == load).all() else np.zeros(blade.tips.shape)


def numbers(fan: Fan, blade: Blade, places: list[int], folder: Path) -> list[Number]:
    """Errors of the tip's motion, and ratios of stresses at some nodes."""
    found = []
    along = np.zeros(len(blade.alone.dof))
    along[blade.tips[:, 1]] = 1.0  # towards theta, on all contact points
    kinds = {
        "in its first mode": blade.alone.mass @ blade.modes[:, 0],
        "by forces along theta on its tip": along,
    }
    moves = {(at, moved, sign): _moved(fan, blade, sign * moved * _unit(blade, load), folder)
             for at, load in kinds.items() for moved in MOVED for sign in (1, -1)}  # fmt: skip
    for (at, load), moved in ((kind, moved) for kind in kinds.items() for moved in MOVED):
        errors = []
        for sign in (1, -1):
            exact = moves[at, moved, sign][blade.alone.contact_node]
            exact = to_cartesian(blade.alone.nodes[blade.alone.contact_node] * [1, -1, 1],
                                 exact[:, :, None])[:, :, 0]  # fmt: skip
            told = at_rest(blade, sign * moved * _unit(blade, load))
            errors.append([np.abs(((t - exact) * blade.normal).sum(axis=1)).max() for t in told])
        for order, error in zip(("first", "second"), np.max(errors, axis=0), strict=True):
            what = f"error of a bent blade's tip along the casing's normal, to {order} order"
            found.append(Number(what, f"{moved:g} mm {at}", 1e3 * error, "mm"))
    first = next(iter(kinds))
    for place, moved in ((place, moved) for place in places for moved in STRESSED):
        ratios = [_stressed(fan, blade, moves[first, moved, sign], place) for sign in (1, -1)]
        what = "largest stress of a bent blade over that of its first order at the same motion"
        at = f"{moved:g} mm {first}, place {1 + places.index(place)}"
        found.append(Number(what, at, ratios[int(np.abs(np.array(ratios) - 1).argmax())], ""))
    return found


def _unit(blade: Any, load: Any) -> Any:
    """The load that moves the tip by one millimetre at most, to first order."""
    first = at_rest(blade, 1e-9 * load)[0]
    return load * (1e-12 / np.linalg.norm(first, axis=1).max())


def _moved(fan: Any, blade: Any, load: Any, folder: Path) -> Any:
    """Displacements x, y, z of all nodes (n, 3) [m] by CalculiX."""
    rows = blade.alone.row
    force = np.where(rows >= 0, load[rows], 0.0)
    force = to_cartesian(np.nan_to_num(blade.alone.nodes), force[:, :, None])[:, :, 0]
    cards = [
        f"{n + 1}, {d + 1}, {force[n, d]:.12e}\n" for n, d in zip(*force.nonzero(), strict=True)
    ]
    root = calculix.held(fan.running.sets["root"])
    steps = root + LARGE + "".join(cards) + PRINT + calculix.END
    path = calculix.solve(folder / "bent_far.inp", fan.running, steps, blade=True)
    return 1e-3 * calculix.displacements(path, len(fan.running.nodes))


def _stressed(fan: Any, blade: Any, moved: Any, place: int) -> float:
    """Von Mises' stress of displacements over that of the first mode with the same tip motion."""
    elements, n = fan.running.elements[fan.running.blade_elements], len(fan.running.nodes)
    rows = blade.alone.row
    shape = np.where(rows >= 0, blade.modes[:, 0][rows], 0.0)
    shape = to_cartesian(np.nan_to_num(blade.alone.nodes), shape[:, :, None])[:, :, 0]
    tip = [np.linalg.norm(m[blade.alone.contact_node], axis=1).max() for m in (moved, shape)]
    straight = stress.by_strain(fan.running.nodes, elements, 1e3 * shape * tip[0] / tip[1])
    bent = stress.by_rotation(fan.running.nodes, elements, 1e3 * moved)
    sizes = [von_mises(stress.at_corners(s, elements, n)[place]) for s in (bent, straight)]
    return float(sizes[0] / sizes[1])
