"""Result files → docs/reproduction.md: every published number beside ours, and the figures."""

from collections import Counter
from datetime import date

from matplotlib.figure import Figure

from evidence import page
from evidence.pictures import keep, save
from evidence.reproduce import numbers, pattern, plan, rows
from hpcrub import __version__, plot
from hpcrub.config.text import flatten
from hpcrub.errors import InputError
from hpcrub.plot.pictures import draw
from hpcrub.plot.style import ORANGE
from hpcrub.results.layout import DONE

KEY_NUMBERS = (  # of the first lines: one that was fitted, two that tell the disks apart
    "tuned peak, n_d = 4 [Hz]",
    "largest localisation [%]",
    "percentile 99 of A_nl, n_d = 4, σ = 2.3 %",
)


def write(folder, scale, target):
    """Write the parts of the page and its figures, of the result files in a folder.

    scale: of the sample counts; target: the page; figures go to a folder of its name beside it.
    """
    results = rows.Results(folder)
    of_case = [
        f"{(results.contact(n).status == DONE).sum(axis=1).min()} for n_d = {n}" for n in plan.CASES
    ]
    found = numbers.rows(results)
    page.replace(page.ROOT / "README.md", verdict=verdict(found))
    page.replace(
        target,
        verdict=verdict(found),
        key_numbers=table([row for row in found if row.quantity in KEY_NUMBERS], remarks=False),
        samples=f"This is SCALE={scale:g} of {date.today().isoformat()} with hpcrub {__version__}; "
        f"finished samples of every level, at least: {', '.join(of_case)}.",
        rows=table(found),
        sensitivity=sensitivity(results),
        figures=figures(folder, target),
    )


def verdict(rows):
    """The whole page in a sentence."""
    judged = [row for row in rows if row.agrees]
    new = [row.agrees for row in judged if not row.fitted]
    counts = Counter(row.agrees for row in judged)
    return (
        f"**Of {len(judged)} numbers and statements of the paper "
        f"{counts['yes'] + counts['near']} agree with ours or are near, {counts['no']} do not, "
        f"{counts['open']} are open; of the {len(new)} that took no part in the search "
        f"for the dimensions of the disk the number of those that agree is "
        f"{new.count('yes') + new.count('near')}.**"
    )


def table(rows, remarks=True):
    """Markdown table of the rows, the remarks on those that disagree below it."""
    lines, said = [], []
    for row in rows:
        note = ""
        if remarks and row.remark and row.agrees != "yes":
            if row.remark not in said:
                said.append(row.remark)
            note = f" ({said.index(row.remark) + 1})"
        quantity = row.quantity + " *fitted*" * row.fitted
        lines.append([row.number, quantity, row.paper, row.ours, row.interval, row.agrees + note])
    heads = ["#", "quantity", "paper", "ours", "interval", "agrees"]
    notes = [f"{i}. {remark}\n" for i, remark in enumerate(said, 1)]
    return "\n".join([page.table(heads, lines), "".join(notes)])


DEPENDS = ["changed", "tuned peak", "percentile 50", "percentile 99", "A_nl > A_lin [%]"]


def sensitivity(results):
    """What the result depends on: the studies of `inputs/sensitivity.yaml`."""
    files = results.files("sensitivity/*.h5")
    reference = next(f for f in files if "lean_deg=-43.74" in f.path.name)
    base = flatten(reference.config.model_dump(mode="json"))
    mistuning = reference.config.mistuning
    lines = [_changed(file, base) for file in sorted(files, key=lambda f: f is not reference)]
    said = f"{mistuning.samples} samples, and {mistuning.tuned_runs} runs of the tuned disk:"
    return f"{said}\n\n{page.table(DEPENDS, lines)}"


def _changed(file, base):
    keys = flatten(file.config.model_dump(mode="json"))
    changed = [f"{k.rpartition('.')[2]} {base[k]} → {keys[k]}" for k in keys
               if keys[k] != base[k] and k != "output"]  # fmt: skip
    peak, *span = rows.tuned_amplitudes(file)
    share, *ends = rows.above_linear(file, 0)
    speed = float(file.read("tuned/peak_speed_hz"))
    return (
        ", ".join(changed) or "nothing",
        f"{peak:.1f} mm {rows.bracket(span, 1)} at {speed:.2f} Hz",
        *(f"{value:.2f} {rows.bracket(ends, 2)}"
          for value, *ends in (rows.percentile(file, 0, at) for at in (50, 99))),
        f"{share:.1f} {rows.bracket(ends, 1)}",
    )  # fmt: skip


FIGURES = (
    ("1", "modal_disk", "the disk", ("modal.h5",), "disk"),
    ("2", "safe", "SAFE diagram, full and reduced model", ("modal.h5",), "safe_diagram"),
    ("3", "casing", "casing", ("modal.h5",), "casing"),
    ("4", "linear", "linear amplification", ("linear.h5",), "linear"),
    ("5", "time_response", "one simulation in full", ("time_response.h5",), "time_response"),
    ("6", "interaction_map", "interaction maps", ("interaction_map.h5",), "interaction_map"),
    ("7", "table2", "tuned disk and the pattern of Table 2; stars: printed", ("table2.h5",),
     "summary"),
    ("8", "casing_parameters", "other casings", ("casing_parameters/*.h5",), "compare"),
    ("9a", "time_step", "other time steps", ("time_step/*.h5",), "compare"),
    ("9b", "reduction", "other reduced models", ("reduction/*.h5",), "compare"),
    ("10", "running", "running means of the percentiles", ("contact/*.h5",), "running_means"),
    ("11", "errors", "convergence errors", ("contact/*.h5",), "convergence_errors"),
    ("12", "percentiles", "amplifications", ("contact/*.h5",), "percentiles"),
    ("13", "amplitudes", "largest amplitudes", ("contact/*.h5",), "amplitudes"),
    ("14", "energies", "amplification by energy", ("energy_4.h5", "energy_6.h5"), "energy"),
    ("15", "cross", "contact beside linear amplification", (plan.FILE_4,), "contact_over_linear"),
    ("16", "damping", "damping", (plan.FILE_4, "contact_low.h5"), "percentiles"),
    ("17", "branches", "several initial states", ("branches.h5",), "branches"),
)  # fmt: skip


def figures(folder, target):
    """Draw every figure of the paper; returns the Markdown that shows them."""
    pictures = target.with_suffix("")
    pictures.mkdir(parents=True, exist_ok=True)
    parts = []
    for number, name, title, patterns, figure in FIGURES:
        paths = [path for pattern in patterns for path in sorted(folder.glob(pattern))]
        picture = pictures / f"figure_{number}_{name}.png"
        if number == "7":
            drawing = Figure(layout="constrained")
            panels = plot.summary(paths[0], drawing)
            # stars at the amplitudes that the paper prints, and at the localisations
            for panel, column in zip(panels, (1, 2), strict=True):
                for point in pattern.POINTS:
                    panel.plot(point[0], point[column], "*", color=ORANGE, ms=13, mec="w", zorder=5)
            save(drawing, picture, dpi=150, bbox_inches="tight")
        else:
            try:
                (drawn,) = draw(getattr(plot, figure), paths, pictures)
            except InputError as error:  # too few samples as yet
                parts.append(f"Figure {number}: {title}: {error}\n")
                continue
            keep(drawn, picture)
            drawn.unlink()
        parts.append(f"Figure {number}: {title}\n\n![{title}]({pictures.name}/{picture.name})\n")
    return "\n".join(parts)
