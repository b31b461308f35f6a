"""What is computed of a disk, stage by stage: functions of (dimensions, draw) to numbers.

Draw 0 is what the search sees. Another draw takes other samples and other perturbed runs of the
same disk, and so tells how far the numbers of one disk scatter.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from evidence.identify import disks, paper
from hpcrub.config.schema import Config
from hpcrub.contact.status import STEADY
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.linear import linear_peak
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import WIDTH, run_sweep
from hpcrub.setup.problem import build_problem
from hpcrub.studies.contact.amplification import peak

SEED = 14
N_BLADES = len(paper.PATTERN)
HALF_RANGES = 0.01, 0.04  # of the levels σ = 0.6 and 2.3 %: equation (4)
LOAD = 150.0  # [N], section 2.3.2
# Speeds of every n_d [Hz], somewhat wider than where table 3 has the peaks, 0.5 % apart: so many
# that one pass of the kernel's lanes takes them all.
SPEEDS = {
    3: np.linspace(44.0, 47.9, WIDTH),
    4: np.linspace(33.2, 35.9, WIDTH),
    5: np.linspace(26.5, 28.6, WIDTH),
    6: np.linspace(21.7, 23.35, WIDTH),
}
PATTERN_SPEEDS = np.arange(33.5, 35.501, 0.05)  # table 3 and section 3.3
PERTURBATION = 1e-6  # of the stiffness: too little to matter, enough for another chaotic motion
LONGEST = 2.0  # [s] simulated; what is not steady by then keeps its amplitude
FINE, COARSE = 1e-6, 2e-5  # [s] steps whose responses are compared: the paper's, figure 9a
FEWER_MODES = 48  # figure 9b
N_LINEAR, N_TUNED, N_PATTERN, N_SAMPLES = 200, 5, 3, 16
LESS_DAMPING = 4e-3  # section 4.4


class Cloud(NamedTuple):
    """Amplifications of some samples of one disk, n_d and level."""

    contact: np.ndarray  # A_nl (n,) [-]
    linear: np.ndarray  # A_lin (n,) [-]
    speed: np.ndarray  # of the peaks of the contact response (n,) [Hz]


def band(dimensions, _draw):
    """The disk of the same shape that has the paper's band, if there is one: 0.1 s."""
    return {"disk": disks.in_band(dimensions)}


def geometry(dimensions, _draw):
    """Frequencies alone: milliseconds."""
    first = disks.family(disks.build(dimensions))
    highest = disks.reduced(dimensions).tuned_eigenvalues[-1]
    return {
        "lowest_hz": first[0],
        "highest_hz": first[-1],
        "reduced_highest_hz": np.sqrt(highest) / (2 * np.pi),
    }


def linear(dimensions, draw):
    """Linear amplifications at the highest level: a second."""
    reduced, scenes = disks.reduced(dimensions), [scene_of(n) for n in SPEEDS]
    modes = mistuned_modes(reduced, np.zeros(N_BLADES))
    tuned = [_linear(modes, scene) for scene in scenes]
    found = []
    for sample in range(N_LINEAR):
        deviation = stiffness_deviation(SEED + draw, 1, sample, N_BLADES, HALF_RANGES[1])
        modes = mistuned_modes(reduced, deviation)
        found.append([_linear(modes, scene) for scene in scenes])
    top = dict(zip(SPEEDS, np.percentile(np.array(found) / tuned, 99, axis=0), strict=True))
    return {
        "linear_99_4": top[4],
        "linear_3_below": max(top[4], top[5], top[6]) - top[3],
        "linear_6_above": top[6] - max(top[3], top[4], top[5]),
    }


def tuned(dimensions, draw):
    """Tuned peaks for every n_d, medians of perturbed runs: some seconds."""
    reduced = disks.reduced(dimensions)
    runs = {n: _tuned_runs(reduced, scene_of(n), draw) for n in SPEEDS}
    mm = {n: 1e3 * np.median(amplitude) for n, (amplitude, _) in runs.items()}
    return {
        **{f"peak_{n}_hz": np.median(speed) for n, (_, speed) in runs.items()},
        **{f"tuned_{n}_mm": value for n, value in mm.items()},
        "tuned_order": min(mm[3], mm[6]) / max(mm[4], mm[5]),
    }


def pattern(dimensions, draw):
    """The pattern of Table 2 in the order of blades that fits better: three seconds.

    The paper does not say whether its blades are numbered with or against the rotation.
    """
    reduced = disks.reduced(dimensions)
    printed, turned = (_pattern(reduced, p, draw) for p in (paper.PATTERN, paper.PATTERN[::-1]))
    better = paper.loss(turned, ("pattern",)) < paper.loss(printed, ("pattern",))
    return (turned if better else printed) | {"reversed": float(better)}


def _pattern(reduced, deviations, draw):
    """Numbers of one pattern, medians of perturbed runs."""
    scene = scene_of(4)
    found = []
    for run in range(N_PATTERN):
        modes = mistuned_modes(reduced, deviations + perturbation(draw, run, N_PATTERN))
        response = run_sweep(modes, scene, PATTERN_SPEEDS)
        mm, local = 1e3 * response.amplitude, 100 * response.localisation
        if not np.isfinite(mm).any():
            return {}
        best, most = np.nanargmax(mm), np.nanargmax(local)
        found.append((mm[best], PATTERN_SPEEDS[best], local[best], local[most],
                      PATTERN_SPEEDS[most], mm[most], np.nanmin(local),
                      _share_steady([response]), response.time.mean()))  # fmt: skip
    names = ("pattern_mm", "pattern_hz", "pattern_local", "most_local", "most_local_hz",
             "most_local_mm", "least_local", "pattern_steady", "pattern_time")  # fmt: skip
    return dict(zip(names, np.median(found, axis=0), strict=True))


