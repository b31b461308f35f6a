"""Merge the files of parts of a study of many samples into the file of the whole study.

The parts may overlap and need not be complete, and their order does not matter: a sample is taken
from any part that has finished it, and samples that no part has stay pending. Where parts overlap,
they must agree to the last bit.

A study of few samples is a part of the same study with more: `--samples N` makes the file of the
larger one, and `main.py --resume` computes what is missing.
"""

import contextlib
import os
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.config.schema import differences
from hpcrub.errors import HpcrubError, InputError, reason
from hpcrub.results import ownership, storage
from hpcrub.results.layout import PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.runs import memory, result_files
from hpcrub.studies import open_result, run_of


def merge(
    out: str | Path,
    paths: Sequence[str | Path],
    overwrite: bool = False,
    samples: int | None = None,
    allow_mixed: bool = False,
) -> tuple[int, int]:
    """Merge result files of parts of one study into `out`, which appears when it is whole.

    overwrite: replace an existing file; samples: number of samples a level of the whole study, if
    the parts tell another; allow_mixed: accept parts that different program texts have computed.
    Returns the numbers of finished samples and of all samples.
    Raises InputError for parts that are unsound, of different studies or programs, or contradict
    each other.
    """
    unfinished = Path(f"{os.path.realpath(out)}.hpcrub-merge")
    lock = ownership.Lock(out)  # first: another job may just have finished the file
    try:
        if os.path.lexists(out) and not overwrite:
            raise InputError(f"{out} exists: --overwrite replaces it")
        if str(unfinished) in [os.path.realpath(Path(path).expanduser()) for path in paths]:
            raise InputError(f"{unfinished} is what a killed merge has left: rename it to use it")
        config, tuned, origin = _survey(out, paths, samples)
        if ", " in origin["program_text"] and not allow_mixed:
            revisions = origin.get("git_revision", "not known")
            raise InputError(
                "the parts were computed by different programs, of the texts "
                f"{origin['program_text']} (revisions: {revisions}): --allow-mixed merges them and "
                "names all"
            )
        storage.refuse_foreign(out)
        if _is_part(out):
            raise InputError(
                f"{out} is a part of a study and is not replaced: the file of the whole comes first"
            )
        run = run_of(config)
        memory.check(run)
        result_files.lay_out(unfinished, run, origin)
        try:
            status = _fill(unfinished, paths, run, tuned)
            ownership.move(unfinished, os.path.realpath(out))
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise HpcrubError(f"cannot write {out}: {reason(error)}") from None
    finally:
        lock.release()
    return int(np.count_nonzero(status != PENDING)), status.size


def _is_part(path: Any) -> Any:
    with contextlib.suppress(InputError), ResultFile(path) as file:
        return file.config.is_part
    return False


def _survey(out: Any, paths: Any, samples: Any) -> tuple[Any, Any, Any]:
    """What all parts share: Config of the whole, results of the tuned disk, attributes.

    The attributes name programs and libraries, and hold the warnings. Raises InputError for parts
    that do not belong together.
    """
    config = tuned = tuned_path = None
    origin, warned = defaultdict[str, set](set), dict[str, None]()
    for path in paths:
        with open_result(path) as part:
            mine = _whole_config(part, out, samples)
            part_tuned = _tuned(part)
            if config and (other := differences(config, mine, (f"in {paths[0]}", f"in {path}"))):
                raise InputError(f"parts of different studies: {'; '.join(other)}")
            config = config or mine
            if part_tuned and tuned:
                for name in sorted(tuned):
                    if tuned[name].tobytes() != part_tuned[name].tobytes():
                        raise InputError(
                            f"the tuned disk of {tuned_path} and of {path} is not the same "
                            f"({name}): they were computed on different kinds of processors, or "
                            "with different libraries"
                        )
            elif part_tuned:
                tuned, tuned_path = part_tuned, path
            warned |= dict.fromkeys(part.warnings)
            for name, value in part.attributes.items():
                if name.endswith(("_version", "_revision", "_text")):
                    origin[name].update(str(value).split(", "))
    attributes = {name: ", ".join(sorted(values)) for name, values in origin.items()}
    if warned:
        attributes["warnings"] = "\n".join(warned)
    return config, tuned, attributes


def _whole_config(part: Any, out: Any, samples: Any) -> Any:
    if "part" not in run_of(part.config).study.sections:
        raise InputError(f"{part.path} is of the study {part.config.study}, which has no parts")
    if part.config.convergence.stop_when_converged:
        raise InputError(f"{part.path} stops when it has converged: it cannot be part of another")
    end = part.config.samples.stop
    if samples is not None and samples < end:
        raise InputError(f"--samples: {samples} is too few, {part.path} has {end} a level")
    keys = {"part.samples": None, "output": str(out)}
    return part.config.replace(keys | ({"mistuning.samples": samples} if samples else {}))


def _names(part: Any, group: str) -> list[str]:
    """Names of the datasets of a group that a part has computed, the status of samples last."""
    run = run_of(part.config)
    names = [line.name for line in run.datasets() if line.name.startswith(group)]
    return [name for name in names if name not in run.study.derived]


def _tuned(part: Any) -> Any:
    """Results of the tuned disk by the names of their datasets; None: not complete."""
    if not run_of(part.config).study.has_tuned(part):
        return None
    return {name: part.read(name) for name in _names(part, "tuned/")}


def _fill(path: Any, parts_paths: Any, run: Any, tuned: Any) -> Any:
    """Write the contents of the parts into the laid-out file; returns the status of all samples."""
    with ResultFile(path, mode="r+") as whole:
        if tuned:
            whole.write(tuned, ())
        for part_path in parts_paths:
            with open_result(part_path) as part:
                _copy(part, whole, _names(part, "samples/"))
        run.study.complete(run, whole)
        return whole.status


def _copy(part: Any, whole: Any, names: Sequence[str]) -> None:
    """Copy the finished samples of a part into the whole file, level by level.

    names: of datasets with a row for every sample, the status last.
    """
    samples = slice(part.config.samples.start, part.config.samples.stop)
    for mine, level in enumerate(part.config.levels):
        new = part.read("samples/status", mine) != PENDING
        both = new & (whole.read("samples/status", (level, samples)) != PENDING)
        for name in names if new.any() else ():
            values, old = part.read(name, mine), whole.read(name, (level, samples))
            if values[both].tobytes() != old[both].tobytes():
                raise InputError(
                    f"{part.path} contradicts another part: {name} of level {level}, samples "
                    f"{samples.start} to {samples.stop - 1}"
                )
            old[new] = values[new]
            whole.write({name: old}, (level, samples))
