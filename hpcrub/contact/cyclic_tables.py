"""Tables of `cyclic.Cyclic`: rows of one blade by nodal diameters, and the order of multipliers."""

import itertools

import numpy as np

from hpcrub.contact.lanes import TILE
from hpcrub.contact.tables import columns
from hpcrub.model.reduction import Blades, Rows
from hpcrub.model.tuned_basis import series


def multipliers(rows: Rows, blades: Blades) -> tuple[np.ndarray, np.ndarray]:
    """Blade of every multiplier of the bank, and its row among those of this blade, int each."""
    (n_blades, n_points), n_bent = blades.points.shape, len(rows.bent) // len(blades.points)
    padded = columns(rows.normal).shape[1]
    blade_of, row_of = np.zeros((2, 3 * padded + len(rows.bent)), dtype=np.int64)
    for direction in range(3):
        of_direction = blades.points + direction * padded
        blade_of[of_direction], row_of[of_direction] = np.indices(blades.points.shape)
        row_of[of_direction] += direction * n_points
    blade_of[3 * padded :] = np.repeat(np.arange(n_blades), n_bent)
    row_of[3 * padded :] = 3 * n_points + np.tile(np.arange(n_bent), n_blades)
    return blade_of, row_of


def tables_of(rows: Rows, blades: Blades) -> dict[str, np.ndarray]:
    """Arrays of one blade that all lanes share, and where the modes of each h begin and end."""
    n_blades, h = len(blades.points), np.arange(len(blades.points) // 2 + 2)
    real, waves, _ = np.split(rows.diameters, np.cumsum(rows.counts)[:-1])
    begins = np.searchsorted(real, h)
    moved = np.abs(rows.blade[:, : len(real)]).max(axis=0, initial=0.0) > 0.0
    last = [np.flatnonzero(moved[a:b]).max(initial=-1) + 1 for a, b in itertools.pairwise(begins)]
    angle = 2.0 * np.pi / n_blades * np.outer(h[:-1], h[:-1])
    sine = np.sin(angle) * (2 * h[:-1] < n_blades) * (h[:-1] > 0)[:, None]
    return {
        **_of_one_blade(rows, blades),
        "cosine": columns(np.cos(angle).T),
        "sine": columns(sine.T),
        "begins": begins,
        # whole tiles of modes, as far as there are modes
        "ends": np.minimum(begins[:-1] + -(-np.array(last) // TILE) * TILE, begins[1:]),
        "waves": len(real) + np.searchsorted(waves, h),
    }


def _of_one_blade(rows: Rows, blades: Blades) -> dict[str, np.ndarray]:
    """Tables of E, then O, and the bent modes of a blade by its modes."""
    n_blades, n_rows = len(blades.points), len(rows.diameters)
    n_bent, shape = len(rows.bent) // n_blades, (n_blades, -1, n_rows)
    forces = [force[blades.points] for force in rows.forces]
    forces.append(rows.bent_forces.reshape(n_blades, n_bent, n_rows))
    normal, tangential, observed, blade, push, load = (
        np.concatenate(series(part, rows.diameters))
        for part in (
            rows.normal[blades.points],
            rows.tangential[blades.points],
            rows.observed[blades.observed],
            rows.blade.reshape(shape),
            rows.blade_forces.reshape(shape),
            np.concatenate(forces, axis=1),
        )
    )
    # bent modes are of the blade's stiffness, and so sums of its modes
    mine = rows.blade[: blades.modes.shape[1]]
    return {
        "bent": np.linalg.lstsq(mine.T, rows.bent[:n_bent].T)[0].T,
        "normal": columns(np.concatenate([normal, tangential]) if n_bent else normal),
        "observed": columns(observed),
        "blade": columns(blade),
        "push": np.pad(push, ((0, 0), (0, TILE))),
        "load": np.pad(-load, ((0, 0), (0, TILE))),
    }
