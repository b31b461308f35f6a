"""`hpcrub import`: the matrices of a finite-element program, to a model file of a bladed disk."""

import argparse
import sys
from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh

from hpcrub.errors import HpcrubError, InputError
from hpcrub.model.imported import (
    assembly,
    blades,
    checks,
    craig_bampton,
    cyclic,
    neutral,
    reduced,
)
from hpcrub.model.imported.frames import about_z, node_angle
from hpcrub.model.imported.readers import ansys, calculix, matrix_market, nastran
from hpcrub.model.imported.readers.rows import PARTS, Lists
from hpcrub.ranks.progress import console
from hpcrub.results import model_file

MODES_PER_DIAMETER = 3
MODES_OF_DISK = 4  # for each blade


def main(argv: list[str] | None = None) -> int:
    """Import a model and print what it is; returns the exit code."""
    try:
        options = parser().parse_args(argv)
        model = import_model(options)
        for line in report(model, options):
            console().print(line, soft_wrap=True, highlight=False)
        if options.reduce is not None:
            model = reduce(model, options)
        if options.output:
            model_file.write(options.output, neutral.to_arrays(model))
            console().print(f"model file: {options.output}", soft_wrap=True, highlight=False)
    except HpcrubError as error:
        print(f"hpcrub: error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    top = argparse.ArgumentParser(prog="hpcrub import", description=__doc__)
    formats = top.add_subparsers(dest="format", required=True)
    add = formats.add_parser
    for name, what, mesh in (
        ("calculix", "deck NAME.inp beside NAME.sti, NAME.mas and NAME.dof", None),
        ("ansys", "NAME.full of the disk at rest", "NAME.cdb with nodes and components"),
        ("nastran", "text OP4 file with KGG and MGG", "bulk data with the grid points"),
    ):
        one = add(name, help=what)
        one.add_argument("source", help=what)
        if mesh:
            one.add_argument("--mesh", required=True, metavar="FILE", help=mesh)
        _add_lists(one)
        _add_common(one)
    one = add("matrixmarket", help="a folder with M.mtx, K.mtx and CSV lists")
    one.add_argument("source", help="the folder")
    one.add_argument("--sectors", type=int, default=0, metavar="N", help="of which this is one")
    _add_common(one)
    one = add("model", help="a model file: check it, reduce it")
    one.add_argument("source", help="model file")
    _add_common(one)
    return top


def _add_lists(one):
    one.add_argument("--contact", required=True, metavar="SET", help="nodes that may touch")
    one.add_argument("--low", metavar="SET", help="side of a sector at the smaller angle")
    one.add_argument("--high", metavar="SET", help="side of a sector at the larger angle")
    one.add_argument("--sectors", type=int, default=0, metavar="N", help="number of sectors")
    one.add_argument("--fixed", metavar="SET", help="nodes that are held, if the file has them")
    one.add_argument("--blade", metavar="FILE", help="the same, of the blades' elements alone")
    one.add_argument(
        "--stiffness", action="append", default=[], metavar="HZ=FILE",
        help="the same, prestressed by a speed of rotation; given twice",
    )  # fmt: skip


def _add_common(one):
    one.add_argument("--output", metavar="FILE.h5", help="model file that is written (or .npz)")
    one.add_argument("--units", help='of the source, such as "mm t s"; of a model file its own')
    one.add_argument("--axis", choices=("x", "y", "z"), default="z", help="of rotation")
    one.add_argument("--blades", type=int, default=0, metavar="N", help="of a whole disk")
    one.add_argument("--reduce", type=int, metavar="MODES", help="write the reduced model")
    one.add_argument(
        "--speed-hz", type=float, default=0.0, help="of rotation, for frequencies and mode shapes"
    )
    one.add_argument("--step-s", type=float, default=2e-6, help="time step of the highest omega h")


def import_model(options: argparse.Namespace) -> neutral.NeutralModel:
    """The checked model that the options name. Raises InputError."""
    _check_numbers(options)
    arrays = _arrays(options)
    if options.axis != "z" and str(arrays.get("frame")) == "cylindrical":
        raise InputError(f"--axis {options.axis}: cylindrical directions are about z")
    if options.units:
        arrays["units"] = np.array(options.units)
    elif options.format != "model":
        raise InputError('--units: the files do not tell their units, such as --units "mm t s"')
    about_z(arrays, options.axis)
    if str(arrays.get("kind")) == "disk" and "contact_blade" not in arrays:
        arrays["contact_blade"] = _numbered(arrays, options.blades)
    return neutral.from_arrays(arrays)


def _check_numbers(options):
    if not 0.0 <= options.speed_hz < np.inf:
        raise InputError(f"--speed-hz: {options.speed_hz:g} is not 0 or more")
    if not 0.0 < options.step_s < np.inf:
        raise InputError(f"--step-s: {options.step_s:g} is not above 0")
    if options.reduce is not None and options.reduce < 0:
        raise InputError(f"--reduce: {options.reduce} is not 0 or more")


def _arrays(options):
    if options.format == "model":
        return model_file.read(options.source)
    if options.format == "matrixmarket":
        return matrix_market.read(options.source, options.sectors)
    if bool(options.low) != bool(options.high) or bool(options.low) != bool(options.sectors):
        raise InputError("--low, --high, --sectors: a sector needs all three")
    lists = Lists(options.contact, options.low, options.high, options.sectors, options.fixed)
    others = options.blade, dict(_speed(text) for text in options.stiffness)
    if options.format == "calculix":
        return calculix.read(options.source, lists, *others)
    module = {"ansys": ansys, "nastran": nastran}[options.format]
    return module.read(options.source, options.mesh, lists, *others)


def _speed(text):
    speed, _, name = text.partition("=")
    try:
        return float(speed), name
    except ValueError:
        raise InputError(f"--stiffness: {text} is not of the form HZ=FILE") from None


def _numbered(arrays, n_blades):
    blade = None
    if f"K_blade/{PARTS[0]}" in arrays:
        n = len(arrays["dof"])
        blade = sp.csr_array(tuple(arrays[f"K_blade/{part}"] for part in PARTS), shape=(n, n))
    mesh = (arrays[name] for name in ("nodes", "dof", "contact_node"))
    return blades.number(*mesh, blade, n_blades)


def report(model: neutral.NeutralModel, options: argparse.Namespace) -> Iterator[str]:
    """Lines about a model. Raises InputError for what cannot be right."""
    found = checks.check(model)
    per_blade = np.bincount(model.contact_blade)
    yield (
        f"{model.kind}: {len(model.dof):,} dof, {model.n_blades} blades, "
        f"{per_blade.min()} to {per_blade.max()} contact nodes each, "
        f"tip radius {1e3 * found.tip_radius:.6g} mm (to {1e3 * found.tip_gap:.2g} mm below it)"
    )
    if model.kind != "reduced":
        yield f"mass: {found.mass:.6g} kg of the whole disk, rows that are not there left out"
        yield (
            f"rigid motions: leave {found.rigid_residual:.1e} of a row's entries (median); "
            f"{found.loaded_rows} rows feel supports"
        )
    if model.kind == "sector":
        *_, error = assembly.pair_sides(model.nodes, model.low, model.high, model.n_sectors)
        yield f"sides: {len(model.low)} nodes each, pairs miss by at most {1e3 * error:.2g} mm"
    if model.blade_stiffness is None:
        yield "blades' stiffness: none; blades can be mistuned only with it (--blade)"
    at = "at rest" if not options.speed_hz else f"at {options.speed_hz:g} Hz"
    if options.speed_hz and len(model.stiffness) == 1:
        yield "centrifugal stiffening: none, the stiffness is that of one speed"
    table = frequencies_by_diameter(model, 2 * np.pi * options.speed_hz)
    checks.check_frequency(np.nanmin(table))
    yield f"first frequencies by nodal diameter [Hz], {at}; speeds [Hz] at which n_d bumps meet the"
    yield "first family by n_d = diameters or n_d = blades - diameters (SAFE diagram):"
    for diameters, row in enumerate(table):
        yield f"  {diameters:3d}: " + _safe_row(row, diameters, model.n_blades)


def _safe_row(row, diameters, n_blades):
    text = "  ".join(f"{f:11.4f}" for f in row if np.isfinite(f))
    orders = sorted({n for n in (diameters, n_blades - diameters) if n})
    return f"{text}   " + ", ".join(f"n_d = {n}: {row[0] / n:.4g}" for n in orders)


def frequencies_by_diameter(model: neutral.NeutralModel, speed: float) -> np.ndarray:
    """First frequencies of each number of nodal diameters (H, MODES_PER_DIAMETER) [Hz].

    speed: of rotation [rad/s]. NaN where fewer are known.
    """
    n_diameters = model.n_blades // 2 + 1
    if model.kind == "sector":
        rows = (
            cyclic.sector_frequencies(model, h, MODES_PER_DIAMETER, speed)
            for h in range(n_diameters)
        )
        return np.array(list(rows))
    n_modes = MODES_OF_DISK * model.n_blades
    if model.kind == "disk":
        disk = assembly.assemble(model)
        K, M = neutral.stiffness_at(disk.stiffness, speed).tocsc(), disk.mass.tocsc()
        values, vectors = craig_bampton.lowest_modes(K, M, min(n_modes, M.shape[0]))
        shapes = vectors[craig_bampton.boundary_rows(disk)]
        angle = node_angle(disk.nodes[disk.contact_node])
    else:
        face = reduced.interface(model)
        values, vectors = eigh(neutral.stiffness_at(model.stiffness, speed), model.mass)
        values, vectors = values[:n_modes], vectors[:, :n_modes]
        shapes = np.concatenate(
            [rows @ vectors for rows in (face.normal, face.tangential, face.axial)]
        )
        angle = face.angle
    return _sorted_by_diameter(values, shapes, angle, model, n_diameters)


def _sorted_by_diameter(values, shapes, angle, model, n_diameters):
    """Table of `frequencies_by_diameter` for like contact points of all blades."""
    shapes = shapes.reshape(-1, len(angle), shapes.shape[1])
    diameters = cyclic.diameters_of(shapes, model.contact_blade, angle)
    table = np.full((n_diameters, MODES_PER_DIAMETER), np.nan)
    frequency = np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)
    for h in range(n_diameters):
        mine = frequency[diameters == h]
        single = h == 0 or 2 * h == model.n_blades
        mine = (mine if single else mine[::2])[:MODES_PER_DIAMETER]
        table[h, : len(mine)] = mine
    return table


def reduce(model: neutral.NeutralModel, options: argparse.Namespace) -> neutral.NeutralModel:
    """The reduced model, its highest frequency said on the screen. Raises InputError."""
    if model.kind == "reduced":
        raise InputError("--reduce: this model is reduced already")
    speed = 2 * np.pi * options.speed_hz
    small, _ = reduced.reduce_disk(assembly.assemble(model), options.reduce, speed)
    values = eigh(neutral.stiffness_at(small.stiffness, speed), small.mass, eigvals_only=True)
    omega = np.sqrt(np.maximum(values, 0.0))
    console().print(
        f"reduced: {len(omega)} coordinates, highest frequency {omega[-1] / (2 * np.pi):.4g} Hz, "
        f"highest omega h {omega[-1] * options.step_s:.3g} at a time step of {options.step_s:g} s",
        soft_wrap=True,
        highlight=False,
    )
    return small
