"""The lines of force of a coating and of the casing behind it; `surfaces` derives them."""

from typing import Any

import numpy as np

from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    any_lane,
    fma,
    inverse,
    load,
    positive_part,
    select,
    store,
)

BEFORE, BEYOND, START = range(3)  # rows of `surfaces.Coated.bars`: k₁, k₂ and c₀
LINES = 4  # before and beyond yield, both without and with the casing behind
WEIGHTS = 3  # a, b and c of a point


def find_gains(lanes: tuple, surface: Any, j: int, compliance: np.ndarray) -> None:
    """Gains γ of the lines of a point from its compliance W (L,) [m/N] (surface is modified)."""
    compliance = compliance * load(lanes, surface.weights, WEIGHTS * j)
    before, beyond = surface.bars[BEFORE, j], surface.bars[BEYOND, j]
    store(surface.gain, LINES * j, compliance * inverse(fma(compliance, before, 1.0)))
    store(surface.gain, LINES * j + 1, compliance * inverse(fma(compliance, beyond, 1.0)))
    behind = surface.stiffness + load(lanes, surface.lag, 0)
    for row, own in ((2, before), (3, beyond)):
        both = compliance * inverse(fma(compliance, own + behind, 1.0))
        rigid = select(compliance > 0.0, 1.0, 0.0)
        store(surface.gain, LINES * j + row, both if surface.carried != 0.0 else rigid)


gains_found = compiled(find_gains, inner=True)


@compiled(inner=True)
def follow(lanes: tuple, surface: Any, j: int, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depth x (L,) [m] that the force of point j undoes of d [m], and the code of its line."""
    worn = load(lanes, surface.worn, surface.bar[j])
    before = surface.bars[BEFORE, j] * d
    beyond = fma(surface.bars[BEYOND, j], d + worn, surface.bars[START, j])
    x = load(lanes, surface.gain, LINES * j) * before
    other = load(lanes, surface.gain, LINES * j + 1) * beyond
    yields = other < x
    x, code = select(yields, other, x), select(yields, 2.0, 1.0)
    behind = (d + worn) - surface.thickness
    pressed = behind > 0.0
    if any_lane(pressed):
        lag, carried = load(lanes, surface.lag, 0), surface.carried
        push = (surface.stiffness + lag) * behind
        push = push - lag * load(lanes, surface.last, j)
        both = load(lanes, surface.gain, LINES * j + 2) * fma(carried, before, push)
        other = load(lanes, surface.gain, LINES * j + 3) * fma(carried, beyond, push)
        yields = other < both
        both = select(pressed, select(yields, other, both), x)
        pushes = x < both
        both_code = select(yields, 4.0, 3.0)
        x, code = select(pushes, both, x), select(pushes, both_code, code)
    return positive_part(x), select(x > 0.0, code, 0.0)


@compiled(inner=True)
def line(lanes: tuple, surface: Any, j: int, code: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slope (L,) [-] and start (L,) [m] of the line x = slope·d + start of a code."""
    worn = load(lanes, surface.worn, surface.bar[j])
    before, beyond = surface.bars[BEFORE, j], surface.bars[BEYOND, j]
    first = fma(beyond, worn, surface.bars[START, j])
    gain = load(lanes, surface.gain, LINES * j)
    other = load(lanes, surface.gain, LINES * j + 1)
    yields = code > 1.5
    slope = select(yields, other * beyond, gain * before)
    start = select(yields, other * first, 0.0)
    pressed = code > 2.5
    if any_lane(pressed):
        lag, carried = load(lanes, surface.lag, 0), surface.carried
        behind = surface.stiffness + lag
        push = behind * (worn - surface.thickness)
        push = push - lag * load(lanes, surface.last, j)
        gain = load(lanes, surface.gain, LINES * j + 2)
        other = load(lanes, surface.gain, LINES * j + 3)
        yields = code > 3.5
        both = select(
            yields, other * fma(carried, beyond, behind), gain * fma(carried, before, behind)
        )
        slope = select(pressed, both, slope)
        both = select(yields, other * fma(carried, first, push), gain * push)
        start = select(pressed, both, start)
    touches = code > 0.0
    return select(touches, slope, 0.0), select(touches, start, 0.0)
