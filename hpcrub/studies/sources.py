"""Where the samples of a study come from: the disks of its input, or an earlier result file."""

import hashlib
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError
from hpcrub.model.reduction import Modes
from hpcrub.response.sweep import Scene
from hpcrub.results.layout import DONE, PENDING
from hpcrub.studies.files import open_result
from hpcrub.studies.problem import build_problem, modes_of

PHYSICS = ("disk", "material", "reduction", "casing", "contact", "speeds", "time", "steady_state")
USED = (
    "sigma",
    "tuned/reference_amplitude_m",
    "samples/status",
    "samples/deviation",
    "samples/amplification",
    "samples/linear_amplification",
)


def disks(config):
    """Stiffness deviations (D, N): the tuned disk, and the pattern when there is one."""
    tuned = np.zeros(config.disk.n_blades)
    pattern = config.pattern_deviation
    return np.array([tuned] if pattern is None else [tuned, pattern])


class DiskProblem(NamedTuple):
    """What simulations of the disks of an input need."""

    config: Config
    scene: Scene
    modes: list[Modes]  # of every disk


def prepare_disks(config):
    """DiskProblem of a configuration. Raises InputError as `build_problem`."""
    problem = build_problem(config)
    modes = [modes_of(config, problem, deviation) for deviation in disks(config)]
    return DiskProblem(config, problem.scene, modes)


def time_grid(config):
    """What `sweep.cut_revolution` needs of a Scene, before there is a model."""
    return SimpleNamespace(step=config.time.step, n_bumps=config.casing.n_bumps)


def amplifications(path):
    """A_nl and A_lin of every sample of a contact study, (V, n) each, NaN where not done.

    Raises InputError for a file that is not a complete contact study.
    """
    file = complete(path)
    done = file.status() == DONE
    names = "samples/amplification", "samples/linear_amplification"
    values = [np.where(done, file.read(name), np.nan) for name in names]
    file.close()
    return values


def fingerprint(path):
    """Checksum of all that a study may have from a contact study, in hexadecimal digits.

    Raises InputError as `complete`.
    """
    file = complete(path)
    digest = hashlib.sha256(str(file.config.material.damping_ratio).encode())
    for name in USED:
        digest.update(np.ascontiguousarray(file.read(name)).tobytes())
    file.close()
    return digest.hexdigest()


def complete(path, config=None):
    """The open ResultFile of a complete contact study, with the same physics as `config`.

    Raises InputError, naming what is wrong with it.
    """
    file = open_result(path)
    if file.config.study != "contact":
        raise InputError(f"sources: {path} is of the study {file.config.study}, not contact")
    if file.config.is_part:
        raise InputError(f"sources: {path} is a part; merge all parts (python -m hpcrub merge)")
    n_pending = int(np.count_nonzero(file.status() == PENDING))
    if n_pending and not file.config.convergence.stop_when_converged:
        raise InputError(f"sources: {path} still lacks {n_pending} samples; --resume its study")
    if config is not None:
        other = [d for d in differences(file.config, config) if d.split(".")[0] in PHYSICS]
        if other:
            raise InputError(f"sources: {path} has {'; '.join(other)}")
    return file
