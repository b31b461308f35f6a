"""What a figure draws: its lines, bands and intervals, against the numbers that they are of."""

import numpy as np
import pytest

from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import Z_95, percentile_interval


def lines(axes):
    """Data (n, 2) of every line."""
    return [np.column_stack(line.get_data()).astype(float) for line in axes.get_lines()]


def assert_drawn(axes, *curves):
    """The curves, pairs (x, y), are among the lines, one after the other."""
    left = lines(axes)
    for x, y in curves:
        wanted = np.column_stack(np.broadcast_arrays(x, y))
        while left:
            line = left.pop(0)
            if line.shape == wanted.shape and np.allclose(line, wanted, rtol=1e-12, atol=0):
                break
        else:
            pytest.fail(f"not drawn, or not in this order: {wanted}")


def edges(axes, number=0):
    """Points of a shaded band."""
    return axes.collections[number].get_paths()[0].vertices


def done(file, name, level):
    return file.read(name, level)[file.status()[level] == DONE]


def percentiles(file, name):
    """Percentiles of the finished samples, (percentile, level)."""
    at = file.config.convergence.percentiles
    return np.transpose([np.percentile(done(file, name, v), at) for v in range(2)])


def bars(axes):
    """Confidence intervals of an axes, {(x, centre): [low, high]}; infinite where an arrow is."""
    found = {}
    for bar in axes.collections:
        if hasattr(bar, "get_segments"):
            for (x0, y0), (_, y1) in bar.get_segments():
                ends = found.setdefault(x0, [])
                ends.append((y0, y1))
    return found


def arrows(axes):
    """Points (x, y, direction up or down) at which an open end is drawn."""
    return sorted(
        (*note.xy, int(np.sign(note.xyann[1]))) for note in axes.texts if note.arrow_patch
    )


def assert_intervals(axes, *rows):
    """Every (x, centre, low, high) is drawn: a bar to each finite end, an arrow at the others."""
    drawn, open_ends = bars(axes), arrows(axes)
    for x, centre, low, high in rows:
        for end, sign in ((low, -1), (high, 1)):
            pair = sorted((centre, end)) if np.isfinite(end) else None
            if pair:
                assert any(np.allclose(sorted(b), pair, rtol=1e-9) for b in drawn[x]), (x, pair)
            else:
                assert any(np.allclose((x, centre, sign), a) for a in open_ends), (x, centre, sign)


def interval_rows(x, values, at):
    """Rows for `assert_intervals` of the percentiles of values."""
    low, high = percentile_interval(values, at, Z_95)
    return [(x, *row) for row in zip(np.percentile(values, at), low, high, strict=True)]
