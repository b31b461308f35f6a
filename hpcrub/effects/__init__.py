"""The physical effects that an input may have, one module each; how to add one: `effect`."""

from collections.abc import Iterator

from hpcrub.config.schema import Config
from hpcrub.effects import air, casing_motion, coating, stress
from hpcrub.effects.effect import EFFECTS, Effect
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding

__all__ = ["EFFECTS", "air", "casing_motion", "coating", "findings", "lines", "of", "stress"]


def of(config: Config) -> list[Effect]:
    """Effects that an input has."""
    return [effect for effect in EFFECTS if effect.exists(config)]


def lines(file: ResultFile, disk: int = 0) -> Iterator[str]:
    """Lines about all effects of an input, for the summary; disk: of a study of whole motions."""
    return (line for effect in of(file.config) for line in effect.lines(file, disk))


def findings(file: ResultFile) -> Iterator[Finding]:
    """Findings of all effects of an input, for the verdict."""
    return (finding for effect in of(file.config) for finding in effect.findings(file))
