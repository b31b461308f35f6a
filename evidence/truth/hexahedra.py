"""A small bladed disk of solid elements for tests: trilinear hexahedra, integrated here."""

import numpy as np
import scipy.sparse as sp

from evidence.blisk.mesh import CORNERS, Shape, sector, whole_disk

YOUNG, POISSON, DENSITY = 113.8e9, 0.33, 4430.0  # titanium
SMALL = Shape(
    n_sectors=5, radial=1, around=4, axial=1, span=3, through=2, thickness=14.0, width=30.0
)
STRAINS = (0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)
_SIGN = 2.0 * np.array(CORNERS) - 1.0


def matrices(nodes, elements):
    """K and M of trilinear hexahedra; nodes (n, 3) [m]. Returns two (3n, 3n) sparse arrays."""
    D = elasticity()
    K, M = (np.zeros((len(elements), 24, 24)) for _ in "KM")
    for shape, size, B in points(nodes, elements):
        K += size[:, None, None] * (B.transpose(0, 2, 1) @ D @ B)
        N = np.kron(shape, np.eye(3))
        M += DENSITY * size[:, None, None] * (N.T @ N)
    return tuple(_assembled(A, elements, len(nodes)) for A in (K, M))


def stresses(nodes, elements, moved):
    """Stresses (k, e, 8, 6) of displacements (k, n, 3) [m]: xx, yy, zz, xy, xz, yz at 8 points."""
    own = moved[:, elements].reshape(len(moved), len(elements), 24)
    parts = [np.einsum("ij,ejd,ked->kei", elasticity(), B, own)
             for _, _, B in points(nodes, elements)]  # fmt: skip
    return np.stack(parts, axis=2)[..., [0, 1, 2, 3, 5, 4]]


def about(nodes, elements, moved):
    """Tangent stiffness (3n, 3n) sparse and inner forces (n, 3) about displacements (n, 3) [m].

    Large displacements of a body whose stress is linear in Green's strain (St. Venant, Kirchhoff).
    """
    D = elasticity()
    K, force = np.zeros((len(elements), 24, 24)), np.zeros((len(elements), 24))
    for _, size, B in points(nodes, elements):
        rows = B.reshape(-1, 6, 8, 3)
        slope = np.stack([rows[:, i, :, i] for i in range(3)], axis=2)  # (e, 8, 3)
        H = np.einsum("eai,eaj->eij", moved[elements], slope)  # displacement gradient
        bent = np.zeros_like(rows)
        for row, (i, j) in enumerate(STRAINS):
            both = slope[:, :, i, None] * (np.eye(3) + H)[:, None, :, j]
            both = both + (i != j) * slope[:, :, j, None] * (np.eye(3) + H)[:, None, :, i]
            bent[:, row] = both
        bent = bent.reshape(-1, 6, 24)
        green = (H + H.swapaxes(1, 2) + H.swapaxes(1, 2) @ H) / 2
        strain = np.stack([green[:, i, j] * (1 + (i != j)) for i, j in STRAINS], axis=1)
        stress = strain @ D
        tensor = stress[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
        K += size[:, None, None] * (bent.transpose(0, 2, 1) @ D @ bent)
        pulled = np.einsum("eai,eij,ebj->eab", slope, tensor, slope)
        K += size[:, None, None] * np.einsum("eab,ij->eaibj", pulled, np.eye(3)).reshape(K.shape)
        force += size[:, None] * np.einsum("erk,er->ek", bent, stress)
    return _assembled(K, elements, len(nodes)), _summed(force, elements, len(nodes))


def _assembled(K, elements, n_nodes):
    rows = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 24)
    i, j = (np.broadcast_to(x, K.shape).ravel() for x in (rows[:, :, None], rows[:, None]))
    return sp.coo_array((K.ravel(), (i, j)), shape=(3 * n_nodes, 3 * n_nodes)).tocsr()


