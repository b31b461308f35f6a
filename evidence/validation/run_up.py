"""Run-ups without contact: the closed form of linear modes whose load gains or loses frequency.

A load of four periods around a disk, no tip of which reaches the casing, is at each tip a harmonic
cos(4(φ + θ(t))), θ the integral of the speed. The tuned disk answers by its waves of four
diameters. `evidence.truth.run_up` has the exact motion of every mode by the Faddeeva function, with
the wave that turns backward (`passed`) and without (`passage`).
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
RATES = {0.1: 1.0, 1.0: 3.0, 5.0: 5.0, 20.0: 7.0}  # [Hz/s], and how far from the resonance [Hz]
STEP, RECORDS = 2e-5, 2e-4  # [s]
NARROW, NARROW_RATE, NARROW_AWAY = DAMPING_RATIO / 20.0, 0.0125, 0.2
FINE = 201  # so many intervals of speed that stretches are single turns


def loaded(scheme="exact_modal", damping=DAMPING_RATIO, **changes):
    """Scene of a load without contact."""
    free = {"clearance": 1.0, "casing": CasingShape(4, 0.0), "load": LOAD, "load_order": ORDER}
    return reference_scene(N_MODES, damping_ratio=damping, scheme=scheme, **free, **changes)


def runner(modes, scene, schedule, repeats=1, n_intervals=FINE):
    """A Runner of a schedule."""
    ends = schedule.speed_hz.min(), schedule.speed_hz.max()
    return Runner(modes, scene, schedule, Asked(np.linspace(*ends, n_intervals), repeats))


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
