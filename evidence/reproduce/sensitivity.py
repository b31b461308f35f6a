"""What the result depends on: the studies of `inputs/sensitivity.yaml` → a table."""

import numpy as np

from evidence.reproduce.rows import bracket, done, percentile, tuned_amplitudes
from hpcrub.config.text import flatten
from hpcrub.statistics.pairs import share_interval
from hpcrub.studies import open_result

HEAD = """\
A_nl of {samples} samples for n_d = 4 and σ = 2.3 %, over 32.5 to 36.5 Hz, when one unknown of the
model is another: the tuned peak (median of {runs} runs, with their range), two percentiles of A_nl
and the share of the samples with A_nl > A_lin, with intervals. The order of the blades against the
rotation is not here: a reversed random sample is as likely as the sample; for the pattern of
Table 2 it is in row 4. Other dampings, σ and n_d were not computed with other dimensions.

| changed | tuned peak | percentile 50 | percentile 99 | A_nl > A_lin [%] |
|---|---|---|---|---|
"""


def table(results):
    """Markdown of the table; a line that says so when there are no results."""
    paths = sorted((results.folder / "sensitivity").glob("*.h5"))
    if not paths:
        return "Not run.\n"
    files = [open_result(path) for path in paths]
    reference = next(f for f in files if "lean_deg=-43.74" in f.path.name)
    base = flatten(reference.config.model_dump(mode="json"))
    mistuning = reference.config.mistuning
    text = HEAD.format(samples=mistuning.samples, runs=mistuning.tuned_runs)
    for file in sorted(files, key=lambda f: f is not reference):
        text += f"| {' | '.join(_cells(file, base))} |\n"
        file.close()
    return text


def _cells(file, base):
    keys = flatten(file.config.model_dump(mode="json"))
    changed = [f"{k.rpartition('.')[2]} {base[k]} → {keys[k]}" for k in keys
               if keys[k] != base[k] and k != "output"]  # fmt: skip
    peak, *span = tuned_amplitudes(file)
    above = done(file, "amplification", 0) > done(file, "linear_amplification", 0)
    share = 100 * np.array(share_interval(np.count_nonzero(above), len(above)))
    return (
        ", ".join(changed) or "nothing",
        f"{peak:.1f} mm {bracket(span, 1)} at {float(file.read('tuned/peak_speed_hz')):.2f} Hz",
        *(f"{value:.2f} {bracket(ends, 2)}"
          for value, *ends in (percentile(file, 0, at) for at in (50, 99))),
        f"{100 * above.mean():.1f} {bracket(share, 1)}",
    )  # fmt: skip
