"""The neutral model file: arrays that any finite-element program can write of a bladed disk.

`docs/model_file.md` specifies the arrays. `NeutralModel` holds them in SI units and checked.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError
from hpcrub.model.imported import bent_blades
from hpcrub.model.imported.arrays import Arrays, held_rows, stored, symmetric, without

VERSION = 1
MOST_BLADES = 200
MODEL_KINDS = "sector", "disk", "reduced"
SI = "m kg s"
FRAMES = "cartesian", "cylindrical"
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}  # [m]
MASSES = {"kg": 1.0, "g": 1e-3, "t": 1e3, "lbm": 0.45359237, "slinch": 175.126835}  # [kg]
TIMES = {"s": 1.0, "ms": 1e-3}  # [s]
POLYNOMIAL = "K0", "K1", "K2"
AT_SPEEDS = "K_at_1", "K_at_2", "K_at_3"
ROTATIONS = 4, 5, 6  # directions that are angles
UNIT = 1e-6  # largest error in the length of a unit vector
NONE, NO_FACES = np.zeros(0, int), np.zeros((0, 4), int)


class NeutralModel(NamedTuple):
    """A bladed disk about z, one sector of it, or a reduced model of it; n rows, SI units."""

    kind: str  # one of MODEL_KINDS
    mass: Any  # (n, n); sparse, but dense in a reduced model
    stiffness: tuple  # K0, or K0, K1, K2 of K0 + W^2 K1 + W^4 K2, W in [rad/s]; each (n, n)
    nodes: np.ndarray  # (n_nodes, 3) x, y, z [m]; NaN for nodes without a place
    dof: np.ndarray  # (n, 2) node and direction of every row: 1-3, rotations 4-6, other 0
    frame: str  # frame of the directions 1-6: one of FRAMES
    stress: Any  # (R, n) stress at R places [Pa per coordinate]; sparse unless reduced
    contact_node: np.ndarray  # (C,) nodes that may touch the casing; of kind sector: its own
    contact_blade: np.ndarray  # (C,) blade of each contact node, from 0
    contact_clearance: np.ndarray  # (C,) added to the casing's clearance [m]
    contact_normal: np.ndarray  # (C, 3) outward unit normal of the casing at each: r, theta (0), z
    fixed: np.ndarray = NONE  # held rows
    low: np.ndarray = NONE  # nodes of the sector's side at the smaller angle
    high: np.ndarray = NONE  # nodes of its side at the larger angle
    n_sectors: int = 0  # number in a whole disk; 0 unless of kind sector
    blade_stiffness: Any = None  # (n, n) of all blades; reduced: (N, m, m)
    surface: np.ndarray = NO_FACES  # (F, 4) nodes of faces to draw
    blade_frequencies: Any = None  # reduced: (N, c) of every blade alone, root held [Hz]
    participation: Any = None  # (N, c, n) modes of every blade per unit coordinate [sqrt(kg)]
    stress_blade: np.ndarray = NONE  # (R,) blade of each place
    stress_static: np.ndarray = np.zeros(0)  # (R,) stress by the rotation [Pa]; (0,): not known
    speeds: np.ndarray = np.zeros(0)  # between which K0, K1, K2 are known [Hz]; (0,): anywhere
    # (n,) in an assembled disk: blade that has stiffness in the row, -1 where no blade has any
    row_blade: np.ndarray = NONE
    bent: bent_blades.BentBlades | None = None  # second order of the blades

    @property
    def n_blades(self) -> int:
        """Number of blades of the whole disk."""
        return self.n_sectors or int(self.contact_blade.max()) + 1

    @property
    def row(self) -> np.ndarray:
        """Rows of the three displacements of every node (n_nodes, 3), -1 for a missing row."""
        return row_table(self.dof, len(self.nodes))[:, 1:4]


def row_table(dof: np.ndarray, n_nodes: int) -> np.ndarray:
    """Row of every node and direction, (n_nodes, 7) int, -1 for a missing row."""
    table = np.full((n_nodes, 7), -1)
    placed = dof[:, 1] > 0
    table[dof[placed, 0], dof[placed, 1]] = np.flatnonzero(placed)
    return table


def contact_rows(model: NeutralModel) -> np.ndarray:
    """Rows of u_r, u_theta and, if the nodes have it, u_z of the contact nodes (2 or 3, C).

    model: in cylindrical node frames. Raises InputError for a contact node that lacks a row.
    """
    rows = model.row[model.contact_node].T
    if (rows[:2] < 0).any():
        raise InputError("contact_node: a contact node is held, or lacks a row in x or y")
    axial = rows[2] >= 0
    if axial.any() and not axial.all():
        raise InputError("contact_node: some contact nodes have a row in z, and others none")
    return rows[: 3 if axial.any() else 2]


def polynomial(stiffness: Sequence, speeds: np.ndarray) -> tuple:
    """K0 [N/m], K1 [N s2/m], K2 [N s4/m] of the parabola through three speeds (3,) [rad/s]."""
    square = np.asarray(speeds, dtype=float) ** 2
    coefficients = np.linalg.inv(np.vander(square / square.max(), 3, increasing=True))
    return tuple(
        sum(c * k for c, k in zip(row, stiffness, strict=True)) / square.max() ** power
        for power, row in enumerate(coefficients)
    )


def stiffness_at(stiffness: Sequence, speed: float) -> Any:
    """K0 + W^2 K1 + W^4 K2 at a speed of rotation [rad/s]."""
    return sum(k * speed ** (2 * power) for power, k in enumerate(stiffness))


def from_arrays(arrays: dict) -> NeutralModel:
    """Model from the arrays of a model file, in SI units, with whole, symmetric matrices.

    Raises InputError, which names the array that is missing or has wrong shape or values.
    """
    left = Arrays(arrays)
    version = left.number("hpcrub_model")
    if version != VERSION:
        raise InputError(f"hpcrub_model: version {version} is not {VERSION}")
    kind = left.word("kind", MODEL_KINDS)
    frame = left.word("frame", FRAMES, default=FRAMES[0])
    length, mass, time = units(left.word("units", default=SI))
    flip = _flip(left.number("turns", default=1))
    dof = left.integers("dof", 2)
    n = len(dof)
    nodes = left.floats("nodes", 3) * length * flip
    _check_dof(dof, len(nodes))
    stiffness, speeds = _stiffness(left, n, time)
    fixed = left.integers("fixed", default=NONE)
    if kind != "reduced" and len(held := held_rows(stiffness[0])):
        stiffness = tuple(without(k, held) for k in stiffness)
        fixed = np.union1d(fixed, held)
    scale = np.where(np.isin(dof[:, 1], ROTATIONS), 1.0, 1.0 / length)
    scale *= np.where(dof[:, 1] > 0, flip[(dof[:, 1] - 1) % 3], 1.0)
    work = mass * (length / time) ** 2  # the file's unit of work [J]
    contact_node = left.integers("contact_node")
    zeros = np.zeros(len(contact_node))
    radial = np.tile([1.0, 0.0, 0.0], (len(contact_node), 1))
    model = NeutralModel(
        kind=kind,
        mass=_scaled(left.symmetric("M", n), scale, work * time**2),
        stiffness=tuple(
            _scaled(k, scale, work * time ** (2 * power)) for power, k in enumerate(stiffness)
        ),
        speeds=speeds,
        nodes=nodes,
        dof=dof,
        frame=frame,
        contact_node=contact_node,
        contact_blade=left.integers("contact_blade", default=zeros.astype(int)),
        contact_clearance=left.floats("contact_clearance", default=zeros) * length,
        contact_normal=_unit_normals(left.floats("contact_normal", 3, default=radial) * flip),
        fixed=fixed,
        low=left.integers("low", default=NONE),
        high=left.integers("high", default=NONE),
        n_sectors=left.number("n_sectors", default=0),
        blade_stiffness=_blade_stiffness(left, kind, n, scale, work),
        surface=left.integers("surface", 4, default=NO_FACES),
        bent=bent_blades.taken(left, len(contact_node), (length, mass, time), flip),
        **_blade_modes(left, n, np.sqrt(mass) * length * scale),
        **_stress(left, kind, n, scale, mass / (length * time**2)),
    )
    left.finish()
    _check_members(model)
    return model if kind == "sector" else _alike(model)


def _alike(model: Any) -> Any:
    """Put the contact points of every blade in the order of one blade's, as their places tell.

    Raises InputError for blades that are not numbered around the disk, one way or the other.
    """
    tips, n = model.nodes[model.contact_node], model.n_blades
    if not np.isfinite(tips).all():  # which `checks` refuses
        return model
    flat, z, order = tips[:, 0] + 1j * tips[:, 1], tips[:, 2], np.arange(len(tips))
    own = [np.flatnonzero(model.contact_blade == blade) for blade in range(n)]
    middle = np.array([flat[mine].sum() for mine in own])
    pitches = np.round(np.angle(middle * middle[0].conj()) * n / (2 * np.pi))
    lost = np.flatnonzero((pitches - (1 if 1 in pitches[:2] else -1) * np.arange(n)) % n)
    if len(lost):
        raise InputError(
            f"contact_blade: {lost[0]} lies {pitches[lost[0]] % n:g} pitches beyond 0; blades are "
            "numbered one after the other around the disk"
        )
    turned = flat * np.exp(-2j * np.pi / n * pitches[model.contact_blade])  # all onto blade 0
    first = min(own, key=len)
    for mine in own:
        apart = np.abs(turned[first, None] - turned[mine]) + np.abs(z[first, None] - z[mine])
        nearest = apart.argmin(axis=1)
        if len(np.unique(nearest)) == len(first):  # else the blades are not alike
            order[mine] = mine[[*nearest, *np.setdiff1d(np.arange(len(mine)), nearest)]]
    names = "contact_node", "contact_clearance", "contact_normal"
    if model.bent is not None:
        model = model._replace(bent=model.bent.at(order))
    return model._replace(**{name: getattr(model, name)[order] for name in names})


def to_arrays(model: NeutralModel) -> dict:
    """Arrays of a model file, by name, in SI units; the inverse of `from_arrays`."""
    arrays = {"hpcrub_model": np.array(VERSION), "units": np.array(SI)}
    arrays |= {name: np.array(getattr(model, name)) for name in ("kind", "frame", "n_sectors")}
    names = POLYNOMIAL if len(model.stiffness) > 1 else ("K",)
    if len(model.speeds):
        arrays["speeds_hz"] = model.speeds
    matrices = dict(zip(names, model.stiffness, strict=True)) | {"M": model.mass}
    if model.blade_stiffness is not None:
        matrices["K_blade"] = model.blade_stiffness
    for name, matrix in matrices.items():
        arrays |= stored(name, sp.triu(matrix) if sp.issparse(matrix) else np.triu(matrix))
    if len(model.stress_blade):
        arrays |= stored("stress", model.stress)
    always = ("nodes", "dof", "contact_node", "contact_blade", "contact_clearance")
    arrays |= {name: getattr(model, name) for name in always}
    if (model.contact_normal[:, 0] != 1.0).any():
        arrays["contact_normal"] = model.contact_normal
    if model.blade_frequencies is not None:
        arrays["blade_frequencies_hz"] = model.blade_frequencies
        arrays["blade_participation"] = model.participation
    arrays |= bent_blades.stored(model.bent)
    optional = ("fixed", "low", "high", "surface", "stress_blade", "stress_static")
    return arrays | {name: getattr(model, name) for name in optional if len(getattr(model, name))}


def _check_members(model: Any) -> None:
    for name in ("contact_node", "low", "high", "surface"):
        _check_inside(name, "node", getattr(model, name), len(model.nodes))
    _check_inside("fixed", "row", model.fixed, len(model.dof))
    if model.kind == "reduced" and len(model.fixed):
        raise InputError(
            f"fixed: {len(model.fixed)} rows are held, none is allowed in a reduced model"
        )
    if not len(model.contact_node):
        raise InputError("contact_node: no contact nodes; a blade without them cannot rub")
    nodes, count = np.unique(model.contact_node, return_counts=True)
    if (count > 1).any():
        raise InputError(f"contact_node: node {nodes[count > 1][0]} is named twice")
    for name in ("contact_blade", "contact_clearance", "contact_normal"):
        if len(getattr(model, name)) != len(model.contact_node):
            raise InputError(
                f"{name}: {len(getattr(model, name))} values for {len(model.contact_node)} "
                "contact nodes"
            )
    if model.kind == "sector":
        _check_sector(model)
    else:
        _check_blades(model)


def _check_sector(model: Any) -> None:
    if not 2 <= model.n_sectors <= MOST_BLADES:
        raise InputError(
            f"n_sectors: {model.n_sectors}; a sector needs their number, 2 to {MOST_BLADES}"
        )
    for name in ("contact_blade", "stress_blade"):
        if getattr(model, name).any():
            raise InputError(f"{name}: a sector has one blade, number 0")
    if not len(model.low) or len(model.low) != len(model.high):
        raise InputError(
            f"low, high: {len(model.low)} and {len(model.high)} nodes; the sides of a sector have "
            "the same number of nodes, at least one"
        )


def _check_blades(model: Any) -> None:
    _check_inside("stress_blade", "blade", model.stress_blade, model.n_blades)
    blades = np.unique(model.contact_blade)
    missing = np.flatnonzero(blades != np.arange(len(blades)))
    if len(missing):
        lost = missing[0] if blades[0] >= 0 else blades[0]
        raise InputError(
            f"contact_blade: blade {lost + 1} has no contact nodes; {lost} is named nowhere"
        )
    if model.n_sectors not in (0, len(blades)):
        raise InputError(f"n_sectors: {model.n_sectors}, and contact_blade names {len(blades)}")
    own = {"K_blade": model.blade_stiffness, "blade_frequencies_hz": model.blade_frequencies}
    for name, values in own.items():
        if model.kind == "reduced" and values is not None and len(values) != len(blades):
            raise InputError(f"{name}: of {len(values)} blades, contact_blade names {len(blades)}")


def _check_dof(dof: Any, n_nodes: int) -> None:
    if not len(dof):
        raise InputError("dof: no rows")
    wrong = (dof[:, 1] < 0) | (dof[:, 1] > 6)
    if wrong.any():
        raise InputError(f"dof: {dof[wrong][0, 1]} is no direction (1 to 6; 0: anything else)")
    rows = dof[dof[:, 1] > 0]
    _check_inside("dof", "node", rows[:, 0], n_nodes)
    if len(np.unique(rows, axis=0)) != len(rows):
        raise InputError("dof: a node has two rows in the same direction")


def _check_inside(name: str, what: Any, numbers: Any, n: Any) -> None:
    wrong = numbers[(numbers < 0) | (numbers >= n)]
    if len(wrong):
        raise InputError(f"{name}: there is no {what} {wrong[0]}, {what}s run from 0 to {n - 1}")


def units(text: str, name: str = "units") -> tuple[float, float, float]:
    """Length [m], mass [kg] and time [s] of units such as "mm t s"; name: of what tells them.

    Raises InputError.
    """
    try:
        length, mass, time = text.split()
        return LENGTHS[length], MASSES[mass], TIMES[time]
    except (KeyError, ValueError):
        raise InputError(
            f'{name}: "{text}" is not a length ({", ".join(LENGTHS)}), a mass '
            f'({", ".join(MASSES)}) and a time ({", ".join(TIMES)}), such as "mm t s"'
        ) from None


def _flip(turns: Any) -> Any:
    """Signs that turn x, y, z (and r, theta, z) so that the disk rotates positively about z.

    They turn the axes by half a turn about x, so that a clockwise disk is seen from behind.
    """
    if turns not in (1, -1):
        raise InputError(f"turns: {turns} is neither 1 nor -1")
    return np.array([1.0, turns, turns])


def _unit_normals(normal: Any) -> Any:
    wrong = ~((np.abs(np.linalg.norm(normal, axis=1) - 1.0) < UNIT) & (normal[:, 0] > 0.0))
    if (wrong | (np.abs(normal[:, 1]) > UNIT)).any():
        raise InputError(
            "contact_normal: unit vectors of radial, tangential and axial parts are expected, "
            "outward, without a tangential part: a casing is a surface of revolution"
        )
    return normal


def _stiffness(left: Any, n: Any, time: Any) -> Any:
    """Return (K0,) or (K0, K1, K2), in the file's units, and the speeds that they were made of."""
    if left.has("K"):
        return (left.symmetric("K", n),), np.zeros(0)
    if left.has(POLYNOMIAL[0]):
        K0, K1 = (left.symmetric(name, n) for name in POLYNOMIAL[:2])
        K2 = left.symmetric("K2", n) if left.has("K2") else 0.0 * K1
        return (K0, K1, K2), left.floats("speeds_hz", default=np.zeros(0))
    if not left.has(AT_SPEEDS[0]):
        raise InputError(f"K: there is neither K, nor {POLYNOMIAL[0]}, nor {AT_SPEEDS[0]}")
    speeds = left.floats("speeds_hz")
    if len(speeds) != 3 or len(np.unique(speeds**2)) != 3:
        raise InputError("speeds_hz: three different speeds are needed, those of K_at_1 to K_at_3")
    of_file = 2 * np.pi * speeds * time  # [rad per unit of time]
    return polynomial([left.symmetric(name, n) for name in AT_SPEEDS], of_file), np.abs(speeds)


