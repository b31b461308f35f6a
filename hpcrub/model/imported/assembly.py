"""Assembly of a whole disk from a neutral model: sectors, supports, blades, contact points."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from hpcrub.errors import InputError
from hpcrub.model.imported.arrays import PARTS
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.neutral import NONE, NeutralModel, contact_rows, row_table

PAIRING = 1e-4  # largest distance of paired nodes, as a share of the largest radius
SHARED = 1e-9  # of the largest entry: smaller entries do not connect rows


def pair_sides(
    nodes: np.ndarray, low: np.ndarray, high: np.ndarray, n_sectors: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """Pair each node of the high side with the node of the low side one sector behind it.

    nodes: (n_nodes, 3) [m]; low, high: (p,) nodes of the sides, which may be exchanged.
    Returns low, high (p,) in pairs; largest distance in a pair [m].
    Raises InputError: the sides do not pair.
    """
    pairings = [_pair(nodes, a, b, n_sectors) for a, b in ((low, high), (high, low))]
    low, high, error = min(pairings, key=lambda pairs: pairs[2])
    reach = np.hypot(nodes[high, 0], nodes[high, 1]).max()
    if not error <= PAIRING * reach or len(np.unique(low)) != len(low):
        raise InputError(
            f"low, high: the sides do not pair; turned by 360/{n_sectors} degrees about z, the "
            f"worst node misses its partner by {error:.3g} m"
        )
    return low, high, error


def _pair(nodes: Any, low: Any, high: Any, n_sectors: int) -> tuple[Any, Any, float]:
    from scipy.spatial import cKDTree  # slow to import, and needed by imports only

    if not np.isfinite(nodes[np.concatenate([low, high])]).all():
        raise InputError("low, high: a node of the sides has no place")
    distance, nearest = cKDTree(turned(nodes[low], 2 * np.pi / n_sectors)).query(nodes[high])
    return low[nearest], high, float(distance.max())


def disk_rows(model: NeutralModel) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the whole disk for the rows of each sector; model: a sector, cylindrical.

    Returns rows (n_sectors, n), sector by sector; own (n_own,), the rows of a sector that it does
    not share with the low side of the next sector.
    """
    low, high, _ = pair_sides(model.nodes, model.low, model.high, model.n_sectors)
    table = row_table(model.dof, len(model.nodes))
    partner = np.full(len(model.nodes), -1)
    partner[high] = low
    shared = (model.dof[:, 1] > 0) & (partner[model.dof[:, 0]] >= 0)
    own = np.flatnonzero(~shared)
    sector = np.arange(model.n_sectors)[:, None]
    rows = np.full((model.n_sectors, len(model.dof)), -1)
    rows[:, own] = sector * len(own) + np.arange(len(own))
    origin = table[partner[model.dof[shared, 0]], model.dof[shared, 1]]
    of_low = (model.dof[:, 1] > 0) & np.isin(model.dof[:, 0], low)
    alone = [*np.flatnonzero(shared)[origin < 0], *np.setdiff1d(np.flatnonzero(of_low), origin)]
    if alone:
        node, direction = model.dof[alone[0]]
        x, y, z = 1e3 * model.nodes[node]
        raise InputError(
            f"low, high: the node at {x:.6g}, {y:.6g}, {z:.6g} mm has a row in direction "
            f"{direction} that its partner on the other side lacks; the matrices must be those of "
            "the free sector, without cyclic constraints, which take the rows of one side away"
        )
    rows[:, shared] = np.roll(rows, -1, axis=0)[:, origin]
    return rows, own


def assemble(model: NeutralModel) -> NeutralModel:
    """Assemble the whole disk of a NeutralModel on its free rows, in cylindrical node frames.

    A reduced model keeps its coordinates.
    Raises InputError: sides do not pair, a contact node lacks rows, or a blade has no contact node.
    """
    model = to_cylindrical(model)
    if model.kind == "reduced":
        return model
    if model.kind == "sector":
        model = _unfold(model)
    free = np.setdiff1d(np.arange(len(model.dof)), model.fixed)

    def of_free(matrix: Any) -> Any:
        return matrix[free][:, free].tocsr()

    blade = model.blade_stiffness
    disk = model._replace(
        mass=of_free(model.mass),
        stiffness=tuple(of_free(k) for k in model.stiffness),
        dof=model.dof[free],
        fixed=NONE,
        blade_stiffness=None if blade is None else of_free(blade),
        stress=model.stress[:, free],
    )
    contact_rows(disk)  # refuses contact nodes without rows
    return disk if blade is None else disk._replace(row_blade=blade_of_rows(disk))


