"""Tables and figures of docs/identification.md from a book of evaluations."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from evidence.identify import conclusions, disks, paper, search, stages
from evidence.page import replace, table
from evidence.validation.report import COLOURS, axes
from hpcrub.contact.status import STEADY
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sweep import run_sweep

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
    shown = dict(zip(("best", "best with variations"), search.leaders(book, trials), strict=False))
    before = [trial for trial in trials if trial.disk[:4] == disks.REFERENCE[:4]]
    shown |= dict(zip(("before",), before, strict=False))
    losses = {name: search.losses(book, trial.disk) for name, trial in shown.items()}
    good = search.as_good(trials, losses["best"]) if len(losses["best"]) > 1 else trials[:1]
    tested = {disk: conclusions.answers(found) for disk, found in book.of("conclusions").items()}
    parts = [
        _effort(book, shown, losses, good),
        "### The best disk, and the set\n",
        _dimensions(shown, good),
        _set_figure(trials, good, shown["best"], folder / "figures" / "identification_set.png"),
        _responses_figure(shown, folder / "figures" / "identification_responses.png"),
        "### The paper's numbers\n",
        _statements(book, shown),
    ]
    if tested:
        parts += [
            "### The paper's conclusions\n",
            _conclusions(tested, good, shown["best"].disk),
            _margins_figure(tested, folder / "figures" / "identification_conclusions.png"),
        ]
    page = folder / "identification.md"
    replace(page, results="\n" + "\n\n".join(part.rstrip() for part in parts) + "\n\n")
    return page


def _effort(book, shown, losses, good):
    counts = ", ".join(f"{stage} {len(book.of(stage))}" for stage in paper.STAGES)
    text = (
        f"Disks that each stage was computed of: {counts}. With all that is below the "
        f"evaluations took {book.spent / 3600:.1f} hours, on a core shared with other programs.\n\n"
    )
    for name, others in losses.items():
        text += f"The loss of the disk named *{name}* is {shown[name].loss:.1f}"
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


def _dimensions(shown, good):
    every = np.array([trial.disk for trial in good])
    rows = [
        [
            text,
            *(f"{getattr(trial.disk, name):.5g}" for trial in shown.values()),
            f"{every[:, i].min():.4g} to {every[:, i].max():.4g}",
        ]
        for i, (name, text) in enumerate(NAMES.items())
    ]
    return table(["dimension", *shown, "the set"], rows)


def _statements(book, shown):
    """Table of the paper's numbers beside those of some disks."""
    found, fresh = [], []
    for trial in shown.values():
        found.append(trial.found | book.of("predictions").get(trial.disk, {}))
        fresh.append(search.draws(book, trial.disk))
    rows = [
        [s.row, s.text, s.paper, "fitted" if s.fitted else "predicted", *cells]
        for s in paper.STATEMENTS
        if (cells := [_cell(s, *both) for both in zip(found, fresh, strict=True)])[0]
    ]
    return table(["row", "quantity", "paper", "", *shown], rows)


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
    """Table of the conclusions: how many disks agree, of the set and of either sense."""
    inside = {trial.disk for trial in good}
    groups = {
        "the set": [disk for disk in tested if disk in inside],
        "against the rotation": [disk for disk in tested if disk.lean_deg < 0],
        "with it": [disk for disk in tested if disk.lean_deg > 0],
    }
    heads = [f"{name}, {len(group)}" for name, group in groups.items()]
    rows = []
    for c in conclusions.CONCLUSIONS:
        counts = [
            _counts([tested[disk][c.name].verdict for disk in group]) for group in groups.values()
        ]
        margins = np.array([answers[c.name].margin for answers in tested.values()])
        own = tested[best][c.name].verdict if best in tested else ""
        spread = f"{np.median(margins):.3f} [{margins.min():.3f}, {margins.max():.3f}]"
        rows.append([c.text, *counts, own, spread])
    return table(["conclusion", *heads, "best disk", "margin: median [range]"], rows)


def _counts(verdicts):
    return ", ".join(f"{verdicts.count(v)} {v}" for v in ("holds", "open", "fails"))


def _set_figure(trials, good, best, path):
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
        panel.plot(getattr(best.disk, name), best.loss, "*", ms=13, color=COLOURS[1])
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


def _responses_figure(shown, path):
    """Responses of the best disk and of the one before, tuned and with the pattern of Table 2."""
    figure, grid = axes(2, 1, figsize=(12, 3.6), sharey=True)
    patterns = {"tuned": np.zeros_like(paper.PATTERN), "Table 2": paper.PATTERN}
    for panel, name in zip(grid.flat, ("before", "best"), strict=True):
        if name not in shown:
            continue
        disk, found = shown[name].disk, shown[name].found
        for colour, (text, pattern) in zip(("black", COLOURS[0]), patterns.items(), strict=True):
            ordered = pattern[::-1] if found.get("reversed") else pattern
            modes = mistuned_modes(disks.reduced(disk), ordered)
            response = run_sweep(modes, stages.scene_of(4), stages.PATTERN_SPEEDS)
            steady, mm = response.point_status == STEADY, 1e3 * response.amplitude
            hz, style = stages.PATTERN_SPEEDS, {"color": colour, "lw": 0.8, "ms": 4}
            panel.plot(hz, np.where(steady, mm, np.nan), "o", **style)
            panel.plot(hz, np.where(steady, np.nan, mm), "o", mfc="white", **style)
            panel.plot(hz, mm, label=text, **style)
        panel.set_title(f"{name}: lean {disk.lean_deg:.1f}°, bow {disk.bow:.3f}", fontsize=9)
        panel.set_xlabel("speed [Hz]")
        panel.legend(fontsize=8)
    grid.flat[0].set_ylabel("largest tip amplitude [mm]")
    figure.savefig(path)
    plt.close(figure)
    return (
        f"![responses of the disk before and of the best](figures/{path.name})\n\n"
        "Four bumps, tuned and with the pattern of Table 2 in the order that fits better. Open "
        "circles: motions that are not steady after 2 s."
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
