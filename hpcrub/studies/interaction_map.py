"""Spectra of the tips over a wide range of speeds: which engine order meets which mode."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY, POINT_REASON, POINT_STATUS, STEADY
from hpcrub.effects.effect import History
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution
from hpcrub.results.layout import SPEEDS, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs.study import Poll, Values
from hpcrub.setup.disks import fixed_disks, own_modes_of
from hpcrub.setup.problem import scene_of
from hpcrub.statistics.percentiles import Z_95
from hpcrub.studies.contact.trials import bent_table
from hpcrub.studies.shared.motions import Motions

_DS = ("disk", "speed")
LAYOUT = (
    SPEEDS,
    Dataset("frequencies_hz", ("frequency",), "Hz", "frequencies of the spectra"),
    Dataset("deviation", ("disk", "blade"), "1", "stiffness deviations: tuned disk, then pattern"),
    Dataset("natural_frequencies_hz", ("disk", "mode"), "Hz", "frequencies without contact"),
    Dataset("spectrum_m", (*_DS, "frequency"), "m", "tangential amplitude, largest of all tips"),
    Dataset("amplitude_m", _DS, "m", "largest tangential displacement within the window"),
    Dataset("point_reason", _DS, "1", f"{POINT_REASON}; where diverged, values are NaN", "u1"),
    Dataset("point_status", _DS, "1", POINT_STATUS, "u1"),
    Dataset("mean_amplitude_m", _DS, "m", "amplitude, as in a contact study"),
    Dataset("mean_error_m", _DS, "m", "its standard error; NaN: unknown"),
    *bent_table("disk"),
)
_OF_MODEL = "the same at each speed; of a model file, whose stiffness depends on it"
AT_SPEED = Dataset("natural_frequencies_at_speed_hz", (*_DS, "mode"), "Hz", _OF_MODEL)
DISKS = "tuned disk", "pattern"
SPECTRUM_RECORDS = 16  # fewest records in a window whose spectrum is computed


def spectrum(signals: np.ndarray, interval: float, wanted: Any) -> np.ndarray:
    """Amplitudes of the harmonic parts of signals, without their means.

    signals: (T, n); interval: between two values [s]; wanted: has step_hz and n_frequencies.
    Returns amplitudes (n, F) [as the signals] at 0, step_hz, ..., through a Hann window.
    """
    from scipy.signal import windows, zoom_fft  # its import takes a second, no other study needs it

    window = windows.hann(len(signals), sym=False)
    top = wanted.step_hz * wanted.n_frequencies
    moving = (signals - signals.mean(axis=0)).T * window
    transform = zoom_fft(moving, [0.0, top], m=wanted.n_frequencies, fs=1.0 / interval)
    return 2.0 * np.abs(transform) / window.sum()


def _frequencies(config: Config, prepared: Any, disk: int, group: np.ndarray) -> Iterator[Values]:
    """Natural frequencies of a disk, and at the speeds of a group where they depend on these."""
    blades, rubbing = fixed_disks(config)[disk], prepared.modes[disk]
    own = own_modes_of(config, prepared.problem, rubbing, blades)
    if group.min() == 0:
        yield "natural_frequencies_hz", disk, own.omega / (2 * np.pi)
    if config.disk.model is not None:
        for speed in group:
            there = own.omega_at(2 * np.pi * config.speeds.values_hz[speed])
            yield AT_SPEED.name, (disk, speed), there / (2 * np.pi)


class InteractionMap(Motions):
    """Spectra over a wide range of speeds."""

    name = "interaction_map"
    what = "spectra over a wide range of speeds"
    sections = ("history", "spectrum")
    scales = {"frequency": "frequencies_hz"}
    amplitude = "mean_amplitude_m"

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets for a planar disk or a model file, and for a coating."""
        of_model = () if config.disk.model is None else (AT_SPEED,)
        return *LAYOUT, *of_model, *self.of_effects(config)

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {"frequency": config.spectrum.n_frequencies, "disk": len(fixed_disks(config))}

    def constants(self, config: Config) -> dict[str, Any]:
        """Frequencies of the spectra, and stiffness deviations of the disks."""
        return {
            "frequencies_hz": config.spectrum.step_hz * np.arange(config.spectrum.n_frequencies),
            "deviation": fixed_disks(config),
        }

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        lowest = config.speeds.from_hz
        grid = cut_revolution(lowest, scene_of(config))
        longest = grid.kept / (lowest * grid.steps_per_revolution)  # between two records [s]
        if config.spectrum.window_s > config.history.duration_s:
            yield (
                f"spectrum.window_s: {config.spectrum.window_s} is more than "
                f"history.duration_s, {config.history.duration_s}"
            )
        elif config.spectrum.window_s < (needed := SPECTRUM_RECORDS * longest):
            yield (
                f"spectrum.window_s: {config.spectrum.window_s} s hold fewer than "
                f"{SPECTRUM_RECORDS} recorded displacements; at least {needed:.2g} s are needed"
            )
        elif config.casing.growth_time > config.history.duration_s - config.spectrum.window_s:
            yield (
                f"casing.growth_time_s: the bumps still grow in the last "
                f"{config.spectrum.window_s} s of history.duration_s, {config.history.duration_s}"
            )

    def compute(self, config: Config, prepared: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Compute the spectra of one disk at a group of speeds, or why speeds have diverged."""
        scene, groups = prepared.problem.scene, history.groups(config.speeds.values_hz)
        disk, number = divmod(task, len(groups))
        modes, group = prepared.modes[disk], groups[number]
        speeds, duration = config.speeds.values_hz[group], config.history.duration_s
        followers, parts = [history.Follower(modes, scene, at, duration) for at in speeds], []
        for piece in history.integrate(modes, scene, speeds, duration, poll=poll):
            for lane, follower in enumerate(followers):
                follower.take(piece, lane)
            touching = scene.interface.of_points(np.swapaxes(piece.normal_force > 0.0, 1, 2))
            parts.append((piece.time, piece.observed, touching, piece.reason))
        *values, reasons = zip(*parts, strict=True)
        time, tips, touching = map(np.concatenate, values)
        yield from _frequencies(config, prepared, disk, group)
        for lane, (speed, follower) in enumerate(zip(group, followers, strict=True)):
            # a group is integrated as long as its fastest speed needs; no speed depends on others
            end = history.n_records(speeds[lane], duration, scene)
            interval = time[1, lane] - time[0, lane]
            last = slice(end - round(config.spectrum.window_s / interval), end)
            window, share = tips[last, :, lane], touching[last, lane].mean(axis=0)
            reason = follower.doubt(reasons[end * len(reasons) // len(time) - 1][lane], share)
            yield "point_reason", (disk, speed), reason
            yield "point_status", (disk, speed), DIVERGED
            if status.are_fatal(reason):
                continue
            yield "point_status", (disk, speed), follower.verdict.status
            yield "mean_amplitude_m", (disk, speed), follower.verdict.amplitude
            yield "mean_error_m", (disk, speed), follower.verdict.error
            motion = History(modes, scene, speeds[lane], partial(getattr, follower, "wear"))
            for effect in effects.of(config):
                for name, value in effect.of_history(self.name, motion):
                    yield name, (disk, speed), value
            spectra = spectrum(window, interval, config.spectrum)
            yield "spectrum_m", (disk, speed), spectra.max(axis=0)
            yield "amplitude_m", (disk, speed), np.abs(window).max()

    def report(self, file: ResultFile) -> Iterator[str]:
        """Points of every disk without a result, and its strongest interaction."""
        speeds, frequencies = file.read("speeds_hz"), file.read("frequencies_hz")
        for disk, name in enumerate(DISKS[: len(file.read("deviation"))]):
            amplitude, reason = file.read("amplitude_m", disk), file.read("point_reason", disk)
            for line in status.lines(status.count(reason), len(reason)):
                yield f"{name}: {line}"
            if not np.isfinite(amplitude).any():
                continue
            names = "point_status", "mean_amplitude_m", "mean_error_m"
            states, mean, error = (file.read(each, disk) for each in names)
            steady, averaged, lost = (states == s for s in (STEADY, AVERAGED, NOT_STEADY))
            text = f"of {len(states)} points {steady.sum()} are steady, {averaged.sum()} averaged"
            if averaged.any():
                text += f", means known to {100 * np.median((error / mean)[averaged]):.1f} %"
            draws = ", each one draw of many" if lost.any() else ""
            yield f"{name}: {text}, {lost.sum()} not steady{draws}"
            known = steady | averaged
            amplitude = np.where(known, mean, amplitude)
            error = np.where(known, np.nan_to_num(error), 0.0)
            best = int(np.nanargmax(amplitude))
            line = frequencies[file.read("spectrum_m", (disk, best)).argmax()]
            interval = f" ± {1e3 * Z_95 * error[best]:.1f}" if error[best] else ""
            yield (
                f"{name}: largest amplitude {1e3 * amplitude[best]:.1f}{interval} mm "
                f"at {speeds[best]:.4g} Hz, mostly at {line:.4g} Hz, "
                f"{line / speeds[best]:.2f} per turn"
            )
            yield from (f"{name}: {line}" for line in effects.lines(file, disk))


STUDY = InteractionMap()
