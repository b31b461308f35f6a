"""Reader of Abaqus: matrices of *MATRIX GENERATE, mesh and sets of the deck."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.readers import deck as decks
from hpcrub.model.imported.readers.nodal import cylindrical
from hpcrub.model.imported.readers.rows import File, Files, Lists, Mesh, Rows, arrays_of, whole
from hpcrub.model.imported.readers.text import content

STEP = (
    "a step with *MATRIX GENERATE, STIFFNESS, MASS and *MATRIX OUTPUT, STIFFNESS, MASS, "
    "FORMAT=MATRIX INPUT"
)


def read(
    path: File, lists: Lists, blade: File | None = None, stiffness: Files | None = None
) -> dict:
    """Read the arrays of a model file from jobs of Abaqus.

    path: deck NAME.inp of the disk at rest, with node sets that `lists` names. Beside each deck lie
        NAME_STIFn.mtx and NAME_MASSn.mtx, n the number of their step.
    blade: deck with the elements of the blades alone, without supports.
    stiffness: decks of jobs at two other speeds [Hz].
    Raises InputError: a file or a set is missing or cannot be read.
    """
    deck = decks.read(path)
    mesh = Mesh(
        deck.node,
        deck.place,
        lambda name: decks.listed(deck.sets, name, f"{path}: there is no node set"),
        [corners for _, _, corners in deck.elements],
        _own_axes(deck),
    )
    K = {speed: job_matrix(job, "STIF") for speed, job in ({0.0: path} | (stiffness or {})).items()}
    mass = _on_rows(job_matrix(path, "MASS"), [part.dof for part in K.values()])
    return arrays_of(mesh, lists, K, mass, job_matrix(blade, "STIF") if blade else None)


def job_matrix(path: File, kind: str) -> Rows:
    """Read the stiffness ("STIF") or the mass ("MASS") of a job. Raises InputError.

    Its lines are node, direction, node, direction, value, of one triangle or of the whole matrix.
    """
    name = _file_of(Path(path), kind)
    with reading(name):
        first = next((x for x in content(name).splitlines() if x.strip() and x[0] not in "*#"), "")
        separator = "," if "," in first else None
        entries = np.loadtxt(name, delimiter=separator, comments=("*", "#"), ndmin=2)
    if entries.shape[1] != 5:
        raise InputError(
            f"{name}: {entries.shape[1]} numbers in a line; node, direction, node, direction, "
            "value are expected, as FORMAT=MATRIX INPUT writes them"
        )
    ends = whole(entries[:, :4], str(name)).reshape(-1, 2, 2)
    dof, row = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    i, j = row.reshape(-1, 2).T
    shape = (len(dof), len(dof))
    return Rows(sp.coo_array((entries[:, 4], (i, j)), shape=shape).tocsr(), dof, str(name))


def _file_of(deck: Path, kind: str) -> Path:
    """Path of the one matrix of a kind that a job has written, whatever its step."""
    own = re.compile(rf"{re.escape(deck.stem)}_{kind}\d+\.mtx(\.gz)?", re.IGNORECASE)
    found = sorted(path for path in deck.parent.iterdir() if own.fullmatch(path.name))
    if not found:
        raise InputError(
            f"{deck}: there is no {deck.stem}_{kind}1.mtx beside it (or of another step); Abaqus "
            f"writes it in {STEP}"
        )
    if len(found) > 1:
        raise InputError(
            f"{deck}: there are {' and '.join(path.name for path in found)}; leave that of the "
            "state that is meant"
        )
    return found[0]


def _on_rows(part: Rows, others: list[np.ndarray]) -> Rows:
    """Matrix on its own rows and on those of others; held rows and rotations may lack a mass."""
    dof, row = np.unique(np.concatenate([part.dof, *others]), axis=0, return_inverse=True)
    entries = sp.coo_array(part.matrix)
    at = row[: len(part.dof)]
    shape = (len(dof), len(dof))
    matrix = sp.coo_array((entries.data, (at[entries.row], at[entries.col])), shape=shape)
    return Rows(matrix.tocsr(), dof, part.name)


def _own_axes(deck: Any) -> dict[int, np.ndarray]:
    """Directions of the nodes that *TRANSFORM turns, {node: (3, 3), a direction in each row}."""
    place = dict(zip(deck.node.tolist(), deck.place, strict=True))
    axes: dict[int, np.ndarray] = {}
    for nodes, kind, (a, b) in deck.transforms:
        if kind == "R":  # a lies on the first direction, b in the plane of the first two
            third = np.cross(a, b)
            base = np.array([a, np.cross(third, a), third])
            base /= np.linalg.norm(base, axis=1)[:, None]
            axes |= dict.fromkeys(nodes.tolist(), base)
        else:  # about the axis from a to b
            base = _about(b - a)
            axes |= {node: cylindrical(base @ (place[node] - a)) @ base for node in nodes.tolist()}
    return axes


def _about(axis: np.ndarray) -> np.ndarray:
    """Any three unit vectors, the rows, of which the third one is along an axis."""
    third = axis / np.linalg.norm(axis)
    first = np.cross(np.eye(3)[np.abs(third).argmin()], third)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])
