"""`python -m evidence.identify.shapes`: what frequencies and shapes alone say of a disk.

Nodal diameters of the first family, free and with all tips held on the casing, where they slide
with friction; the speeds of the peaks that follow for a blade that is free for one half of its
period and touches in the other; what friction does in a collision; and the highest frequency of the
reduced model on finer meshes of ring and spokes.
"""

import numpy as np
from scipy.linalg import LinAlgError
from scipy.optimize import root

from evidence.identify import disks, stages
from hpcrub.model.disk import _section_motion
from hpcrub.model.elements import rectangular_beam, ring_element, spoke_element
from hpcrub.model.reduction import craig_bampton

FRICTION = 0.15
HIGHEST_HZ = 2000.0  # of the touching vibrations looked at
LOWEST_HZ = 20.0  # below: rigid motions of the constraint
PEAK_HZ = 34.45  # tuned, n_d = 4: paper, section 3.2
MESHES = (1, 1), (2, 1), (1, 2), (2, 2), (4, 4)  # ring and spoke elements in a sector


def families(reduced, friction=FRICTION):
    """Frequencies by nodal diameter, free and touching.

    Parameters
    ----------
    reduced : ReducedModel
    friction : float [-]

    Returns
    -------
    dict
        free, touching: lists by nodal diameter [Hz]; growth: of the fastest touching vibration
        [1/s]; shape: u_r/u_t of the first family; lost: energy lost in a collision of one tip
        over that without friction.

    Notes
    -----
    A force lam(-n - mu t) that keeps n'q = 0 on modes q of the frequencies W leaves
    q'' = -P W^2 q, P = I - d (n'd)^-1 n', d = n + mu t, whose eigenvalues may be complex.
    """
    squares, modes = reduced.tuned_eigenvalues, reduced.tuned_modes
    normal, tangential = (getattr(reduced.interface, n) @ modes for n in ("normal", "tangential"))
    pushed = normal + friction * tangential
    left = np.eye(len(squares)) - pushed.T @ np.linalg.solve(normal @ pushed.T, normal)
    touching_squares, vectors = np.linalg.eig(left * squares)
    touching = np.sqrt(touching_squares.astype(complex))
    seen = np.abs(touching.real / (2 * np.pi) - HIGHEST_HZ / 2) < HIGHEST_HZ / 2 - LOWEST_HZ
    first = np.arange(len(normal))  # the first family
    alone = normal[0] @ normal[0]
    stuck, moved = normal[0] @ pushed[0], pushed[0] @ pushed[0]
    return {
        "free": _lowest(np.sqrt(squares[first]), tangential[:, first]),
        "touching": _lowest(touching[seen].real, tangential @ vectors[:, seen]),
        "growth": np.abs(touching[seen].imag).max(),
        "shape": (normal[0, first] @ tangential[0, first]) / np.sum(tangential[0, first] ** 2),
        "lost": 2 * alone / stuck * (1 - moved / (2 * stuck)),
    }


