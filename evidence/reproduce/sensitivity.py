"""What the result depends on: the studies of `inputs/sensitivity.yaml` → a table."""

from evidence import page
from evidence.reproduce.rows import above_linear, bracket, percentile, tuned_amplitudes
from hpcrub.config.text import flatten
from hpcrub.studies import open_result

HEADS = ["changed", "tuned peak", "percentile 50", "percentile 99", "A_nl > A_lin [%]"]


def table(results):
    """Markdown of the table; a line that says so when there are no results."""
    paths = sorted((results.folder / "sensitivity").glob("*.h5"))
    if not paths:
        return "Not run.\n"
    files = [open_result(path) for path in paths]
    reference = next(f for f in files if "lean_deg=-43.74" in f.path.name)
    base = flatten(reference.config.model_dump(mode="json"))
    mistuning = reference.config.mistuning
    rows = [_cells(file, base) for file in sorted(files, key=lambda f: f is not reference)]
    for file in files:
        file.close()
    said = f"{mistuning.samples} samples, and {mistuning.tuned_runs} runs of the tuned disk:"
    return f"{said}\n\n{page.table(HEADS, rows)}"


def _cells(file, base):
    keys = flatten(file.config.model_dump(mode="json"))
    changed = [f"{k.rpartition('.')[2]} {base[k]} → {keys[k]}" for k in keys
               if keys[k] != base[k] and k != "output"]  # fmt: skip
    peak, *span = tuned_amplitudes(file)
    share, *ends = above_linear(file, 0)
    return (
        ", ".join(changed) or "nothing",
        f"{peak:.1f} mm {bracket(span, 1)} at {float(file.read('tuned/peak_speed_hz')):.2f} Hz",
        *(f"{value:.2f} {bracket(ends, 2)}"
          for value, *ends in (percentile(file, 0, at) for at in (50, 99))),
        f"{share:.1f} {bracket(ends, 1)}",
    )  # fmt: skip
