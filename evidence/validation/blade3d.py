"""One three-dimensional compressor blade against an oval casing, beside two other programs.

    python -m evidence.validation.blade3d PATH [STEP_US ...]

PATH: an archive of the reduced blade (16 contact nodes with three dof each and 50 modes) and of the
responses by Siconos (Moreau–Jean on the same matrices) and NLstep (massless boundary). It is not
part of this project. Prints the difference of the response, root mean square over the peak, and
what the solver of the contact forces does.
"""

import sys
import time

import numpy as np
from scipy.linalg import eigh

from hpcrub.contact.arrays import SWEEPS
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.lcp.gauss_seidel import TOLERANCE
from hpcrub.contact.observers import Record
from hpcrub.contact.recurrence import coefficients
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene

STEPS_US = (18.7, 9.35, 5.0, 1.17, 0.5)
TEXT = """## A three-dimensional compressor blade

The blade of NASA's rotor 37, reduced to 16 contact nodes with three degrees of freedom each and 50
modes, starts from rest in an oval casing. Two other programs have computed its first two
revolutions: Siconos (Moreau–Jean time stepping on the same matrices) and NLstep (another reduction,
with a massless boundary). They differ from each other by 1.6 % in the first revolution and 2.4 % in
the second. Their data are not part of this project, so `make validate` does not repeat this case;
`python -m evidence.validation.blade3d PATH` does, for whoever has them. The first table holds what
it found: the difference of the response over two revolutions, root mean square over the peak and of
the peaks, and how many sets of contact points were tried in the worst step. The second compares two
solvers of the contact forces on the same 60 problems, random penetrations of this blade's nodes:
sweeps of Gauss–Seidel from point to point, and sets tried by principal pivoting that starts without
a guess."""
MEASURED = """| step [µs] | Siconos: rms | peak | NLstep: rms | peak | most sets tried |
|---|---|---|---|---|---|
| 9.35 | 0.12 % | -0.07 % | 0.96 % | -1.92 % | 2 |
| 5 | 0.08 % | -0.01 % | 0.92 % | -1.86 % | 3 |

| step [µs] | sweeps point by point: median | most | sets of points tried: median | most |
|---|---|---|---|---|
| 5 | 9 | 14 | 2 | 3 |
| 1.17 | 40 | 117 | 3 | 4 |
| 0.5 | 66 | 225 | 3 | 5 |
| 0.29 | 70 | 241 | 3 | 5 |"""
REVOLUTIONS, N_PROBLEMS = 2, 60


def section(_folder):
    """Markdown of this case, as measured once; no verdicts."""
    return f"{TEXT}\n\n{MEASURED}", []


def modes_of(data):
    """Modes of the Craig–Bampton model; the local frames are (inward, axial, against rotation)."""
    eigenvalues, shapes = eigh(data["K_CB"], data["M_CB"])
    points = 3 * np.arange(int(data["nc"]))
    return Modes(
        omega=np.sqrt(np.maximum(eigenvalues, 0.0)),
        normal=-shapes[points],
        tangential=-shapes[points + 2],
        axial=shapes[points + 1],
        observed=data["Tresp_CB"] @ shapes,
        shapes=shapes,
    )


def scene_of(data):
    """Scene: two bumps, whose shape `integrate` replaces by that of the archive; units N, mm, t."""
    n, m = int(data["nc"]), len(data["M_CB"])
    none = np.zeros((n, m))
    interface = Interface(
        blade=np.zeros(n, dtype=int),
        angle=data["phi"],
        radius=data["radius"],
        axial_position=np.zeros(n),
        clearance=np.zeros(n),
        normal=none,
        tangential=none,
        axial=none,
        observed=data["Tresp_CB"],
        observed_blade=np.zeros(1, dtype=int),
    )
    mean = float(data["gmean_mm"])
    return Scene(
        interface, float(data["zeta"]), 2, 2.0 * mean, mean, 0.0, float(data["mu"]),
        scheme="exact_modal",
    )  # fmt: skip


