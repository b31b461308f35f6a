"""Time steps of the reduced disk with contact, several speeds at once: the only loop over steps.

The modal equations of motion are q'' + 2ξω q' + ω² q = Φᵀf with the contact forces f. A step
predicts the motion without contact force (`passes`); then the contact law computes its multipliers
(`laws`), and an observer records the step (`observers`). The result of a lane never depends on the
other lanes.
"""

from typing import Any

from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import any_lane
from hpcrub.contact.observers import NOTHING
from hpcrub.model import casing

bump_ramp = compiled(casing.ramp)


@compiled(inner=True)
def raise_bumps(scheme: Scheme, state: State) -> bool:
    """Set the factor of the bumps for the coming step (state is modified).

    Returns False once the bumps of all lanes have their full height.
    """
    rising = False
    for lane in range(scheme.step.shape[0]):
        t = (state.n_steps[lane] + 1) * scheme.step[lane]
        state.ramp[0, lane] = bump_ramp(t, scheme.ramp_time)
        # an idle lane has no time; the time of a lane that waits is negative
        rising = rising or (scheme.step[lane] > 0.0 and t < scheme.ramp_time)
    return rising


@compiled
def integrate(lanes: tuple, bank: Bank, observer: Any, n_blocks: int) -> None:
    """Integrate every lane over some blocks of the bump table.

    bank: motion, coefficients and contact law of every lane (modified).
    observer: recorder of the steps, of a class like those in ``observers`` (modified).
    n_blocks: number of blocks.

    The forces of the last step are applied before the function returns. Joachim, Nyssen, Batailly
    (2020), section 2.2.2, gives the scheme; ``docs/theory.md`` derives this form of it.
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
    bank.basis.correct(lanes, bank, n_active)


def run(bank: Bank, n_blocks: int, observer: Any = NOTHING) -> None:
    """Call `integrate` for all lanes of a bank; by default no step is recorded."""
    integrate((0,) * bank.width, bank, observer, n_blocks)
