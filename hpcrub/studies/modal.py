"""Modes of the tuned disk: full model beside the reduced one, shapes to draw."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.linalg import eigh

from hpcrub.config.schema import Config
from hpcrub.model.disk import Points
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.studies.problem import build_model
from hpcrub.studies.study import Poll, Study, Values

MOST_SHAPES = 48  # modes whose shapes are kept
_DIAMETERS = "nodal diameters of a mode"
LAYOUT = (
    Dataset("position_m", ("node", "axis"), "m", "nodes of the disk, x and y"),
    Dataset("blades", ("blade", "blade_node"), "1", "nodes of a blade, root to tip", "i8"),
    Dataset("ring", ("blade", "end"), "1", "end nodes of every ring element", "i8"),
    Dataset("spokes", ("blade", "end"), "1", "inner and outer node of every spoke", "i8"),
    Dataset("full/frequencies_hz", ("dof",), "Hz", "frequencies of the full model"),
    Dataset("full/nodal_diameters", ("dof",), "1", _DIAMETERS, "i8"),
    Dataset("reduced/frequencies_hz", ("mode",), "Hz", "frequencies of the reduced model"),
    Dataset("reduced/nodal_diameters", ("mode",), "1", _DIAMETERS, "i8"),
    Dataset(
        "shapes", ("shape", "node", "axis"), "1", "displacements x, y of a mode, largest one is 1"
    ),
)


def sizes(config: Config) -> dict[str, int]:
    """Length of every dimension."""
    blade, n_blades = config.disk.blade, config.disk.n_blades
    n_modes = config.n_coordinates
    return {
        "node": n_blades * (blade.n_elements + 2),
        "axis": 2,
        "end": 2,
        "blade": n_blades,
        "blade_node": blade.n_elements + 1,
        "dof": config.disk.n_dof,
        "mode": n_modes,
        "shape": min(MOST_SHAPES, n_modes),
    }


def compute(config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
    """Frequencies and shapes."""
    disk, reduced = problem
    n_blades = len(disk.blade_dof)
    eigenvalues, full = eigh(disk.stiffness, disk.mass)
    shapes = reduced.basis @ reduced.tuned_modes
    yield "full/frequencies_hz", (), np.sqrt(eigenvalues) / (2 * np.pi)
    yield "full/nodal_diameters", (), nodal_diameters(full, n_blades)
    yield "reduced/frequencies_hz", (), np.sqrt(reduced.tuned_eigenvalues) / (2 * np.pi)
    yield "reduced/nodal_diameters", (), nodal_diameters(shapes, n_blades)
    points = disk.points
    for name in ("blades", "ring", "spokes"):
        yield name, (), getattr(points, name)
    yield "position_m", (), points.position
    yield "shapes", (), displacements(points, shapes[:, :MOST_SHAPES])


def nodal_diameters(shapes: np.ndarray, n_blades: int) -> np.ndarray:
    """Number of nodal diameters of every mode.

    shapes: (n, K) on the dof of the full model, which come sector by sector in turning frames.
    Returns (K,) int: the harmonic of the sectors with the largest share.
    """
    sectors = shapes.reshape(n_blades, -1, shapes.shape[1])
    size = (np.abs(np.fft.fft(sectors, axis=0)) ** 2).sum(axis=1)
    harmonic = np.arange(n_blades)
    folded = np.zeros((n_blades // 2 + 1, shapes.shape[1]))
    np.add.at(folded, np.minimum(harmonic, n_blades - harmonic), size)
    return folded.argmax(axis=0)


def displacements(points: Points, shapes: np.ndarray) -> np.ndarray:
    """Displacements of the nodes in x and y, scaled to 1.

    points: disk.Points; shapes: (n, K). Returns (K, n_nodes, 2).
    """
    padded = np.vstack([shapes, np.zeros((1, shapes.shape[1]))])  # dof -1 is clamped
    radial, tangential = padded[points.dof[:, 0]].T, padded[points.dof[:, 1]].T
    c, s = np.cos(points.frame), np.sin(points.frame)
    xy = np.stack([c * radial - s * tangential, s * radial + c * tangential], axis=2)
    largest = np.hypot(xy[..., 0], xy[..., 1]).max(axis=1)
    return xy / largest[:, None, None]


def report(file: ResultFile) -> Iterator[str]:
    """First frequencies of both models."""
    for kind in ("full", "reduced"):
        frequencies, diameters = (
            file.read(f"{kind}/{name}") for name in ("frequencies_hz", "nodal_diameters")
        )
        n = file.config.disk.n_blades + 2
        first = ", ".join(
            f"{f:.4f} ({d})" for f, d in zip(frequencies[:n], diameters, strict=False)
        )
        yield f"{kind} model, {len(frequencies)} modes, Hz (nodal diameters): {first}"


def problems(config: Config) -> Iterator[str]:
    """Keys that do not fit this study."""
    if config.disk.model is not None:
        yield "disk.model: modal is of the planar disk; `hpcrub import model` prints frequencies"


STUDY = Study(
    name="modal",
    problems=problems,
    figures="1, 2",
    what="the disk, its mode shapes, SAFE diagram",
    layout=lambda config: LAYOUT,
    scales={},
    sizes=sizes,
    prepare=build_model,
    compute=compute,
    report=report,
)
