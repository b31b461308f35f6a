"""The paper's numbers, one function each: result files → ours, with an interval, and agreement."""

import numpy as np

from hpcrub import cli
from hpcrub.config import Config
from hpcrub.config_text import flatten
from hpcrub.layout import DONE, STEADY
from hpcrub.statistics import MIN_VALUES, Z_95, percentile_interval
from hpcrub.storage import ResultFile
from hpcrub.studies import branches
from hpcrub.study import build_problem
from reproduce.rows import MissingError, Row, claim_row, done, percentile, value_row

CHAOS = (
    "The motion at this speed is not periodic: rounding alone moves amplitudes by several per "
    "cent, so a single disk can agree only so far; see the lower panel of figure 17."
)
LOCALISED = (
    "More than rounding explains. How far a motion spreads from blade to blade depends on how the "
    "disk couples them, and the disk's sections are among what the paper does not give."
)
UNKNOWN = (
    "A prediction of the fitted geometry. The dimensions of the disk are not published; the table "
    'under "What it depends on" shows how far such numbers move with them.'
)


ENOUGH = 1000  # samples that tell which of two percentiles 99 is larger


def rows(results):
    """All rows whose results are there."""
    found = []
    for make in (
        family, peaks, ranges, table2, coexistence, steady_time, time_step, reduction,
        amplification, linear, medians, shares, below, amplitudes, samples_needed, cost,
    ):  # fmt: skip
        try:
            found += make(results)
        except MissingError as missing:
            found.append(Row("", f"{make.__doc__.rstrip('.')}: {missing}", "", "", "", "not run"))
    return found


def family(results):
    """1: frequencies of the first family."""
    first = results.file("modal.h5").read("full/frequencies_hz")[:12]
    return [
        value_row("1", "lowest frequency of family 1B [Hz]", 90.1, first.min(), digits=1,
                  fitted=True),
        value_row("1", "highest frequency of family 1B [Hz]", 93.2, first.max(), digits=1,
                  fitted=True),
    ]  # fmt: skip


def peaks(results):
    """2: tuned peaks for four bumps."""
    ours = float(results.contact(4).read("tuned/peak_speed_hz"))
    found = [value_row("2", "tuned peak, n_d = 4 [Hz]", 34.45, ours, fitted=True, remark=CHAOS)]
    chart = results.file("interaction_map.h5")
    speeds, amplitude = chart.read("speeds_hz"), chart.read("amplitude_m", 0)
    upper = speeds > 60
    second = speeds[upper][np.nanargmax(amplitude[upper])]
    remark = "The interaction is broad; its largest amplitude is not its centre. " + UNKNOWN
    found.append(value_row("2", "second tuned interaction, n_d = 4 [Hz]", 69, second, digits=0,
                           fitted=True, remark=remark))  # fmt: skip
    return found


def ranges(results):
    """3: speed ranges that hold the peaks of the samples."""
    found = []
    for n_d, text in ((3, "44.5–47.5"), (4, "33.5–35.5"), (5, "26.7–28.2"), (6, "22–23")):
        file = results.contact(n_d)
        speeds = file.read("speeds_hz")
        peak = np.concatenate(
            [done(file, "peak_speed_hz", v) for v in range(len(file.read("sigma")))]
        )
        at_edge = np.mean((peak <= speeds[0]) | (peak >= speeds[-1]))
        low, high = np.percentile(peak, [1, 99])
        found.append(
            claim_row(
                "3", f"speeds of the samples' peaks, n_d = {n_d} [Hz]", text,
                f"98 % in {low:.2f}–{high:.2f}, {100 * at_edge:.1f} % at an edge", at_edge < 0.01,
                fitted=True, remark="The tuned peak of every n_d was fitted; how far the samples "
                "spread around it was not.",
            )
        )  # fmt: skip
    return found


