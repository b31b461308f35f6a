"""The C program that the kernel's speed is compared with computes the same motion."""

import numpy as np
import pytest

from evidence.benchmarks import spatial_speed
from evidence.benchmarks.kernel_speed import Lanes

SPEED = 214.0  # [Hz]
N_BLOCKS = 12


def test_the_c_program_in_three_dimensions_finds_the_motion_of_the_kernel():
    modes, scene = spatial_speed.blisk(n_points=12, n_modes=60)
    lanes = Lanes(modes, scene, 8, speeds=(SPEED, SPEED), warm=N_BLOCKS)
    n_steps = N_BLOCKS * lanes.grid.steps_per_block
    own = np.abs(modes.tangential @ lanes.bank.state.position[: len(modes.omega), 0]).max()
    assert (lanes.bank.state.multiplier > 0.0).any()
    _, largest, failed = spatial_speed.plain_c(lanes, SPEED, n_steps)
    assert failed == 0
    assert largest == pytest.approx(own, rel=1e-8)
