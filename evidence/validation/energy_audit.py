"""Energy audit of the reference disk: what the casing puts in and where it goes."""

import numpy as np

from evidence.validation import energy_balance, report
from hpcrub.contact.bank import allocate
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sweep import Grid
from tests.truth.disk import reference_reduced, reference_scene
from tests.truth.motion import WIDTH

SPEEDS = np.array([33.5, 34.25, 35.0])
REVOLUTION, BLOCKS = 3000, 20  # steps of 10 µs; five revolutions of four bumps
TEXT = """## Energy audit

The energy balance of the two-step scheme holds exactly ([theory](theory.md)): what is stored, what
damping and impacts take, is the work of the casing, of friction and of external forces.
`evidence/validation/energy_balance.py` follows it step by step. It takes the same steps as a study,
bit for bit, and several times as long. The balance closes if at most 10⁻⁹ of the energy turned over
is unexplained, and as much of the losses of single tips lies below their bound. That bound is zero
for `small`; for `polar` it is what the linearised correction may leave of the gap, which shrinks
with the step.

The table is for the reference disk, mistuned by up to ±3 %, over five revolutions from rest at
34.25 Hz with 3000 steps each, in joule. *Unexplained* is the sum over all steps, divided by the
energy turned over. *Below zero* is the sum of all losses of single tips that are negative, divided
likewise, and *beyond* the part of it that its bound does not allow."""
POLAR_TEXT = """With polar kinematics the losses below zero are an artefact of the linearised
correction. They vanish with the step, faster than their bound (`central_difference`, 34.25 Hz, over
the energy turned over):"""
DIVISIONS = np.array([1500, 3000, 6000, 12000])  # steps a revolution


def bank_of(kinematics, scheme_name, n_modes=60, revolution=REVOLUTION, reduced=None, **changes):
    """The reference disk, or another reduced one, at SPEEDS, one lane each, at rest; revolution:
    steps of one; changes of the Scene.
    """
    reduced = reduced or reference_reduced(n_modes)
    changes = {"interface": reduced.interface, **changes}
    scene = reference_scene(n_modes, kinematics=kinematics, scheme=scheme_name, **changes)
    modes = mistuned_modes(reduced, np.linspace(-0.03, 0.03, 12))
    return allocate(modes, scene, Grid(revolution, 4, 1), WIDTH, SPEEDS)


def section(folder):
    """Markdown and verdicts of this case; figures go to ``folder``."""
    head = ["", *energy_balance.ACCOUNTS[:-1], "unexplained", "below zero", "beyond"]
    rows, verdicts = [], []
    for kinematics in ("small", "polar"):
        for name in ("central_difference", "exact_modal"):
            books = energy_balance.audit(bank_of(kinematics, name), BLOCKS)
            totals, case = energy_balance.close_lane(books, 1), f"{kinematics}, `{name}`"
            below, _, beyond = signs(books)
            unexplained = totals[-1] / turned_over(books)
            cells = [f"{total:.1f}" for total in totals[:-1]]
            rows.append([case, *cells, *(f"{x:.0e}" for x in (unexplained, below, beyond))])
            verdicts += [
                report.at_most(f"{case}, unexplained", unexplained, energy_balance.TOLERANCE),
                report.at_most(
                    f"{case}, losses beyond their bound", beyond, energy_balance.TOLERANCE
                ),
            ]
    polar = {"below zero": [], "bound": []}
    for n in DIVISIONS:
        books = energy_balance.audit(bank_of("polar", "central_difference", revolution=n), BLOCKS)
        for column, share in zip(polar.values(), signs(books)[:2], strict=True):
            column.append(share)
    size = 1.0 / DIVISIONS
    verdicts += [report.order(f"polar losses, {what}", size, e, 0.9) for what, e in polar.items()]
    table = report.order_table(("steps a revolution", DIVISIONS), size, polar)
    figure = _figure(folder, energy_balance.audit(bank_of("small", "central_difference"), BLOCKS))
    return "\n\n".join([TEXT, report.table(head, rows), POLAR_TEXT, table, figure]), verdicts


def turned_over(books, lane=1):
    """Sum of the works of a lane, either way [J]."""
    return np.abs(books.work[:, :, lane]).sum()


def signs(books, lane=1):
    """Losses below zero, their bound and what is beyond it, over the energy turned over (3,)."""
    return np.abs(books.negative[:, lane]) / turned_over(books, lane)


def _figure(folder, books):
    figure, ax = report.axes()
    turns = np.arange(1, len(books.energy) + 1) / REVOLUTION
    total = np.zeros(len(turns))
    work = np.cumsum(books.work[:, :, 1], axis=0)
    parts = {
        "energy of the disk": books.energy[:, 1],
        "lost in impacts": work[:, energy_balance.IMPACT],
        "damping": work[:, energy_balance.DAMPING],
        "friction": -work[:, energy_balance.FRICTION],
    }
    for (name, part), colour in zip(parts.items(), report.COLOURS, strict=True):
        ax.fill_between(turns, total, total + part, color=colour, alpha=0.75, lw=0, label=name)
        total = total + part
    ax.plot(turns, work[:, energy_balance.CASING], "k--", lw=1.6, label="work of the casing")
    ax.set_xlabel("revolutions from rest")
    ax.set_ylabel("energy [J]")
    ax.legend(loc="upper left")
    return report.save(figure, folder, "energy")
