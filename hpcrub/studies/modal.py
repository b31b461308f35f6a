"""Modes of the tuned disk: frequencies of the full and the reduced model, shapes for figures."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.linalg import eigh

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.effects.effect import Load
from hpcrub.model import crossings, damping, families
from hpcrub.model.disk import Points
from hpcrub.model.imported import cyclic
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cartesian
from hpcrub.model.imported.neutral import contact_rows, stiffness_at
from hpcrub.model.reduction import ReducedModel
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, USELESS, Finding
from hpcrub.runs.study import Poll, Study, Values
from hpcrub.setup import imported
from hpcrub.setup.problem import Model, build_model

FAR_OFF = 0.01  # error of the first family's frequencies that moves all crossings too far
MOST_SHAPES = 48  # modes whose shapes are kept
_DIAMETERS = "nodal diameters of a mode"
_FREQUENCIES = (
    Dataset("full/frequencies_hz", ("dof",), "Hz", "frequencies of the full model"),
    Dataset("full/nodal_diameters", ("dof",), "1", _DIAMETERS, "i8"),
    Dataset("reduced/frequencies_hz", ("mode",), "Hz", "frequencies of the reduced model"),
    Dataset("reduced/nodal_diameters", ("mode",), "1", _DIAMETERS, "i8"),
    Dataset("blade_share", (), "1", "blades' part in the stiffness of the first family"),
    Dataset("crossing_hz", (), "Hz",
            "speed at which the casing's order meets the first family without contact; nan: never"),
    Dataset("shapes", ("shape", "node", "axis"), "1", "displacements of a mode, largest one is 1"),
)  # fmt: skip
PLANAR = (
    Dataset("position_m", ("node", "axis"), "m", "nodes of the disk, x and y"),
    Dataset("blades", ("blade", "blade_node"), "1", "nodes of a blade, root to tip", "i8"),
    Dataset("ring", ("blade", "end"), "1", "end nodes of every ring element", "i8"),
    Dataset("spokes", ("blade", "end"), "1", "inner and outer node of every spoke", "i8"),
    *_FREQUENCIES,
)
OF_FILE = (  # for a model file
    Dataset("position_m", ("node", "axis"), "m", "nodes of the disk, x, y and z"),
    Dataset("surface", ("face", "corner"), "1", "nodes of the faces of its surface", "i8"),
    Dataset("contact_node", ("point",), "1", "node of every contact point", "i8"),
    Dataset("contact_blade", ("point",), "1", "blade of every contact point", "i8"),
    *_FREQUENCIES,
)


def _of_file(config: Config, model: Model) -> Iterator[Values]:
    """Results for a model file, with the stiffness at the middle of the band of speeds."""
    disk, reduced = model
    seen, face = imported.scenery(config), reduced.interface
    for name in ("surface", "contact_node", "contact_blade"):
        yield name, (), getattr(seen, name)
    yield "position_m", (), seen.nodes
    yield from _of_reduced(config, reduced, cyclic.tuned_diameters(reduced))
    if disk is not None:
        K = stiffness_at(disk.stiffness, reduced.speed).tocsc()
        values, full = lowest_modes(K, disk.mass.tocsc(), min(MOST_SHAPES, len(reduced.mass)))
        tips = full[contact_rows(disk)]  # (p, C, K)
        yield "full/frequencies_hz", (), np.sqrt(values) / (2 * np.pi)
        yield "full/nodal_diameters", (), cyclic.diameters_of(tips, face.blade, face.angle)
    shapes = reduced.basis @ reduced.tuned_modes[:, :MOST_SHAPES]
    shapes = np.vstack([shapes, np.zeros(shapes.shape[1])])  # row -1: nodes that are held
    xyz = to_cartesian(seen.nodes, shapes[seen.rows])  # (n, 3, K)
    largest = np.linalg.norm(xyz, axis=1).max(axis=0)
    yield "shapes", (), np.moveaxis(xyz / largest, 2, 0)


def _of_reduced(config: Config, reduced: ReducedModel, diameters: Any) -> Iterator[Any]:
    """Modes and first family of the reduced model; diameters: nodal diameters of the modes."""
    yield "reduced/frequencies_hz", (), np.sqrt(reduced.tuned_eigenvalues) / (2 * np.pi)
    yield "reduced/nodal_diameters", (), diameters
    yield "crossing_hz", (), crossings.of_disk(reduced, diameters, config.casing.main_order)
    yield "blade_share", (), families.share(reduced)


def _diameters(shapes: Any, n_blades: int) -> Any:
    """Nodal diameters of modes (n, K) whose dof are sorted by sector, each in its own frame."""
    sectors = shapes.reshape(n_blades, -1, shapes.shape[1])
    angle = 2 * np.pi * np.arange(n_blades) / n_blades
    return cyclic.nodal_diameters(sectors.swapaxes(0, 1), angle)


def displacements(points: Points, shapes: np.ndarray) -> np.ndarray:
    """Displacements of the nodes in x and y, scaled so that the largest is 1.

    points: disk.Points; shapes: (n, K). Returns (K, n_nodes, 2).
    """
    padded = np.vstack([shapes, np.zeros((1, shapes.shape[1]))])  # dof -1 is clamped
    radial, tangential = padded[points.dof[:, 0]].T, padded[points.dof[:, 1]].T
    c, s = np.cos(points.frame), np.sin(points.frame)
    xy = np.stack([c * radial - s * tangential, s * radial + c * tangential], axis=2)
    largest = np.hypot(xy[..., 0], xy[..., 1]).max(axis=1)
    return xy / largest[:, None, None]


class Modal(Study):
    """Modes of the tuned disk."""

    name = "modal"
    what = "the disk, its mode shapes, SAFE diagram"
    mistunes = False
    prepare = staticmethod(build_model)

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets for a planar disk or a model file, for waves of the casing and for air."""
        of_disk = PLANAR if config.disk.model is None else OF_FILE
        return of_disk + self.of_effects(config)

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions, as far as no model file has to be read."""
        shapes = {"shape": min(MOST_SHAPES, config.n_coordinates)}
        if config.disk.model is not None:
            return shapes | {"axis": 3, "corner": 4, "point": config.disk.n_points}
        blade = config.disk.blade
        return shapes | {
            "node": config.disk.n_blades * (blade.n_elements + 2),
            "axis": 2,
            "end": 2,
            "blade_node": blade.n_elements + 1,
            "dof": config.disk.n_dof,
        }

    def source_sizes(self, config: Config) -> dict[str, int]:
        """Numbers of nodes, faces and frequencies of a model file."""
        if config.disk.model is None:
            return {}
        seen = imported.scenery(config)
        n_modes = 0 if seen.is_reduced else min(MOST_SHAPES, config.n_coordinates)
        return {"node": len(seen.nodes), "face": len(seen.surface), "dof": n_modes}

    def compute(self, config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Compute frequencies, shapes, waves of a casing that vibrates, and damping by the air."""
        for effect in effects.of(config):
            for name, values in effect.of_model(self.name, config, [Load(problem)]):
                yield name, (), values
        if config.disk.model is not None:
            yield from _of_file(config, problem)
            return
        disk, reduced = problem
        n_blades = len(disk.blade_dof)
        eigenvalues, full = eigh(disk.stiffness, disk.mass)
        shapes = reduced.basis @ reduced.tuned_modes
        yield "full/frequencies_hz", (), np.sqrt(eigenvalues) / (2 * np.pi)
        yield "full/nodal_diameters", (), _diameters(full, n_blades)
        yield from _of_reduced(config, reduced, _diameters(shapes, n_blades))
        points = disk.points
        for name in ("blades", "ring", "spokes"):
            yield name, (), getattr(points, name)
        yield "position_m", (), points.position
        yield "shapes", (), displacements(points, shapes[:, :MOST_SHAPES])

    def report(self, file: ResultFile) -> Iterator[str]:
        """First frequencies of both models, spread and crossing of the first family, and air."""
        for kind in ("full", "reduced"):
            frequencies = file.read(f"{kind}/frequencies_hz")
            if not len(frequencies):  # a model file that is reduced already has no full model
                continue
            modes = zip(frequencies, file.read(f"{kind}/nodal_diameters"), strict=True)
            words = [f"{f:.4f} ({d})" for f, d in modes][: file.config.disk.n_blades + 2]
            about = f"{kind} model, {len(frequencies)} modes, Hz (nodal diameters)"
            yield f"{about}: {', '.join(words)}"
        config, (full, reduced) = file.config, _first_families(file)
        half_range = config.mistuning.half_range.max()
        ratio = float(np.mean(damping.ratios_of(config.damping, 2 * np.pi * reduced)))
        yield families.sentence(full, reduced, float(file.read("blade_share")), half_range, ratio)
        order, speed = config.casing.main_order, float(file.read("crossing_hz"))
        meets = "never meets the first family"
        if np.isfinite(speed):
            there = f"{speed:.4g} Hz, where its frequency is {order * speed:.4g} Hz"
            meets = f"meets the first family at {there}"
        yield f"without contact, order {order} {meets}"
        yield from effects.lines(file)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Error of the first family's frequencies by the reduction."""
        full, reduced = _first_families(file)
        if len(full):
            error = float(np.abs(np.sort(reduced) / np.sort(full) - 1.0).max())
            by = f"{100 * error:.2g} %"
            yield Finding(
                USELESS if error > FAR_OFF else REMARK,
                f"first family off by {by}",
                f"the reduction changes frequencies of the first family by up to {by}: "
                "reduction.n_modes",
            )


def _first_families(file: ResultFile) -> list[Any]:
    """Frequencies of the first family [Hz], of the full model and of the reduced one."""
    n = file.config.disk.n_blades
    return [file.read(f"{kind}/frequencies_hz")[:n] for kind in ("full", "reduced")]


STUDY = Modal()