def table2(results):
    """4: the pattern of Table 2."""
    file = results.file("table2.h5")
    speeds = file.read("speeds_hz")
    amplitude, local = (file.read(f"samples/{n}", (0, 0)) for n in ("amplitude_m", "localisation"))
    best, most = np.nanargmax(amplitude), np.nanargmax(local)
    more, local_more = {"remark": CHAOS}, {"remark": LOCALISED}
    mm, share = 1e3 * amplitude, 100 * local
    return [
        value_row("4", "pattern of Table 2, n_d = 4: largest amplitude [mm]", 58.1, mm[best],
                  digits=1, fitted=True, **more),
        value_row("4", "its speed [Hz]", 34.78, speeds[best], **more),
        value_row("4", "localisation there [%]", 49.0, share[best], digits=1, **local_more),
        value_row("4", "largest localisation [%]", 67.9, share[most], digits=1, **local_more),
        value_row("4", "its speed [Hz]", 33.66, speeds[most], **more),
        value_row("4", "amplitude there [mm]", 38.9, mm[most], digits=1, **local_more),
        value_row("4", "smallest localisation over the speeds [%]", 17, np.nanmin(share),
                  digits=0, **local_more),
    ]  # fmt: skip


def coexistence(results):
    """5: coexisting stable motions of the pattern."""
    file = results.file("branches.h5")
    found, speeds = branches.label_file(file), file.read("speeds_hz")
    local = 100 * file.read("mean_localisation")
    several = branches.coexisting(found) > 1
    zone = (speeds > 34.175) & (speeds < 34.295)
    at = f"{speeds[several].min():.3f}–{speeds[several].max():.3f}" if several.any() else "none"
    rows = [
        claim_row(
            "5", "speeds with several stable branches [Hz]", "34.18–34.29",
            f"{several.sum()} of {len(speeds)} speeds, within {at}",
            several[zone].mean() > 0.9 and several[~zone].mean() < 0.1,
            remark="Single windows of three revolutions differ from start to start at most speeds; "
            "means over twelve windows differ by more than chance only at those given (figure 17).",
        )
    ]  # fmt: skip
    inside = local[:, zone][found[:, zone] >= 0]
    if inside.size:
        for name, paper, ours in (
            ("highest", 25.9, np.percentile(inside, 90)),
            ("lowest", 17.4, np.percentile(inside, 10)),
        ):  # fmt: skip
            rows.append(value_row("5", f"localisation of the {name} branch there (our percentile "
                                  f"{90 if name == 'highest' else 10} of all starts) [%]", paper,
                                  ours, digits=1, remark=LOCALISED))  # fmt: skip
    return rows


def steady_time(results):
    """6: mean simulated time."""
    files = [results.contact(n_d) for n_d in (3, 4, 5, 6)]
    times = [file.read("samples/time_s")[file.status() == DONE].mean(axis=1) for file in files]
    means = np.concatenate(times)
    half = Z_95 * means.std(ddof=1) / np.sqrt(len(means))
    limit = files[0].config.steady_state.max_time_s
    remark = (
        f"Ours counts points that were not steady at {limit:g} s with that time; where the paper "
        "ends them is not said."
    )
    return [value_row("6", "mean simulated time to the steady state [s]", 0.96, means.mean(),
                      means.mean() - half, means.mean() + half, remark=remark)]  # fmt: skip


def _differences(results, folder, key):
    """Median difference [%] of each response of a sweep to that with the finest value of a key."""
    files = [ResultFile.open(path) for path in sorted((results.folder / folder).glob("*.h5"))]
    if not files:
        raise MissingError(f"no {folder}/*.h5")
    values = [flatten(f.config.model_dump(mode="json"))[key] for f in files]
    curves = np.array([f.read("samples/amplitude_m", (0, 0)) for f in files])
    for file in files:
        file.close()
    order = np.argsort(values)
    values, curves = np.array(values)[order], curves[order]
    finest = curves[0] if key == "time.step_s" else curves[-1]
    return values, 100 * np.nanmedian(np.abs(curves - finest), axis=1) / np.nanmax(finest)


SCATTER = (
    "Single points of the response differ by this much after any small change, because most "
    "motions here are not periodic; the difference does not shrink with refinement."
)


def time_step(results):
    """7: convergence with the time step."""
    values, difference = _differences(results, "time_step", "time.step_s")
    text = ", ".join(f"{h:.0e}: {d:.1f} %" for h, d in zip(values[1:], difference[1:], strict=True))
    return [
        claim_row(
            "7", "median difference of the pattern's response to that at h = 1e-6 s",
            "none seen for h ≤ 5e-5 s", text, difference.max() < 2,
            remark=SCATTER + " Central differences are unstable above 3.55e-5 s with η = 60.",
        )
    ]  # fmt: skip


