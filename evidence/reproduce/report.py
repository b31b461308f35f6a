"""Result files → docs/reproduction.md: every published number beside ours, and the figures."""

import shutil
from collections import Counter
from datetime import date

from matplotlib.figure import Figure

from evidence.reproduce import numbers, pattern, plan, rows, sensitivity
from hpcrub import __version__, plot
from hpcrub.config.sections import Time
from hpcrub.errors import InputError
from hpcrub.plot.pictures import draw
from hpcrub.plot.style import ORANGE
from hpcrub.results.layout import DONE

DEFAULT = Time()
KEY_NUMBERS = (  # of the first lines: one that was fitted, two that tell the disks apart
    "tuned peak, n_d = 4 [Hz]",
    "largest localisation [%]",
    "percentile 99 of A_nl, n_d = 4, σ = 2.3 %",
)
HEAD = """# Reproduction of the paper

{verdict}

{key_numbers}The paper does not print the dimensions of its disk; ours is the best of a
[search](identification.md). It has the frequencies, speeds of the peaks and linear amplifications
of the paper. It has neither its localisation nor its coexisting motions, nor responses that hardly
depend on step and modes. The paper's conclusion that the linear analysis is not on the safe side
holds on our disk with four bumps and fails with five; with six bumps both find the linear analysis
to be on the safe side.

This page puts every number that J. Joachim, F. Nyssen and A. Batailly, *Numerical Investigation of
a Mistuned Academic Bladed Disk Dynamics with Blade/Casing Contact* (2020), give for this model
beside ours. It is written by `make reproduce`.

- **Samples.** This is SCALE={scale:g} of {today} with hpcrub {version}: of every level at least
  {samples} are done, where the paper
  has 5000 for each number of bumps. At full scale nothing changes but these counts.
- **Time integration.** It is the default one, {scheme} with {step:g} s, but for figure 9a. The
  paper has central differences with 1e-6 s.
- **Reference.** A_nl is relative to the median of {runs} runs of the tuned disk, all but the first
  with slightly perturbed stiffness. The paper has one run.
- **Intervals** are 95 %: of percentiles by order statistics, of shares by Wilson, of means by the
  scatter of the samples. "–" is an end that so few samples do not bound. One disk whose motion is
  chaotic (rows 2, 4, 7, 8) is integrated {perturbed} times with stiffnesses that differ by up to
  10⁻⁸: its interval holds 95 % of these runs, any of which the paper's one run may be, and its
  number is their median.
- **Agreement.** "Yes" means that the paper's number lies in the interval or, where there is none,
  within 1 % (a speed: 0.1 Hz), rounding allowed for. "Near" means within 5 % (a speed: 1 %), "open"
  that there are too few samples to tell. Several numbers in a row are as good as the worst. A
  statement agrees or not; where that is no matter of plain order, the row says when.
- **Fitted rows.** The dimensions of the disk are not published. They were found by a search, and
  the rows marked *fitted* took part in it, so that their agreement proves nothing. The others are
  predictions.

"""