def _lowest(omega, tips):
    """Lowest frequency of every nodal diameter [Hz]; tips: their motion (N, n)."""
    waves = np.abs(np.fft.fft(tips, axis=0))
    n = np.arange(len(tips))
    diameter = np.minimum(n, len(tips) - n)[np.argmax(waves, axis=0)]
    return [omega[diameter == d].min() / (2 * np.pi) for d in range(len(tips) // 2 + 1)]


def peaks(found, bumps):
    """Speeds of the tuned peaks [Hz] by the frequencies of a bilinear oscillator."""
    bumps = np.array(list(bumps))
    free, touching = (np.array(found[name])[bumps] for name in ("free", "touching"))
    return 2 * free * touching / (free + touching) / bumps


def with_peak(dimensions):
    """The disk with the paper's band and, by the estimate, its tuned peak for n_d = 4.

    Parameters
    ----------
    dimensions : Dimensions
        Its lean, hub and variations; the bow and two thicknesses are where the search starts.

    Returns
    -------
    Dimensions or None
        None if there is none near by.
    """

    def bowed(unknowns):
        spoke, blade = np.exp(np.clip(unknowns[:2], -5, 5))
        return dimensions._replace(
            bow=unknowns[2], spoke_thickness_mm=spoke, blade_thickness_mm=blade
        )

    def distance(unknowns):
        disk = disks.build(bowed(unknowns))
        found = families(craig_bampton(disk, disks.N_MODES))
        (peak,) = peaks(found, [4])
        return np.array([min(found["free"]), max(found["free"]), peak]) / [
            *disks.BAND, PEAK_HZ] - 1  # fmt: skip

    d = dimensions
    start = [np.log(d.spoke_thickness_mm), np.log(d.blade_thickness_mm), d.bow]
    low, high = disks.BOUNDS["bow"]
    try:
        found = root(distance, start, method="hybr", options={"maxfev": 40, "xtol": 1e-5})
        if np.abs(found.fun).max() > 1e-3 or not low <= found.x[2] <= high:
            return None
        return disks.in_band(bowed([*found.x[:2], round(float(found.x[2]), 6)]))
    except (ValueError, LinAlgError):
        return None


def refined(dimensions, n_ring, n_spoke):
    """Finite elements of a disk without variations whose sectors have more ring and spoke elements.

    Parameters
    ----------
    dimensions : Dimensions
    n_ring, n_spoke : int

    Returns
    -------
    hpcrub.model.disk.Disk
    """
    d, paper = dimensions, disks._PAPER
    radius, width = paper.disk.hub_radius, paper.disk.width
    material = paper.material.young_modulus, paper.material.density
    blades = disks._part(d, radius, blade=d.blade_thickness_mm)
    n_blades, n_dof = len(blades.blade_dof), len(blades.mass)
    new = 4 * (n_ring - 1 + n_spoke - 1)
    mass, stiffness = np.zeros((2, n_dof + n_blades * new, n_dof + n_blades * new))
    mass[:n_dof, :n_dof], stiffness[:n_dof, :n_dof] = blades.mass, blades.stiffness
    ring = ring_element(
        rectangular_beam(width, 1e-3 * d.ring_thickness_mm, *material),
        2 * np.pi * radius / n_blades / n_ring,
        radius,
    )
    spoke = spoke_element(
        rectangular_beam(width, 1e-3 * d.spoke_thickness_mm, *material),
        (radius - 1e-3 * d.inner_radius_mm) / n_spoke,
    )
    # the spoke's last node is the ring's, as in the reference model
    foot = np.eye(8)
    foot[4:, 4:] = 0.0
    foot[[4, 6, 7], 4:7], foot[5, 7] = _section_motion(radius), 1.0
    first = n_dof // n_blades * np.arange(n_blades)
    for sector in range(n_blades):
        inner = (n_dof + new * sector + np.arange(new)).reshape(-1, 4)
        start, end = (first[(sector + i) % n_blades] + np.arange(4) for i in (0, 1))
        nodes = [start, *inner[: n_ring - 1], end]
        for dof in map(np.concatenate, zip(nodes[:-1], nodes[1:], strict=True)):
            mass[np.ix_(dof, dof)] += ring[0]
            stiffness[np.ix_(dof, dof)] += ring[1]
        nodes = [np.zeros(0, dtype=int), *inner[n_ring - 1 :], first[sector] + [0, 1, 2, 4]]
        for i, dof in enumerate(map(np.concatenate, zip(nodes[:-1], nodes[1:], strict=True))):
            turn = foot if i == n_spoke - 1 else np.eye(8)
            free = slice(4 if i == 0 else 0, 8)  # the first node is clamped
            mass[np.ix_(dof, dof)] += (turn.T @ spoke[0] @ turn)[free, free]
            stiffness[np.ix_(dof, dof)] += (turn.T @ spoke[1] @ turn)[free, free]
    # sector by sector
    old, added = np.arange(n_dof), n_dof + np.arange(n_blades * new)
    order = np.hstack([old.reshape(n_blades, -1), added.reshape(n_blades, -1)]).ravel()
    place = np.argsort(order)
    return blades._replace(
        mass=mass[np.ix_(order, order)],
        stiffness=stiffness[np.ix_(order, order)],
        blade_dof=place[blades.blade_dof],
        contact_dof=place[blades.contact_dof],
    )


def highest_hz(disk):
    """Highest frequency of the reduced model [Hz]."""
    return np.sqrt(craig_bampton(disk, disks.N_MODES).tuned_eigenvalues[-1]) / (2 * np.pi)


def show(dimensions):
    """Print what is found of a disk."""
    found = families(disks.reduced(dimensions))
    print(", ".join(f"{value:.5g}" for value in dimensions))
    for name in ("free", "touching"):
        print(f"  {name} [Hz]:", " ".join(f"{f:.2f}" for f in found[name]))
    print("  peaks [Hz]:", " ".join(f"{f:.2f}" for f in peaks(found, stages.SPEEDS)))
    print(f"  u_r/u_t {found['shape']:.2f}, lost in a collision {found['lost']:.2f}, "
          f"growth {found['growth']:.0f} 1/s")  # fmt: skip
    if dimensions.is_plain:
        heights = (f"{n} x {m}: {highest_hz(refined(dimensions, n, m)):.0f}" for n, m in MESHES)
        print("  highest of the reduced model [Hz], ring x spoke elements:", ", ".join(heights))


if __name__ == "__main__":
    for shown in disks.EARLIER:
        show(disks.in_band(shown))
