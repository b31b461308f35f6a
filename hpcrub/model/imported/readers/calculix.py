"""Reader of CalculiX: matrices of SOLVER=MATRIXSTORAGE, mesh and sets of the deck, stress."""

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError, reading
from hpcrub.model.imported import stress as recovery
from hpcrub.model.imported.arrays import stored
from hpcrub.model.imported.readers import deck as decks
from hpcrub.model.imported.readers.rows import Lists, Mesh, Rows, arrays_of, places, whole
from hpcrub.model.imported.readers.text import content, existing

INCOMPATIBLE = "C3D8I"  # elements with three inner nodes each, numbered after all others
INNER = 3
EIGENVALUES = re.compile(r"E I G E N V A L U E   O U T P U T\D*((?:\s*\d.*\n)+)")
RIGID = 1e-6  # of the largest eigenvalue: below 0 by less is the rounding of a rigid motion


def read(
    path: str | Path,
    lists: Lists,
    blade: str | Path | None = None,
    stiffness: dict[float, str | Path] | None = None,
    stress: str | Path | None = None,
) -> dict:
    """Read the arrays of a model file from jobs of CalculiX.

    path: deck NAME.inp of the disk at rest, with node sets that `lists` names. NAME.sti, NAME.mas
        and NAME.dof lie beside each deck.
    blade: deck with the elements of the blades alone.
    stiffness: decks of jobs at two other speeds [Hz].
    stress: .dat file with displacements and stresses of modes of this mesh; the model then gets
        a group of six rows of stress for each integration point, see `imported.stress`.
    Raises InputError: a file or a set is missing or cannot be read.
    """
    deck = decks.read(path)
    if "CYCLIC SYMMETRY MODEL" in deck.keywords:
        raise InputError(
            f"{path}: *CYCLIC SYMMETRY MODEL takes the rows of one side out of the matrices; leave "
            "it and its *TIE out of the job that stores them"
        )
    mesh = Mesh(
        deck.node,
        deck.place,
        lambda name: decks.listed(deck.sets, name, f"{path}: there is no node set"),
        [corners for _, _, corners in deck.elements],
    )
    speeds = {0.0: path} | (stiffness or {})
    mass = job_matrix(path, "mas")
    K = {speed: job_matrix(job, "sti") for speed, job in speeds.items()}
    arrays = arrays_of(mesh, lists, K, mass, _blade_matrix(blade, deck) if blade else None)
    if stress:
        number = np.union1d(deck.node, mass.dof[:, 0])
        elements = _printed(stress, {label: nodes for _, label, nodes in deck.elements}, number)
        rows = recovery.rows(elements, arrays["dof"], len(number))
        arrays |= stored("stress", rows)
        arrays["stress_blade"] = np.zeros(rows.shape[0], dtype=np.int64)
    return arrays


def job_matrix(path: str | Path, kind: str) -> Rows:
    """Read the stiffness ("sti") or mass ("mas") of the deck NAME.inp. Raises InputError."""
    name, rows = (existing(Path(path).with_suffix(f".{ending}")) for ending in (kind, "dof"))
    for file in (rows, name):
        if not file.exists():
            raise InputError(
                f"{file}: there is no such file; ccx writes it in a step *FREQUENCY, "
                "SOLVER=MATRIXSTORAGE"
            )
    words = content(rows).split()
    with reading(name):
        dof = np.array([word.split(".") for word in words], dtype=np.int64).reshape(-1, 2)
        i, j, value = np.loadtxt(name, unpack=True, ndmin=2)
        place = whole(i, str(name)) - 1, whole(j, str(name)) - 1
        if (last := max(map(np.max, place), default=-1) + 1) > len(dof):
            raise InputError(f"{name}: has a row {last}, but {rows} names {len(dof)} rows")
        shape = (len(dof), len(dof))
        return Rows(sp.coo_array((value, place), shape=shape).tocsr(), dof, str(name))


def _blade_matrix(path: Any, deck: Any) -> Any:
    """Stiffness of the blades alone, with the inner nodes of elements numbered as in the disk."""
    blade, part = decks.read(path), job_matrix(path, "sti")
    inner = part.dof[:, 0] > blade.node.max()
    if not inner.any():
        return part
    labels = [label for kind, label, _ in deck.elements if kind == INCOMPATIBLE]
    own = [label for kind, label, _ in blade.elements if kind == INCOMPATIBLE]
    number = {label: k for k, label in enumerate(labels)}
    if lost := set(own) - set(number):
        raise InputError(f"{path}: element {min(lost)} is not one of the disk")
    first = deck.node.max() + 1 + INNER * np.array([number[label] for label in own])
    element, place = np.divmod(part.dof[inner, 0] - blade.node.max() - 1, INNER)
    moved = part.dof.copy()
    moved[inner, 0] = first[element] + place
    return part._replace(dof=moved)


def _printed(path: Any, elements: Any, number: Any) -> Iterator[Any]:
    """Yield nodes, displacements and stresses in the modes of each element in a .dat file.

    elements: {label: node numbers}; number: of all nodes of the model, increasing.
    """
    with reading(path):
        text = content(path)
        rows = "".join(EIGENVALUES.findall(text)).splitlines()
        eigenvalues = np.array([float(row.split()[1]) for row in rows if row.strip()])
        modes = list(_modes(text.splitlines()))
    lost = np.flatnonzero(eigenvalues < -RIGID * np.abs(eigenvalues).max(initial=0.0))
    still = [k for k, (moved, _) in enumerate(modes) if not moved[:, 1:].any()]
    if len(lost) or still:
        mode, what = (lost[0], "a negative eigenvalue") if len(lost) else (still[0], "no motion")
        raise InputError(
            f"{path}: mode {mode + 1} has {what}: ccx was asked for more modes than it can find in "
            f"this model; print fewer (*FREQUENCY), {mode} at most"
        )
    shapes = {(len(moved), stress.shape) for moved, stress in modes}
    if len(shapes) != 1:
        raise InputError(
            f"{path}: displacements and stresses of the same nodes and elements in several modes "
            "are expected (*NODE PRINT with U, then *EL PRINT with S)"
        )
    moved, stress = (np.array(part) for part in zip(*modes, strict=True))
    node, label = moved[0, :, 0], stress[0, :, 0]
    order = np.argsort(node)
    for one in np.unique(label):
        if int(one) not in elements:
            raise InputError(f"{path}: element {one:g} is not one of the deck")
        nodes = np.array(elements[int(one)])
        at = order[places(nodes, node[order], str(path))]
        yield places(nodes, number, str(path)), moved[:, at, 1:], stress[:, label == one, 2:]


def _modes(lines: Any) -> Iterator[Any]:
    """Yield displacements (nodes, 4) and stresses (points, 8) mode by mode."""
    blocks: list[tuple[str, list[Any]]] = [("", [])]
    for words in filter(None, map(str.split, lines)):
        if words[0].isdigit():
            blocks[-1][1].append(words)
        else:
            blocks.append((words[0], []))
    for (first, moved), (second, stress) in pairwise(blocks):
        if (first, second) == ("displacements", "stresses"):
            yield np.array(moved, dtype=float), np.array(stress, dtype=float)