def samples(dimensions, draw):
    """Random samples for four bumps at the lowest and highest level: some seconds."""
    responses = []
    low, high = amplifications(disks.reduced(dimensions), 4, draw, N_SAMPLES, seen=responses.append)
    return {
        "median_06": np.median(low.contact),
        "median_23": np.median(high.contact),
        "share_06": 100 * np.mean(low.contact > low.linear),
        "share_23": 100 * np.mean(high.contact > high.linear),
        "largest_23": np.max(high.contact),
        "samples_steady": _share_steady(responses),
        "samples_time": np.mean([response.time for response in responses]),
    }


def smooth(dimensions, draw):
    """How far the pattern's response depends on the step and on the modes kept: ten seconds.

    In the printed order.
    """
    disk = disks.build(dimensions)
    whole, fewer = (craig_bampton(disk, n) for n in (disks.N_MODES, FEWER_MODES))
    coarse = _pattern_response(whole, COARSE, draw)
    return {
        "step_change": _change(coarse, _pattern_response(whole, FINE, draw)),
        "modes_change": _change(coarse, _pattern_response(fewer, COARSE, draw)),
    }


def fine(dimensions, draw):
    """The tuned disk's response at the program's speeds, perturbed runs: two seconds."""
    reduced, scene = disks.reduced(dimensions), scene_of(4)
    responses = [
        run_sweep(
            mistuned_modes(reduced, np.full(N_BLADES, perturbation(draw, run, N_TUNED))),
            scene,
            PATTERN_SPEEDS,
        )
        for run in range(N_TUNED)
    ]
    mm, hz = np.array([peak(response, PATTERN_SPEEDS) for response in responses]).T
    return {
        "tuned_steady": _share_steady(responses),
        "peak_scatter": 100 * np.ptp(mm) / np.median(mm),
        "fine_mm": 1e3 * np.median(mm),
        "fine_hz": np.median(hz),
    }


def _pattern_response(reduced, step, draw):
    modes = mistuned_modes(reduced, paper.PATTERN + perturbation(draw, 0, N_PATTERN))
    return run_sweep(modes, scene_of(4)._replace(step=step), PATTERN_SPEEDS).amplitude


def _change(one, other):
    """Mean difference of two responses over the larger of their largest amplitudes [%]."""
    return 100 * np.nanmean(np.abs(one - other)) / max(np.nanmax(one), np.nanmax(other))


def _share_steady(responses):
    """Share of the points that are steady [%]."""
    return 100 * np.mean([response.point_status == STEADY for response in responses])


def amplifications(
    reduced, n_bumps, draw, n_samples, levels=(0, 1), damping_ratio=None, seen=lambda response: None
):
    """Contact and linear amplifications of random samples.

    Parameters
    ----------
    reduced : ReducedModel
    n_bumps : int
    draw : int
    n_samples : int
        Of every level.
    levels : sequence of int
        Places in `HALF_RANGES`.
    damping_ratio : float, optional
        Of every mode, tuned and mistuned [-]; the paper's if left out.
    seen : callable
        Takes the contact response of every sample.

    Returns
    -------
    list of Cloud
        One for every level.
    """
    scene = scene_of(n_bumps, damping_ratio)
    reference = np.median(_tuned_runs(reduced, scene, draw)[0])
    linear_reference = _linear(mistuned_modes(reduced, np.zeros(N_BLADES)), scene)
    found = []
    for level in levels:
        cloud = []
        for sample in range(n_samples):
            place = SEED + draw, level, sample
            modes = mistuned_modes(
                reduced, stiffness_deviation(*place, N_BLADES, HALF_RANGES[level])
            )
            response = run_sweep(modes, scene, SPEEDS[n_bumps])
            seen(response)
            amplitude, speed = peak(response, SPEEDS[n_bumps])
            above = _linear(modes, scene) / linear_reference
            cloud.append((amplitude / reference, above, speed))
        found.append(Cloud(*np.array(cloud).T))
    return found


def tuned_peak(reduced, n_bumps, draw):
    """Speed of the tuned disk's peak, median of its perturbed runs [Hz]."""
    return np.median(_tuned_runs(reduced, scene_of(n_bumps), draw)[1])


def _tuned_runs(reduced, scene, draw):
    """Peak amplitudes [m] and speeds [Hz] of the tuned disk's perturbed runs."""
    runs = (np.full(N_BLADES, perturbation(draw, run, N_TUNED)) for run in range(N_TUNED))
    return np.array([_peak(mistuned_modes(reduced, run), scene) for run in runs]).T


def _peak(modes, scene):
    speeds = SPEEDS[scene.n_bumps]
    return peak(run_sweep(modes, scene, speeds), speeds)


def _linear(modes, scene):
    """Largest linear amplitude [m]."""
    load = LOAD, scene.n_bumps, scene.interface
    return linear_peak(modes, scene.damping_ratio, *load, N_BLADES)[0]


def perturbation(draw, run, n_runs):
    return PERTURBATION * (draw * n_runs + run)


@lru_cache
def scene_of(n_bumps, damping_ratio=None, longest=LONGEST):
    """Casing, friction and time integration of the paper's study, alike for all disks.

    Parameters
    ----------
    n_bumps : int
    damping_ratio : float, optional
        Of every mode [-]; the paper's if left out.
    longest : float
        Simulated time at which a motion that is not steady ends [s].

    Returns
    -------
    hpcrub.response.scene.Scene
    """
    scene = build_problem(Config.model_validate({"casing": {"n_bumps": n_bumps}})).scene
    return scene._replace(
        damping_ratio=damping_ratio or scene.damping_ratio,
        steady=SteadyCriteria(max_time=longest),  # else the paper's
    )
