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

from hpcrub import __version__, effects
from hpcrub.commands.plot import of_study
from hpcrub.config.schema import Config
from hpcrub.config.text import counted, key_table, lines_of, show
from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, InputError
from hpcrub.plot import FIGURES
from hpcrub.plot.families import labels
from hpcrub.ranks.progress import WIDTH, as_text, say
from hpcrub.results import model_file
from hpcrub.results.layout import PENDING
from hpcrub.studies import open_result, run_of

KINDS = {".svg": "image/svg+xml", ".png": "image/png"}
FILLED_IN = "filled in when a run begins"  # in the description of keys that no user sets


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub report", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    parser.add_argument("--out", metavar="REPORT.html", help="beside the first file by default")
    options = parser.parse_args(argv)
    target = Path(options.out or f"{without_suffix(options.files[0])}.html")
    if os.path.lexists(target) and not _is_report(target):
        raise InputError(f"{target} is no report, and is not replaced; choose another --out")
    page = render(options.files)
    try:
        target.write_text(page, encoding="utf-8")
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
    with contextlib.ExitStack() as opened:
        what_differs = labels([opened.enter_context(open_result(path)) for path in paths])
    for file, words in zip(files, what_differs, strict=True):
        file["differs"] = words
    compared = list(_figures(paths)) if len(paths) > 1 else []
    loader = jinja2.PackageLoader("hpcrub", "commands")
    pages = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
    title = f"{files[0]['study'].capitalize()} study: {files[0]['name']}"
    return pages.get_template("report.html").render(
        title=title if len(files) == 1 else f"{len(files)} results compared",
        version=__version__,
        today=datetime.date.today().isoformat(),
        files=files,
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
        headline = next(iter(study.report(file)), "")
        answer = study.answer(file, verdict.usable, WIDTH)
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
            "headline": headline.removesuffix(f"; {verdict.words}"),
            "asked": list(_asked(config)),
            "answer": as_text(item for item in answer if item != headline),
            "figures": list(_figures([path])),
            "checks": list(dict.fromkeys([*verdict.lines[1:], *file.warnings])),
            "omitted": list(_omitted_effects(config)),
            "provenance": [
                ("file", str(Path(path).resolve())),
                ("SHA-256", model_file.checksum(path)),
                *((name, str(value)) for name, value in attributes if name not in apart),
            ],
        }


def _omitted_effects(config: Config) -> Iterator[Any]:
    """Yield sentences on effects that the model leaves out, unless a key switches them on."""
    contact, limits = config.contact, config.limits
    slope = config.casing.outline.slope / config.disk.tip_radius
    omitted = (effect.omitted for effect in effects.EFFECTS if not effect.exists(config))
    yield from filter(None, omitted)
    yield from lines_of(
        (contact.law == "rigid", "The casing is hard: it neither gives nor wears (contact.law)."),
        (config.casing.clearance_hz_mm is None,
         "The clearance is the same at all speeds (casing.clearance_hz_mm)."),
        (limits.stress_mpa is None, "No stress is looked at (limits.stress_mpa)."),
        (limits.stress_mpa is not None and limits.strength_mpa is None,
         "The stress of rotation is not in the limit (limits.static_mpa)."),
        (config.disk.model is None,
         "Blades are plane beams: no torsion, no motion along the axis, no stiffening by "
         "rotation."),
        (True, "Displacements are small: a blade that bends does not get shorter."),
        (True,
         f"Contact forces are radial: the casing's slope, up to {slope:.2g} beside a friction of "
         f"{contact.friction:g}, does not tilt them."),
        (True, "The hub is held: shaft, bearings and whirl are left out."),
        (True, "Every speed begins at rest: the time of a run-up, heat and growth in time are not "
         "followed."),
    )  # fmt: skip


def _asked(config: Config) -> Iterator[dict[str, str]]:
    """Yield the keys whose value is not the default, each with its meaning, value and default."""
    own, usual = config.by_path(), Config().by_path()
    meaning = {key.path: key.description for key in key_table(Config)}
    for key, value in own.items():
        if key != "output" and value != usual[key] and FILLED_IN not in meaning[key]:
            short = float(f"{value:.6g}") if isinstance(value, float) else value
            values = {"value": show(short), "default": show(usual[key])}
            yield {"key": key, "meaning": meaning[key]} | values


def _figures(paths: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield the figures of one file, or those that compare several, as data inside the page."""
    what = {figure.__name__: figure.about.what for figure in FIGURES}
    main = {f.about.studies[0]: f.about.what for f in FIGURES if f.about.main}
    with tempfile.TemporaryDirectory() as folder, open_result(paths[0]) as file:
        for picture in of_study(paths, folder=folder, kind="svg"):
            if isinstance(picture, HpcrubError):
                continue
            words = next((w for name, w in what.items() if picture.stem.endswith(name)), None)
            data = base64.b64encode(picture.read_bytes()).decode()
            yield {
                "what": words or main.get(file.config.study, picture.stem),
                "data": f"data:{KINDS[picture.suffix]};base64,{data}",
            }
