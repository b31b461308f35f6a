"""Lanes on a coating that wears: they are looked at all the time, and not before checks alone."""

import numpy as np

from hpcrub.response.band import Band


class CoatedBand(Band):
    """A band whose amplitudes and worn depths count from the start."""

    def _next_event(self, now):
        """All lanes record, and each one's coating is looked at after each of its windows."""
        running = [course for _, course in self._running()]
        checks = [course.check for course in running]
        kept = [now + self.window - (now - course.start) % self.window for course in running]
        return True, min(checks + kept)

    def _watched(self, now):
        """All running lanes."""
        running = self._running() if self.scene.observes_stress else []
        return np.array([lane for lane, _ in running], dtype=np.int64)

    def _follow(self, now, until):
        """See the amplitudes of all blocks; keep the coating at the end of a lane's own windows."""
        places = np.arange(now, until) % (2 * self.window)
        peak = self.record.peak.reshape(2 * self.window, -1, len(self.lanes))[places]
        peak = peak[:, : len(self.modes.observed)].max(axis=1)
        for lane, course in self._running():
            for block, size in zip(range(now + 1, until + 1), peak[:, lane], strict=True):
                course.watch.see(size, course.seconds(block))
            if (until - course.start) % self.window == 0:
                self._keep(lane, course, until)

    def _keep(self, lane, course, now):
        revolutions = (now - course.start) // self.grid.blocks_per_revolution
        course.watch.keep(revolutions, self.bank.law.surface.worn_depth(lane))

    def _conclude(self, lane, course, now, out):
        """What became of the coating (out is modified)."""
        self._keep(lane, course, now)
        course.watch.write(course.index, out.wear)
