"""`hpcrub report FILE.h5 ...`: one HTML file to read, print and sign, of one or several results."""

import argparse
import base64
import contextlib
import datetime
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from rich.table import Table

from hpcrub import __version__, effects
from hpcrub.commands.plot import of_study
from hpcrub.config import yaml_text
from hpcrub.config.run_up import runs_up
from hpcrub.config.schema import Config
from hpcrub.config.text import counted, key_table, lines_of, set_key, show
from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, InputError
from hpcrub.ranks.progress import say
from hpcrub.results import model_file, ownership
from hpcrub.results.layout import PENDING
from hpcrub.studies import open_result, run_of

FILLED_IN = "filled in when a run begins"  # in the description of keys that no user sets


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub report", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    parser.add_argument("--output", metavar="REPORT.html", help="beside the first file by default")
    options = parser.parse_args(argv)
    target = Path(options.output or f"{without_suffix(options.files[0])}.html")
    if os.path.lexists(target) and not _is_report(target):
        raise InputError(f"{target} is no report, and is not replaced; choose another --output")
    page = render(options.files)
    try:
        with ownership.replacing(target) as part:  # an empty file would be no report
            part.write_text(page, encoding="utf-8")
    except OSError as error:
        raise HpcrubError(f"cannot write {target}: {error.strerror or error}") from None
    say(f"report:  {target}")
    return 0


def _is_report(path: Any) -> Any:
    with contextlib.suppress(OSError):  # a pipe would never end
        return os.path.isfile(path) and path.read_bytes().startswith(b"<!doctype html>")
    return False


def render(paths: Sequence[str]) -> str:
    """Return the HTML of a report, which needs no other file. Raises InputError."""
    files = [_facts(path) for path in paths]
    compared = _figures(paths) if len(paths) > 1 else {"drawn": [], "failed": []}
    loader = jinja2.PackageLoader("hpcrub", "commands")
    pages = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
    title = f"{files[0]['study'].capitalize().replace('_', ' ')} study: {files[0]['name']}"
    return pages.get_template("report.html").render(
        title=title if len(files) == 1 else f"{len(files)} results compared",
        version=__version__,
        today=datetime.date.today().isoformat(),
        files=files,
        differences=_differences(paths),
        compared=compared,
    )


def _facts(path: Any) -> dict[Any, Any]:
    """Return everything that the report says of one file, for the template."""
    with open_result(path) as file:
        study, config = run_of(file.config).study, file.config
        status = study.parts(file)
        n_done = int(np.count_nonzero(status != PENDING))
        if not n_done:
            raise InputError(f"{path} holds no result yet; run its input with --resume")
        verdict = study.verdict(file)
        conclusion = list(study.conclusion(file, verdict.usable))
        answer = study.answer(file, verdict.usable)
        complete = n_done == status.size or study.is_enough(file)
        of = counted(status.size, study.unit.rstrip("s"))
        attributes, apart = sorted(file.attributes.items()), ("config", "warnings")
        partly = "" if complete else f"not complete, {n_done} of {of} are done; what is there is "
        return {
            "name": Path(path).name,
            "study": study.name,
            "what": study.what,
            "verdict": partly + verdict.words,
            "usable": complete and verdict.usable,
            "conclusion": [line.removesuffix(f"; {verdict.words}") for line in conclusion],
            "asked": list(_asked(config)),
            "answer": [_as_html(item) for item in answer if item not in conclusion],
            "figures": _figures([path]),
            "checks": list(dict.fromkeys([*verdict.lines[1:], *file.warnings])),
            "omitted": list(_omitted_effects(config)),
            "input": repeating(config),
            "input_name": f"{without_suffix(path).name}.yaml",
            "provenance": [
                ("file", str(Path(path).resolve())),
                ("SHA-256", model_file.checksum(path)),
                *((name, str(value)) for name, value in attributes if name not in apart),
            ],
        }


def _as_html(item: str | Table) -> dict[str, Any]:
    """Return a line or a table of an answer for the template."""
    if isinstance(item, str):
        return {"line": item}
    cells = [[str(cell) for cell in column.cells] for column in item.columns]
    return {
        "title": str(item.title or ""),
        "headings": [str(column.header) for column in item.columns],
        "rows": list(zip(*cells, strict=True)),
    }