def integrate(data, step, turning=True):
    """Times [s], response, most sweeps or tried sets of a step, and wall time per step [s].

    Without ``turning`` friction stays circumferential, and forces are found point by point.
    """
    omega = float(data["Omrot_rad_s"])
    n_steps = round(2.0 * np.pi / omega / step)
    modes, scene = modes_of(data), scene_of(data)
    if not turning:
        modes = modes._replace(axial=modes.axial[:0])
    bank = allocate(modes, scene, Grid(n_steps, 1, n_steps), 1, [omega / (2.0 * np.pi)])
    turned = 2.0 * np.pi * np.arange(1, n_steps + 1) / n_steps
    x = (np.mod(turned[:, None] + data["phi"], np.pi) / np.pi - 0.5) / 0.15
    bumps = 2.0 * float(data["gmean_mm"]) * np.exp(-(x**2))
    bank.scheme.bump[:, : len(data["phi"])] = bumps
    record = Record.allocate(bank, REVOLUTIONS, 1)
    start = time.perf_counter()
    run(bank, REVOLUTIONS, record)
    seconds = time.perf_counter() - start
    response = np.concatenate([[0.0], record.history.reshape(REVOLUTIONS * n_steps, -1)[:, 0]])
    times = np.arange(len(response)) * 2.0 * np.pi / omega / n_steps
    return times, response, bank.state.report[SWEEPS, 0], seconds / (REVOLUTIONS * n_steps)


def main(path, *steps_us):
    with np.load(path) as archive:
        data = {name: archive[name] for name in archive.files}
    steps = [float(s) for s in steps_us] or STEPS_US
    for turning in (True, False):
        integrate(data, 5e-5, turning)  # compiles
    print("step [us] | Siconos: rms/peak, peak [%] | NLstep | most sets tried | us per step")
    print("          | friction along the rotation only, forces point by point: same, most sweeps")
    for step in steps:
        for turning in (True, False):
            t, u, effort, seconds = integrate(data, 1e-6 * step, turning)
            cells = [
                "{:8.3f} {:+8.3f}".format(*difference(data, peer, t, u))
                for peer in ("siconos", "nlstep")
            ]
            head = f"{step:>9}" if turning else 9 * " "
            print(" | ".join([head, *cells, f"{effort:5.0f}", f"{1e6 * seconds:7.1f}"]), flush=True)
    for step in steps:
        numbers = [f"{np.median(n):.0f}, {n.max()}" for n in effort(data, 1e-6 * step)]
        print(f"{step:>9} us: sweeps (median, most) {numbers[0]}; sets {numbers[1]}")


def effort(data, step):
    """Sweeps point by point, and sets tried, of random problems of the contact forces (2, n)."""
    modes, mu = modes_of(data), float(data["mu"])
    _, gain = coefficients("exact_modal", modes.omega, float(data["zeta"]), step)
    W = (modes.normal * gain) @ (modes.normal + mu * modes.tangential).T
    coupling, rng, found = W / np.diag(W), np.random.default_rng(0), []
    for _ in range(N_PROBLEMS):
        depth = rng.uniform(-1.0, 0.3, len(W)) + rng.uniform(-0.5, 0.5)
        if depth.max() > 0.0:
            found.append([_sweeps(coupling, depth), _sets(coupling, depth)])
    return np.array(found).T


def _sweeps(coupling, depth, most=2000):
    x, limit = np.zeros(len(depth)), TOLERANCE * depth.max()
    for sweep in range(most):
        before = x.copy()
        for j in range(len(x)):
            x[j] = max(x[j] + depth[j] - coupling[j] @ x, 0.0)
        if np.abs(x - before).max() <= limit:
            return sweep + 1
    return most


def _sets(coupling, depth, most=60):
    touching, limit = np.zeros(len(depth), dtype=bool), TOLERANCE * depth.max()
    for trial in range(most):
        x = np.zeros(len(depth))
        x[touching] = np.linalg.solve(coupling[np.ix_(touching, touching)], depth[touching])
        wrong = np.where(touching, x < 0.0, depth - coupling @ x > limit)
        if not wrong.any():
            return trial + 1
        touching ^= wrong
    return most


def difference(data, peer, t, u):
    """Root mean square over peak, and of the peaks, from a peer's response [%]."""
    inside = data[f"{peer}_t_s"] <= t[-1]
    known, at = data[f"{peer}_q_mm"][inside], data[f"{peer}_t_s"][inside]
    found, peak = np.interp(at, t, u), np.abs(known).max()
    rms = np.sqrt(np.mean((found - known) ** 2))
    return 100 * rms / peak, 100 * (np.abs(found).max() / peak - 1)


if __name__ == "__main__":
    main(*sys.argv[1:])