def _blade_stiffness(left: Any, kind: Any, n: Any, scale: Any, work: Any) -> Any:
    if not left.has("K_blade"):
        return None
    if kind != "reduced":
        return _scaled(left.symmetric("K_blade", n), scale, work)
    blades = left.floats("K_blade", n, n)
    return np.stack([_scaled(symmetric("K_blade", k), scale, work) for k in blades])


def _blade_modes(left: Any, n: Any, scale: Any) -> dict[Any, Any]:
    if not left.has("blade_frequencies_hz"):
        return {}
    frequencies = left.floats("blade_frequencies_hz", None)
    participation = left.floats("blade_participation", frequencies.shape[1], n)
    if len(participation) != len(frequencies):
        raise InputError("blade_participation: another number of blades than blade_frequencies_hz")
    return {"blade_frequencies": frequencies, "participation": participation * scale}


def _stress(left: Any, kind: Any, n: Any, scale: Any, unit: Any) -> dict[Any, Any]:
    if not left.has("stress"):
        return {"stress": np.zeros((0, n)) if kind == "reduced" else sp.csr_array((0, n))}
    blade = left.integers("stress_blade")
    stress = left.matrix("stress", len(blade), n) @ sp.diags_array(scale * unit)
    if kind == "reduced" and sp.issparse(stress):
        stress = stress.toarray()
    static = unit * left.floats("stress_static", default=np.zeros(0))
    if len(static) not in (0, len(blade)):
        raise InputError(f"stress_static: {len(static)} values for {len(blade)} places")
    return {"stress": stress, "stress_blade": blade, "stress_static": static}


def _scaled(matrix: Any, scale: Any, factor: Any) -> Any:
    """Matrix in SI units; scale: of each row's displacement (n,), factor: of the unit of work."""
    if np.all(scale == 1.0) and factor == 1.0:
        return matrix
    if sp.issparse(matrix):
        turn = sp.diags_array(scale)
        return (factor * (turn @ matrix @ turn)).tocsr()
    return factor * scale[:, None] * matrix * scale
