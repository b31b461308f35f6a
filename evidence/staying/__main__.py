"""Do motions that are called steady or averaged stay? Follows them on, and writes docs/staying.md.

One core takes half an hour. `make staying ARGS=tuned` measures one section only.
"""

import numpy as np

from evidence.page import DOCS, sections, table
from evidence.progress import followed
from evidence.staying.follow import follow, shares
from evidence.staying.scenes import MISTUNED, TUNED, Scenes
from hpcrub.contact.status import NOT_STEADY
from hpcrub.response.sweep import run_sweep
from hpcrub.statistics.percentiles import Z_95, percentile_interval
from hpcrub.studies.contact.amplification import AIM

RUNS = 9  # of each tuned disk, as a study has
AFTER = 8.0  # time for which a tuned disk is followed on [s]
RULES = {"not looked at": {"watches_growth": False}, "looked at": {}}


def tuned():
    """Tuned disks: what equal blades do, what the reference says, and what stays."""
    rows, unmarked = [], 0
    for (n, damping), changes in followed(list(TUNED.items()), "tuned disks", len(TUNED)):
        scenes = Scenes("quickstart", changes)
        kept = scenes.scene(watches_growth=False, aim=AIM)
        equal = run_sweep(scenes.modes(None, -1), kept, scenes.speeds)
        parts = [
            follow(scenes.modes(None, run), scenes.scene(aim=AIM), scenes.speeds, AFTER)
            for run in range(RUNS)
        ]
        best = [int(np.nanargmax(part.amplitude)) for part in parts]
        # a peak may move to another speed: all speeds count, before and after
        off = [
            part.amplitude[k] / np.nanmax(part.truth) - 1.0
            for part, k in zip(parts, best, strict=True)
        ]
        states = np.array([part.state[k] for part, k in zip(parts, best, strict=True)])
        later = np.median([np.nanmax(part.truth) for part in parts])
        peaks = np.array([np.nanmax(part.amplitude) for part in parts])
        found = np.median(peaks)
        low, high = np.ravel(percentile_interval(peaks, [50.0], Z_95))
        at_peak = int(np.count_nonzero(states == NOT_STEADY))
        unmarked += abs(found / later - 1.0) > 0.03 and not low <= later <= high
        rows.append([
            n, f"{damping:g}", f"{1e3 * np.nanmax(equal.amplitude):.2f}",
            f"{1e3 * found:.2f} ({1e3 * low:.1f} to {1e3 * high:.1f})",
            f"{1e3 * later:.2f}", f"{100 * (found / later - 1.0):+.1f} %",
            f"{100 * max(off, key=abs):+.1f} %", at_peak or "",
        ])  # fmt: skip
    heads = ["bumps", "damping", "equal blades [mm]", "reference [mm]",
             f"after {AFTER:g} s more [mm]", "off", "worst run", "marked"]  # fmt: skip
    said = (
        f"{unmarked} of {len(rows)} references are more than 3 % off and outside their interval.\n"
    )
    return {"disks": table(heads, rows) + "\n" + said}


def averages():
    """Points of many disks by kind of verdict: how far off they are later."""
    rows = []
    names = [f"{name}, {rule}" for name in MISTUNED for rule in RULES]
    todo = [(*item, rule) for item in MISTUNED.items() for rule in RULES]
    for name, (source, changes, disks, seconds), rule in followed(todo, "scenes", names=names):
        scenes = Scenes(source, changes)
        scene = scenes.scene(**RULES[rule])
        parts = [follow(scenes.modes(*disk), scene, scenes.speeds, seconds) for disk in disks]
        cost = np.mean([part.seconds for part in parts])
        mean = np.mean([part.time.mean() for part in parts])
        rows += [(name, rule, *row, f"{mean:.3f}", f"{cost:.3f}") for row in shares(parts)]
    heads = ["scene", "growth", "points", "number", "> 2 errors", "> 3 errors",
             "> 5 % and 2 errors", "worst", "simulated [s]", "core s a disk"]  # fmt: skip
    return {"points": table(heads, rows)}


SECTIONS = {"tuned": tuned, "averages": averages}


if __name__ == "__main__":
    sections("staying", __doc__, DOCS / "staying.md", SECTIONS)
