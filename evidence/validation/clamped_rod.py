"""A clamped rod, driven at its free end before an elastic stop: published curves, all branches.

Figure 17 of Vadcard, Batailly and Thouverez (2022), Journal of Sound and Vibration 531, whose
program balances harmonics. Here the rod is a model file of one blade, the stop an elastic casing
without bumps, and the force a load of one period around it: a turn is a period of the force.
"""

import tempfile

import numpy as np
from scipy.linalg import eigh

from evidence.page import table
from evidence.truth import harmonics
from evidence.truth.chain import assemble
from evidence.validation import report
from evidence.validation.report import Verdict
from hpcrub.config.schema import Config
from hpcrub.model.elements import Beam, frame_element
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import history
from hpcrub.response.sweep import Motion
from hpcrub.results import model_file
from hpcrub.setup import imported
from hpcrub.setup.problem import build_problem

LENGTH, YOUNG, DENSITY, AREA, N_ELEMENTS = 0.13, 210e9, 7800.0, 15.6e-4, 20
DAMPING_RATIO, LOAD, GAP = 0.0075, 25e3, 2e-4
STEP, SECONDS = 1e-7, 0.04  # transients decay by 10⁻⁸
# stiffness over EA/L: frequencies over the first natural one, published displacements [mm], of
# which each motion starts from the one before, and the first from rest
PUBLISHED = (
    (0.4, (1.0, 1.01, 1.02), (0.27062, None, 0.40895)),
    (0.4, (1.04, 1.02), (None, 0.18439)),
    (4.0, (1.0, 1.01, 1.02), (0.21730, None, 0.24231)),
    (4.0, (1.04,), (0.09488,)),
    (20.0, (1.0, 1.01, 1.02), (0.21017, None, 0.21694)),
)
# the upper branch goes on: stiffness, ratios, and the displacement published for the last one [mm]
BEYOND = 4.0, (1.02, 1.025, 1.03, 1.035, 1.04), 0.28373
SERIES = 20, 60  # harmonics
ALLOWED, EXACT = 1e-3, 1e-4


def matrices():
    """Mass and stiffness (N_ELEMENTS, N_ELEMENTS) of the rod, the free end first."""
    element = frame_element(Beam(YOUNG * AREA, 1.0, DENSITY * AREA), LENGTH / N_ELEMENTS)
    axial = [part[np.ix_([0, 3], [0, 3])] for part in element]
    return [matrix[:0:-1, :0:-1] for matrix in assemble(axial, N_ELEMENTS)]


def arrays():
    """Arrays of its model file; the end is held sideways by a spring of its own."""
    size = N_ELEMENTS + 1
    rows = np.delete(np.arange(size), 1)
    M, K = np.eye(size), np.eye(size) * 1e12
    M[np.ix_(rows, rows)], K[np.ix_(rows, rows)] = matrices()
    dof = np.array([[0, 1], [0, 2], *[[-1, 0]] * (size - 2)])
    return {
        "hpcrub_model": np.array(1), "kind": np.array("reduced"), "M": M, "K": K, "dof": dof,
        "nodes": np.array([[LENGTH, 0.0, 0.0]]), "contact_node": np.array([0]),
    }  # fmt: skip


def keys(path, stiffness, hertz):
    """Input of a time_response of the rod driven at a frequency; stiffness: over EA/L."""
    return {
        "study": "time_response", "disk": {"model": str(path)},
        "material": {"damping_ratio": DAMPING_RATIO},
        "casing": {"bump_height_mm": 0, "clearance_mm": 1e3 * GAP},
        "contact": {"law": "elastic", "friction": 0,
                    "casing_stiffness_n_per_m": stiffness * YOUNG * AREA / LENGTH},
        "forcing": {"amplitude_n": LOAD, "in_contact": True, "engine_order": 1},
        "speeds": {"from_hz": hertz, "to_hz": hertz}, "time": {"step_s": STEP},
        "history": {"duration_s": SECONDS, "record_interval_s": STEP},
    }  # fmt: skip


def last_turn(path, stiffness, hertz, motion):
    """Displacement of the end (n,) over the last period [m]; motion goes on, a Motion."""
    problem = build_problem(imported.resolved(Config(**keys(path, stiffness, hertz))))
    modes = mistuned_modes(problem.reduced, np.zeros(1))
    motion.time[:] = 0.0
    *_, piece = history.integrate(modes, problem.scene, [hertz], SECONDS, motion)
    return piece.position[:, :, 0] @ modes.normal[0]


