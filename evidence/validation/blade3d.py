"""One three-dimensional compressor blade against an oval casing, beside two other programs.

    python -m evidence.validation.blade3d PATH [STEP_US ...]

PATH: an archive of the reduced blade (16 contact nodes with three dof each and 50 modes) and of the
responses by Siconos (Moreau–Jean on the same matrices) and NLstep (massless boundary). It is not
part of this project. Prints the difference of the response, root mean square over the peak, and how
many sets of contact points were tried in the worst step.
"""

import sys

import numpy as np
from scipy.linalg import eigh

from hpcrub.contact.arrays import SWEEPS
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.model.casing import CasingShape
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene

STEPS_US = 9.35, 5.0
REVOLUTIONS = 2


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
    one_blade = np.zeros(int(data["nc"]), dtype=int)
    interface = planar_interface(data["phi"], data["radius"], blade=one_blade)
    interface = interface._replace(observed=data["Tresp_CB"], observed_blade=one_blade[:1])
    mean = float(data["gmean_mm"])
    return Scene(
        interface, float(data["zeta"]), CasingShape(2, 2.0 * mean), mean, 0.0, float(data["mu"]),
        scheme="exact_modal",
    )  # fmt: skip


def integrate(data, step):
    """Times [s], response, and most sets of contact points tried in a step."""
    omega = float(data["Omrot_rad_s"])
    n_steps = round(2.0 * np.pi / omega / step)
    modes, scene = modes_of(data), scene_of(data)
    bank = allocate(modes, scene, Grid(n_steps, 1, n_steps), 1, [omega / (2.0 * np.pi)])
    turned = 2.0 * np.pi * np.arange(1, n_steps + 1) / n_steps
    x = (np.mod(turned[:, None] + data["phi"], np.pi) / np.pi - 0.5) / 0.15
    bumps = 2.0 * float(data["gmean_mm"]) * np.exp(-(x**2))
    bank.scheme.bump[:, : len(data["phi"])] = bumps
    record = Record.allocate(bank, REVOLUTIONS, 1)
    run(bank, REVOLUTIONS, record)
    response = np.concatenate([[0.0], record.history.reshape(REVOLUTIONS * n_steps, -1)[:, 0]])
    times = np.arange(len(response)) * 2.0 * np.pi / omega / n_steps
    return times, response, bank.state.report[SWEEPS, 0]


def difference(data, peer, t, u):
    """Root mean square over peak, and of the peaks, from a peer's response [%]."""
    inside = data[f"{peer}_t_s"] <= t[-1]
    known, at = data[f"{peer}_q_mm"][inside], data[f"{peer}_t_s"][inside]
    found, peak = np.interp(at, t, u), np.abs(known).max()
    rms = np.sqrt(np.mean((found - known) ** 2))
    return 100 * rms / peak, 100 * (np.abs(found).max() / peak - 1)


def main(path, *steps_us):
    with np.load(path) as archive:
        data = {name: archive[name] for name in archive.files}
    print("step [us] | Siconos: rms/peak, peak [%] | NLstep | most sets tried")
    for step in steps_us or STEPS_US:
        t, u, most = integrate(data, 1e-6 * float(step))
        cells = ["{:8.3f} {:+8.3f}".format(*difference(data, peer, t, u))
                 for peer in ("siconos", "nlstep")]  # fmt: skip
        print(" | ".join([f"{step:>9}", *cells, f"{most:.0f}"]), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
