"""Run-ups without contact: the closed form of linear modes whose load gains or loses frequency.

A load of four periods around a disk, no tip of which reaches the casing, is at each tip a harmonic
cos(4(φ + θ(t))), θ the integral of the speed. The tuned disk answers by its waves of four
diameters, a mistuned one by all its modes. `evidence.truth.run_up` has the exact motion of every
mode by the Faddeeva function, with the wave that turns backward (`passed`) and without (`passage`).
"""

import itertools
from typing import NamedTuple

import numpy as np

from evidence.page import table
from evidence.truth.disk import DAMPING_RATIO, LOAD, reference_reduced, reference_scene
from evidence.truth.run_up import passage, passed
from evidence.validation import report
from hpcrub.model.casing import CasingShape
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.run_up import Asked, Runner
from hpcrub.response.schedule import Schedule

HZ, ORDER, N_MODES = 2.0 * np.pi, 4, 12
MISTUNING = np.linspace(-0.03, 0.03, 12)[[3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]]
RATES = {0.1: 1.0, 1.0: 3.0, 5.0: 5.0, 20.0: 7.0}  # [Hz/s], and how far from the resonance [Hz]
STEP, RECORDS = 2e-5, 2e-4  # [s]
NARROW, NARROW_RATE, NARROW_AWAY = DAMPING_RATIO / 20.0, 0.0125, 0.2
STEPS = 8e-5 * 2.0 ** -np.arange(4)  # [s]
STEPS_ENDS, STEPS_LAST = (22.7, 23.2), 0.4  # of the mistuned disk [Hz], [s]
FINE = 201  # so many intervals of speed that stretches are single turns


class Trail(NamedTuple):
    """Modal displacements of R repetitions at the ends of stretches, with the exact time."""

    time: np.ndarray  # of every repetition, negative before it begins to turn (S, R) [s]
    position: np.ndarray  # (S, K, R) [m √kg]
    waits: np.ndarray  # before it begins to turn (R,) [s]


def loaded(scheme="exact_modal", damping=DAMPING_RATIO, **changes):
    """Scene of a load without contact."""
    free = {"clearance": 1.0, "casing": CasingShape(4, 0.0), "load": LOAD, "load_order": ORDER}
    return reference_scene(N_MODES, damping_ratio=damping, scheme=scheme, **free, **changes)


def runner(modes, scene, schedule, repeats=1, n_intervals=FINE):
    """A Runner of a schedule."""
    ends = schedule.speed_hz.min(), schedule.speed_hz.max()
    return Runner(modes, scene, schedule, Asked(np.linspace(*ends, n_intervals), repeats))


def trail(modes, scene, schedule, repeats=1):
    """The Trail of a run until the last stretch that ends before the schedule does."""
    run, time, position = runner(modes, scene, schedule, repeats), [], []
    waits = run.delay / (schedule.speed_hz[0] * run.grid.steps_per_revolution)
    for _ in run.go_on():
        if run.time.max() > schedule.time[-1]:
            break
        time.append(run.time)
        position.append(run.bank.state.position[:, :repeats].copy())
    return Trail(np.array(time), np.array(position), waits)


def records(run):
    """Times (n,) [s], and displacements of all tips (n, C) [m], of the first repetition."""
    time, tips, began = [], [], 0.0
    for _ in run.go_on():
        seen = run.record.history.reshape(-1, len(run.last), run.bank.width)[..., 0]
        time.append(began + (run.time[0] - began) * np.arange(1, len(seen) + 1) / len(seen))
        tips.append(seen[:, : len(run.modes.observed)].copy())
        began = run.time[0]
    return np.concatenate(time), np.concatenate(tips)


def forces(modes, scene):
    """Complex modal forces (K,) [N/√kg] of the load."""
    face = scene.interface
    return LOAD * (face.share * np.exp(1j * ORDER * face.angle)) @ modes.normal


def exact(modes, scene, from_hz, rate, times):
    """Exact modal displacements (T, K) [m √kg] in a linear change of speed from rest."""
    end = times[-1]
    return by_table(modes, scene, [0.0, end], [from_hz, from_hz + rate * end], times)


def by_table(modes, scene, at, hz, times):
    """The same for a table of times and speeds."""
    each = zip(modes.omega, forces(modes, scene), strict=True)
    moved = [passed(w, scene.damping_ratio, ORDER, f, at, hz, times) for w, f in each]
    return np.stack(moved, axis=1)


def wave(scene, tips):
    """Size (T,) of the wave of four diameters in displacements of all tips (T, C)."""
    return np.abs(tips @ np.exp(-1j * ORDER * scene.interface.angle)) * 2.0 / tips.shape[1]


class Passage(NamedTuple):
    """Wave of the tips over its largest size at constant speed, of one run."""

    speed: np.ndarray  # at the records (T,) [Hz]
    found: np.ndarray  # by the product (T,)
    exact: np.ndarray  # all modes (T,)
    alone: np.ndarray  # one mode, rotating wave (T,)
    envelope: np.ndarray  # by the product, largest motion of a tip in intervals of speed (I,)
    resonance: float  # [Hz]

    def peaks(self):
        """Largest size of the three, and how far beyond the resonance [Hz], of found and alone."""
        way = np.sign(self.speed[-1] - self.speed[0])
        late = [way * (self.speed[s.argmax()] - self.resonance) for s in (self.found, self.alone)]
        return [s.max() for s in (self.found, self.exact, self.alone)], late


