"""A study ↔ its parts: which levels and samples each computes, and into which file.

A part is `part.levels` and `part.samples` of the configuration; all else is the whole study's. So
a part computes the same bits as the whole study, and `hpcrub.merge` can put it into its place.
"""

import re

from hpcrub.config import schema as configuration
from hpcrub.config.schema import Config
from hpcrub.config.types import without_suffix
from hpcrub.errors import InputError

BY = "samples", "level"


def parse(text: str) -> tuple[int, int]:
    """(number, count) of a part from a text such as "3/8". Raises InputError."""
    match = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", text)
    number, count = map(int, match.groups()) if match else (0, 0)
    if not 1 <= number <= count:
        raise InputError(f"--part: {text!r} is not of the form K/N, K from 1 to N")
    return number, count


def cut(config: Config, number: int, count: int, by: str = "samples") -> Config:
    """Configuration of one of several parts of a study.

    Parameters
    ----------
    config : Config
        Config of the whole study.
    number : int
        Of the part, from 1.
    count : int
        Number of parts.
    by : str
        "samples": a range of the samples of all levels; "level": a range of the samples of one
        level, so that `count` is a multiple of the number of levels.

    Returns
    -------
    Config
        Config whose output is NAME.part-K-of-N.h5.

    Raises
    ------
        InputError: the study cannot be cut in this way.
    """
    if config.is_part:
        raise InputError("part: the input is of a part already, it cannot be cut again")
    levels, n_samples = len(config.levels), len(config.samples)
    if by == "level" and count % levels:
        raise InputError(f"--part-by level: {count} is no multiple of the {levels} levels")
    per_level = count // levels if by == "level" else count
    if per_level > n_samples:
        raise InputError(f"--part: {n_samples} samples cannot be cut into {per_level} parts")
    level, place = divmod(number - 1, per_level)
    first, end = (k * n_samples // per_level for k in (place, place + 1))
    width = len(str(count))  # the parts of a folder listed in order
    keys = {
        "part.samples": [first, end],
        "output": f"{without_suffix(config.output)}.part-{number:0{width}}-of-{count}.h5",
    }
    if by == "level":
        keys["part.levels"] = [level]
    return configuration.replaced(config, keys)


def whole(config: Config, output: str, samples: int | None = None) -> Config:
    """Configuration of the whole study, into the file output, of that of a part.

    samples: number of samples a level, that of the part's own study if left out.
    """
    keys = {"part.levels": None, "part.samples": None, "output": str(output)}
    if samples is not None:
        keys["mistuning.samples"] = samples
    return configuration.replaced(config, keys)
