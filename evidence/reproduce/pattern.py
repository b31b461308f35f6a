"""The paper's numbers of the one disk with the pattern of Table 2: rows 4, 5, 7 and 8."""

import itertools

import numpy as np

from evidence.reproduce.rows import (
    RUNS_BETWEEN,
    Row,
    bounded,
    bracket,
    claim_row,
    done,
    run_row,
    value_row,
    verdict,
    worst,
)
from hpcrub.config.text import flatten
from hpcrub.statistics.coexistence import coexisting, stretches
from hpcrub.studies import branches

CHAOS = (
    "More than rounding explains: none of the middle 95 % of our runs, which differ by a rounding, "
    "has the paper's number."
)
LOCALISED = (
    "More than rounding explains. How far a motion spreads from blade to blade depends on how the "
    "disk couples them, and the disk's sections are among what the paper does not give."
)
# of the paper's pattern: speed [Hz], amplitude [mm], localisation [%] where each is largest
POINTS = (34.78, 58.1, 49.0), (33.66, 38.9, 67.9)
ZONE = 34.1775, 34.2925  # [Hz], the paper's 34.18 to 34.29 with half a step of its figure 17


def table2(results):
    """4: the pattern of Table 2."""
    file = results.file("perturbed_pattern.h5")
    mm, share = 1e3 * done(file, "amplitude_m", 0), 100 * done(file, "localisation", 0)
    speeds, run = file.read("speeds_hz"), np.arange(len(mm))
    best, most = np.nanargmax(mm, axis=1), np.nanargmax(share, axis=1)
    more = {"fitted": True, "remark": CHAOS}
    local_more = {"fitted": True, "remark": LOCALISED}
    ends = np.nanmin(share, axis=1), share[run, most]
    (least, *low), (largest, *high) = (np.percentile(e, [50, *RUNS_BETWEEN]) for e in ends)
    both = verdict(17, least, 0.5, *low), verdict(65, largest, 0.5, *high)
    return [
        run_row("4", "pattern of Table 2, n_d = 4: largest amplitude [mm]", 58.1, mm[run, best],
                digits=1, **more),
        run_row("4", "its speed [Hz]", 34.78, speeds[best], **more),
        run_row("4", "localisation there [%]", 49.0, share[run, best], digits=1, **local_more),
        run_row("4", "largest localisation [%]", 67.9, share[run, most], digits=1, **local_more),
        run_row("4", "its speed [Hz]", 33.66, speeds[most], **more),
        run_row("4", "amplitude there [mm]", 38.9, mm[run, most], digits=1, **local_more),
        Row("4", "smallest and largest localisation, as section 5 says before its 67.9 [%]",
            "17, 65", f"{least:.1f}, {largest:.1f}", f"{bracket(low, 1)}, {bracket(high, 1)}",
            worst(both), **local_more),
    ]  # fmt: skip


def coexistence(results):
    """5: coexisting stable motions of the pattern."""
    file = results.file("branches.h5")
    found, speeds = branches.label_file(file), file.read("speeds_hz")
    several = coexisting(found) > 1
    zone = (speeds > ZONE[0]) & (speeds < ZONE[1])
    n_windows = file.read("window_amplitude_m").shape[-1]
    remark = (
        "Single windows of three revolutions differ from start to start at most speeds. Ours are "
        f"motions whose means over {n_windows} windows differ by more than chance (figure 17); one "
        "that jumps between two within these counts with either."
    )
    inside, outside = np.mean(several[zone]), np.mean(several[~zone])
    together = [f"{speeds[first]:.3f}–{speeds[end - 1]:.3f}"
                for first, end in stretches(several) if end - first > 2]  # fmt: skip
    rows = [
        claim_row(
            "5", "speeds with several stable branches (yes: 9 in 10 of the paper's and fewer than "
            "1 in 10 of the others) [Hz]", "34.18–34.29",
            f"{several.sum()} of {len(speeds)} speeds, {several[zone].sum()} of them among the "
            f"paper's {zone.sum()}; together: {', '.join(together) or 'none'}",
            inside > 0.9 and outside < 0.1, remark=remark,
        )
    ]  # fmt: skip
    both = np.where(zone & several, found, -1)
    counts = np.bincount(both[both >= 0])
    if np.count_nonzero(counts) < 2:
        return rows
    amplitude, local = (file.read(f"window_{n}").mean(axis=-1)
                        for n in ("amplitude_m", "localisation"))  # fmt: skip
    pair = sorted(np.argsort(counts)[-2:], key=lambda branch: amplitude[both == branch].mean())
    for branch, name, paper in zip(pair, ("lower", "upper"), (17.4, 25.9), strict=True):
        ours = 100 * local[both == branch].mean()
        rows.append(value_row("5", f"mean localisation of the {name} branch there, of the two with "
                              "the most points [%]", paper, ours, digits=1,
                              remark=LOCALISED))  # fmt: skip
    return rows


