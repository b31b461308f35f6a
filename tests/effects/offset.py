"""An effect that is no part of the package: the mean displacement of the tips."""

import numpy as np

from hpcrub.effects.effect import Change, Effect, Kind, Quantity, largest, times
from hpcrub.results.verdict import SINGLE, Finding


class Offset(Effect):
    """Mean displacement of the tip that is displaced most."""

    name = "offset"
    needed = "offsets"
    omitted = "No tip is dragged aside."
    points = (Quantity("offset_m", "m", "mean displacement of a tip, the largest of all tips"),)
    peaks = (Quantity("largest_offset_m", "m", "largest offset of any speed"),)
    kinds = (Kind("offset", "largest_offset_m", "m", "largest offsets"),)
    changes = (Change("twice the offset", "contact.friction", times({"contact.friction": 2.0})),)

    def exists(self, config):
        """Whether friction drags the tips."""
        return config.contact.friction > 0.0

    def observers(self, config):
        return {"offset_m": lambda end: float(np.abs(end.last.mean(axis=0)).max())}

    def of_disk(self, result, speeds_hz):
        return {"largest_offset_m": largest(result.observed["offset_m"], speeds_hz)[0]}

    def lines(self, file, disk):
        if file.config.study == "contact":
            yield f"tuned offset {1e3 * file.read('tuned/offset_m').max():.4g} mm"

    def findings(self, file):
        yield Finding(SINGLE, "an offset", "the tips have an offset")
