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
    "ring_width": "ring's width over blades' [-]",
    "spoke_width": "spokes' width over blades' [-]",
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
    leaders = search.leaders(trials)
    losses = [search.losses(book, leader.disk) for leader in leaders]
    good = search.as_good(trials, losses[0]) if len(losses[0]) > 1 else trials[:1]
    tested = {disk: conclusions.answers(found) for disk, found in book.of("conclusions").items()}
    parts = [
        _effort(book, leaders, losses, good),
        "### The best disk, and the set\n",
        _dimensions(leaders, good),
        _set_figure(trials, good, folder / "figures" / "identification_set.png"),
        "### The paper's numbers\n",
        _statements(book, leaders),
    ]
    if tested:
        parts += [
            "### The paper's conclusions\n",
            _conclusions(tested, good, leaders[0].disk),
            _margins_figure(tested, folder / "figures" / "identification_conclusions.png"),
        ]
    page = folder / "identification.md"
    replace(page, results="\n" + "\n\n".join(part.rstrip() for part in parts) + "\n\n")
    return page


def _effort(book, leaders, losses, good):
    counts = ", ".join(f"{stage} {len(book.of(stage))}" for stage in paper.STAGES)
    text = (
        f"Disks that each stage was computed of: {counts}. With all that is below the "
        f"evaluations took {book.spent / 3600:.1f} hours, on a core shared with other programs.\n\n"
    )
    for name, leader, others in zip(_names(leaders), leaders, losses, strict=True):
        text += f"The loss of the {name} disk is {leader.loss:.1f}"
        if len(others) > 1:
            text += (
                f"; in {len(others)} other draws of samples and perturbed runs it is "
                f"{others.mean():.1f} ± {others.std(ddof=1):.1f} (mean and standard deviation)"
            )
        text += ". "
    n_plain = sum(trial.disk.is_plain for trial in good)
    return text + (
        f"{len(good)} disks lie within two standard deviations of the best one's mean, {n_plain} "
        "of them without variations: the set of those that fit as well."
    )


def _names(leaders):
    """What the leaders are called in tables."""
    return ("best", "best without variations")[: len(leaders)]


def _dimensions(leaders, good):
    every = np.array([trial.disk for trial in good])
    shown = [disks.EARLIER[0], *(leader.disk for leader in leaders)]
    rows = [
        [
            text,
            *(f"{getattr(disk, name):.5g}" for disk in shown),
            f"{every[:, i].min():.4g} to {every[:, i].max():.4g}",
        ]
        for i, (name, text) in enumerate(NAMES.items())
    ]
    return table(["dimension", "reference of hpcrub 0.1", *_names(leaders), "the set"], rows)


def _statements(book, leaders):
    """Table of the paper's numbers beside those of the leaders."""
    found, fresh = [], []
    for leader in leaders:
        found.append(leader.found | book.of("predictions").get(leader.disk, {}))
        fresh.append(search.draws(book, leader.disk))
    rows = [
        [s.row, s.text, s.paper, "fitted" if s.fitted else "predicted", *cells]
        for s in paper.STATEMENTS
        if (cells := [_cell(s, *both) for both in zip(found, fresh, strict=True)])[0]
    ]
    return table(["row", "quantity", "paper", "", *_names(leaders)], rows)


def _cell(statement, found, fresh):
    """Ours, the mean of the other draws with its standard deviation if there are any, verdict."""
    values = [numbers[statement.name] for numbers in fresh if statement.name in numbers]
    if len(values) > 1:
        mean = np.mean(values)
        spread = round(np.std(values, ddof=1), 6)
        return f"{mean:.4g} ± {spread:.2g}: {statement.verdict(mean)}"
    if statement.name not in found:
        return ""
    value = found[statement.name]
    return f"{value:.4g}: {statement.verdict(value)}"


def _conclusions(tested, good, best):
    """Table of the conclusions: how many disks agree, of the set and of all that were tested."""
    inside = {trial.disk for trial in good}
    groups = [list(tested)]
    if not set(tested) <= inside:
        groups.insert(0, [disk for disk in tested if disk in inside])
    heads = [
        f"{name} {len(group)}"
        for name, group in zip(("of the set,", "of all,"), groups, strict=False)
    ]
    rows = []
    for c in conclusions.CONCLUSIONS:
        counts = [_counts([tested[disk][c.name].verdict for disk in group]) for group in groups]
        margins = np.array([answers[c.name].margin for answers in tested.values()])
        own = tested[best][c.name].verdict if best in tested else ""
        spread = f"{np.median(margins):.3f} [{margins.min():.3f}, {margins.max():.3f}]"
        rows.append([c.text, *counts, own, spread])
    return table(["conclusion", *heads, "best disk", "margin: median [range]"], rows)


def _counts(verdicts):
    return ", ".join(f"{verdicts.count(v)} {v}" for v in ("holds", "open", "fails"))


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
        panel.set_title(c.text, fontsize=8)
        panel.set_xticks([])
    for panel in grid[:, 0]:
        panel.set_ylabel("margin")
    for panel in grid[1]:
        panel.set_xlabel("disks, by margin")
    figure.savefig(path)
    plt.close(figure)
    return (
        f"![margins of the conclusions](figures/{path.name})\n\n"
        "Margin of every conclusion on every disk, with 95 % intervals: above zero it holds. "
        "Green: the interval lies above zero; orange: below; grey: so few samples do not tell."
    )