def _responses(results, folder, key):
    """Values of the key of a sweep (V,), ascending, the responses (V, speeds) [m], and scatter.

    Scatter is the difference [%] below which 97.5 % of the pairs of runs lie that differ by a
    rounding: what any small change makes of motions that are not periodic.
    """
    files = results.files(f"{folder}/*.h5")
    values = np.array([flatten(f.config.model_dump(mode="json"))[key] for f in files])
    curves = np.array([f.read("samples/amplitude_m", (0, 0)) for f in files])
    order = np.argsort(values)
    runs = done(results.file("perturbed_pattern.h5"), "amplitude_m", 0)
    apart = [np.median(_difference(a, b)) for a, b in itertools.combinations(runs, 2)]
    return values[order], curves[order], np.percentile(apart, RUNS_BETWEEN[1])


def _difference(curve, finest):
    """Differences at all speeds where both have a number, in % of the peak."""
    difference = 100 * np.abs(curve - finest) / np.nanmax(finest)
    return difference[np.isfinite(difference)]


def _list(names, found):
    return ", ".join(
        f"{name}: {middle:.1f} % {bracket(ends, 1)}"
        for name, (middle, *ends) in zip(names, found, strict=True)
    )


SCATTER = (
    "Single points of the response differ after any small change, because most motions here are "
    "not periodic."
)


def time_step(results):
    """7: convergence with the time step."""
    steps, curves, scatter = _responses(results, "time_step", "time.step_s")
    found = [bounded(_difference(curve, curves[0]), 50) for curve in curves[1:]]
    limit = 1.0 / (np.pi * results.file("modal.h5").read("reduced/frequencies_hz").max())
    holds = all(middle <= scatter for middle, *_ in found)
    return [
        claim_row(
            "7", f"median difference of the pattern's response to that at h = {steps[0]:.0e} s "
            f"(yes: none above {scatter:.1f} %, below which 97.5 % of the pairs of runs lie)",
            "none seen", _list([f"{h:.0e}" for h in steps[1:]], found), holds, remark=SCATTER,
        ),
        value_row(
            "7", "largest h at which central differences work, η = 60 [1e-5 s]", 5.0, 1e5 * limit,
            digits=1, fitted=True,
            remark="The stability limit 2/ω of the highest mode of the reduced model, which is not "
            "the paper's.",
        ),
    ]  # fmt: skip


def reduction(results):
    """8: convergence with the number of modes."""
    modes, curves, scatter = _responses(results, "reduction", "reduction.n_modes")
    found = [bounded(_difference(curve, curves[-1]), 50) for curve in curves[:-1]]
    alike = [bool(middle <= scatter) for middle, *_ in found]
    holds = all(a for n, a in zip(modes, alike, strict=False) if n > 36)
    return [
        claim_row(
            "8", f"median difference of the pattern's response to that with η = {modes[-1]} (yes: "
            f"for η > 36 none above {scatter:.1f} %, as in row 7)",
            "none seen for η > 36", _list([f"η = {n}" for n in modes[:-1]], found), holds,
            remark=SCATTER,
        )
    ]  # fmt: skip