def _unfold(model: Any) -> Any:
    """Repeat a sector in cylindrical node frames around the disk, to a model of kind "disk"."""
    rows, own = disk_rows(model)
    n, N, n_nodes = rows.max() + 1, model.n_sectors, len(model.nodes)
    n_places = len(model.stress_blade)

    def whole(matrix: Any, at: Any) -> Any:
        """Sum of the sectors' matrices; at: where the rows of each sector go (N, any)."""
        entries = sp.coo_array(matrix)
        i, j = at[:, entries.row].ravel(), rows[:, entries.col].ravel()
        shape = (1 + at.max(initial=-1), n)
        return sp.coo_array((np.tile(entries.data, N), (i, j)), shape=shape).tocsr()

    copies = np.arange(N)[:, None]
    dof = np.empty((n, 2), dtype=np.int64)
    dof[rows[:, own], 0] = model.dof[own, 0] + copies * n_nodes
    dof[rows[:, own], 1] = model.dof[own, 1]
    blade = model.blade_stiffness
    low, high = _sides(model)
    owner = np.arange(n_nodes)[None] + copies * n_nodes
    owner[:, high] = np.roll(owner, -1, axis=0)[:, low]  # their partners in the next sector
    return model._replace(
        kind="disk",
        n_sectors=0,
        dof=dof,
        mass=whole(model.mass, rows),
        stiffness=tuple(whole(k, rows) for k in model.stiffness),
        blade_stiffness=None if blade is None else whole(blade, rows),
        nodes=np.concatenate([turned(model.nodes, 2 * np.pi * s / N) for s in range(N)]),
        fixed=np.unique(rows[:, model.fixed]),
        contact_node=(copies * n_nodes + model.contact_node).ravel(),
        contact_blade=np.repeat(np.arange(N), len(model.contact_node)),
        contact_clearance=np.tile(model.contact_clearance, N),
        contact_normal=np.tile(model.contact_normal, (N, 1)),
        surface=owner[:, model.surface].reshape(-1, 4),
        stress=whole(model.stress, np.arange(N * n_places).reshape(N, n_places)),
        stress_blade=np.repeat(np.arange(N), n_places),
        stress_static=np.tile(model.stress_static, N),
        bent=model.bent and model.bent.at(np.tile(np.arange(len(model.contact_node)), N)),
    )


def _sides(model: Any) -> tuple[Any, Any]:
    """Paired sides of a sector, whose rows on the high one are those of the next sector."""
    low, high, _ = pair_sides(model.nodes, model.low, model.high, model.n_sectors)
    if twice := set(model.contact_node.tolist()) & set(high.tolist()):
        raise InputError(
            f"contact_node: node {min(twice)} is on the side of the sector that the next one has, "
            "too; name the nodes of the other side alone"
        )
    return low, high


def turned(nodes: np.ndarray, angle: float) -> np.ndarray:
    """Nodes (n, 3) turned by an angle about z [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return nodes @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def joined(K: sp.csr_array) -> tuple[np.ndarray, np.ndarray]:
    """Connected part (n,) int of every row of K; whether the row has any stiffness (n,) bool."""
    strong = abs(K) > SHARED * abs(K).max()
    _, part = connected_components(strong, directed=False)
    return part, np.asarray(strong.sum(axis=0)).ravel() > 0


def blade_numbers(arrays: dict) -> np.ndarray:
    """Blade of every contact node of a whole disk (C,) int, counted by angle from the x axis.

    arrays: of a model file; each connected part of the sparse K_blade is a blade.
    Raises InputError: there is no K_blade, or a contact node has no row.
    """
    if f"K_blade/{PARTS[0]}" not in arrays:
        raise InputError(
            "contact_blade: a whole disk needs the blade of every contact node, or the stiffness "
            "of the blades (--blade, K_blade), which tells them apart"
        )
    nodes, dof, contact_node = (arrays[name] for name in ("nodes", "dof", "contact_node"))
    parts, shape = tuple(arrays[f"K_blade/{part}"] for part in PARTS), (len(dof), len(dof))
    part, _ = joined(sp.csr_array(parts, shape=shape))
    row = {node: k for k, node in enumerate(dof[:, 0].tolist())}
    if lost := [node for node in contact_node.tolist() if node not in row]:
        raise InputError(f"contact_node: node {lost[0]} has no rows")
    _, group = np.unique(part[[row[node] for node in contact_node.tolist()]], return_inverse=True)
    x, y = (np.bincount(group, nodes[contact_node, axis]) for axis in (0, 1))
    pitch = 2 * np.pi / len(x)
    turn = np.mod(np.arctan2(y, x) + pitch / 2, 2 * np.pi)  # the first blade may lie about 0
    return np.argsort(np.argsort(turn))[group]  # the rank of each in the order by angle


def blade_of_rows(disk: NeutralModel) -> np.ndarray:
    """Blade of every row (n,), -1 for none, from the connected parts of the blades' stiffness.

    Raises InputError when a part has no contact node, or has contact nodes of two blades.
    """
    part, touched = joined(disk.blade_stiffness)
    blade = np.full(part.max() + 1, -1)
    at = disk.row[disk.contact_node, 0]
    for number, contact in zip(part[at], disk.contact_blade, strict=True):
        if blade[number] not in (-1, contact):
            raise InputError(
                f"K_blade: blades {blade[number]} and {contact} hang together; it must hold the "
                "stiffness of the blades alone"
            )
        blade[number] = contact
    if not touched[at].all():
        raise InputError("K_blade: a contact node is on no blade of it")
    lost = np.unique(part[touched][blade[part[touched]] < 0])
    if len(lost):
        raise InputError(f"K_blade: {len(lost)} blades of it have no contact nodes")
    split = len(np.unique(part[at])) - len(np.unique(disk.contact_blade))
    if split:
        raise InputError(f"K_blade: blades in pieces that do not touch, {split} too many")
    return np.where(touched, blade[part], -1)
