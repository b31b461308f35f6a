"""The search: points of the whole range first, then CMA-ES around the best.

Every round carries some disks through the stages, from cheap to dear; after each stage only the
best go on. CMA-ES is told nothing but the order: disks that came further come first, and among
these the lower loss.
"""

import math
from typing import NamedTuple

import cma
import numpy as np
from scipy.stats import qmc

from evidence.identify import disks, paper

SEED = 14
FIRST = {
    "linear": 96,
    "pattern": 32,
    "tuned": 8,
    "samples": 3,
    "smooth": 1,
    "fine": 1,
}  # that go on
LATER = {
    "linear": 8,
    "pattern": 6,
    "tuned": 3,
    "samples": 2,
    "smooth": 1,
    "fine": 1,
}  # of a generation
GENERATION = 8
WIDTH = 0.06  # of the first generation, in ranges of the dimensions
BOWS = -0.0017, -0.00095  # per degree of lean against and with the rotation: where `line` starts
N_PLAIN, N_VARIED = 2, 0  # disks that are computed in other draws
REPEATS = 4  # draws that tell how far the loss of one disk scatters
AGAIN = tuple(stage for stage in paper.STAGES if stage != "smooth")  # in these draws


class Trial(NamedTuple):
    """A disk, as far as it was carried."""

    disk: disks.Dimensions
    found: dict
    n_stages: int

    @property
    def loss(self):
        """Of the stages that it has seen."""
        return paper.loss(self.found, paper.STAGES[: self.n_stages])

    @property
    def order(self):
        """Sorting key: the best comes first."""
        return -self.n_stages, self.loss


def whole_range(book, n_points, say=print):
    """Points spread evenly over the whole range, and the disks of earlier searches.

    Parameters
    ----------
    book : Book
    n_points : int
        Power of two.
    say : callable
        Takes a line of progress.

    Returns
    -------
    list of Trial
        The best first.
    """
    points = qmc.Sobol(len(disks.BOUNDS), seed=SEED).random(n_points)
    earlier = [disk for disk in _in_band(book, disks.EARLIER) if disk]
    placed = [disks.place(point, disks.BOUNDS, _start(point)) for point in points]
    spread = [disk for disk in _in_band(book, placed) if disk]
    say(f"{len(spread)} of {n_points} points can have the paper's band")
    trials = _through(book, earlier, dict.fromkeys(FIRST, len(earlier)))
    trials += _through(book, spread, FIRST)
    return _report(sorted(trials, key=lambda t: t.order), "whole range", say)


def line(book, n_points, say=print):
    """Points spread over lean and hub, with the bow that gives the paper's tuned peak.

    Parameters as of `whole_range`; the bow follows from the estimate of `shapes.peaks`.

    Returns
    -------
    list of Trial
        The best first.
    """
    bounds = {name: disks.BOUNDS[name] for name in disks.BOUNDS if name != "bow"}
    shapes = []
    for point in qmc.Sobol(len(bounds), seed=SEED).random(n_points):
        shape = disks.place(point, bounds, _start(np.insert(point, 1, 0.5)))
        shapes.append(shape._replace(bow=shape.lean_deg * BOWS[shape.lean_deg > 0]))
    found = book.measure([("line", shape, 0) for shape in shapes])
    spread = [disks.Dimensions(*numbers["disk"]) for numbers in found if numbers["disk"]]
    say(f"{len(spread)} of {n_points} points can have the paper's band and peak")
    return _report(sorted(_through(book, spread, FIRST), key=lambda t: t.order), "line", say)


def _start(point):
    """A disk whose spokes are about right for their length: bending goes with (t/L)^3."""
    d = disks.EARLIER[1]
    low, high = disks.BOUNDS["inner_radius_mm"]
    length = 200 - (low + point[list(disks.BOUNDS).index("inner_radius_mm")] * (high - low))
    return d._replace(spoke_thickness_mm=d.spoke_thickness_mm * length / (200 - d.inner_radius_mm))


def around(book, best, bounds, n_generations, say=print, seed=SEED):
    """CMA-ES around a disk.

    Parameters
    ----------
    book : Book
    best : Dimensions
        Where it starts.
    bounds : dict
        Ranges of the dimensions that may change.
    n_generations : int
    say : callable
    seed : int

    Returns
    -------
    list of Trial
        All of them, the best first.
    """
    options = {"seed": seed, "bounds": [0, 1], "popsize": GENERATION, "verbose": -9}
    start = np.clip(disks.unit_of(best, bounds), 0.01, 0.99)
    strategy = cma.CMAEvolutionStrategy(start, WIDTH, options)
    trials = []
    for generation in range(n_generations):
        points = strategy.ask()
        placed = _in_band(book, [disks.place(point, bounds, best) for point in points])
        found = {t.disk: t for t in _through(book, [d for d in placed if d], LATER)}
        order = [found[d].order if d else (1, math.inf) for d in placed]
        strategy.tell(points, [float(sorted(order).index(o)) for o in order])
        trials += found.values()
        name = f"generation {generation + 1}, width {strategy.sigma:.3f}"
        _report(sorted(found.values(), key=lambda t: t.order), name, say)
    return sorted(trials, key=lambda t: t.order)


