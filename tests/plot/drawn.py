"""What a figure draws: its lines, bands and intervals, against the numbers that they are of."""

import numpy as np
import pytest

from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import Z_95, percentile_interval

AT = [1.0, 50.0, 99.0]  # the percentiles of every input of these tests


def lines(axes):
    """Data (n, 2) of every line that has points."""
    data = [np.column_stack(line.get_data()).astype(float) for line in axes.get_lines()]
    return [line for line in data if len(line)]


def assert_drawn(axes, *curves):
    """The curves, pairs (x, y), are among the lines, one after the other."""
    left = lines(axes)
    for x, y in curves:
        wanted = np.column_stack(np.broadcast_arrays(x, y))
        while left:
            line = left.pop(0)
            if line.shape == wanted.shape and np.allclose(
                line, wanted, rtol=1e-12, atol=0, equal_nan=True
            ):
                break
        else:
            pytest.fail(f"not drawn, or not in this order: {wanted}")


def edges(axes, x):
    """Lower and upper end of the first shaded band at x."""
    band = axes.collections[0].get_paths()[0].vertices
    at = band[np.isclose(band[:, 0], x, rtol=1e-12), 1]
    return [at.min(), at.max()]


def done(file, name, level):
    return file.read(name, level)[file.status[level] == DONE]


def words(axes):
    """What the legends of axes and their figure say."""
    legends = [*axes.figure.legends, axes.get_legend()]
    return [text.get_text() for one in legends if one for text in one.get_texts()]


def arrows(axes):
    """Points (x, y, direction up or down) at which an open end is drawn."""
    return [(*note.xy, int(np.sign(note.xyann[1]))) for note in axes.texts if note.arrow_patch]


def assert_intervals(axes, x, values, at=AT):
    """The percentiles of values have a bar to every finite end at x, and an arrow at the others."""
    bars = np.array([b.get_segments()[i] for b in axes.collections if hasattr(b, "get_segments")
                     for i in range(len(b.get_segments()))])  # fmt: skip
    low, high = percentile_interval(values, at, Z_95)
    for centre, *ends in zip(np.percentile(values, at), low, high, strict=True):
        bar = [centre if np.isnan(end) else end for end in ends]
        assert any(np.allclose(b, [[x, bar[0]], [x, bar[1]]], rtol=1e-9) for b in bars)
        for end, sign in zip(ends, (-1, 1), strict=True):
            drawn = any(np.allclose((x, centre, sign), a) for a in arrows(axes))
            assert drawn == np.isnan(end)


def assert_percentiles(axes, x, levels, start=()):
    """Percentiles of the values of every level are drawn over x, with their intervals.

    start: point (x, y) at which all curves begin.
    """
    curves = np.transpose([np.percentile(values, AT) for values in levels])
    first = [[at] for at in start] or [[], []]
    assert_drawn(axes, *(([*first[0], *x], [*first[1], *curve]) for curve in curves))
    for at, values in zip(x, levels, strict=True):
        assert_intervals(axes, at, values)
