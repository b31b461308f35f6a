"""From the sections to the model file of the fan: CalculiX on one sector, at rest and at speeds."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from evidence import calculix, second_order
from evidence.calculix import Mesh
from evidence.rotor67 import mesh as meshes
from evidence.rotor67 import reduction
from evidence.rotor67 import sections as geometry
from evidence.rotor67.numbers import Number
from evidence.rotor67.sections import Sections
from hpcrub.model.imported import neutral
from hpcrub.model.imported.bent_blades import BentBlades
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.neutral import polynomial
from hpcrub.model.imported.readers import calculix as reader
from hpcrub.model.imported.readers.rows import Lists

SPEED = 16_043 / 60  # design speed [Hz]
SHARES = 0.0, 0.6, 1.0, 1.1  # of it, of the matrices
FITTED = 3  # of them, through which eigenvalues go over the speed; the last one is a check
DESIGN = 2  # number of the design speed
N_MODES = 6  # fixed-interface modes for each number of nodal diameters
FOLLOWED = 6  # families whose frequencies depend on the speed
BLADE_MODES = 6  # cantilever modes, for mistuning
POINTS = 6  # contact points of a blade
MISS = 0.01  # of the running shape [mm]
UNITS = np.array("mm t s")


class Fan(NamedTuple):
    """One sector in its shape at rest and at all SHARES of the speed."""

    sections: Sections
    running: Mesh  # the published shape, at the design speed
    at_rest: Mesh
    moved: np.ndarray  # (SHARES, n, 3) displacements from the shape at rest [mm]


def shapes(sections: Sections, folder: Path) -> Fan:
    """The shape at rest that the design speed moves to the published one, and what speeds do to it.

    Corrections are the misses, stretched by Aitken's factor.
    """
    running = meshes.sector(sections)
    rest, factor, before = running, 1.0, None
    while True:
        moved = _state(rest, sections.n_blades, 1.0, folder)
        miss = running.nodes - rest.nodes - moved
        print(f"running shape missed by {np.linalg.norm(miss, axis=1).max():.4f} mm", flush=True)
        if np.linalg.norm(miss, axis=1).max() < MISS:
            break
        if before is not None:
            less = miss - before
            factor *= -np.vdot(before, less) / np.vdot(less, less)
        rest, before = rest._replace(nodes=rest.nodes + factor * miss), miss
    states = [
        _state(rest, sections.n_blades, share, folder) if share else np.zeros_like(moved)
        for share in SHARES
    ]
    return Fan(sections, running, rest, np.array(states))


def numbers(fan: Fan) -> list[Number]:
    """What the speed does to the tip: growth, and how much closer it is to the casing."""
    found = []
    ends = fan.running.sets["tip"][[0, -1]]
    for share, moved in zip(SHARES, fan.moved, strict=True):
        for edge, node in zip(("leading", "trailing"), ends, strict=True):
            x = fan.at_rest.nodes[node] + moved[node]
            radius, slope = geometry.wall(fan.sections.casing, x[2])
            gap = (radius - np.hypot(x[0], x[1])) / np.hypot(1.0, slope)
            at = f"{100 * share:.0f} % of the design speed, {edge} edge"
            found.append(Number("clearance of the tip, normal to the casing", at, gap, "mm"))
            shift = np.linalg.norm(moved[node])
            found.append(Number("motion of the tip by rotation", at, shift, "mm"))
    return found


def _loaded(speed):
    return calculix.SPINNING.format(speed**2) + "*NODE PRINT, NSET=NALL\nU\n" + calculix.END


def at_rest(mesh: Mesh) -> str:
    """Step that stores the matrices of the free sector at rest."""
    return calculix.held(mesh.sets["bore"]) + calculix.STEP + calculix.STORE


def cyclic_state(mesh: Mesh, n_sectors: int, speed: float) -> str:
    """Step that prints the displacements of the whole disk at a speed [rad/s]."""
    inner = np.setdiff1d(mesh.sets["bore"], mesh.sets["low"])  # the tie moves its first surface
    sides = calculix.CYCLIC.format(n_sectors)
    return sides + calculix.held(inner) + calculix.STATIC + _loaded(speed)


def about_state(mesh: Mesh, speed: float, moved: np.ndarray) -> str:
    """Steps that store the matrices of the free sector about the state at a speed [rad/s].

    moved: displacements of all nodes in that state (n, 3) [mm]. The sides are moved by them, and
    let go in the last step: CalculiX would eliminate their rows if it had cyclic symmetry itself.
    """
    bore = mesh.sets["bore"]
    sides = np.setdiff1d(np.concatenate([mesh.sets["low"], mesh.sets["high"]]), bore)
    rows = [f"{n + 1}, {d}, {d}, {moved[n, d - 1]:.12e}\n" for n in sides for d in (1, 2, 3)]
    state = calculix.STATIC + "*BOUNDARY\n" + "".join(rows) + _loaded(speed)
    last = calculix.PERTURBED + calculix.held(bore, ", OP=NEW") + calculix.STORE
    return calculix.held(bore) + state + last


def _state(mesh, n_sectors, share, folder):
    steps = cyclic_state(mesh, n_sectors, 2 * np.pi * share * SPEED)
    printed = calculix.solve(folder / f"state_{100 * share:.0f}.inp", mesh, steps)
    return calculix.displacements(printed, len(mesh.nodes))


def matrices(fan: Fan, folder: Path) -> list[neutral.NeutralModel]:
    """Free sectors at all SHARES of the speed, their nodes at the places of the design speed."""
    models = []
    for share, moved in zip(SHARES, fan.moved, strict=True):
        path = folder / f"sector_{100 * share:.0f}.inp"
        steps = at_rest(fan.at_rest)
        if share:
            steps = about_state(fan.at_rest, 2 * np.pi * share * SPEED, moved)
        calculix.solve(path, fan.at_rest, steps)
        lists = Lists("TIP", "LOW", "HIGH", fan.sections.n_blades)
        models.append(_model(reader.read(path, lists), fan.running))
    return models


def _model(arrays, running):
    """A sector with the places of the running shape, and contact points along its tip."""
    tip = running.sets["tip"]
    chosen = tip[np.linspace(0, len(tip) - 1, POINTS).round().astype(int)]
    arrays |= {"units": UNITS, "nodes": running.nodes, "contact_node": chosen}
    return neutral.from_arrays(arrays)


def blade_alone(fan: Fan, folder: Path) -> neutral.NeutralModel:
    """The free blade of the running shape, at rest and without the disk; nodes as in a sector."""
    path = folder / "blade.inp"
    calculix.solve(path, fan.running, at_rest(fan.running), blade=True)
    return _model(reader.read(path, Lists("TIP")), fan.running)


def bent_blade(fan: Fan, folder: Path) -> tuple[neutral.NeutralModel, BentBlades]:
    """The blade of `blade_alone` with its root held, and its second order."""

    def read(path):
        return _model(reader.read(path, Lists("TIP")), fan.running)

    return second_order.by_calculix(fan.running, read, folder)


def reduced(fan: Fan, models: list, blade: neutral.NeutralModel) -> dict:
    """Arrays of the model file of the reduced fan."""
    n, m_points = fan.sections.n_blades, POINTS
    parts, stiffness = reduction.reduce(models, DESIGN, N_MODES, FOLLOWED)
    places = models[DESIGN].nodes[models[DESIGN].contact_node]
    turn = 2 * np.pi * np.arange(n) / n
    radius, angle = np.hypot(*places[:, :2].T), np.arctan2(places[:, 1], places[:, 0])
    around = angle + turn[:, None]
    nodes = np.stack([radius * np.cos(around), radius * np.sin(around)], axis=-1)
    nodes = np.concatenate([nodes, np.tile(places[:, 2:], (n, 1, 1))], axis=2).reshape(-1, 3)
    slope = geometry.wall(fan.sections.casing, 1e3 * places[:, 2])[1]
    # outward, of the casing beside the points: r, theta, z parts
    normal = np.column_stack([np.ones_like(slope), np.zeros_like(slope), -slope])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    m = len(parts[0].mass)
    dof = np.full((n, m, 2), [-1, 0])
    for direction in range(3):
        dof[:, direction : 3 * m_points : 3, 0] = np.arange(n * m_points).reshape(n, -1)
        dof[:, direction : 3 * m_points : 3, 1] = direction + 1
    speeds = 2 * np.pi * SPEED * np.array(SHARES[:FITTED])
    K = polynomial([_whole([k[s] for k in stiffness], n) for s in range(FITTED)], speeds)
    arrays = {
        "hpcrub_model": np.array(1),
        "kind": np.array("reduced"),
        "frame": np.array("cylindrical"),
        "units": np.array("m kg s"),
        "nodes": nodes,
        "dof": dof.reshape(-1, 2),
        "contact_node": np.arange(n * m_points),
        "contact_blade": np.repeat(np.arange(n), m_points),
        "contact_normal": np.tile(normal, (n, 1)),
        "M": _whole([part.mass for part in parts], n),
    }
    arrays |= dict(zip(neutral.POLYNOMIAL, K, strict=True))
    if places_of_stress := len(models[DESIGN].stress_blade):
        stress = to_cylindrical(models[DESIGN]).stress
        rows = reduction.whole([stress @ part.basis for part in parts], n)
        arrays["stress"] = rows.reshape(n * places_of_stress, -1)
        arrays["stress_blade"] = np.repeat(np.arange(n), places_of_stress)
        arrays["stress_static"] = np.tile(models[DESIGN].stress_static, n)
    return arrays | _blades(blade, fan, models[DESIGN], parts)


def _whole(parts, n):
    size = n * len(parts[0])
    matrix = reduction.whole(parts, n).reshape(size, size)
    return (matrix + matrix.T) / 2


def _blades(blade, fan, sector, parts):
    """Cantilever modes of every blade, root held, and their amplitudes per unit coordinate."""
    blade, sector = to_cylindrical(blade), to_cylindrical(sector)
    n = fan.sections.n_blades
    inner = np.flatnonzero(~np.isin(blade.dof[:, 0], fan.running.sets["root"]))
    K = blade.stiffness[0][inner]
    values, phi = lowest_modes(
        K[:, inner].tocsc(), blade.mass[inner][:, inner].tocsc(), BLADE_MODES
    )
    place = {tuple(pair): row for row, pair in enumerate(sector.dof.tolist())}
    rows = [place[tuple(pair)] for pair in blade.dof.tolist()]
    weights = phi.T @ K / values[:, None]
    share = reduction.whole([weights @ part.basis[rows] for part in parts], n)
    return {
        "blade_frequencies_hz": np.tile(np.sqrt(values) / (2 * np.pi), (n, 1)),
        "blade_participation": share.reshape(n, BLADE_MODES, -1),
    }
