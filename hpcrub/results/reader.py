"""A result file for a notebook: arrays by their names, pandas tables.

It needs neither MPI nor the models, and xarray only for tables, which can open the file, too.
"""

import difflib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from hpcrub.errors import InputError
from hpcrub.results.storage import ResultFile

if TYPE_CHECKING:
    import pandas

COLUMNS = "blade"  # a dimension that, as the last one, makes columns of a table instead of rows
RUNS = "tuned/run"  # dimension of the runs of the tuned disk, which are no samples
# short names of tables: a dataset that is a column of the table
SHORT = {"percentiles": "statistics/contact/amplification", "tuned": "tuned/amplitude_m"}


class Results(ResultFile):
    """A result file that is open to be read: a mapping of dataset names to arrays.

    Of any study, finished or still running; to be used in a `with` statement, or closed by its
    `close`. Raises InputError when there is no such file, or it is damaged, or no result of hpcrub.

    Attributes
    ----------
    path : Path
        The file.
    config : Config
        The effective configuration of its study, every key.

    Examples
    --------
    >>> import hpcrub
    >>> with hpcrub.open("results/quickstart.h5") as file:
    ...     amplification = file["samples/amplification"]
    ...     table = file.to_dataframe("samples")
    """

    def __getitem__(self, name: str) -> Any:
        """Return the values of a dataset in SI units: an array, or a number when it has no axes."""
        try:
            return self.read(name)
        except InputError as error:
            if name in self.names():
                raise
            near = difflib.get_close_matches(name, self, 3, 0.4) or [*self]
            raise KeyError(f"{error}; there are {', '.join(near)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __len__(self) -> int:
        return len(self.names())

    def __repr__(self) -> str:
        return f"<hpcrub {self.config.study} study {str(self.path)!r}>"

    def units(self, name: str) -> str:
        """Unit of a dataset, "1" when it has none."""
        return str(self.attributes_of(name).get("units", "1"))

    def description(self, name: str) -> str:
        """What a dataset holds."""
        attributes = self.attributes_of(name)
        return str(attributes.get("long_name", attributes.get("description", "")))

    def tables(self) -> dict[str, tuple[str, ...]]:
        """{name: dimensions} of the tables that `to_dataframe` makes of this file.

        Each is named by its dimensions, such as "half_range,sample". Of those that most questions
        are about there are short names: "samples"; "points", a row for each speed of each sample;
        "percentiles", for each number of samples seen; "tuned", for each speed of the tuned disk.
        """
        tables = {",".join(d): d for name in self if (d := self._rows(name)) and d != (name,)}
        shortest = sorted(tables.values(), key=len)
        rows = [d for d in shortest if d[-1] == "sample"]
        points = [d for d in shortest if d[-1] == "speeds_hz" and len(d) > 1 and d[0] != RUNS]
        short = {name: some[0] for name, some in (("samples", rows), ("points", points)) if some}
        return tables | short | {name: self._rows(of) for name, of in SHORT.items() if of in self}

    def _rows(self, name: str) -> Any:
        """Return the dimensions of the table where a dataset is a column, or has one per blade."""
        names = self.dimensions(name)
        return names[:-1] if len(names) > 1 and names[-1] == COLUMNS else names

    def to_dataframe(self, table: str = "samples") -> "pandas.DataFrame":
        """One row for each sample, or each point, or another of the `tables`.

        Columns are called as the datasets; one column for each blade, counted from 1, where they
        have values by blade. The rows are indexed by the table's dimensions.
        Raises InputError when there is no such table, or xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            raise InputError("xarray is not installed: pip install 'hpcrub[tables]'") from None
        tables = self.tables()
        if table not in tables:
            there = "; ".join(reversed(tables))  # tables with short names first
            raise InputError(f"{self.path}: no table {table!r}; there are {there}")
        dimensions = tables[table]
        names = [n for n in self if self._rows(n) == dimensions and n not in dimensions]
        short = {name: name.rpartition("/")[2] for name in (*names, *dimensions)}
        columns = {}
        for name in names:
            label = short[name] if [*short.values()].count(short[name]) == 1 else name
            if self.dimensions(name) == dimensions:
                columns[label] = dimensions, self[name]
                continue
            for blade, values in enumerate(np.moveaxis(self[name], -1, 0), 1):
                columns[f"{label}_{blade}"] = dimensions, values
        lengths = zip(dimensions, self.shape(names[0]), strict=False)  # without the blades
        known = {d: self[d] for d, n in lengths if d in self and self.shape(d) == (n,)}
        rows = xarray.Dataset(columns, known).to_dataframe(dim_order=[*dimensions])
        return rows.rename_axis([short[dimension] for dimension in dimensions])
