"""Natural frequencies of the fan: convergence with the mesh, Campbell diagram, crossings."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import eigh

from evidence import calculix, pictures
from evidence.rotor67.mesh import Size, sector
from evidence.rotor67.model import SPEED, Fan, cyclic_state
from evidence.rotor67.numbers import Number
from hpcrub.model import crossings
from hpcrub.model.families import multiplicity
from hpcrub.model.imported import cyclic, neutral, reduced
from hpcrub.model.imported.neutral import stiffness_at

MESHES = Size(7, 8), Size(14, 16), Size(21, 24), Size(28, 32), Size(28, 32, 2)
N_ALONE = 5
SHOWN = 4  # families of the Campbell diagram
NAMES = "first bending", "second bending", "first torsion", "higher"
ORDERS = range(1, 9)
NEAR = 0.9, 1.1  # shares of the design speed, of the table of crossings
SAME = 1e-6  # relative difference of a crossing's order from the family that has that frequency
SHARES = np.linspace(0.0, 1.1, 12)
PER_DIAMETER = 4  # frequencies that are held against those that CalculiX prints


def converged(sections, folder: Path) -> list[Number]:
    """Frequencies of the blade alone in its published shape, root held, at rest, on all MESHES."""
    found = []
    for size in MESHES:
        path = folder / f"alone_{size.chord}_{size.through}.inp"
        mesh = sector(sections, size)
        held = calculix.held(mesh.sets["root"])
        steps = held + calculix.STEP + calculix.frequencies_of(N_ALONE)
        printed = calculix.solve(path, mesh, steps, blade=True)
        elements = f"{size.chord} x {size.span} x {size.through} elements"
        values = calculix.frequencies(printed, N_ALONE)
        found += [
            Number("frequency of the blade alone", f"mode {k}, {elements}", f, "Hz")
            for k, f in enumerate(values, 1)
        ]
    return found


def held_against_calculix(fan: Fan, sector: neutral.NeutralModel, folder: Path) -> float:
    """Largest relative difference of a free sector's frequencies from those of CalculiX's own.

    CalculiX's are those of a cyclic sector at the design speed, nodal diameters 0 to 3.
    """
    state = cyclic_state(fan.at_rest, fan.sections.n_blades, 2 * np.pi * SPEED)
    steps = state + calculix.PERTURBED + calculix.frequencies_of(PER_DIAMETER, 3)
    path = calculix.solve(folder / "cyclic.inp", fan.at_rest, steps)
    printed = calculix.by_diameters(path)
    found = {h: cyclic.sector_frequencies(sector, h, len(f)) for h, f in printed.items()}
    return max(np.abs(found[h] / f - 1.0).max() for h, f in printed.items())


def families(model: neutral.NeutralModel, share: float, n_families: int = SHOWN) -> np.ndarray:
    """Frequencies by nodal diameters and family, (diameters, n_families) [Hz]; NaN without one.

    A family has the blade's cantilever mode that stores most of a mode's energy; where several
    modes have the same, the one in which it stores most.
    """
    speed = 2 * np.pi * share * SPEED
    values, shapes = eigh(stiffness_at(model.stiffness, speed), model.mass)
    n_modes = 3 * n_families * model.n_blades
    frequency, shapes = np.sqrt(values[:n_modes]) / (2 * np.pi), shapes[:, :n_modes]
    face = reduced.interface(model)
    tips = np.array([rows @ shapes for rows in (face.normal, face.tangential, face.axial)])
    diameters = cyclic.diameters_of(tips, face.blade, face.angle)
    q = np.einsum("ncm,mk->nck", model.participation, shapes)
    energy = (model.blade_frequencies[0][:, None] ** 2 * (q**2).sum(axis=0)) / frequency**2
    out = np.full((model.n_blades // 2 + 1, n_families), np.nan)
    for h in range(len(out)):
        mine = np.flatnonzero(diameters == h)
        for family in range(n_families):
            own = mine[energy[:, mine].argmax(axis=0) == family]
            if len(own):
                out[h, family] = frequency[own[energy[family, own].argmax()]]
    return out


def near_design(model: neutral.NeutralModel) -> list[tuple[int, int, int, float]]:
    """Where an engine order meets a family near the design speed.

    Returns (family, diameters, order, speed [Hz]) by the distance from the design speed. An engine
    order n excites n nodal diameters, or the n_blades - n that look the same to the blades.
    """
    n, whole, found = model.n_blades, reduced.reduced_model(model, 2 * np.pi * SPEED), []
    of_mode = cyclic.tuned_diameters(whole)
    for diameters in range(n // 2 + 1):
        shapes = whole.tuned_modes[:, of_mode == diameters]
        stiffness = [shapes.T @ K @ shapes for K in model.stiffness]
        for order in {diameters, n - diameters} - {0}:
            met = crossings.speeds(stiffness, np.eye(shapes.shape[1]), order) / (2 * np.pi)
            for speed in met[:: multiplicity(diameters, n)]:
                if NEAR[0] <= speed / SPEED <= NEAR[1]:
                    own = families(model, speed / SPEED)[diameters]
                    (family,) = np.nonzero(np.isclose(own, order * speed, rtol=SAME))
                    found += [(int(k) + 1, diameters, order, float(speed)) for k in family]
    return sorted(found, key=lambda row: abs(row[-1] / SPEED - 1))


def numbers(model: neutral.NeutralModel, figure: Path) -> list[Number]:
    """Frequencies at rest and at the design speed, crossings; draws the Campbell diagram."""
    table = np.array([families(model, share) for share in SHARES])
    draw(table, figure)
    found = []
    for share, where in ((0.0, "at rest"), (1.0, "at 267.4 Hz")):
        for (h, family), f in np.ndenumerate(families(model, share)):
            at = f"{where}, family {family + 1}, {h} diameters"
            found.append(Number("natural frequency", at, f, "Hz"))
    for family, diameters, order, speed in near_design(model):
        at = f"engine order {order}, family {family}, {diameters} diameters"
        found.append(Number("speed of a crossing", at, speed, "Hz"))
    return found


def draw(table: np.ndarray, path: Path) -> None:
    """Campbell diagram."""
    figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
    speed = SHARES * SPEED
    for family in range(table.shape[2]):
        rows = table[:, :, family]
        low, high = np.nanmin(rows, axis=1), np.nanmax(rows, axis=1)
        axes.fill_between(speed, low, high, alpha=0.25, color=f"C{family}", lw=0)
        label = f"family {family + 1}: {NAMES[family]}"
        axes.plot(speed, rows[:, -1], color=f"C{family}", lw=1.2, label=label)
    top = 1.05 * np.nanmax(table)
    for order in ORDERS:
        axes.plot(speed, order * speed, color="0.6", lw=0.7, zorder=0)
        end = min(speed[-1], top / order)
        axes.annotate(f"EO {order}", (end, order * end), fontsize=7, color="0.4",
                      ha="left" if end == speed[-1] else "center", va="bottom")  # fmt: skip
    axes.axvline(SPEED, color="0.3", lw=0.8, ls=":")
    axes.set(xlabel="speed of rotation [Hz]", ylabel="natural frequency [Hz]",
             xlim=(0, 1.16 * SPEED), ylim=(0, top))  # fmt: skip
    axes.legend(frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 0.36))
    pictures.save(figure, path, dpi=150)
    plt.close(figure)
