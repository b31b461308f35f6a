"""Energy audit of the reference disk: what the casing puts in and where it goes."""

import numpy as np

from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.motion import WIDTH
from evidence.validation import energy_balance, report
from hpcrub.contact.bank import allocate
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import Grid

SPEEDS = np.array([33.5, 34.25, 35.0])
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
    head = ["", *energy_balance.ACCOUNTS, "below zero"]
    rows, verdicts, books = [], [], {}
    for name in ("central_difference", "exact_modal"):
        books[name] = energy_balance.audit(bank_of(name), BLOCKS)
        *totals, unexplained = energy_balance.accounts(books[name], 1)
        turned_over = np.abs(books[name].work[:, :, 1]).sum()
        shares = unexplained / turned_over, -books[name].negative[0, 1] / turned_over
        cells = [f"{total:.1f}" for total in totals]
        rows.append([f"`{name}`", *cells, *(f"{share:.0e}" for share in shares)])
        verdicts += [
            report.at_most(f"`{name}`, {what}", share, energy_balance.TOLERANCE)
            for what, share in zip(("unexplained", "losses below zero"), shares, strict=True)
        ]
    _figure(folder, books["central_difference"])
    return {"accounts": report.table(head, rows)}, verdicts


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
    report.save(figure, folder, "energy")