def reduction(results):
    """8: convergence with the number of modes."""
    values, difference = _differences(results, "reduction", "reduction.n_modes")
    text = ", ".join(f"η = {n}: {d:.1f} %" for n, d in zip(values, difference, strict=True) if d)
    return [
        claim_row("8", f"median difference of the pattern's response to that with η = {values[-1]}",
                  "none seen for η > 36", text, difference[values > 36].max() < 2, remark=SCATTER)
    ]  # fmt: skip


def amplification(results):
    """9: percentile 99 of the contact amplification, two dampings."""
    rows = []
    for name, file, paper in (
        ("", results.contact(4), 1.75), (", ξ = 4·10⁻³", results.file("contact_low.h5"), 1.84),
    ):  # fmt: skip
        rows.append(value_row("9", f"percentile 99 of A_nl, n_d = 4, σ = 2.3 %{name}", paper,
                              *percentile(file, -1, 99), remark=UNKNOWN))  # fmt: skip
    return rows


def linear(results):
    """10: linear amplification."""
    file = results.file("linear.h5")
    n_d = list(file.read("n_diameters"))
    values = file.read("amplification")
    four = [np.percentile(level[n_d.index(4)], 99) for level in values]
    level = int(np.argmax(four))
    low, high = np.ravel(percentile_interval(values[level, n_d.index(4)], [99], Z_95))
    last = {n: np.percentile(values[-1, i], 99) for i, n in enumerate(n_d)}
    order = sorted(last, key=last.get)
    smallest, largest = order[0], order[-1]
    few = values.shape[-1] < ENOUGH
    remark = "n_d = 3 and 4 are close to each other; with few samples either can be the smallest."
    rows = [
        value_row("10", "largest percentile 99 of A_lin over σ, n_d = 4", 1.57, max(four), low,
                  high, fitted=True),
        claim_row("10", "n_d with the largest A_lin (percentile 99, σ = 2.3 %)", "6", str(largest),
                  largest == 6, fitted=True),
        claim_row("10", "n_d with the smallest", "3", str(smallest), smallest == 3, fitted=True,
                  remark=remark),
    ]  # fmt: skip
    return [r._replace(agrees="open") if few and r.agrees == "no" else r for r in rows]


def medians(results):
    """11: median of A_nl beside percentile 99 of A_lin."""
    file = results.contact(4)
    ours, low, high = percentile(file, -1, 50)
    paper = percentile(file, -1, 99, "linear_amplification")[0]
    what = "percentile 50 of A_nl, n_d = 4, σ = 2.3 %; beside percentile 99 of A_lin"
    row = value_row("11", what, paper, ours, low, high, remark=UNKNOWN)
    near = abs(ours - paper) < 0.05 * paper
    return [row._replace(paper=f"about equal ({paper:.2f})", agrees="yes" if near else "no")]


def shares(results):
    """12: share of the samples above the diagonal."""
    file = results.file("cross.h5")
    return [
        value_row("12", f"samples with A_nl > A_lin, n_d = 4, σ = {sigma} % [%]", paper,
                  100 * file.read("share", level), *(100 * file.read("share_interval", level)),
                  digits=0, remark=UNKNOWN)
        for sigma, paper, level in ((0.6, 82, 0), (2.3, 96, 3))
    ]  # fmt: skip


def below(results):
    """13: six bumps."""
    file = results.contact(6)
    parts, holds = [], True
    for at in (50, 99):
        pairs = [
            (percentile(file, v, at)[0], percentile(file, v, at, "linear_amplification")[0])
            for v in range(4)
        ]
        parts.append(f"percentile {at}: " + ", ".join(f"{a:.2f}/{b:.2f}" for a, b in pairs))
        holds = holds and all(a < b for a, b in pairs)
    return [claim_row("13", "A_nl / A_lin at n_d = 6, σ = 0.6 … 2.3 %", "A_nl below A_lin",
                      "; ".join(parts), holds, remark=UNKNOWN)]  # fmt: skip


def tuned_amplitudes(file):
    """Reference, smallest and largest peak of the tuned disk's runs [mm]."""
    reference, runs = file.read("tuned/reference_amplitude_m"), file.read("tuned/run_peaks_m")
    return 1e3 * float(reference), 1e3 * np.nanmin(runs), 1e3 * np.nanmax(runs)