def stop_and_rod(stiffness):
    """Arguments of `harmonics` but for the frequency and the motion; stiffness: over EA/L."""
    squares, shapes = eigh(*matrices()[::-1])
    rod = {"shape": shapes[0], "omega": np.sqrt(squares), "damping_ratio": DAMPING_RATIO}
    return rod | {"stop": (stiffness * YOUNG * AREA / LENGTH, GAP)}


def coefficients(u, n_harmonics):
    """Fourier coefficients (n_harmonics + 1,) of a period (n,) that ends at time 0."""
    c = 2.0 * np.fft.rfft(np.roll(u, 1))[: n_harmonics + 1] / len(u)
    c[0] /= 2.0
    return c


def stability(path, first, motion, u):
    """Rows of the upper branch beyond its last motion that stays, and verdicts on them.

    motion, u: Motion and period of the motion at the ratio before the first of `BEYOND`.
    """
    stiffness, ratios, published = BEYOND
    rod, c, rows = stop_and_rod(stiffness), coefficients(u, SERIES[0]), []
    for ratio in ratios:
        drive = ratio * first
        c, balanced = harmonics.periodic(**rod, load=LOAD, drive=drive, guess=c)
        largest = np.abs(harmonics.multipliers(**rod, drive=drive, u=balanced)).max()
        periods = [last_turn(path, stiffness, drive / (2.0 * np.pi), motion) for _ in range(2)]
        before, after = (np.abs(period).max() for period in periods)
        rows.append([ratio, 1e3 * np.abs(balanced).max(), largest, abs(after / before - 1.0)])
    known, last = rows[0], rows[-1]
    verdicts = [
        report.at_most(f"{SERIES[0]} harmonics, off {published} mm",
                       abs(last[1] / published - 1.0), 3.0 * EXACT),
        Verdict(f"multiplier at {last[0]:g} ω₁, which does not stay", last[2], 1.0, np.inf),
        Verdict("hpcrub there, from one period to a later one", last[3], 1e-3, np.inf),
        report.at_most(f"multiplier at {known[0]:g} ω₁, which stays", known[2], 1.0),
        report.at_most("hpcrub there, from one period to a later one", known[3], 1e-3),
    ]  # fmt: skip
    return [[f"{x:.4g}" for x in row] for row in rows], verdicts


def section():
    """Parts of the page, and verdicts."""
    M, K = matrices()
    first, rows, off = np.sqrt(eigh(K, M, eigvals_only=True)[0]), [], []
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/rod.h5"
        model_file.write(path, arrays())
        for stiffness, ratios, published in PUBLISHED:
            motion = Motion.at_rest(1, N_ELEMENTS + 1)
            for ratio, known in zip(ratios, published, strict=True):
                u = last_turn(path, stiffness, ratio * first / (2.0 * np.pi), motion)
                if (stiffness, ratio) == (BEYOND[0], BEYOND[1][0]):
                    branch = motion, u
                if known is None:
                    continue
                rod = stop_and_rod(stiffness) | {"load": LOAD, "drive": ratio * first}
                series = [harmonics.periodic(**rod, guess=coefficients(u, n))[1] for n in SERIES]
                found, short, long = (1e3 * np.abs(one).max() for one in (u, *series))
                off.append([found / known - 1.0, found / long - 1.0, short / known - 1.0])
                numbers = [f"{value:.5f}" for value in (known, found, short, long)]
                rows.append([f"{stiffness:g}", f"{ratio:g}", *numbers, f"{off[-1][0]:.0e}"])
        beyond, on_stability = stability(path, first, *branch)
    worst = np.abs(off).max(axis=0)
    verdicts = [
        report.at_most("hpcrub, off the published displacements", worst[0], ALLOWED),
        report.at_most(f"hpcrub, off {SERIES[1]} harmonics", worst[1], EXACT),
        report.at_most(f"{SERIES[0]} harmonics, off the published ones", worst[2], 3.0 * EXACT),
    ]
    heads = ["k L/EA", "ω/ω₁", "published [mm]", "hpcrub [mm]"]
    heads += [f"{n} harmonics [mm]" for n in SERIES]
    parts = {"branches": table([*heads, "off published"], rows)}
    heads = ["ω/ω₁", heads[-2], "largest Floquet multiplier", "hpcrub, change to a later period"]
    return parts | {"stability": table(heads, beyond)}, verdicts + on_stability
