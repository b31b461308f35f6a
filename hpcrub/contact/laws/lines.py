"""The lines of force of a coating and of the casing behind it; `surfaces` derives them."""

from typing import Any

import numpy as np

from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    any_lane,
    below,
    fma,
    inverse,
    load,
    positive_part,
    select,
    splat,
    store,
)

BEFORE, BEYOND, START = range(3)  # rows of `surfaces.Coated.bars`: k₁, k₂ and c₀
LINES = 4  # before and beyond yield, both without and with the casing behind
WEIGHTS = 3  # a, b and c of a point


def find_gains(lanes: tuple, surface: Any, j: int, compliance: np.ndarray) -> None:
    """Gains γ of the lines of a point from its compliance W (L,) [m/N] (surface is modified)."""
    one, compliance = splat(lanes, 1.0), compliance * load(lanes, surface.weights, WEIGHTS * j)
    before, beyond = splat(lanes, surface.bars[BEFORE, j]), splat(lanes, surface.bars[BEYOND, j])
    store(surface.gain, LINES * j, compliance * inverse(fma(compliance, before, one)))
    store(surface.gain, LINES * j + 1, compliance * inverse(fma(compliance, beyond, one)))
    if surface.carried == 0.0:
        behind = select(below(splat(lanes, 0.0), compliance), one, splat(lanes, 0.0))
        store(surface.gain, LINES * j + 2, behind)
        store(surface.gain, LINES * j + 3, behind)
        return
    behind = splat(lanes, surface.stiffness) + load(lanes, surface.lag, 0)
    before, beyond = before + behind, beyond + behind
    store(surface.gain, LINES * j + 2, compliance * inverse(fma(compliance, before, one)))
    store(surface.gain, LINES * j + 3, compliance * inverse(fma(compliance, beyond, one)))


gains_found = compiled(find_gains, inner=True)


@compiled(inner=True)
def follow(lanes: tuple, surface: Any, j: int, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depth x (L,) [m] that the force of point j undoes of d [m], and the code of its line."""
    zero, worn = splat(lanes, 0.0), load(lanes, surface.worn, surface.bar[j])
    before = splat(lanes, surface.bars[BEFORE, j]) * d
    beyond = fma(
        splat(lanes, surface.bars[BEYOND, j]), d + worn, splat(lanes, surface.bars[START, j])
    )
    x = load(lanes, surface.gain, LINES * j) * before
    other = load(lanes, surface.gain, LINES * j + 1) * beyond
    yields = below(other, x)
    x, code = select(yields, other, x), select(yields, splat(lanes, 2.0), splat(lanes, 1.0))
    behind = (d + worn) - splat(lanes, surface.thickness)
    pressed = below(zero, behind)
    if any_lane(pressed):
        lag, carried = load(lanes, surface.lag, 0), splat(lanes, surface.carried)
        push = (splat(lanes, surface.stiffness) + lag) * behind
        push = push - lag * load(lanes, surface.last, j)
        both = load(lanes, surface.gain, LINES * j + 2) * fma(carried, before, push)
        other = load(lanes, surface.gain, LINES * j + 3) * fma(carried, beyond, push)
        yields = below(other, both)
        both = select(pressed, select(yields, other, both), x)
        pushes = below(x, both)
        both_code = select(yields, splat(lanes, 4.0), splat(lanes, 3.0))
        x, code = select(pushes, both, x), select(pushes, both_code, code)
    return positive_part(x), select(below(zero, x), code, zero)


@compiled(inner=True)
def line(lanes: tuple, surface: Any, j: int, code: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slope (L,) [-] and start (L,) [m] of the line x = slope·d + start of a code."""
    zero, worn = splat(lanes, 0.0), load(lanes, surface.worn, surface.bar[j])
    before, beyond = (
        splat(lanes, surface.bars[BEFORE, j]), splat(lanes, surface.bars[BEYOND, j])
    )  # fmt: skip
    first = fma(beyond, worn, splat(lanes, surface.bars[START, j]))
    gain, other = (
        load(lanes, surface.gain, LINES * j), load(lanes, surface.gain, LINES * j + 1)
    )  # fmt: skip
    yields = below(splat(lanes, 1.5), code)
    slope = select(yields, other * beyond, gain * before)
    start = select(yields, other * first, zero)
    pressed = below(splat(lanes, 2.5), code)
    if any_lane(pressed):
        lag, carried = load(lanes, surface.lag, 0), splat(lanes, surface.carried)
        behind = splat(lanes, surface.stiffness) + lag
        push = behind * (worn - splat(lanes, surface.thickness))
        push = push - lag * load(lanes, surface.last, j)
        gain = load(lanes, surface.gain, LINES * j + 2)
        other = load(lanes, surface.gain, LINES * j + 3)
        yields = below(splat(lanes, 3.5), code)
        both = select(
            yields, other * fma(carried, beyond, behind), gain * fma(carried, before, behind)
        )
        slope = select(pressed, both, slope)
        both = select(yields, other * fma(carried, first, push), gain * push)
        start = select(pressed, both, start)
    touches = below(zero, code)
    return select(touches, slope, zero), select(touches, start, zero)
