"""Rotor 67 in the modes of each sample and in the basis that samples share: steps, and samples."""

import os
import time
from unittest import mock

import numpy as np

from evidence.benchmarks.kernel_speed import best
from evidence.page import table
from hpcrub.config.schema import load_runs
from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.contact.lanes import WIDTH
from hpcrub.contact.observers import NOTHING, Record
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.sweep import Disk, run_sweeps
from hpcrub.setup.disks import deviation, rubbing_modes
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

INPUT = "inputs/rotor67/percentiles.yaml"
SPEEDS = np.linspace(256.0, 262.0, WIDTH)  # [Hz], of one rung
WARM, BLOCKS, TURNS = 40, 4, 20
SAMPLES = {(262, 262): 32, (258, 264): 16, (254, 268): 8}  # by the range of speeds [Hz]
BASES = "dense", "cyclic", "samples"
FAR = 1.0  # clearance that no blade reaches [m]


def problem(basis, **speeds):
    """Configuration and Problem of rotor 67 in a basis, dense or cyclic."""
    keys = [f"speeds.{key}={value}" for key, value in speeds.items()]
    config = resolved(load_runs(INPUT, keys)[0])
    with mock.patch.dict(os.environ, HPCRUB_BASIS=basis):
        return config, build_problem(config)


def banks():
    """Banks of both bases with and without contact, and of lanes with a sample each, by name."""
    found = {}
    for basis in ("dense", "cyclic"):
        config, built = problem(basis)
        level, grid = len(config.levels) - 1, cut_revolution(SPEEDS[0], built.scene)
        disks = [rubbing_modes(config, built, deviation(config, level, k)) for k in range(WIDTH)]
        for what, clearance in (("without contact", FAR), ("in contact", built.scene.clearance)):
            scene = built.scene._replace(clearance=clearance)
            found[what, basis] = allocate(disks[0], scene, grid, WIDTH, SPEEDS), grid
    lanes = allocate(disks[0], built.scene, grid, WIDTH, SPEEDS)
    for lane, (disk, speed) in enumerate(zip(disks, SPEEDS, strict=True)):
        step = 1.0 / (speed * grid.steps_per_revolution)
        fill_lane(lanes, lane, disk.at(speed), built.scene.at(speed), step)
    return found | {("in contact", "samples"): (lanes, grid)}


def steps():
    """Table: µs of a step of all lanes, without and while recording."""
    seconds, found = {}, banks()
    for bank, _ in found.values():
        run(bank, WARM)
    for _ in range(TURNS):  # in turns, as the machine's speed drifts
        for name, (bank, grid) in found.items():
            record = Record.allocate(bank, BLOCKS, grid.stride, grid.look)
            for recording, observer in ((False, NOTHING), (True, record)):
                key = *name, recording
                taken = best(lambda b=bank, o=observer: run(b, BLOCKS, o), 1)
                seconds[key] = min(
                    taken / (BLOCKS * grid.steps_per_block), seconds.get(key, np.inf)
                )
    rows = []
    for what in ("without contact", "in contact"):
        for recording in (False, True):
            cells = (seconds.get((what, basis, recording)) for basis in BASES)
            rows.append([what + ", recording" * recording,
                         *(f"{1e6 * s:.1f}" if s else "" for s in cells)])  # fmt: skip
    heads = f"µs of a step of {WIDTH} lanes", "dense", "shared", "lanes of different samples"
    return table(heads, rows)


def samples():
    """Table: processor time of a sample in both bases, where samples fill the lanes together."""
    rows = []
    for (low, high), n in SAMPLES.items():
        taken = []
        for basis, n_disks in (("dense", 3), ("cyclic", n)):
            config, built = problem(basis, from_hz=low, to_hz=high)
            disks = [Disk(rubbing_modes(config, built, deviation(config, 1, k)))
                     for k in range(n_disks)]  # fmt: skip
            groups = [disks] if basis == "cyclic" else [[disk] for disk in disks]
            speeds = config.speeds.values_hz
            list(run_sweeps(groups[0][:1], built.scene, speeds))  # compiles
            start = time.process_time()
            for group in groups:
                list(run_sweeps(group, built.scene, speeds))
            taken.append((time.process_time() - start) / n_disks)
        rows.append([f"{len(speeds)}", *(f"{s:.2f}" for s in taken), f"{taken[0] / taken[1]:.1f}"])
    return table(("speeds of a sample", "dense [s]", "shared [s]", "ratio"), rows)


def section():
    """Parts of the page."""
    return {"steps": steps(), "samples": samples()}
