"""Time steps of the reduced disk with contact, several speeds at once: the only loop over steps.

Modal equations of motion  q'' + 2ξω q' + ω² q = Φᵀf,  f the contact forces. A step predicts
without contact force (`passes`), lets the contact law find its multipliers (`laws`) and an observer
see them (`observers`). What one lane computes never depends on the other lanes.
"""

from typing import Any

from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import any_lane
from hpcrub.contact.observers import NOTHING
from hpcrub.contact.passes import correct
from hpcrub.model import casing

bump_ramp = compiled(casing.ramp)


@compiled(inner=True)
def raise_bumps(scheme: Scheme, state: State) -> bool:
    """Factor of the bumps at the coming step (state is modified).

    Returns False once the bumps of all lanes have their full height.
    """
    rising = False
    for lane in range(scheme.step.shape[0]):
        t = (state.n_steps[lane] + 1) * scheme.step[lane]
        state.ramp[0, lane] = bump_ramp(t, scheme.ramp_time)
        rising = rising or 0.0 < t < scheme.ramp_time  # an idle lane has no time
    return rising


@compiled
def integrate(lanes: tuple, bank: Bank, observer: Any, n_blocks: int) -> None:
    """Take every lane over some blocks of the bump table.

    lanes: as many zeros as there are lanes, which tells the compiler the width.
    bank: Motion, coefficients and contact law of every lane (modified).
    observer: what is kept of the steps, of a class like those of ``observers`` (modified).
    n_blocks: blocks to integrate.

    The forces of the last step are applied before it returns. Joachim, Nyssen, Batailly (2020),
    section 2.2.2, gives the scheme; ``docs/theory.md`` derives this form of it.
    """
    n_active = 0
    rising = True
    for block in range(n_blocks):
        for step in range(bank.scheme.bump.shape[0]):
            if rising:
                rising = raise_bumps(bank.scheme, bank.state)
            for lane in range(len(lanes)):
                bank.state.n_steps[lane] += 1
            deepest = bank.law.predict(lanes, bank, step, n_active)
            n_active = 0
            if any_lane(deepest > 0.0):
                n_active = bank.law.forces(lanes, bank, step, deepest)
            n_active = observer.observe(lanes, bank, observer, block, step, n_active)
    correct(lanes, bank.scheme, bank.state, n_active)


def run(bank: Bank, n_blocks: int, observer: Any = NOTHING) -> None:
    """`integrate` for all lanes of a bank; by default nothing is kept of the steps."""
    integrate((0,) * bank.width, bank, observer, n_blocks)