def _differences(paths: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Return all keys in which files differ, each with its value in every file."""
    rows = []
    for path in paths:
        with open_result(path) as file:
            rows.append(file.config.by_path())
    keys = (key for key in rows[0] if key not in ("output", "sources"))
    return [
        (key, [show(row[key]) for row in rows])
        for key in keys
        if any(row[key] != rows[0][key] for row in rows)
    ]


def _omitted_effects(config: Config) -> Iterator[Any]:
    """Yield sentences on effects that the model leaves out, unless a key switches them on."""
    contact, limits = config.contact, config.limits
    slope = config.casing.outline.slope / config.disk.tip_radius
    omitted = (effect.omitted for effect in effects.EFFECTS if not effect.exists(config))
    yield from filter(None, omitted)
    yield from lines_of(
        (contact.law == "rigid", "The casing is hard: it neither gives nor wears (contact.law)."),
        (config.casing.running is None and config.casing.over_time is None,
         "The clearance is the same at all speeds (casing.clearance_hz_mm)."),
        (limits.stress_mpa is None, "No stress is looked at (limits.stress_mpa)."),
        (limits.stress_mpa is not None and limits.strength_mpa is None,
         "The stress of rotation is not in the limit (limits.static_mpa)."),
        (config.disk.model is None,
         "Blades are plane beams: no torsion, no motion along the axis, no stiffening by "
         "rotation."),
        (not contact.bends, "Displacements are small: a blade that bends does not get shorter."),
        (not contact.bends,
         f"Contact forces are radial: the casing's slope, up to {slope:.2g} beside a friction of "
         f"{contact.friction:g}, does not tilt them."),
        (True, "The hub is held: shaft, bearings and whirl are left out."),
        (not runs_up(config), "Every speed begins at rest: no run-up is followed."),
        (True, "Heat, and growth in time by it, are not followed."),
    )  # fmt: skip


def _asked(config: Config) -> Iterator[dict[str, str]]:
    """Yield the keys whose value is not the default, each with its meaning, value and default."""
    own, usual = config.by_path(), Config().by_path()
    for key in key_table(Config):
        value = own.get(key.path)
        if value == usual.get(key.path) or key.path == "output" or FILLED_IN in key.description:
            continue
        short = float(f"{value:.6g}") if isinstance(value, float) else value
        values = {"value": show(short).strip("'"), "default": show(usual[key.path]).strip("'")}
        yield {"key": key.path, "meaning": key.description} | values


def repeating(config: Config) -> str:
    """YAML text of an input that repeats a study elsewhere, without what files hold."""
    filled = {key.path for key in key_table(Config) if FILLED_IN in key.description}
    filled = {path for path in filled if not path.endswith("_sha256")} | {"output"}
    own, data = config.by_path(), config.model_dump(mode="json", exclude_defaults=True)
    again = Config(**data).by_path()
    for path in own:  # defaults that other keys decide
        if again[path] != own[path]:
            set_key(data, path, own[path])
    for path in filled:
        section, _, key = path.rpartition(".")
        (data.get(section, {}) if section else data).pop(key, None)
    return yaml_text.dump({"study": config.study} | data)


def _figures(paths: Sequence[str]) -> dict[str, list[Any]]:
    """Return the figures of one file, or those that compare several, as data inside the page.

    What could not be drawn is said; a figure that does not suit the files is left out.
    """
    drawn, failed = [], []
    with tempfile.TemporaryDirectory() as folder:
        for figure, picture in of_study(paths, folder=folder, kind="svg"):
            if isinstance(picture, HpcrubError):
                failed += [str(picture)] * (not isinstance(picture, InputError))
                continue
            data = base64.b64encode(picture.read_bytes()).decode()
            drawn.append(
                {
                    "what": figure.about.what,
                    "data": f"data:image/svg+xml;base64,{data}",
                }
            )
    return {"drawn": drawn, "failed": list(dict.fromkeys(failed))}
