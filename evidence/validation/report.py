"""Tables, fitted orders, verdicts and figures of the validation page."""

from typing import NamedTuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from evidence import pictures
from evidence.page import DOCS, table
from hpcrub.plot.style import COLOURS, STYLE

SCHEMES = "central_difference", "exact_modal"
LOOK = {"figure.figsize": (9.0, 4.2), "axes.prop_cycle": matplotlib.cycler(color=COLOURS)}


class Verdict(NamedTuple):
    """A number that a case holds against what theory or the requirement allows."""

    what: str
    value: float
    low: float  # least value allowed
    high: float  # largest value allowed

    @property
    def passed(self):
        return bool(self.low <= self.value <= self.high)  # NaN fails

    @property
    def allowed(self):
        """The range in words."""
        if self.low == -np.inf:
            return f"at most {self.high:.4g}"
        if self.high == np.inf:
            return f"at least {self.low:.4g}"
        return f"{self.low:.4g} to {self.high:.4g}"


def at_most(what, value, bound):
    """Verdict on an error."""
    return Verdict(what, float(value), -np.inf, bound)


def order(what, size, error, low, high=np.inf):
    """Verdict on the fitted order of errors (n,) over sizes (n,)."""
    return Verdict(f"order, {what}", fitted_order(size, error), low, high)


def fitted_order(size, error):
    """Slope of log(error) over log(size)."""
    return float(np.polyfit(np.log(size), np.log(error), 1)[0])


def order_table(first, size, errors):
    """Table of errors against a step or a mesh size, its last line the fitted orders.

    first: heading and entries of the first column; size (n,); errors: heading → (n,).
    """
    rows = [
        [label, *(float(error[i]) for error in errors.values())] for i, label in enumerate(first[1])
    ]
    orders = [f"**{fitted_order(size, error):.2f}**" for error in errors.values()]
    return table([first[0], *errors], [*rows, ["**fitted order**", *orders]])


def axes(n_columns=1, n_rows=1, **options):
    """A figure in the page's style and its axes."""
    with plt.rc_context(STYLE | LOOK):
        return plt.subplots(n_rows, n_columns, **options)


def save(figure, name):
    """Write a figure of the page."""
    pictures.save(figure, DOCS / "figures" / f"{name}.png", dpi=130)
    plt.close(figure)
