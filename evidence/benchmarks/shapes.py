"""Tiles and lanes of the kernel on the machine at hand: what the rule chose, and what is best."""

import os
import subprocess
import sys
import tempfile

from evidence.benchmarks import spatial_speed
from evidence.benchmarks.kernel_speed import Lanes, planar
from evidence.page import ROOT, table
from evidence.program import command
from hpcrub.contact.lanes import WIDTH
from hpcrub.contact.machine import LANES, shape, shape_of, this_machine

TILES = 12, 6, 4
ROUNDS = 5  # in turns, of which the best counts
FAR = 0.05  # of the best rate: farther from it the choice is marked
COLUMNS = "planar", "planar, recording", "three dimensions, recording"


def serve():
    """Print the rates of this process's shape [million steps/s] whenever a line comes in."""
    disk, blisk = Lanes(*planar(), WIDTH), spatial_speed.rubbing(*spatial_speed.blisk())
    for _ in sys.stdin:
        rates = disk.rate(), disk.rate(recording=True), blisk.rate(3, recording=True)
        print(*(rate / 1e6 for rate in rates), flush=True)


def start(shape_, folder):
    """A process of one shape that waits for a line."""
    environment = {"HPCRUB_SHAPE": "x".join(map(str, shape_)), "XDG_CACHE_HOME": folder}
    return subprocess.Popen(
        command(0, "-c", "from evidence.benchmarks import shapes; shapes.serve()"), bufsize=1,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT,
        env=os.environ | environment,
    )  # fmt: skip


def measured():
    """Best rates of every shape, of the columns of the table."""
    machine, chosen = this_machine(), shape()
    all_ = {shape_of(tile, lanes, machine) for tile in TILES for lanes in LANES}
    with tempfile.TemporaryDirectory() as folder:
        processes = {each: start(each, folder) for each in sorted(all_ | {chosen})}
        best = dict.fromkeys(processes, (0.0,) * len(COLUMNS))
        for _ in range(ROUNDS):
            for each, process in processes.items():
                process.stdin.write("\n")
                rates = map(float, process.stdout.readline().split())
                best[each] = tuple(map(max, best[each], rates))
        for process in processes.values():
            process.communicate()
    return best


def section():
    """Parts of the page: the table of shapes, and how far the choice is from the best."""
    rates, chosen = measured(), shape()
    rows = [
        [f"{each.tile} × {each.lanes}", *(f"{rate:.2f}" for rate in found),
         "the rule's" if each == chosen else ""]
        for each, found in sorted(rates.items(), reverse=True)
    ]  # fmt: skip
    lines = []
    for column, name in enumerate(COLUMNS):
        best = max(rates, key=lambda each, column=column: rates[each][column])
        behind = 1.0 - rates[chosen][column] / rates[best][column]
        words = f"{behind:.0%} behind the best, {best.tile} × {best.lanes}"
        lines.append([name, f"**{words}**" if behind > FAR else words])
    heads = ["tile × lanes", *COLUMNS, ""]
    return {"rates": table(heads, rows),
            "choice": table(["million steps/s", "the rule's choice"], lines)}  # fmt: skip
