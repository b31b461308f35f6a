"""`python -m hpcrub merge OUT.h5 PART.h5 ...`: files of parts of a study → the file of the study.

The parts may overlap and need not be complete, and their order does not matter: a sample is taken
from any part that has finished it, and samples that no part has stay pending. Where parts overlap,
they must agree to the last bit. Memory does not grow with the samples.

A study of few samples is a part of the same study with more: `--samples N` makes the file of the
larger one, and `main.py --resume` computes what is missing.
"""

import argparse
import os
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from hpcrub import studies
from hpcrub.config import parts
from hpcrub.config.schema import differences
from hpcrub.errors import HpcrubError, InputError
from hpcrub.results import ownership, storage
from hpcrub.results.layout import PENDING
from hpcrub.run.parallel import Team
from hpcrub.studies import size
from hpcrub.studies.monte_carlo import Study

AT_ONCE = 2**26  # bytes read at once


def main(argv=None):
    """Merge and say how complete the result is; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m hpcrub merge", description="Merge files of parts of one study."
    )
    parser.add_argument("out", metavar="OUT.h5", help="file of the whole study")
    parser.add_argument("parts", metavar="PART.h5", nargs="+", help="files of its parts")
    parser.add_argument("--overwrite", action="store_true", help="replace an existing OUT.h5")
    parser.add_argument(
        "--samples", type=int, metavar="N", help="give OUT.h5 N samples a level, not the parts' own"
    )
    options = parser.parse_args(argv)
    try:
        n_done, n_all = merge(options.out, options.parts, options.overwrite, options.samples)
    except HpcrubError as error:
        print(f"hpcrub: error: {error}", file=sys.stderr)
        return error.exit_code
    print(f"{options.out}: {n_done} of {n_all} samples, from {len(options.parts)} files")
    if n_done < n_all:
        more = f" --set mistuning.samples={options.samples}" if options.samples else ""
        print(f"main.py with --output {options.out}{more} --resume computes the others")
    return 0


def merge(out, paths, overwrite=False, samples=None):
    """Merge result files of parts of one study.

    Args:
        out: file of the whole study; it appears when it is whole.
        paths: result files of parts, or of the whole study.
        overwrite: replace an existing file.
        samples: number of samples a level of the whole study, if not that of the parts' own.

    Returns:
        number of finished samples, and of all.

    Raises:
        InputError: parts that are unsound, of different studies, or contradict each other.
    """
    unfinished = Path(f"{os.path.realpath(out)}.hpcrub-merge")
    lock = ownership.Lock(out)  # first: another job may just have finished the file
    try:
        if os.path.lexists(out) and not overwrite:
            raise InputError(f"{out} exists: --overwrite replaces it")
        config, tuned, origin = _survey(out, paths, samples)
        ownership.refuse_foreign(out)
        size.check(config, out)
        storage.lay_out(unfinished, config, origin)
        whole = storage.ResultFile(unfinished, mode="r+")
        if tuned:
            whole.write_tuned(tuned)
        for path in paths:
            part = storage.ResultFile.open(path)
            _copy(part, whole)
            part.close()
        Study(Team(), config, None, whole).update_statistics()
        status = whole.status()
        whole.close()
        whole.put_back()
        ownership.move(unfinished, os.path.realpath(out))
    except OSError as error:
        raise HpcrubError(f"cannot write {out}: {error.strerror}") from None
    finally:
        unfinished.unlink(missing_ok=True)
        lock.release()
    return int(np.count_nonzero(status != PENDING)), status.size


def _survey(out, paths, samples):
    """What all parts agree on: Config of the whole, results of the tuned disk, and where from.

    Raises InputError for parts that do not belong together.
    """
    config = tuned = tuned_path = None
    origin = defaultdict(set)
    for path in paths:
        part = storage.ResultFile.open(path)
        mine, found = _whole_config(part, out, samples), part.tuned()
        if config and (other := differences(config, mine, (f"in {paths[0]}", f"in {path}"))):
            raise InputError(f"parts of different studies: {'; '.join(other)}")
        config = config or mine
        if found and tuned:
            _same_tuned(tuned, tuned_path, found, path)
        elif found:
            tuned, tuned_path = found, path
        for name, value in part.attributes().items():
            if name.endswith(("_version", "_revision")) and name != "program_version":
                origin[name].update(str(value).split(", "))
        part.close()
    return config, tuned, {name: ", ".join(sorted(values)) for name, values in origin.items()}


def _whole_config(part, out, samples):
    if part.config.study != "contact":
        raise InputError(f"{part.path} is of the study {part.config.study}; only contact has parts")
    if part.config.convergence.stop_when_converged:
        raise InputError(f"{part.path} stops when it has converged: it cannot be part of another")
    end = part.config.samples.stop
    if samples is not None and samples < end:
        raise InputError(f"--samples: {samples} is too few, {part.path} has {end} a level")
    return parts.whole(part.config, out, samples)


def _same_tuned(tuned, path, found, other):
    differ = [name for name in tuned if tuned[name].tobytes() != found[name].tobytes()]
    if differ:
        raise InputError(
            f"the tuned disk of {path} and of {other} is not the same (tuned/{differ[0]}): they "
            "were computed on different kinds of processors, or with different libraries"
        )


def _copy(part, whole):
    """Copy what is finished in a part into the whole file, a group of samples at a time."""
    names = [line.name for line in studies.layout(part.config) if line.name.startswith("samples/")]
    start, n_samples = part.config.samples.start, len(part.config.samples)
    rows = max(1, AT_ONCE // sum(part.read(name, (0, 0)).nbytes for name in names))
    for mine, level in enumerate(part.config.levels):
        for first in range(0, n_samples, rows):
            end = min(first + rows, n_samples)
            source, target = (mine, slice(first, end)), (level, slice(start + first, start + end))
            new = part.read("samples/status", source) != PENDING
            there = whole.read("samples/status", target) != PENDING
            for name in names if new.any() else ():
                values, old = part.read(name, source), whole.read(name, target)
                both = new & there
                if values[both].tobytes() != old[both].tobytes():
                    raise InputError(
                        f"{part.path} contradicts another part: {name} of level {level}, samples "
                        f"{start + first} to {start + end - 1}"
                    )
                old[new] = values[new]
                whole.write({name: old}, target)