def pass_by(rate, away, damping=DAMPING_RATIO):
    """A Passage of the tuned disk; rate: also negative [Hz/s]; away: begin and end of it [Hz]."""
    scene = loaded(damping=damping, step=STEP, record_interval=RECORDS)
    modes = mistuned_modes(reference_reduced(N_MODES), np.zeros(12))
    size = np.abs(forces(modes, scene))
    main = int(size[:12].argmax())
    omega = modes.omega[main]
    at = omega * np.sqrt(1.0 - damping**2) / (ORDER * HZ)
    begin, lasts = at - np.sign(rate) * away, 2.0 * away / abs(rate)
    run = runner(modes, scene, Schedule([0.0, lasts], [begin, begin + rate * lasts]))
    t, tips = records(run)
    before = t < lasts - 2.0 / begin  # in the last stretch the schedule ends
    t, tips = t[before], tips[before]
    both = np.abs(modes.omega / omega - 1.0) < 1e-9
    steady = np.abs((modes.observed * both) @ forces(modes, scene)).max() / (2 * damping * omega**2)
    whole = exact(modes, scene, begin, rate, t) @ modes.observed.T
    alone = np.abs(passage(omega, damping, ORDER, begin, rate, t)) * damping * omega
    sizes = wave(scene, tips) / steady, wave(scene, whole) / steady
    return Passage(begin + rate * t, *sizes, alone, run.run.envelope[0, 0] / steady, at)


def step_errors(modes, scheme, ends=STEPS_ENDS):
    """Steps (n,) [s], and errors of all tips at them (n, S, C) [-]; ends: of the speed [Hz]."""
    rate, found = (ends[1] - ends[0]) / STEPS_LAST, []
    for step in STEPS:
        scene = loaded(scheme, step=step, record_interval=0.0)
        run = trail(modes, scene, Schedule([0.0, STEPS_LAST], ends))
        known = exact(modes, scene, ends[0], rate, run.time[:, 0]) @ modes.observed.T
        off = run.position[..., 0] @ modes.observed.T - known
        found.append(off / np.abs(known).max())
    return STEPS, np.array(found)


def extrapolated(steps, errors):
    """Largest error of the limit of the two smallest of steps (n,), by errors (n, ...) at all."""
    a, b = steps[-2:] ** 2
    return float(np.abs((a * errors[-1] - b * errors[-2]) / (a - b)).max())


def section():
    """Parts of the page, verdicts and the figure."""
    asked = itertools.product(RATES, (1, -1))
    runs = {(rate, way): pass_by(way * rate, RATES[rate]) for rate, way in asked}
    rows, apart = [], 0.0
    for (rate, way), run in runs.items():
        peaks, late = run.peaks()
        apart = max(apart, np.abs(run.found - run.exact).max())
        rows.append([f"{rate:g}", "up" if way > 0 else "down", *(f"{100 * p:.2f}" for p in peaks),
                     *(f"{hz:.3f}" for hz in late)])  # fmt: skip
    heads = ["Hz/s", "way", "hpcrub [%]", "all modes [%]", "one mode [%]", "hpcrub, late [Hz]",
             "one mode, late [Hz]"]  # fmt: skip
    at = next(iter(runs.values())).resonance
    parts = {"passages": f"Resonance at {at:.3f} Hz, {ORDER * at:.2f} Hz of vibration.\n\n"
             + table(heads, rows)}  # fmt: skip
    narrow = [pass_by(way * NARROW_RATE, NARROW_AWAY, NARROW) for way in (1, -1)]
    beside = max(np.abs(run.found - run.alone).max() for run in narrow)
    verdicts = [
        report.at_most("all modes, at every record, over the steady peak", apart, 1e-4),
        report.at_most(f"one mode, ξ = {NARROW:g}, over the steady peak", beside, 1e-3),
    ]
    mistuned, columns = mistuned_modes(reference_reduced(N_MODES), MISTUNING), {}
    for scheme in report.SCHEMES:
        steps, errors = step_errors(mistuned, scheme)
        columns[f"`{scheme}`"] = np.abs(errors).max(axis=(1, 2))
        verdicts += [
            report.order(f"`{scheme}`", steps, columns[f"`{scheme}`"], 1.9, 2.1),
            report.at_most(f"`{scheme}`, limit of the steps", extrapolated(steps, errors), 1e-6),
        ]
    labels = "h", [f"{1e6 * step:g} µs" for step in steps]
    parts["steps"] = report.order_table(labels, steps, columns)
    _figure(runs)
    return parts, verdicts


def _figure(runs):
    """Waves over the speed, up and down, at all rates."""
    figure, axes = report.axes(2, sharey=True)
    for way, ax in zip((1, -1), axes, strict=True):
        for rate in RATES:
            run = runs[rate, way]
            (line,) = ax.plot(run.speed, 100 * run.found, lw=1.6, label=f"{rate:g} Hz/s")
            dots = np.linspace(0, len(run.speed) - 1, 10_001).astype(int)
            path = np.append(0.0, np.cumsum(np.hypot(np.diff(run.speed[dots]) / 0.15,
                                                     np.diff(run.alone[dots]) / 0.06)))  # fmt: skip
            dots = dots[np.searchsorted(path, np.arange(0.0, path[-1]))]
            ax.plot(run.speed[dots], 100 * run.alone[dots], "o", ms=2.6, color=line.get_color())
        ax.set(xlabel="speed of rotation [Hz]", xlim=(run.resonance - 2.5, run.resonance + 2.5))
        ax.set(title="speed rises" if way > 0 else "speed falls")
    axes[0].set(ylabel="wave of the tips [% of the steady peak]", ylim=(0.0, 105.0))
    axes[0].plot([], [], "o", ms=2.6, color="0.3", label="one mode, closed form")
    figure.legend(*axes[0].get_legend_handles_labels(), ncols=5, loc="outside upper center")
    report.save(figure, "validation_run_up")
