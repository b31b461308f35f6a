"""Energy audit of the reference disk: what the casing puts in and where it goes."""

import numpy as np

from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.energy import TOLERANCE, audit
from evidence.truth.motion import WIDTH
from evidence.validation import report
from hpcrub.contact.bank import allocate
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import Grid

SPEEDS = np.array([33.5, 34.25, 35.0])
ACCOUNTS = "casing", "friction", "damping", "impact"
LANE = 1  # shown: 34.25 Hz
REVOLUTION, BLOCKS = 3000, 20  # steps of 10 µs; five revolutions of four bumps


def bank_of(scheme_name, n_modes=60, reduced=None, **changes):
    """The reference disk, or another reduced one, at SPEEDS, one lane each, at rest; changes of the
    Scene."""
    reduced = reduced or reference_reduced(n_modes)
    changes = {"interface": reduced.interface, **changes}
    scene = reference_scene(n_modes, scheme=scheme_name, **changes)
    modes = mistuned_modes(reduced, np.linspace(-0.03, 0.03, 12))
    return allocate(modes, scene, Grid(REVOLUTION, 4, 1), WIDTH, SPEEDS)


def section(folder):
    """Parts of the page, and verdicts; figures go to ``folder``."""
    head = ["", *ACCOUNTS, "stored", "unexplained", "below zero"]
    rows, verdicts, books = [], [], {}
    for name in report.SCHEMES:
        bank = bank_of(name)
        found = books[name] = audit(bank, BLOCKS * len(bank.scheme.bump))
        totals = [getattr(found, part)[:, LANE].sum() for part in ACCOUNTS]
        totals.append(found.energy[-1, LANE] - found.energy[0, LANE])
        below_zero = -found.negative[:, LANE].sum() / found.turnover()[LANE]
        shares = found.unexplained()[LANE], below_zero
        cells = [f"{total:.1f}" for total in totals]
        rows.append([f"`{name}`", *cells, *(f"{share:.0e}" for share in shares)])
        verdicts += [
            report.at_most(f"`{name}`, {what}", share, TOLERANCE)
            for what, share in zip(("unexplained", "losses below zero"), shares, strict=True)
        ]
    _figure(folder, books["central_difference"])
    return {"accounts": report.table(head, rows)}, verdicts


def _figure(folder, books):
    figure, ax = report.axes()
    turns = np.arange(1, len(books.casing) + 1) / REVOLUTION
    total = np.zeros(len(turns))
    work = {name: getattr(books, name)[:, LANE].cumsum() for name in ACCOUNTS}
    parts = {
        "energy of the disk": books.energy[1:, LANE],
        "lost in impacts": work["impact"],
        "damping": work["damping"],
        "friction": -work["friction"],
    }
    for (name, part), colour in zip(parts.items(), report.COLOURS, strict=False):
        ax.fill_between(turns, total, total + part, color=colour, alpha=0.75, lw=0, label=name)
        total = total + part
    ax.plot(turns, work["casing"], "k--", lw=1.6, label="work of the casing")
    ax.set(xlabel="revolutions from rest", ylabel="energy [J]")
    ax.legend(loc="upper left")
    report.save(figure, folder, "energy")
