"""Tables and figures of docs/identification.md from a book of evaluations."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from evidence.identify import conclusions, disks, paper, search
from evidence.page import replace, table
from evidence.validation.report import COLOURS, axes

NAMES = {
    "lean_deg": "lean [°]",
    "bow": "bow [-]",
    "inner_radius_mm": "inner radius [mm]",
    "ring_thickness_mm": "ring thickness [mm]",
    "spoke_thickness_mm": "spoke thickness [mm]",
    "blade_thickness_mm": "blade thickness [mm]",
    "skew": "skew of the bow [-]",
    "ring_inset_mm": "ring inside the hub circle [mm]",
    "ring_width": "width of the ring over the blades' [-]",
    "spoke_width": "width of the spokes over the blades' [-]",
}


def write(book, folder):
    """Write the figures and the results of the page; returns the page's path.

    Parameters
    ----------
    book : Book
        At least one disk was carried through all stages.
    folder : Path
        Of the documentation.
    """
    trials = search.finished(book)
    best, numbers = trials[0], search.draws(book, trials[0].disk)
    losses = np.array([paper.loss(found) for found in numbers])
    good = search.as_good(trials, losses) if len(losses) > 1 else trials[:1]
    tested = {disk: conclusions.answers(found) for disk, found in book.of("conclusions").items()}
    parts = [
        _effort(book, trials, losses, good),
        "### The best disk, and the set\n",
        _dimensions(best, good),
        _set_figure(trials, good, folder / "figures" / "identification_set.png"),
        "### The paper's numbers\n",
        _statements(best, numbers, book.of("predictions").get(best.disk, {})),
    ]
    if tested:
        parts += [
            "### The paper's conclusions\n",
            _conclusions(tested, best.disk),
            _margins_figure(tested, folder / "figures" / "identification_conclusions.png"),
        ]
    page = folder / "identification.md"
    replace(page, results="\n" + "\n\n".join(part.rstrip() for part in parts) + "\n\n")
    return page


def _effort(book, trials, losses, good):
    counts = ", ".join(f"{stage} {len(book.of(stage))}" for stage in paper.STAGES)
    text = (
        f"Disks that each stage was computed of: {counts}. That took {book.spent / 3600:.1f} core "
        f"hours with all that is below. The lowest loss is {trials[0].loss:.1f}"
    )
    if len(losses) > 1:
        text += (
            f"; the same disk in {len(losses)} other draws of samples and perturbed runs has "
            f"{losses.mean():.1f} ± {losses.std(ddof=1):.1f} (mean and standard deviation). "
            f"{len(good)} disks lie within two standard deviations of that mean: the set of those "
            "that fit as well"
        )
    return text + "."


def _dimensions(best, good):
    fields = disks.Dimensions._fields
    every = np.array([trial.disk for trial in good])
    earlier = disks.EARLIER[0]
    rows = [
        [
            NAMES[name],
            f"{getattr(earlier, name):.4g}",
            f"{getattr(best.disk, name):.5g}",
            f"{every[:, i].min():.4g} to {every[:, i].max():.4g}",
        ]
        for i, name in enumerate(fields)
    ]
    return table(["dimension", "reference of hpcrub 0.1", "best", "the set"], rows)


def _statements(best, numbers, predicted):
    """Table of the paper's numbers beside the best disk's, fitted ones first."""
    rows = []
    for s in paper.STATEMENTS:
        fresh = [found[s.name] for found in numbers if s.name in found]
        value = (best.found | predicted).get(s.name)
        if value is None:
            continue
        scatter = f"{np.mean(fresh):.4g} ± {np.std(fresh, ddof=1):.2g}" if len(fresh) > 1 else ""
        judged = np.mean(fresh) if len(fresh) > 1 else value
        how = "fitted" if s.fitted else "predicted"
        rows.append([s.row, s.text, s.paper, how, f"{value:.4g}", scatter, s.verdict(judged)])
    head = ["row", "quantity", "paper", "", "best disk", "in other draws", "agrees"]
    return table(head, rows)


def _conclusions(tested, best):
    rows = []
    for c in conclusions.CONCLUSIONS:
        found = [answers[c.name] for answers in tested.values()]
        count = {v: sum(a.verdict == v for a in found) for v in ("holds", "open", "fails")}
        margins = np.array([a.margin for a in found])
        own = tested[best].verdict if best in tested else ""
        spread = f"{np.median(margins):.3f} [{margins.min():.3f}, {margins.max():.3f}]"
        rows.append([c.text, *map(str, count.values()), own, spread])
    head = ["conclusion", "holds", "open", "fails", "best disk", "margin: median [range]"]
    return table(head, rows)


def _set_figure(trials, good, path):
    """Loss over every dimension; the set in colour."""
    names = [*disks.BOUNDS, "spoke_thickness_mm", "blade_thickness_mm", *disks.VARIATIONS]
    figure, grid = axes(5, 2, figsize=(12, 5.2), sharey=True)
    chosen = {trial.disk for trial in good}
    inside = np.array([trial.disk in chosen for trial in trials])
    losses = np.array([trial.loss for trial in trials])
    for panel, name in zip(grid.flat, names, strict=True):
        x = np.array([getattr(trial.disk, name) for trial in trials])
        panel.plot(x[~inside], losses[~inside], ".", color="0.65")
        panel.plot(x[inside], losses[inside], "o", ms=4, color=COLOURS[0])
        panel.plot(x[0], losses[0], "*", ms=13, color=COLOURS[1])
        panel.set_xlabel(NAMES[name], fontsize=9)
    for panel in grid[:, 0]:
        panel.set_ylabel("loss")
    figure.savefig(path)
    plt.close(figure)
    return (
        f"![loss over the dimensions](figures/{path.name})\n\n"
        "Loss of all disks that were carried through every stage, over each dimension. Blue: the "
        "set; star: the best."
    )


def _margins_figure(tested, path):
    """Margin of every disk for every conclusion, with its interval."""
    figure, grid = axes(3, 2, figsize=(12, 6))
    for panel, c in zip(grid.flat, conclusions.CONCLUSIONS, strict=True):
        found = sorted((answers[c.name] for answers in tested.values()), key=lambda a: a.margin)
        for place, a in enumerate(found):
            colour = {"holds": COLOURS[2], "open": "0.55", "fails": COLOURS[1]}[a.verdict]
            panel.plot([place, place], [a.low, a.high], color=colour)
            panel.plot(place, a.margin, "o", ms=4, color=colour)
        panel.axhline(0, color="black", lw=0.8)
        panel.set_title(c.text, fontsize=9)
        panel.set_xticks([])
    for panel in grid[:, 0]:
        panel.set_ylabel("margin")
    for panel in grid[1]:
        panel.set_xlabel("disks of the set, by margin")
    figure.savefig(path)
    plt.close(figure)
    return (
        f"![margins of the conclusions](figures/{path.name})\n\n"
        "Margin of every conclusion on every disk, with 95 % intervals: above zero it holds. "
        "Green: the interval lies above zero; orange: below; grey: so few samples do not tell."
    )
