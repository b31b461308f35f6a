"""Tables, fitted orders and figures of the validation page."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")  # told apart by colour-blind eyes too
STYLE = {
    "figure.figsize": (9.0, 4.2),
    "figure.dpi": 130,
    "figure.constrained_layout.use": True,
    "font.size": 11,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
}


def fitted_order(size, error):
    """Slope of log(error) over log(size)."""
    return float(np.polyfit(np.log(size), np.log(error), 1)[0])


def table(head, rows):
    """Markdown table; rows of strings or numbers (three digits)."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(map(_cell, row)) + " |" for row in rows]
    return "\n".join(lines)


def _cell(value):
    return f"{value:.3g}" if isinstance(value, float) else str(value)


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
    with plt.rc_context(STYLE):
        return plt.subplots(n_rows, n_columns, **options)


def save(figure, folder, name):
    """Write a figure and return the Markdown that shows it."""
    figure.savefig(folder / f"validation_{name}.png")
    plt.close(figure)
    return f"![{name}](figures/validation_{name}.png)"
