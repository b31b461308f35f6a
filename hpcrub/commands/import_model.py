"""`hpcrub import`: the matrices of a finite-element program, to a model file of a bladed disk."""

import argparse
import functools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.commands import import_bending
from hpcrub.config.text import counted
from hpcrub.errors import InputError, reading
from hpcrub.model import crossings, families
from hpcrub.model.imported import assembly, bent_blades, checks, cyclic, neutral, reduced, stress
from hpcrub.model.imported.arrays import Arrays
from hpcrub.model.imported.frames import about_z
from hpcrub.model.imported.readers import abaqus, ansys, calculix, matrix_market, nastran
from hpcrub.model.imported.readers.rows import Lists, whole
from hpcrub.model.imported.readers.text import table
from hpcrub.ranks.progress import say
from hpcrub.results import model_file

HALF_RANGE, DAMPING = 0.01, 0.005  # mistuning and damping in the sentence on coupling
LEAN = 1e-3  # lift by friction, below which blades count as straight: they move neither in nor out
PER_TIP = 1e-2, 1e6  # [MPa/mm] a stress of a first family outside comes from wrong units
RISES = 0.02, 20.0  # of a frequency's square over that of the speed; others come from wrong speeds
BETWEEN = 1.0  # [%] error of a frequency between the speeds of --stiffness that gives a warning