def amplitudes(results):
    """14: amplitudes of the tuned disk and of the samples."""
    tuned = {n: tuned_amplitudes(results.contact(n)) for n in (3, 4, 5, 6)}
    order = sorted(tuned, key=tuned.get)
    text = ", ".join(
        f"n_d = {n}: {middle:.1f} [{low:.1f}, {high:.1f}]"
        for n, (middle, low, high) in tuned.items()
    )
    claim = "highest for 3 and 6, lowest for 4 and 5"
    holds = set(order[2:]) == {3, 6}
    what = "tuned amplitudes, with the range of their runs [mm]"
    rows = [claim_row("14", what, claim, text, holds, remark=UNKNOWN)]
    for n_d in (3, 6):
        file = results.contact(n_d)
        top = [1e3 * percentile(file, v, 99, "peak_amplitude_m")[0] for v in range(4)]
        rows.append(claim_row("14", f"percentile 99 of the amplitude, n_d = {n_d}, all σ [mm]",
                              "near 65", f"{min(top):.1f}–{max(top):.1f}",
                              all(abs(v - 65) < 5 for v in top), remark=UNKNOWN))  # fmt: skip
    return rows


def samples_needed(results):
    """15: samples until the convergence error is below 0.5 %."""
    rows = []
    for n_d, paper in ((6, "500"), (3, "2000"), (4, "worst: 4000"), (5, "3000")):
        file = results.contact(n_d)
        error = file.read("statistics/contact/convergence_error")
        seen = file.read("statistics/contact/samples_seen")
        worst = error.reshape(-1, error.shape[-1]).max(axis=0)
        above = np.flatnonzero(~(worst < file.config.convergence.target_error))
        first = above[-1] + 1 if len(above) else 0  # from here on it stays below
        reached = first < len(seen) and len(seen) > MIN_VALUES
        ours = f"{seen[first]}" if reached else f"not within {file.config.mistuning.samples}"
        enough = reached and seen[first] <= 1.5 * int(paper.split()[-1])
        row = claim_row("15", f"samples per level until the error stays below 0.5 %, n_d = {n_d}",
                        paper, ours, enough, remark="More samples are needed to tell, or " +
                        "the scatter of this disk's A_nl is larger than the paper's.")  # fmt: skip
        open_ = not reached and file.config.mistuning.samples < int(paper.split()[-1])
        rows.append(row._replace(agrees="open") if open_ else row)
    return rows


def cost(results):
    """16: cost of one sample."""
    file = results.contact(4)
    done_ = file.status() == DONE
    simulated = file.read("samples/time_s")[done_].sum(axis=1).mean()
    share = np.mean(file.read("samples/point_status")[done_] == STEADY)
    cfg = Config()
    rate, _ = cli.measure(cfg, build_problem(cfg))
    text = (
        f"{simulated / cfg.time.step / rate:.2g} s on a core here: {simulated:.0f} s simulated, "
        f"{rate / 1e6:.2g} million steps of {cfg.time.step:g} s per second "
        f"({100 * share:.0f} % of the points steady)"
    )
    return [Row("16", "one response of 41 speeds", "about 1 h on a core", text, "", "")]


def sensitivity(results):
    """Cells of the sensitivity table."""
    files = [ResultFile.open(p) for p in sorted((results.folder / "sensitivity").glob("*.h5"))]
    if not files:
        return
    reference = next(f for f in files if "lean_deg=45.41" in f.path.name)
    base = flatten(reference.config.model_dump(mode="json"))
    for file in sorted(files, key=lambda f: f is not reference):
        keys = flatten(file.config.model_dump(mode="json"))
        changed = [f"{k.rpartition('.')[2]} {base[k]} → {keys[k]}" for k in keys
                   if keys[k] != base[k] and k != "output"]  # fmt: skip
        middle, (top, low, high) = percentile(file, 0, 50)[0], percentile(file, 0, 99)
        ends = (f"{end:.2f}" if np.isfinite(end) else "–" for end in (low, high))
        peak = tuned_amplitudes(file)[0]
        yield (
            ", ".join(changed) or "nothing",
            f"{peak:.1f} mm at {float(file.read('tuned/peak_speed_hz')):.2f} Hz",
            f"{middle:.2f}", f"{top:.2f}", f"[{', '.join(ends)}]",
        )  # fmt: skip
        file.close()
