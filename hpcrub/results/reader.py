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
# short names of tables: a dataset that is a column of the table
SHORT = {
    "samples": "samples/status",
    "points": "samples/point_status",
    "percentiles": "statistics/contact/amplification",
    "tuned": "tuned/amplitude_m",
}


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

    def _rows(self, name: str) -> Any:
        """Return the dimensions of the table where a dataset is a column, or has one per blade."""
        names = self.dimensions(name)
        return names[:-1] if len(names) > 1 and names[-1] == COLUMNS else names

    def to_dataframe(self, table: str = "samples") -> "pandas.DataFrame":
        """One row for each sample, or for each place along the axes of another dataset.

        table: name of a dataset, or a short one: "samples"; "points", a row for each speed of each
        sample; "percentiles", for each number of samples seen; "tuned", for each speed of the tuned
        disk.
        Columns are all datasets with the same axes, called as they are; one column for each blade,
        counted from 1, where they have values by blade. The rows are indexed by the axes.
        Raises InputError when there is no such dataset, or xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            raise InputError("xarray is not installed: pip install 'hpcrub[tables]'") from None
        all_names = self.names()
        if (name := SHORT.get(table, table)) not in all_names:
            there = [
                *(short for short, of in SHORT.items() if of in all_names),
                "any name in file.names()",
            ]
            raise InputError(f"{self.path}: no table {table!r}; there are {', '.join(there)}")
        dimensions = self._rows(name)
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