SOURCES = {
    "calculix": "deck NAME.inp beside NAME.sti, NAME.mas and NAME.dof",
    "ansys": "NAME.full of the disk at rest",
    "nastran": "OP4 file with KGG and MGG, text or binary",
    "abaqus": "deck NAME.inp beside NAME_STIF1.mtx and NAME_MASS1.mtx, of *MATRIX GENERATE",
    "matrixmarket": "a folder with M.mtx, K.mtx (or .hb, Harwell-Boeing) and CSV lists",
    "model": "a model file: check it, reduce it",
}
DECKS = "calculix", "ansys", "nastran", "abaqus"
OPTIONS: tuple[tuple[Iterable[str], str, dict[str, Any]], ...] = (  # formats that have it, option
    (["ansys", "nastran"], "--mesh", {
        "required": True, "metavar": "FILE",
        "help": "NAME.cdb with nodes and components; bulk data with the grid points"}),
    (["calculix"], "--stress", {
        "metavar": "MODES.dat",
        "help": "of a sector: displacements and stresses of modes of the same mesh"}),
    (DECKS, "--contact", {"required": True, "metavar": "SET", "help": "nodes that may touch"}),
    (DECKS, "--low", {"metavar": "SET", "help": "side of a sector at the smaller angle"}),
    (DECKS, "--high", {"metavar": "SET", "help": "side of a sector at the larger angle"}),
    ((*DECKS, "matrixmarket"), "--sectors", {
        "type": int, "default": 0, "metavar": "N", "help": "number of sectors, if this is one"}),
    (DECKS, "--fixed", {"metavar": "SET", "help": "nodes that are held, if the file has them"}),
    (DECKS, "--blade", {"metavar": "FILE", "help": "the same, of the blades' elements alone"}),
    (DECKS, "--stiffness", {
        "action": "append", "default": [], "metavar": "HZ=FILE",
        "help": "the same, prestressed by a speed of rotation; given twice"}),
    (["model"], "--stress", {
        "metavar": "TABLE.csv",
        "help": "of a reduced model: a row for each place, its blade from 0, then its stress for "
        "a unit of each coordinate"}),
    (["model"], "--static", {
        "metavar": "TABLE.csv", "help": "stress of the rotation, a line for each place"}),
    (["model"], "--second-order", {
        "metavar": "FOLDER",
        "help": "one blade alone, and bent into its modes: blade.h5; bent_1.csv, forwards_1.h5, "
        "backwards_1.h5, and so on"}),
    (["model"], "--table-units", {
        "metavar": "UNITS",
        "help": 'of these tables: "mm t s" for MPa and MPa per mm, "m kg s" for Pa and Pa per m'}),
    (SOURCES, "--output", {"metavar": "FILE.h5", "help": "model file that is written"}),
    (SOURCES, "--overwrite", {"action": "store_true", "help": "replace an existing model file"}),
    (SOURCES, "--units", {"help": 'of the source, such as "mm t s"; of a model file its own'}),
    (SOURCES, "--axis", {"choices": ("x", "y", "z"), "default": "z", "help": "of rotation"}),
    (SOURCES, "--turns", {
        "type": int, "choices": (1, -1), "default": 1,
        "help": "-1: the disk turns against the axis, clockwise seen from its head"}),
    (SOURCES, "--reduce", {"type": int, "metavar": "MODES", "help": "write the reduced model"}),
    (SOURCES, "--speed-hz", {
        "type": float, "default": 0.0, "help": "of rotation, for frequencies and mode shapes"}),
)  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Import a model and print what it is; returns the exit code."""
    options = parser().parse_args(argv)
    with reading(options.source):
        model = import_model(options)
        if options.output:  # before the long work
            model_file.require_free(options.output, options.overwrite)
        family = report(model, options)
        if options.reduce is not None:
            model = reduce(model, options, family)
    if options.output:
        model_file.write(options.output, neutral.to_arrays(model), options.overwrite)
        say(f"model file: {options.output}")
    return 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    top = argparse.ArgumentParser(prog="hpcrub import", description=__doc__)
    add = top.add_subparsers(dest="format", required=True).add_parser
    for name, what in SOURCES.items():
        one = add(name, help=what)
        one.add_argument("source", help=what)
        for formats, option, how in OPTIONS:
            if name in formats:
                one.add_argument(option, **how)
    return top


def import_model(options: argparse.Namespace) -> neutral.NeutralModel:
    """Return the model that the options name, checked. Raises InputError."""
    for name, value in (("--speed-hz", options.speed_hz), ("--reduce", options.reduce or 0)):
        if not 0 <= value < np.inf:
            raise InputError(f"{name}: {value:g} is not 0 or more")
    arrays = _arrays(options)
    if options.axis != "z" and str(arrays.get("frame")) == "cylindrical":
        raise InputError(f"--axis {options.axis}: cylindrical directions are about z")
    if options.units:
        arrays["units"] = np.array(options.units)
    elif options.format != "model":
        raise InputError('--units: the files do not tell their units, such as --units "mm t s"')
    about_z(arrays, options.axis)
    if options.turns == -1:
        arrays["turns"] = np.array(-int(np.ravel(arrays.get("turns", 1))[0]))
    if str(arrays.get("kind")) == "disk" and "contact_blade" not in arrays:
        arrays["contact_blade"] = assembly.blade_numbers(arrays)
    model = neutral.from_arrays(arrays)
    if options.format == "model" and options.second_order:
        length = _table_units(options)[0]
        model = import_bending.with_second_order(model, Path(options.second_order), length)
    if options.format == "calculix" and options.stress:  # at places that these modes select
        model, size = stress.chosen(model, 2 * np.pi * options.speed_hz)
        modes = ", ".join(f"{1e-9 * value:.4g}" for value in size)
        say(f"largest stress of the modes of the first families [MPa per mm of the tip]: {modes}")
    return model


def _arrays(options: Any) -> Any:
    if options.format == "model":
        arrays = model_file.read(options.source)
        if options.stress or options.static:
            _add_stresses(arrays, options)
        return arrays
    if options.format == "matrixmarket":
        return matrix_market.read(options.source, options.sectors)
    if bool(options.low) != bool(options.high) or bool(options.low) != bool(options.sectors):
        raise InputError("--low, --high, --sectors: a sector needs all three")
    lists = Lists(options.contact, options.low, options.high, options.sectors, options.fixed)
    others = options.blade, dict(_speed(text) for text in options.stiffness)
    if options.format == "calculix":
        if options.stress and not options.low:
            raise InputError("--stress: goes with one sector (--low, --high, --sectors)")
        return calculix.read(options.source, lists, *others, options.stress)
    if options.format == "abaqus":
        return abaqus.read(options.source, lists, *others)
    module = {"ansys": ansys, "nastran": nastran}[options.format]
    return module.read(options.source, options.mesh, lists, *others)


def _add_stresses(arrays: Any, options: Any) -> None:
    """Add tables of stress to the arrays of a model file, in the units of the file."""
    there = Arrays(arrays)
    own = np.array(neutral.units(options.units or there.word("units", default=neutral.SI)))
    length, mass, time = _table_units(options) / own
    unit = mass / (length * time**2)
    if options.stress:
        dof, values = there.integers("dof", 2), table(options.stress)[1]
        _require_columns(options.stress, values, 1 + len(dof))
        of = f"{options.stress}, first column, the blade from 0"
        arrays["stress_blade"] = whole(values[:, 0], of)
        rotates = np.isin(dof[:, 1], neutral.ROTATIONS)
        arrays["stress"] = values[:, 1:] * np.where(rotates, unit, unit / length)
    if options.static:
        values = table(options.static)[1]
        _require_columns(options.static, values, 1)
        arrays["stress_static"] = unit * values[:, 0]


def _table_units(options: Any) -> Any:
    if not options.table_units:
        raise InputError(
            "--table-units: the tables do not tell their units: "
            '"mm t s" for mm, MPa and MPa per mm, "m kg s" for m, Pa and Pa per m'
        )
    return neutral.units(options.table_units, "--table-units")


def _require_columns(path: Any, values: Any, n: Any) -> None:
    if values.shape[1] != n:
        raise InputError(f"{path}: {values.shape[1]} columns, {n} are expected")


def _speed(text: str) -> tuple[float, Any]:
    speed, _, name = text.partition("=")
    try:
        return float(speed), name
    except ValueError:
        raise InputError(f"--stiffness: {text} is not of the form HZ=FILE") from None


def report(model: neutral.NeutralModel, options: argparse.Namespace) -> np.ndarray:
    """Print what a model is. Raises InputError for a model that cannot be right.

    Returns the frequencies of its first family over the number of nodal diameters (H,) [Hz].
    """
    for line in _found(model, options):
        say(line)
    if model.kind == "sector":  # the frequencies assemble a model of another kind
        assembly.assemble(model)  # refuses what no study could take: blades that hang together
    speed = 2 * np.pi * options.speed_hz
    by_diameter = functools.partial(cyclic.frequencies_by_diameter, model)
    table = checks.at_speed("--speed-hz", by_diameter, speed)
    at = "at rest" if not options.speed_hz else f"at {options.speed_hz:g} Hz"
    at += _star(options.speed_hz, model.speeds)
    say(f"first frequencies by nodal diameter [Hz], {at}; speeds [Hz] at which n_d bumps meet the")
    say("first family, whose frequency is that at the same speed, by n_d = diameters or")
    say("n_d = blades - diameters (SAFE diagram):")
    depends = len(model.stiffness) > 1 and speed > 0.0  # at speed 0 the disk at rest suffices
    pencils = cyclic.pencils(model, [0.0, speed] if depends else [speed])
    for diameters, (row, pencil) in enumerate(zip(table, pencils, strict=True)):
        frequencies = "  ".join(f"{f:11.4f}" for f in row if np.isfinite(f))
        orders = sorted({n for n in (diameters, model.n_blades - diameters) if n})
        met = ", ".join(f"n_d = {n}: {_crossing(pencil, n, model.speeds)}" for n in orders)
        say(f"  {diameters:3d}: {frequencies}   {met}")
    if len(model.speeds):
        low, high = model.speeds.min(), model.speeds.max()
        say(f"  (*: extrapolated beyond {low:g} to {high:g} Hz, the speeds of the matrices)")
    elif len(model.stiffness) > 1:
        say("  (the file does not tell of which speeds its matrices are, or what is extrapolated)")
    return table[:, 0]


def _crossing(pencil: Any, order: Any, known: Any) -> str:
    """Text of the speed at which an engine order meets the lowest mode of a stiffness and mass.

    known: speeds between which the stiffness is known [Hz].
    """
    stiffness, mass = pencil
    speeds = crossings.speeds(stiffness, mass, order) / (2 * np.pi)
    return f"{speeds[0]:.4g}{_star(speeds[0], known)}" if len(speeds) else "never"


def _star(speed: Any, known: Any) -> Any:
    """Mark of a speed at which the stiffness is extrapolated from known speeds [Hz], if any are."""
    return "*" * bool(len(known) and not known.min() <= speed <= known.max())


def _found(model: neutral.NeutralModel, options: argparse.Namespace) -> Iterator[str]:
    facts = checks.check(model)
    per_blade = np.bincount(model.contact_blade)
    yield (
        f"{model.kind}: {len(model.dof):,} dof, {counted(model.n_blades, 'blade')}, "
        f"{per_blade.min()} to {per_blade.max()} contact nodes each, "
        f"tip radius {1e3 * facts.tip_radius:.6g} mm (to {1e3 * facts.tip_gap:.2g} mm below it)"
    )
    if model.kind != "reduced":
        yield f"mass: {facts.mass:.6g} kg of the whole disk, rows that are not there left out"
        yield (
            f"rigid motions: leave {facts.rigid_residual:.1e} of a row's entries (median); "
            f"{facts.loaded_rows} rows feel supports"
        )
    if len(model.fixed):
        yield f"held: {len(model.fixed):,} of the rows (fixed)"
    if model.kind == "sector":
        *_, error = assembly.pair_sides(model.nodes, model.low, model.high, model.n_sectors)
        yield f"sides: {len(model.low)} nodes each, pairs miss by at most {1e3 * error:.2g} mm"
    if model.blade_stiffness is None and model.blade_frequencies is None:
        yield "blades' stiffness: none; blades can be mistuned only with it (--blade, K_blade)"
    elif model.blade_stiffness is None:
        n_modes = model.blade_frequencies.shape[1]
        yield f"blades: {n_modes} cantilever modes each alone; mistuning.by: cantilever_modes"
    if n_places := len(model.stress_blade):
        if model.kind == "reduced":
            yield _of_tips(model, options)
        of = len(np.unique(model.stress_blade)) if model.kind != "sector" else 1
        static = f", of the rotation up to {1e-6 * model.stress_static.max(initial=0.0):.4g} MPa"
        yield (
            f"stress: of the vibration at {n_places} places on {counted(of, 'blade')}"
            f"{static if len(model.stress_static) else ''}"
        )
    if model.bent is not None:
        yield _of_bent_blades(model)
    yield from _rotation(model, options)
    if options.speed_hz and len(model.stiffness) == 1:
        yield "centrifugal stiffening: none, the stiffness is that of one speed"
    if getattr(options, "stiffness", None):
        yield from _between_speeds(model)


def _of_bent_blades(model: Any) -> str:
    radius = np.hypot(*model.nodes[model.contact_node, :2].T)
    share = 1e2 * bent_blades.check(model.bent, radius) / (2e3 * radius.mean())
    return (
        f"second order: of {counted(model.bent.modes.shape[2], 'bent mode')}; a motion of the tips "
        f"by 10 mm in the first one shortens a blade by {share:.3g} mm"
    )


def _of_tips(model: Any, options: Any) -> str:
    """Largest stress of the first family, in words. Raises InputError for one of wrong units."""
    size = 1e-9 * stress.largest(model, 2 * np.pi * options.speed_hz)
    if not PER_TIP[0] <= size <= PER_TIP[1]:
        raise InputError(
            f"stress: {size:.3g} MPa per mm of a tip in the first family, which no blade has; are "
            "the units those of the file, or of --table-units?"
        )
    return f"largest stress of the modes of the first family: {size:.4g} MPa per mm of a tip"


def _between_speeds(model: Any) -> Iterator[str]:
    """Warn of matrices of three speeds that cannot be right, or are wrong between them."""
    error, rises = cyclic.between_speeds(model, 2 * np.pi * model.speeds)
    error *= 100
    if abs(error) > BETWEEN:
        yield (
            f"warning: between the speeds of --stiffness the first frequency is off by {error:+.2g}"
            " %: blades turn by too much from one to the next; take the matrices of one speed alone"
        )
    if not RISES[0] <= rises.min() <= rises.max() <= RISES[1]:
        low, middle, high = np.sort(model.speeds)
        first, second = rises
        yield (
            f"warning: the first frequency's square rises by {first:.2g} of that of the speed from "
            f"{low:g} to {middle:g} Hz and by {second:.2g} from {middle:g} to {high:g} Hz; "
            f"{RISES[0]:g} to {RISES[1]:g} is usual: are the speeds of --stiffness in Hz, and each "
            "of its own file?"
        )


def _rotation(model: Any, options: Any) -> Iterator[str]:
    source = "; the other way round than in the source, whose axes are x, -y, -z here"
    yield "rotation: counter-clockwise, seen from +z" + source * (options.turns == -1)
    lift = cyclic.friction_lift(model, 2 * np.pi * options.speed_hz)
    way = "outwards" if lift > 0.0 else "inwards"
    by = f"{way} by {abs(lift):.2g} of their way back" if abs(lift) > LEAN else "neither in nor out"
    yield f"friction on all tips: moves them {by}"
    if lift > LEAN:
        yield (
            "warning: so friction presses the tips against the casing, which it would not if the "
            f"disk turned the other way (--turns {-options.turns}); matrices cannot tell if it does"
        )


def reduce(
    model: neutral.NeutralModel, options: argparse.Namespace, family: np.ndarray
) -> neutral.NeutralModel:
    """Return the reduced model, and print its frequencies. Raises InputError.

    family: frequencies of the model's first family over the number of nodal diameters (H,) [Hz].
    """
    if model.kind == "reduced":
        raise InputError("--reduce: this model is reduced already")
    speed = 2 * np.pi * options.speed_hz
    small, _ = reduced.reduce_disk(assembly.assemble(model), options.reduce, speed)
    modal = reduced.reduced_model(small, speed)
    omega = np.sqrt(modal.tuned_eigenvalues)
    n_modes = families.whole(options.reduce, model.n_blades)
    say(
        f"reduced: {len(omega)} coordinates, of which {n_modes} modes in whole families; highest "
        f"frequency {omega[-1] / (2 * np.pi):.4g} Hz"
    )
    hz = omega[: model.n_blades] / (2 * np.pi)
    say(families.sentence(family, hz, families.share(modal), HALF_RANGE, DAMPING))
    return small