def write(folder, scale, target):
    """Write the report and copy its figures.

    Args:
        folder: where the result files are.
        scale: of the sample counts.
        target: Markdown file to write; figures go to a folder of its name beside it.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    results = rows.Results(folder)
    of_case = [
        f"{(results.contact(n).status == DONE).sum(axis=1).min()} samples for n_d = {n}"
        for n in plan.CASES
    ]
    found = numbers.rows(results)
    text = HEAD.format(
        verdict=verdict(found),
        key_numbers=table([row for row in found if row.quantity in KEY_NUMBERS], remarks=False),
        scale=scale, today=date.today().isoformat(), version=__version__,
        samples=", ".join(of_case),
        scheme=DEFAULT.scheme, step=DEFAULT.step_s, runs=plan.RUNS,
        perturbed=plan.PERTURBED["mistuning.samples"],
    )  # fmt: skip
    text += table(found)
    text += "\n## What it depends on\n\n" + sensitivity.table(results)
    text += "\n## Figures\n\n" + figures(folder, target)
    target.write_text(text, encoding="utf-8")


def verdict(rows):
    """The whole page in a sentence."""
    judged = [row for row in rows if row.agrees]
    new = [row.agrees for row in judged if not row.fitted]
    counts = Counter(row.agrees for row in judged)
    missing = f", {counts['not run']} were not computed" if counts["not run"] else ""
    return (
        f"**Of {len(judged)} numbers and statements of the paper "
        f"{counts['yes'] + counts['near']} agree with ours or are near, {counts['no']} do not, "
        f"{counts['open']} are open{missing}; of the {len(new)} that took no part in the search "
        f"for the dimensions of the disk the number of those that agree is "
        f"{new.count('yes') + new.count('near')}.**"
    )


def table(rows, remarks=True):
    """Markdown table of the rows, the remarks on those that disagree below it."""
    lines = ["| # | quantity | paper | ours | interval | agrees |", "|---|---|---|---|---|---|"]
    said = []
    for row in rows:
        mark = " *fitted*" if row.fitted else ""
        note = ""
        if remarks and row.remark and row.agrees != "yes":
            if row.remark not in said:
                said.append(row.remark)
            note = f" ({said.index(row.remark) + 1})"
        lines.append(
            f"| {row.number} | {row.quantity}{mark} | {row.paper} | {row.ours} | {row.interval} | "
            f"{row.agrees}{note} |"
        )
    lines += ["", *(f"{i}. {remark}" for i, remark in enumerate(said, 1))]
    return "\n".join(lines) + "\n"


FIGURES = (
    ("1", "modal_disk", "the disk", ("modal.h5",), "disk"),
    ("2", "safe", "SAFE diagram, full and reduced model", ("modal.h5",), "safe_diagram"),
    ("3", "casing", "casing", ("modal.h5",), "casing"),
    ("4", "linear", "linear amplification", ("linear.h5",), "linear"),
    ("5", "time_response", "one simulation in full", ("time_response.h5",), "time_response"),
    ("6", "interaction_map", "interaction maps", ("interaction_map.h5",), "interaction_map"),
    (
        "7",
        "table2",
        "tuned disk and the pattern of Table 2; stars: printed",
        ("table2.h5",),
        "summary",
    ),
    ("8", "casing_parameters", "other casings", ("casing_parameters/*.h5",), "compare"),
    ("9a", "time_step", "other time steps", ("time_step/*.h5",), "compare"),
    ("9b", "reduction", "other reduced models", ("reduction/*.h5",), "compare"),
    ("10", "running", "running means of the percentiles", ("contact/*.h5",), "running_means"),
    ("11", "errors", "convergence errors", ("contact/*.h5",), "convergence_errors"),
    ("12", "percentiles", "amplifications", ("contact/*.h5",), "percentiles"),
    ("13", "amplitudes", "largest amplitudes", ("contact/*.h5",), "amplitudes"),
    ("14", "energies", "amplification by energy", ("energy_4.h5", "energy_6.h5"), "energy"),
    ("15", "cross", "contact beside linear amplification", (plan.FILE_4,), "contact_over_linear"),
    ("16", "damping", "damping", (plan.FILE_4, "contact_low.h5"), "damping"),
    ("17", "branches", "several initial states", ("branches.h5",), "branches"),
)


def figures(folder, target):
    """Draw every figure of the paper; returns the Markdown that shows them."""
    pictures = target.with_suffix("")
    pictures.mkdir(parents=True, exist_ok=True)
    parts = []
    for number, name, title, patterns, figure in FIGURES:
        paths = [path for pattern in patterns for path in sorted(folder.glob(pattern))]
        if not paths:
            continue
        picture = pictures / f"figure_{number}_{name}.png"
        if number == "7":
            draw_table_2(paths[0], picture)
        else:
            try:
                (drawn,) = draw(plot.find(figure), paths, pictures)
            except InputError as error:  # too few samples as yet
                parts.append(f"Figure {number}: {title}: {error}\n")
                continue
            shutil.move(drawn, picture)
        parts.append(f"Figure {number}: {title}\n\n![{title}]({pictures.name}/{picture.name})\n")
    return "\n".join(parts)


def draw_table_2(path, picture):
    """Figure 7, with the points that the paper prints."""
    figure = Figure(layout="constrained")
    mark_points(*plot.summary(path, figure))
    figure.savefig(picture, dpi=150, bbox_inches="tight")


def mark_points(left, right):
    """Stars at the printed amplitudes, and at the localisations."""
    for panel, column in ((left, 1), (right, 2)):
        for point in pattern.POINTS:
            panel.plot(point[0], point[column], "*", color=ORANGE, ms=13, mec="w", zorder=5)
