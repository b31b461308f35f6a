"""Result files of studies: laid out, checked and opened by what their study says it needs."""

import itertools
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub import studies
from hpcrub.config import schema as configuration
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.results import provenance, storage
from hpcrub.results.layout import MOST_PROGRAMS, NUMBER, PENDING, PROGRAMS, Plan, index_scale
from hpcrub.results.storage import ResultFile
from hpcrub.studies.sources import fingerprint


def plan(
    config: Config,
    attributes: dict[str, str] | None = None,
    programs: Sequence[str] | None = None,
) -> Plan:
    """All that is known of a study's result file before anything is computed.

    Parameters
    ----------
    config
        Configuration of the study.
    attributes
        Of the root, beside those that every file has.
    programs
        That have computed what it will hold; this one if left out.

    Returns
    -------
    Plan
        For `storage.lay_out`.

    Raises
    ------
    InputError
        A source of the study cannot be used, or there are too many programs.
    """
    study = studies.find(config)
    scales, lengths = study.all_scales(config), study.all_sizes(config)
    values: dict[str, Any] = {name: np.arange(lengths[name]) for name in _indices(study, config)}
    if "percentile" in values:
        values["percentile"] = config.convergence.percentiles
    values |= study.constants(config)
    values["programs"] = _rows(programs or [provenance.program()])
    attributes = dict(attributes or {})
    if found := fingerprints(config):
        attributes["sources_sha256"] = " ".join(found.values())
    return Plan(config, _lines(study, config), lengths, scales, values, attributes)


def _indices(study, config):
    """Dimensions whose scale is no dataset of the study: just numbers."""
    there = {line.name for line in study.lines(config)}
    return [
        name for name in study.all_scales(config).values() if "{" not in name and name not in there
    ]


def _lines(study, config):
    """All datasets of the result file."""
    return (*map(index_scale, _indices(study, config)), *study.lines(config))


def fingerprints(config: Config) -> dict[str, str]:
    """{path: hexadecimal digits} of what a study has from its sources."""
    n_sources = studies.find(config).n_sources
    return {path: fingerprint(path) for path in config.sources} if n_sources else {}


def _rows(programs):
    """The dataset `programs`, empty rows at its end."""
    if len(programs) > MOST_PROGRAMS:
        raise InputError(f"more than {MOST_PROGRAMS} programs cannot share a result file")
    rows = np.zeros(MOST_PROGRAMS, PROGRAMS.dtype)
    rows[: len(programs)] = [program.encode() for program in programs]
    return rows


def file_size(config: Config) -> int:
    """Bytes that the result file of a study takes."""
    study = studies.find(config)
    return storage.file_size(_lines(study, config), study.all_sizes(config))


def lay_out(
    path: str | Path,
    config: Config,
    attributes: dict[str, str] | None = None,
    programs: Sequence[str] | None = None,
) -> None:
    """Create the result file of a study, as `storage.lay_out`; the others as for `plan`."""
    storage.lay_out(path, plan(config, attributes, programs))


def open_result(
    path: str | os.PathLike[str], config: Config | None = None, mode: str = "r"
) -> ResultFile:
    """Open a result file that holds all that its study needs.

    Parameters
    ----------
    path
        Result file, of any version of the program.
    config
        The configuration that it must have; None for any.
    mode
        "r" to read, "r+" to write too.

    Returns
    -------
    ResultFile
        To be closed by the caller, or used in a `with` statement.

    Raises
    ------
    InputError
        Says what is wrong with the file.
    """
    file = ResultFile(Path(path), mode=mode)
    try:
        if config is not None:
            _check_config(file, config)
        studies.find(file.config).check_file(file)
    except BaseException:
        file.close()
        raise
    return file


def check_resumable(path: str | Path, config: Config, allow_mixed: bool = False) -> None:
    """Refuse to go on with a file that was not begun by the same program for the same study.

    Parameters
    ----------
    path
        Result file.
    config
        The configuration asked for.
    allow_mixed
        Go on with what another program text has begun.

    Raises
    ------
    InputError
        Says what differs: configuration, layout, program text, or a source.
    """
    with open_result(path, config) as file:
        if file.layout != NUMBER:
            raise InputError(
                f"{path} has layout {file.layout} of {file.written_by()}: it can be read and "
                "plotted; --overwrite begins anew"
            )
        if not allow_mixed and (file.status() == PENDING).any():
            _require_this_program(file)
        stored = str(file.attributes().get("sources_sha256", "")).split()
    found = fingerprints(config)
    for source, before in itertools.zip_longest(found, stored):
        if before != found.get(source):
            raise InputError(
                f"sources: {source} has changed since {path} was begun; --overwrite begins anew"
            )


def _require_this_program(file):
    if _row(file) is None:
        last = file.programs()[-1]
        raise InputError(
            f"{file.path} was computed by another program ({last}); this is {provenance.program()}:"
            " --allow-mixed goes on and notes which samples each has computed, --overwrite begins "
            "anew"
        )


def _row(file):
    """Row of the program text that runs in a file's `programs`, None when it is not there."""
    texts = [program.split()[0] for program in file.programs()]
    mine = provenance.program_text()
    return texts.index(mine) if mine in texts else None


def register(file: ResultFile) -> int:
    """Note in an open file that this program computes the rest of it; one rank.

    Returns its row of `programs`. Raises InputError when these are full.
    """
    if (row := _row(file)) is None:
        programs = [*file.programs(), provenance.program()]
        file.write({"programs": _rows(programs)}, ())
        row = len(programs) - 1
    return row


def _check_config(file, config):
    differences = configuration.differences(file.config, config)
    if differences:
        more = f" (and {len(differences) - 1} more)" if len(differences) > 1 else ""
        n_samples = config.mistuning.samples
        if len(differences) == 1 and file.config.mistuning.samples < n_samples:
            program = f"python -m hpcrub merge --samples {n_samples}"
            more = f"; {program} NEW.h5 {file.path} makes room for them"
        raise InputError(f"{file.path} has another configuration: {differences[0]}{more}")
