"""Types of the values in an input, and the base class of its sections."""

from itertools import pairwise
from numbers import Integral
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    Tag,
)

from hpcrub.config import text as config_text

Number = Annotated[float, Strict(), AllowInfNan(False)]  # no booleans, no texts
Level = Annotated[Number, Field(ge=0, lt=100)]
Percentile = Annotated[Number, Field(ge=0, le=100)]
Deviation = Annotated[Number, Field(gt=-100, lt=100)]
Frequency = Annotated[Number, Field(gt=0, le=1e6)]
Ratio = Annotated[Number, Field(ge=1e-6, lt=1)]
MOST_SAMPLES = 10**12


def _whole(value: Any) -> Any:
    """A float without fraction is a whole number, too, such as 1e4; and so are those of NumPy."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value if isinstance(value, bool) or not isinstance(value, Integral) else int(value)


_to_int = BeforeValidator(_whole)
Whole = Annotated[int, Strict(), _to_int]
Switch = Annotated[bool, Strict()]


def _increasing(values: Any) -> Any:
    """Values, or the first numbers of points, that increase."""
    first = [value[0] if isinstance(value, tuple) else value for value in values]
    if any(a >= b for a, b in pairwise(first)):
        raise ValueError("not increasing")
    return values


Increasing = (AfterValidator(_increasing), Field(json_schema_extra={"format": "increasing"}))
Levels = Annotated[tuple[Level, ...], Field(min_length=1, max_length=1000)]
Percentiles = Annotated[tuple[Percentile, ...], Field(min_length=1, max_length=20), *Increasing]
Deviations = Annotated[tuple[Deviation, ...], Field(min_length=2, max_length=200)]
Bands = Annotated[tuple[Frequency, ...], Field(min_length=1, max_length=999), *Increasing]
Ratios = Annotated[tuple[Ratio, ...], Field(min_length=1, max_length=1000)]
Checksum = Annotated[str, Strict(), Field(pattern="^[0-9a-f]{64}$")]


def _file_name(text: str) -> Any:
    if not text.isprintable() or Path(text).name in ("", "..") or text.endswith("/"):
        raise ValueError("no name of a file")
    return text


FileName = Annotated[
    str,
    Strict(),
    BeforeValidator(lambda name: str(name) if isinstance(name, Path) else name),
    AfterValidator(_file_name),
    Field(max_length=4000, json_schema_extra={"format": "a file name"}),
]
Files = Annotated[tuple[FileName, ...], Field(max_length=20)]
_List, _Table = (Tag(kind) for kind in config_text.TAGS)
_ListOrTable = Discriminator(lambda value: config_text.TAGS[isinstance(value, str)])
Blades = Annotated[tuple[Number, ...], Field(min_length=1, max_length=200), _List]
# the values of one disk, or a file of a table with the values of many disks
Pattern = Annotated[Blades | Annotated[FileName, _Table], _ListOrTable]
Point = Annotated[tuple[Number, ...], Field(min_length=2, max_length=2)]
Points = Annotated[tuple[Point, ...], Field(min_length=2, max_length=1000), *Increasing, _List]
# points of a curve, or a file of a table with such points
Curve = Annotated[Points | Annotated[FileName, _Table], _ListOrTable]


def si(key: str, unit: str, times: float = 1, per: float = 1) -> Any:
    """Property that returns the value of `key` in SI units."""
    return property(lambda section: getattr(section, key) * times / per, doc=f"[{unit}]")


def without_suffix(output: str | Path) -> Path:
    """Path of a result file without .h5, with which the names of files beside it begin.

    Any other suffix stays, so that the runs r_0.25 and r_0.50 share no files.
    """
    path = Path(output)
    return path.with_suffix("") if path.suffix == ".h5" else path


class Section(BaseModel):
    """A mapping of the input file: frozen, and without keys that nobody reads.

    The text below a key says what it is, for error messages, the reference and editors.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)
