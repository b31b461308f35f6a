"""Lanes on a coating that wears: they are looked at all the time, and not before checks alone."""

import numpy as np

from hpcrub.response.band import Band


class CoatedBand(Band):
    """A band whose amplitudes and worn depths count from the start."""

    def _next_event(self, now):
        """All lanes record, and each one's coating is looked at after each of its windows."""
        running = self._running()
        checks = [self.check[lane] for lane in running]
        starts = [self.start[lane] for lane in running]
        kept = [s + ((now - s) // self.window + 1) * self.window for s in starts]
        return True, min(checks + kept)

    def _watched(self, now):
        """All running lanes."""
        return np.array(self._running() if self.scene.observes_stress else [], dtype=np.int64)

    def _follow(self, now, until):
        """See the amplitudes of all blocks; keep the coating at the end of a lane's own windows."""
        places = np.arange(now, until) % (2 * self.window)
        peak = self.record.peak.reshape(2 * self.window, -1, len(self.speed))[places]
        peak = peak[:, : len(self.modes.observed)].max(axis=1)
        for lane in self._running():
            for block, size in zip(range(now + 1, until + 1), peak[:, lane], strict=True):
                self.watch[lane].see(size, self._seconds(lane, block))
            if (until - self.start[lane]) % self.window == 0:
                self._keep(lane, until)

    def _keep(self, lane, now):
        revolutions = (now - self.start[lane]) // self.grid.blocks_per_revolution
        self.watch[lane].keep(revolutions, self.bank.law.surface.worn_depth(lane))

    def _conclude(self, lane, now, out):
        """What became of the coating (out is modified)."""
        self._keep(lane, now)
        self.watch[lane].write(self.speed[lane], out.wear)
