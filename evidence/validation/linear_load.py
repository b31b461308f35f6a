"""The contact run, casing withdrawn, with an engine-order excitation: the closed-form response.

The load F cos(n_d(θ_i + Ωt)) of a study stands still, as bumps do, and enters the kernel as modal
forces in time, over one bump pitch. The tips' motion over the last three revolutions of a long run
is held against `hpcrub.response.linear.engine_order_response`.
"""

import numpy as np

from evidence.truth.disk import reference_reduced
from evidence.validation import report
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.model.casing import CasingShape
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import engine_order_response
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene

WIDTH = 8
LOAD, DIAMETERS = 150.0, 4
DAMPING_RATIO = 0.05  # transients decay by 10⁻⁹ in SECONDS
SECONDS = 0.75
RECORDS = 32  # a pitch
SPEEDS_HZ = np.linspace(21.5, 25.0, WIDTH)
DIVISIONS = np.array([256, 512, 1024, 2048])
FINEST = 1e-5  # largest error allowed at the finest step


def error(modes, interface, scheme_name, steps_per_pitch):
    """Largest error of u_t of any tip at any speed, phase included, over the largest amplitude."""
    # bumps without height, a clearance out of reach, no friction
    scene = Scene(
        interface, DAMPING_RATIO, CasingShape(DIAMETERS, 0.0), 1.0, 0.0, 0.0, scheme=scheme_name,
        load=LOAD, load_order=DIAMETERS,
    )  # fmt: skip
    grid = Grid(DIAMETERS * steps_per_pitch, DIAMETERS, steps_per_pitch // RECORDS)
    bank = allocate(modes, scene, grid, WIDTH, SPEEDS_HZ)
    n_blocks = int(SECONDS * max(SPEEDS_HZ)) * DIAMETERS
    record = Record.allocate(bank, 3 * DIAMETERS, grid.stride)
    run(bank, n_blocks, record)
    records = record.history.reshape(-1, bank.scheme.observed.shape[1], WIDTH)
    records = records[:, : len(modes.observed)]
    # a pitch is one period of every tip: its amplitude is the first Fourier coefficient
    periods = records.reshape(-1, RECORDS, *records.shape[1:])
    wave = np.exp(-2j * np.pi * np.arange(1, RECORDS + 1) / RECORDS)
    computed = 2.0 / RECORDS * np.einsum("prts,r->st", periods, wave) / len(periods)
    load = DAMPING_RATIO, LOAD, -DIAMETERS, interface
    exact = engine_order_response(modes, *load, SPEEDS_HZ)
    return np.abs(computed - exact).max() / np.abs(exact).max()


def section(_folder):
    """Parts of the page, and verdicts."""
    reduced = reference_reduced(12)
    modes = mistuned_modes(reduced, np.linspace(-0.03, 0.03, 12))
    columns = {
        f"`{name}`": np.array([error(modes, reduced.interface, name, n) for n in DIVISIONS])
        for name in report.SCHEMES
    }
    finest, verdicts = (f"error at {DIVISIONS[-1]} steps a pitch", FINEST), []
    for name, found in columns.items():
        verdicts += report.falling(name, 1.0 / DIVISIONS, found, finest, 1.95, 2.05)
    labels = "steps a pitch", DIVISIONS
    return {"errors": report.order_table(labels, 1.0 / DIVISIONS, columns)}, verdicts
