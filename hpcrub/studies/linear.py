"""Linear amplification of many samples under engine-order excitation.

One eigenproblem per sample serves all its loads, so that the samples of all nodal diameters are
the same. A contact study with the same seed and levels has these samples, too. Where the stiffness
depends on the speed, every load has modes of its own: those of the speed at which it is largest.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.effects.effect import Load
from hpcrub.errors import InputError
from hpcrub.model import crossings
from hpcrub.model.imported import cyclic
from hpcrub.response.linear import linear_peak
from hpcrub.results.layout import LEVELS, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Poll, Study, Values
from hpcrub.setup.aero import in_air
from hpcrub.setup.disks import deviation, modes_of, sigma_of
from hpcrub.setup.problem import Model, build_model
from hpcrub.statistics.percentiles import finite, interval_in_words, with_interval

ROUNDING = 1e-9  # share of the radial displacement below which a tangential one is rounding
CHUNK = 50  # samples of a level that make a task
_VDN = ("level", "n_diameters", "sample")
LAYOUT = (
    *LEVELS,
    Dataset("n_diameters", ("n_diameters",), "1", "nodal diameters of the load", "i8"),
    Dataset("tuned/amplitude_m", ("n_diameters",), "m", "tangential amplitude of the tuned disk"),
    Dataset("tuned/speed_hz", ("n_diameters",), "Hz", "speed at which it is reached"),
    Dataset("amplification", _VDN, "1", "linear amplitude over the tuned disk's"),
)


def _chunks(config: Config) -> Any:
    return -(-config.mistuning.samples // CHUNK)


def _loads(config: Config, model: Model) -> list[Load]:
    """Every load, of `model` itself where its stiffness does not change."""
    reduced, loads = model.reduced, []
    diameters = cyclic.tuned_diameters(reduced)
    for order in config.linear.n_diameters:
        hz = crossings.of_disk(reduced, diameters, order) if reduced.stiffening else np.nan
        speed = None if np.isnan(hz) else 2.0 * np.pi * hz
        there = model if speed is None else model._replace(reduced=in_air(config, reduced, speed))
        loads.append(Load(there, speed, order))
    return loads


def _modes(config: Config, loads: list[Load], blades: Any) -> list[Any]:
    """Modes of one disk for every load; the same ones where the stiffness does not change."""
    found = {}
    for model, speed, _ in loads:
        if speed not in found:
            found[speed] = modes_of(config, model, blades, speed)
    return [found[load.speed] for load in loads]


def _peaks(
    config: Config, loads: list[Load], modes: Any, blades: Any, observed: str = "observed"
) -> Any:
    """Largest amplitude [m] and its speed [Hz] under every load, (D, 2)."""

    def at(model: Any, speed: Any) -> Any:
        modes = modes_of(config, model, blades, speed)
        return modes._replace(observed=getattr(modes, observed))

    return np.array([
        linear_peak(
            of_load._replace(observed=getattr(of_load, observed)), config.damping,
            config.forcing.amplitude, config.forcing.sense * load.n_diameters,
            load.model.reduced.interface, config.disk.n_blades, partial(at, load.model),
        )
        for load, of_load in zip(loads, modes, strict=True)
    ])  # fmt: skip


class Linear(Study):
    """Linear amplification of many samples."""

    name = "linear"
    what = "linear amplification, percentiles over σ and n_d"
    sections = ("linear",)
    scales = {"level": "half_range"}
    datasets = LAYOUT

    def loads(self, config: Config) -> tuple[int, ...]:
        """Nodal diameters of all loads."""
        return config.linear.n_diameters

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {"n_diameters": len(config.linear.n_diameters)}

    def constants(self, config: Config) -> dict[str, Any]:
        """The levels and the loads."""
        return {
            "half_range": config.mistuning.half_range,
            "sigma": sigma_of(config),
            "n_diameters": config.linear.n_diameters,
        }

    def n_tasks(self, config: Config) -> int:
        """One task for every chunk of samples, level by level."""
        return len(config.mistuning.half_range) * _chunks(config)

    def cost(self, config: Config) -> Cost:
        """Cost of an eigenproblem for every sample, without time steps."""
        return Cost(disks=len(config.mistuning.half_range) * config.mistuning.samples)

    def prepare(self, config: Config) -> tuple[list[Load], np.ndarray]:
        """All loads, and the tuned disk's peaks, amplitude [m] and speed [Hz] (D, 2).

        Raises InputError for a disk that is hardly excited.
        """
        loads, alike = _loads(config, build_model(config)), np.zeros(config.disk.n_blades)
        modes = _modes(config, loads, alike)
        tuned = _peaks(config, loads, modes, alike)
        radial = _peaks(config, loads, modes, alike, "normal")
        lost = np.flatnonzero(tuned[:, 0] < ROUNDING * radial[:, 0])
        if lost.size:
            raise InputError(
                f"linear.n_diameters: under {config.linear.n_diameters[lost[0]]} diameters the "
                "tips of the tuned disk move radially only, and amplitudes are tangential"
            )
        return loads, tuned

    def compute(self, config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Compute the amplifications of a chunk of samples of one level."""
        loads, tuned = problem
        level, chunk = divmod(task, _chunks(config))
        samples = range(chunk * CHUNK, min((chunk + 1) * CHUNK, config.mistuning.samples))
        amplification, of_first = np.full((len(tuned), len(samples)), np.nan), []
        for i, sample in enumerate(samples):
            blades = deviation(config, level, sample)
            modes = _modes(config, loads, blades)
            of_first.append(modes[0])
            peaks = _peaks(config, loads, modes, blades)
            known = np.isfinite(peaks[:, 0] + tuned[:, 0])  # a disk in flutter has no response
            amplification[known, i] = peaks[known, 0] / tuned[known, 0]
            poll()
        for effect in effects.of(config):
            yield from effect.of_samples(level, samples.start, of_first)
            for name, values in effect.of_model(self.name, config, loads) if task == 0 else ():
                yield name, (), values
        if task == 0:
            yield "tuned/amplitude_m", (), tuned[:, 0]
            yield "tuned/speed_hz", (), tuned[:, 1]
        where = level, slice(None), slice(samples.start, samples.stop)
        yield "amplification", where, amplification

    def report(self, file: ResultFile) -> Iterator[str]:
        """Effects, and percentiles at every level and load."""
        yield from effects.lines(file)
        names = "/".join(f"{p:g}" for p in file.config.convergence.percentiles)
        yield f"percentiles {names} of the linear amplification, interval of the last"
        for d, n_diameters in enumerate(file.read("n_diameters")):
            for level, sigma in enumerate(file.read("sigma")):
                every = file.read("amplification", (level, d))
                values, lost = finite(every), int(np.count_nonzero(np.isnan(every)))
                if len(values) == 0:
                    continue
                middle, low, high = with_interval(values, file.config.convergence.percentiles)
                text = " / ".join(f"{value:.3f}" for value in middle)
                text += f"  [{interval_in_words(low[-1], high[-1])}]"
                text += f", without {counted(lost, 'disk')} that flutter" if lost else ""
                yield f"n_d = {n_diameters}, sigma = {100 * sigma:.2f} %: {text}"

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Percentiles that need more samples; no grid of speeds could miss a peak."""
        yield from findings.too_few_samples(
            file.config.convergence.percentiles, file.config.mistuning.samples
        )


STUDY = Linear()
