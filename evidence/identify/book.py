"""The file of evaluations: one line of JSON each, so that nothing that was computed is lost.

The search is a deterministic sequence of evaluations. To go on with one that was stopped is to run
it again: what the book holds is read instead of computed.
"""

import json
import multiprocessing
import time

from evidence.identify import conclusions, disks, paper, predictions, shapes, stages

COMPUTE = {name: getattr(stages, name) for name in ("band", *paper.STAGES)}
COMPUTE["line"] = lambda disk, _draw: {"disk": shapes.with_peak(disk)}
COMPUTE |= {"conclusions": conclusions.measure, "predictions": predictions.measure}


class BudgetSpentError(Exception):
    """The time given is over; the same command goes on from here."""


class Book:
    """Evaluations of a search, in a file that only grows."""

    def __init__(self, path, n_cores=1, seconds=float("inf")):
        """Open or begin a file.

        Parameters
        ----------
        path : Path
        n_cores : int
            Evaluations computed side by side, each on one core.
        seconds : float
            Time given [s]; no evaluation begins later.

        Raises
        ------
        ValueError
            The file was written with other settings, so its numbers do not compare with new ones.
        """
        self.path = path
        self.give(seconds)
        self.spent, self.lines = 0.0, {}
        self.pool = multiprocessing.get_context("spawn").Pool(n_cores) if n_cores > 1 else None
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            self._read()
        else:
            self._append({"settings": settings()})

    def give(self, seconds):
        """Time from now [s]; no evaluation begins later."""
        self.end = time.monotonic() + seconds

    def measure(self, tasks):
        """What is found at every task, in their order.

        Parameters
        ----------
        tasks : list of (str, Dimensions, int)
            Stage, disk and draw.

        Returns
        -------
        list of dict

        Raises
        ------
        BudgetSpentError
        """
        missing = list(dict.fromkeys(task for task in tasks if task not in self.lines))
        run = self.pool.imap_unordered if self.pool else map
        for answer in run(_compute, self._until_the_end(missing)):
            self._append(answer)
            self._take(answer)
        return [self.lines[task] for task in tasks]

    def of(self, stage, draw=0):
        """All disks that a stage was computed of, with what was found: {Dimensions: dict}."""
        return {disk: found for (name, disk, number), found in self.lines.items()
                if (name, number) == (stage, draw)}  # fmt: skip

    def _until_the_end(self, tasks):
        for task in tasks:
            if time.monotonic() > self.end:
                raise BudgetSpentError
            yield task

    def _take(self, line):
        disk = disks.Dimensions(*line["disk"])
        self.lines[line["stage"], disk, line["draw"]] = line["found"]
        self.spent += line["seconds"]

    def _append(self, line):
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")

    def _read(self):
        text = self.path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        if whole != text:  # the program was ended while it wrote its last line
            self.path.write_text(whole, encoding="utf-8")
        head, *lines = map(json.loads, whole.splitlines())
        if head != json.loads(json.dumps({"settings": settings()})):
            raise ValueError(f"{self.path}: of a search with other settings; give another folder")
        for line in lines:
            self._take(line)


def settings():
    """All that the numbers of a stage depend on besides the disk and the draw."""
    return {
        "seed": stages.SEED,
        "speeds_hz": {n: [s[0], s[-1], len(s)] for n, s in stages.SPEEDS.items()},
        "longest_s": stages.LONGEST,
        "smooth": [stages.FINE, stages.COARSE, stages.FEWER_MODES],
        "samples": [stages.N_LINEAR, stages.N_TUNED, stages.N_PATTERN, stages.N_SAMPLES],
        "conclusions": conclusions.N_SAMPLES,
    }


def _compute(task):
    stage, disk, draw = task
    began = time.perf_counter()
    found = COMPUTE[stage](disk, draw)
    found = json.loads(json.dumps(found, default=lambda number: number.tolist()))
    return {"stage": stage, "disk": list(disk), "draw": draw, "found": found,
            "seconds": round(time.perf_counter() - began, 3)}  # fmt: skip
