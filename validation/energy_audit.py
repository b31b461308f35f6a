"""Energy audit of the reference disk: what the casing puts in and where it goes."""

import numpy as np

from hpcrub import energy, scheme
from hpcrub.reduction import mistuned_modes
from hpcrub.sweep import Grid, Scene
from validation import disk, report
from validation.motion import WIDTH

SPEEDS = np.array([33.5, 34.25, 35.0])
REVOLUTION, STEPS = 3000, 15_000  # steps of 10 µs; five revolutions
TEXT = """## Energy audit

`hpcrub.energy.audit` follows the energy of any march, step by step, by a balance that the two-step
scheme satisfies exactly ([theory](theory.md)): energy + damping + impact loss = work of the casing
+ work of friction + work of external forces. It is a function for tests and for this page, not an
option of a study: it marches one step at a time from Python. Here: the reference disk, mistuned by
up to ±3 %, five revolutions from rest at 34.25 Hz, in joule. Residual: the largest of any step and
speed, over the largest energy. Least loss: of any tip's step, over the largest loss."""


def bank_of(kinematics, scheme_name, friction=0.15, n_modes=60):
    """The reference disk at SPEEDS, one lane each, at rest."""
    reduced = disk.reduced(n_modes)
    scene = Scene(
        contact_angle=reduced.contact_angle,
        contact_radius=float(reduced.contact_radius[0]),
        damping_ratio=0.005,
        n_bumps=4,
        bump_height=1.25e-3,
        clearance=0.25e-3,
        growth_time=0.01,
        friction=friction,
        kinematics=kinematics,
        scheme=scheme_name,
    )
    modes = mistuned_modes(reduced, np.linspace(-0.03, 0.03, 12))
    bank = scheme.allocate(modes, scene, Grid(REVOLUTION, 4, 1), WIDTH)
    for lane in range(WIDTH):
        scheme.empty_lane(bank, lane)
    for lane, speed in enumerate(SPEEDS):
        scheme.fill_lane(bank, lane, modes, scene, 1.0 / (speed * REVOLUTION))
    return bank


def section(folder):
    """Markdown of this case; figures go to ``folder``."""
    head = ["", "casing", "friction", "damping", "impacts", "energy", "residual", "least loss"]
    rows, ledgers = [], {}
    for kinematics in ("small", "polar"):
        for name in ("central_difference", "exact_modal"):
            ledger = energy.audit(bank_of(kinematics, name), STEPS)
            ledgers[kinematics, name] = ledger
            works = (ledger.casing, ledger.friction, ledger.damping, ledger.impact)
            residual = np.abs(ledger.residual()).max() / ledger.energy.max()
            least = ledger.impact.min() / ledger.impact.max()
            totals = [f"{work[:, 1].sum():.1f}" for work in works]
            totals.append(f"{ledger.energy[-1, 1]:.1f}")
            rows.append([f"{kinematics}, `{name}`", *totals, f"{residual:.0e}", f"{least:.0e}"])
    figure = _figure(folder, ledgers["small", "central_difference"])
    return "\n\n".join([TEXT, report.table(head, rows), figure])


def _figure(folder, ledger):
    figure, ax = report.axes()
    turns = np.arange(1, STEPS + 1) / REVOLUTION
    total = np.zeros(STEPS)
    parts = {
        "energy of the disk": ledger.energy[1:, 1],
        "lost in impacts": np.cumsum(ledger.impact[:, 1]),
        "damping": np.cumsum(ledger.damping[:, 1]),
        "friction": np.cumsum(-ledger.friction[:, 1]),
    }
    for (name, part), colour in zip(parts.items(), report.COLOURS, strict=True):
        ax.fill_between(turns, total, total + part, color=colour, alpha=0.75, lw=0, label=name)
        total = total + part
    ax.plot(turns, np.cumsum(ledger.casing[:, 1]), "k--", lw=1.6, label="work of the casing")
    ax.set_xlabel("revolutions from rest")
    ax.set_ylabel("energy [J]")
    ax.legend(loc="upper left")
    return report.save(figure, folder, "energy")
