"""Linear analysis of a casing that vibrates: its waves, and permanent contact of all tips."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model import crossings
from hpcrub.model.casing_modes import CasingModes
from hpcrub.model.crossings import MEETINGS, N_FAMILIES
from hpcrub.model.imported import cyclic
from hpcrub.model.reduction import Modes, ReducedModel, mistuned_modes
from hpcrub.response.casing_stability import growth
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.setup.casing import casing_modes_of

REACH = 10.0  # times the highest speed of the input: interactions are stored up to there
SHOWN = 1.5  # times the highest speed of the input: report and figures go up to there
N_SPEEDS = 90  # speeds at which the growth in permanent contact is computed
LAYOUT = (
    Dataset("casing/waves", ("casing_mode",), "1", "waves n around the casing", "i8"),
    Dataset("casing/frequencies_hz", ("casing_mode",), "Hz", "its natural frequency f_c"),
    Dataset("casing/critical_speed_hz", ("casing_mode",), "Hz", "speed f_c/n of its travel"),
    Dataset(
        "casing/interaction_hz", ("casing_mode", "family", "sum_or_difference"), "Hz",
        "speeds at which n times the speed is f_c + f_b, or |f_c - f_b|, f_b of a family of blades "
        "with the nodal diameters that n waves fold to; nan: never, or far above",
    ),
    Dataset("casing/blades_hz", ("casing_mode", "family"), "Hz", "this f_b, at the highest speed"),
    Dataset("casing/speed_hz", ("stability",), "Hz", "speeds at which permanent contact is judged"),
    Dataset(
        "casing/growth_per_s", ("friction", "stability"), "1/s",
        "fastest growth in permanent contact of all tips; without friction, then with it",
    ),
    Dataset("casing/growing_waves", ("friction", "stability"), "1", "its n that moves most", "i8"),
    Dataset("casing/growing_hz", ("friction", "stability"), "Hz", "its frequency, from the rotor"),
)  # fmt: skip


def permanent_growth(config: Config, modes: Modes, speeds_hz: np.ndarray) -> np.ndarray:
    """Growth of the linear disk and casing, which vibrates, in permanent contact at speeds (S,).

    modes: Modes of the tuned disk. Returns rates [1/s], waves that move most, and frequencies seen
    from the rotor [Hz], (3, 2, S): each without friction, then with it.
    """
    found = [
        [growth(modes.at(speed), config.damping, friction, speed) for speed in speeds_hz]
        for friction in (0.0, config.contact.friction)
    ]
    return np.moveaxis(np.array(found), -1, 0)


def sizes(config: Config) -> dict[str, int]:
    """Lengths of the dimensions of these datasets."""
    casing = config.casing
    n_pairs = len(casing.modes) if casing.ring.thickness_mm is None else len(casing.ring.waves)
    kinds = {"family": N_FAMILIES, "sum_or_difference": len(MEETINGS), "friction": 2}
    return kinds | {"casing_mode": n_pairs, "stability": N_SPEEDS}


def interactions(config: Config, reduced: ReducedModel, casing: CasingModes) -> np.ndarray:
    """Speeds at which waves of the casing meet blades, as of `crossings.interactions` [Hz]."""
    highest = 2.0 * np.pi * REACH * config.speeds.to_hz
    speeds = crossings.interactions(reduced, cyclic.tuned_diameters(reduced), casing, highest)
    return speeds / (2.0 * np.pi)


def values(config: Config, reduced: ReducedModel) -> Iterator[tuple[str, Any]]:
    """Yield (name, values) of waves, interaction speeds and growth rates."""
    casing = casing_modes_of(config)
    assert casing is not None  # it vibrates
    yield "casing/waves", casing.n_waves
    yield "casing/frequencies_hz", casing.omega / (2.0 * np.pi)
    yield "casing/critical_speed_hz", casing.critical_speeds / (2.0 * np.pi)
    yield "casing/interaction_hz", interactions(config, reduced, casing)
    yield "casing/blades_hz", _blades(reduced, casing, config.speeds.to_hz)
    speeds = np.linspace(0.0, SHOWN * config.speeds.to_hz, N_SPEEDS + 1)[1:]
    modes = mistuned_modes(reduced._replace(casing=casing), np.zeros(config.disk.n_blades))
    rates, waves, frequencies = permanent_growth(config, modes, speeds)
    yield "casing/speed_hz", speeds
    yield "casing/growth_per_s", rates
    yield "casing/growing_waves", waves
    yield "casing/growing_hz", frequencies


def _blades(reduced: ReducedModel, casing: Any, speed_hz: Any) -> Any:
    """Frequencies of blades that waves of the casing can meet (casing modes, families) [Hz]."""
    diameters, speed = cyclic.tuned_diameters(reduced), 2.0 * np.pi * speed_hz

    def frequency(n: Any, family: Any) -> Any:
        folded = crossings.folded(int(n), reduced.interface.n_blades)
        blades = crossings.family_frequency(reduced, diameters, folded, family)
        return blades(speed) / (2.0 * np.pi) if blades else np.nan

    return np.array([[frequency(n, f) for f in range(N_FAMILIES)] for n in casing.n_waves])


def lines(config: Config, casing: CasingModes, found: np.ndarray) -> Iterator[str]:
    """Lines about the waves of the casing: where they meet blades, which the rotor overtakes.

    found: speeds as `interactions` returns them [Hz].
    """
    critical, highest = casing.critical_speeds / (2.0 * np.pi), config.speeds.to_hz
    for j, n in enumerate(casing.n_waves):
        text = f"casing, n = {n}: {casing.omega[j] / (2.0 * np.pi):.4g} Hz"
        if n:
            text += f", travels at {critical[j]:.4g} Hz"
        meets = [
            f"family {family + 1} at {found[j, family, k]:.4g} Hz ({kind})"
            for family in range(N_FAMILIES)
            for k, kind in enumerate(MEETINGS)
            if found[j, family, k] <= SHOWN * highest
        ]
        yield text + (f", meets {', '.join(meets)}" if meets else "")
    overtaken = casing.n_waves[critical < highest]
    if len(overtaken):
        yield (
            f"casing: from {critical.min():.4g} Hz on the rotor overtakes waves of the casing (n = "
            f"{', '.join(map(str, overtaken))}); contact feeds these, and motions may grow"
        )
    else:
        yield f"casing: no wave is overtaken up to {critical.min():.4g} Hz"


def report(file: ResultFile) -> Iterator[str]:
    """Lines about the waves, and about the speed from which permanent contact is unstable."""
    config, read, casing = file.config, file.read, casing_modes_of(file.config)
    assert casing is not None  # it vibrates
    yield from lines(config, casing, read("casing/interaction_hz"))
    speeds, rates = read("casing/speed_hz"), read("casing/growth_per_s")
    waves, friction = read("casing/growing_waves"), config.contact.friction
    moves = read("casing/growing_hz")
    for row, words in enumerate(("without friction", f"with a friction of {friction:g}")):
        grows = np.flatnonzero(rates[row] > 0.0)
        if len(grows):
            first, most = grows[0], grows[np.argmax(rates[row, grows])]
            since = f"from {speeds[first]:.3g} Hz on" if first else "at all speeds"
            yield (
                f"permanent contact of all tips, {words}: grows {since}, first by "
                f"{rates[row, first]:.3g} 1/s in a motion of {moves[row, first]:.3g} Hz seen from "
                f"the rotor; up to {speeds[-1]:.3g} Hz at most by {rates[row, most]:.3g} 1/s, at "
                f"{speeds[most]:.3g} Hz with n = {waves[row, most]}, in a motion of "
                f"{moves[row, most]:.3g} Hz"
            )
        else:
            yield f"permanent contact of all tips, {words}: decays up to {speeds[-1]:.3g} Hz"