def _summed(force, elements, n_nodes):
    out = np.zeros((n_nodes, 3))
    np.add.at(out, elements, force.reshape(-1, 8, 3))
    return out


def elasticity():
    """Stresses of strains xx, yy, zz, xy, yz, xz (6, 6) [Pa]."""
    a = YOUNG / (1 + POISSON) / (1 - 2 * POISSON)
    D = np.zeros((6, 6))
    D[:3, :3] = a * POISSON
    D[range(6), range(6)] = a * np.array([1 - POISSON] * 3 + [0.5 - POISSON] * 3)
    return D


def points(nodes, elements):
    """Shape functions (8,), volumes (e,) and strains (e, 6, 24) at each of 8 points."""
    for point in _SIGN / np.sqrt(3):
        factors = 1 + _SIGN * point  # (8, 3)
        shape = factors.prod(axis=1) / 8
        others = np.stack([factors[:, [1, 2]], factors[:, [0, 2]], factors[:, [0, 1]]], axis=1)
        slope = _SIGN * others.prod(axis=2) / 8  # (8, 3)
        J = np.einsum("ai,eaj->eij", slope, nodes[elements])
        size = np.linalg.det(J)
        assert (size > 0).all()
        g = np.einsum("eij,aj->eai", np.linalg.inv(J), slope)
        B = np.zeros((len(elements), 6, 8, 3))
        for i in range(3):
            B[:, i, :, i] = g[:, :, i]
        for row, (i, j) in list(enumerate(STRAINS))[3:]:
            B[:, row, :, i], B[:, row, :, j] = g[:, :, j], g[:, :, i]
        yield shape, size, B.reshape(len(elements), 6, 24)


def leaning(mesh, lean):
    """The mesh with nodes turned about z the further the larger their radius, up to lean [rad]."""
    x, y, z = mesh.nodes.T
    r = np.hypot(x, y)
    angle = np.arctan2(y, x) + lean * (r / r.max()) ** 2
    return mesh._replace(nodes=np.column_stack([r * np.cos(angle), r * np.sin(angle), z]))


def sector_arrays(shape=SMALL, lean=0.0):
    """Arrays of a model file of one sector."""
    return _arrays(leaning(sector(shape), lean), "sector") | {
        "n_sectors": np.array(shape.n_sectors),
        "low": sector(shape).sets["low"],
        "high": sector(shape).sets["high"],
    }


def disk_arrays(shape=SMALL, lean=0.0):
    """Arrays of a model file of the whole disk."""
    mesh = leaning(whole_disk(sector(shape), shape.n_sectors), lean)
    blade = np.repeat(np.arange(shape.n_sectors), len(mesh.sets["tip"]) // shape.n_sectors)
    return _arrays(mesh, "disk") | {"contact_blade": blade}


def _arrays(mesh, kind):
    nodes = mesh.nodes / 1e3
    K, M = matrices(nodes, mesh.elements)
    K_blade, _ = matrices(nodes, mesh.elements[mesh.blade_elements])
    node, direction = np.divmod(np.arange(3 * len(nodes)), 3)
    arrays = {
        "hpcrub_model": np.array(1),
        "kind": np.array(kind),
        "nodes": nodes,
        "dof": np.column_stack([node, direction + 1]),
        "fixed": (3 * mesh.sets["bore"][:, None] + np.arange(3)).ravel(),
        "contact_node": mesh.sets["tip"],
    }
    return arrays | stored(K=K, M=M, K_blade=K_blade)


PARTS = "data", "indices", "indptr"


def stored(**matrices):
    """Sparse or dense matrices as the arrays of a model file."""
    rows = {name: sp.csr_array(matrix) for name, matrix in matrices.items()}
    return {f"{name}/{part}": getattr(rows[name], part) for name in rows for part in PARTS}


def matrix_of(arrays, name):
    """The sparse matrix of such arrays."""
    n = len(arrays["dof"])
    return sp.csr_array(tuple(arrays[f"{name}/{part}"] for part in PARTS), shape=(n, n))
