"""Layout, checks and resumption of the result files of runs, from the datasets of their study."""

import itertools
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError, reason
from hpcrub.results import layout, provenance, storage
from hpcrub.results.layout import DONE, FAILED, PENDING, Plan, index_scale
from hpcrub.results.storage import ResultFile
from hpcrub.runs.study import Run


def lay_out(path: str | Path, run: Run, attributes: dict[str, Any] | None = None) -> None:
    """Create the result file of a run, with all values that are known without computing.

    attributes: of the root; they are added to the attributes of every file or replace them.
    Raises InputError as `storage.lay_out`, and when a source of the study cannot be used.
    """
    lengths = run.sizes()
    values: dict[str, Any] = {name: np.arange(lengths[d]) for d, name in _indices(run).items()}
    if "blade" in values:
        values["blade"] += 1  # figures and tables count blades from 1
    if "percentile" in values:
        values["percentile"] = run.config.convergence.percentiles
    values |= run.constants()
    attributes = dict(attributes or {})
    if run.study.integrates:
        attributes["time_step_s"] = run.config.step
    plan = Plan(run.config, _lines(run), lengths, run.scales(), values, attributes)
    storage.lay_out(path, plan)


def _indices(run: Any) -> dict[Any, Any]:
    """{dimension: scale} of the dimensions whose scale is an index and no dataset of the study."""
    there = {line.name for line in run.datasets()}
    return {d: name for d, name in run.scales().items() if name not in there}


def _lines(run: Any) -> Any:
    """All datasets of the result file."""
    return (*itertools.starmap(index_scale, _indices(run).items()), *run.datasets())


def file_size(run: Run) -> int:
    """Size of the result file of a run [bytes]."""
    return layout.file_size(_lines(run), run.sizes())


def check(file: ResultFile, run: Run) -> None:
    """Raise InputError unless an open file itself holds all datasets that a run writes."""
    file.require_own(line.name for line in run.datasets())
    length = run.known_sizes()
    for line in run.datasets():
        shape, dtype = file.shape(line.name), file.dtype(line.name)
        # a length that the configuration does not tell must be equal in all datasets
        length = dict(zip(line.dimensions, shape or (), strict=False)) | length
        wanted = tuple(length.get(d) for d in line.dimensions)
        if shape != wanted or dtype != np.dtype(line.dtype):
            raise InputError(
                f"{file.path} was written by {file.written_by()}: {line.name} is "
                f"{dtype}{list(shape or ())}, not {np.dtype(line.dtype)}{list(wanted)}"
            )
    if len(strange := np.setdiff1d(file.status, (PENDING, DONE, FAILED))):
        raise InputError(f"{file.path} is damaged: it holds a status {strange[0]}, which is none")


def check_config(file: ResultFile, config: Config) -> None:
    """Raise InputError, which names the difference, for an open file of another configuration."""
    if changed := differences(file.config, config):
        more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        n_samples, alone = config.mistuning.samples, len(changed) == 1
        growing = config.study == "contact" and not config.convergence.stop_when_converged
        if alone and growing and file.config.mistuning.samples < n_samples:
            program = f"python -m hpcrub merge --samples {n_samples}"
            more = f"; {program} NEW.h5 {shlex.quote(str(file.path))} makes room for them"
        elif alone and file.config.mistuning.samples > n_samples:
            more = (
                f"; its first {n_samples} are these: go on with "
                f"{file.config.mistuning.samples}, or give another output"
            )
        raise InputError(f"{file.path} has another configuration: {changed[0]}{more}")


def check_resumable(path: str | Path, run: Run, allow_mixed: bool = False) -> None:
    """Check that this program has begun the file for this run.

    allow_mixed: accept a file that another program text has begun. Raises InputError, which says
    what differs: configuration, datasets, program text or a source.
    """
    with ResultFile(path) as file:
        check_config(file, run.config)
        check(file, run)
        if not allow_mixed and not _knows_this_program(file) and (file.status == PENDING).any():
            raise InputError(
                f"{path} was begun by another program: {file.written_by()} can go on with it; "
                "--allow-mixed goes on and names both in the file, --overwrite begins anew"
            )
        known = run.constants() if run.study.n_sources else {}
        if not all(np.array_equal(file.read(name), values) for name, values in known.items()):
            sources = ", ".join(run.config.sources)
            raise InputError(
                f"sources: {sources} has changed since {path} was begun; --overwrite begins anew"
            )


def _knows_this_program(file: ResultFile) -> bool:
    return provenance.program_text() in str(file.attributes.get("program_text")).split(", ")


def register(path: str | Path) -> None:
    """Record in a closed file that this program computes the rest. Raises InputError."""
    with ResultFile(path) as file:
        known = _knows_this_program(file) or not (file.status == PENDING).any()
    try:
        if not known:
            storage.note_program(path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {reason(error)}") from None
