"""Division of a study into parts: the samples and the result file of each part.

A part differs from the whole study only in `part.samples` and `output`. So it computes
the same bits as the whole study, and `hpcrub merge` can put it into its place.
"""

import re

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.config.types import without_suffix
from hpcrub.errors import InputError


def parse(text: str) -> tuple[int, int]:
    """Parse (number, count) of a part from a text such as "3/8". Raises InputError."""
    match = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", text)
    number, count = map(int, match.groups()) if match else (0, 0)
    if not 1 <= number <= count:
        raise InputError(f"--part: {text!r} is not of the form K/N, K from 1 to N")
    return number, count


def cut(config: Config, number: int, count: int) -> Config:
    """Configuration of one of `count` parts of a study, each a range of samples of all levels.

    number: of the part, from 1. The output of part K of N is NAME.part-K-of-N.h5.
    Raises InputError when the study cannot be cut in this way.
    """
    if config.is_part:
        raise InputError("part: the input is of a part already, it cannot be cut again")
    n_samples = len(config.samples)
    if count > n_samples:
        raise InputError(f"--part: {counted(n_samples, 'sample')} cannot be cut into {count} parts")
    first, end = (k * n_samples // count for k in (number - 1, number))
    width = len(str(count))  # leading zeros list the parts in order
    output = f"{without_suffix(config.output)}.part-{number:0{width}}-of-{count}.h5"
    return config.replace({"part.samples": [first, end], "output": output})