def _in_band(book, shapes):
    """Disks of these shapes with the paper's band, None where there is none."""
    found = book.measure([("band", shape, 0) for shape in shapes])
    return [numbers["disk"] and disks.Dimensions(*numbers["disk"]) for numbers in found]


def _through(book, candidates, kept):
    """Carry disks through the stages; so many as `kept` says enter each but the first."""
    ended, running = [], [Trial(disk, {}, 0) for disk in dict.fromkeys(candidates)]
    for number, stage in enumerate(paper.STAGES, start=1):
        if stage in kept:
            running, out = running[: kept[stage]], running[kept[stage] :]
            ended += out
        found = book.measure([(stage, trial.disk, 0) for trial in running])
        running = [
            Trial(trial.disk, trial.found | new, number)
            for trial, new in zip(running, found, strict=True)
        ]
        running.sort(key=lambda t: t.order)
    return running + ended


def _report(trials, name, say):
    best = trials[0]
    say(f"{name}: best of {len(trials)}: loss {best.loss:.1f} after {best.n_stages} stages, "
        + ", ".join(f"{k} {v:.4g}" for k, v in best.disk._asdict().items()))  # fmt: skip
    return trials


def finished(book):
    """All disks of a book that were carried through every stage, the best first."""
    per_stage = [book.of(stage) for stage in paper.STAGES]
    trials = []
    for disk in per_stage[-1]:
        found = {name: value for numbers in per_stage for name, value in numbers[disk].items()}
        trials.append(Trial(disk, found, len(per_stage)))
    return sorted(trials, key=lambda t: t.order)


def contenders(trials):
    """Disks to compute in other draws: the best without variations, the best with, the reference.

    The loss that the search saw is partly luck, so that several have a chance to be the best.
    """
    plain = [t for t in trials if t.disk.is_plain]
    varied = [t for t in trials if not t.disk.is_plain]
    chosen = plain[:N_PLAIN] + varied[:N_VARIED]
    return chosen + [t for t in plain[N_PLAIN:] if t.disk[:4] == disks.REFERENCE[:4]][:1]


def repeat(book, contenders):
    """Compute disks in `REPEATS` other draws of samples and perturbed runs, draw after draw."""
    for draw in range(1, REPEATS + 1):
        for trial in contenders:
            for stage in AGAIN:
                book.measure([(stage, trial.disk, draw)])


def leaders(book, trials):
    """The best disk without variations in other draws, and the best one with, if it is better."""
    known = [t for t in trials if len(losses(book, t.disk)) > 1] or trials[:1]
    known.sort(key=lambda t: losses(book, t.disk).mean() if len(losses(book, t.disk)) else 0.0)
    plain = next((t for t in known if t.disk.is_plain), known[0])
    return [plain] if plain == known[0] else [plain, known[0]]


def draws(book, disk):
    """What was found of a disk in other draws that are complete: list of dict."""
    found = []
    for draw in range(1, REPEATS + 1):
        numbers = [book.of(s, draw if s in AGAIN else 0).get(disk) for s in paper.STAGES]
        if all(n is not None for n in numbers):
            found.append({name: value for n in numbers for name, value in n.items()})
    return found


def losses(book, disk):
    """Loss of a disk in the other draws that are complete, (n,) [-]."""
    return np.array([paper.loss(found) for found in draws(book, disk)])


def as_good(trials, losses):
    """Disks whose loss is that of the best, as far as its scatter tells.

    Parameters
    ----------
    trials : list of Trial
    losses : (n,)
        Of the best disk in other draws.

    Returns
    -------
    list of Trial
    """
    limit = losses.mean() + 2 * losses.std(ddof=1)
    return [trial for trial in trials if trial.loss <= limit]


def to_test(trials, losses, n):
    """Disks that the conclusions are tested on: those of the set, the next best if these are few.

    Parameters
    ----------
    trials : list of Trial
        The best first.
    losses : (m,)
        Of the best disk in other draws.
    n : int
        How many disks.

    Returns
    -------
    list of Trial
    """
    good = as_good(trials, losses)
    return apart(good, n) if len(good) > n else trials[:n]


def apart(trials, n):
    """At most n trials that lie as far apart as possible, the best among them.

    Each next one is the farthest, in ranges of the dimensions, from all those taken so far.
    """
    bounds = disks.BOUNDS | disks.VARIATIONS
    place = np.array([disks.unit_of(trial.disk, bounds) for trial in trials])
    taken = [0]
    while len(taken) < min(n, len(trials)):
        distance = np.linalg.norm(place[:, None] - place[None, taken], axis=-1).min(axis=1)
        taken.append(int(np.argmax(distance)))
    return [trials[i] for i in taken]
