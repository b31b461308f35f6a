"""Craig-Bampton reduction of the disk and the modes of its mistuned samples."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve, eigh

from hpcrub.model import families
from hpcrub.model.aero import Air, Waves, complex_modes
from hpcrub.model.casing_modes import NO_PAIRS, CasingModes, Pairs
from hpcrub.model.damping import Damping, ratios_of
from hpcrub.model.disk import Disk
from hpcrub.model.interface import Interface, planar_interface

MOTIONS = "normal", "tangential", "axial", "observed", "bent"  # displacements per unit of a mode


class ReducedModel(NamedTuple):
    """Tuned disk of any origin on m coordinates; n dof of the full model, N blades."""

    mass: np.ndarray  # (m, m)
    stiffness: np.ndarray  # (m, m)
    blade_stiffness: np.ndarray  # (N, m, m) part of each blade in the stiffness
    basis: np.ndarray  # (n, m) from the coordinates to the dof of the full model
    interface: Interface  # contact points and observed displacements on these coordinates
    tuned_modes: np.ndarray  # (m, m) mass-normalised modes of the tuned disk
    tuned_eigenvalues: np.ndarray  # (m,) squares of their angular frequencies [rad2/s2]
    modal_blade_stiffness: np.ndarray  # (N, m, m) ``blade_stiffness`` in the tuned modes
    speed: float = 0.0  # speed of rotation to which ``stiffness`` belongs [rad/s]
    # K1, K2 of K + (W^2 - speed^2) K1 + (W^4 - speed^4) K2 in the tuned modes, each (m, m)
    stiffening: tuple = ()
    casing: CasingModes | None = None  # None: the casing does not vibrate
    air: Air | None = None  # None: air does not couple the blades


class Blades(NamedTuple):
    """How N blades that deviate act on the K modes of a tuned disk (`model.tuned_basis`)."""

    diameters: np.ndarray  # nodal diameters of every mode, never decreasing (K,) int
    points: np.ndarray  # corresponding contact points of all blades (N, P) int
    observed: np.ndarray  # corresponding observed displacements (N, Q) int
    modes: np.ndarray  # y_bj, J modes of each blade (N, J, K), Σ_j y yᵀ its stiffness [1/s]
    of_family: np.ndarray  # whether a mode of the disk is of the family of blade mode j (J, K)
    stress_blade: np.ndarray  # blade of every place of a stress (R,) int
    deviation: np.ndarray  # relative, of each blade's stiffness from that of the modes (N,) [-]
    reference: float  # deviation of all blades of the modes from the tuned disk [-]

    @property
    def stiffer(self) -> np.ndarray:
        """Stress at every place over that of the tuned disk in the same motion (R,) [-].

        The sections of a stiffer blade carry a higher force.
        """
        return 1.0 + self.reference + self.deviation[self.stress_blade]

    def energies(self, omega: np.ndarray) -> np.ndarray:
        """Shares of each blade mode in the strain energy of the modes of its family (J, K) [-].

        omega: of the modes of the disk (K,) [rad/s].
        """
        return self.of_family * (self.modes[0] / omega) ** 2


class Rows(NamedTuple):
    """What the kernel integrates: R rows of a motion, before C contact points.

    They are the real modes of the disk, Re z and Im z of its complex modes, pairs of the casing.
    """

    omega: np.ndarray  # (R,) [rad/s]
    normal: np.ndarray  # (C, R) as in `Modes`, of the points relative to the casing [1/sqrt(kg)]
    tangential: np.ndarray  # (C, R) [1/sqrt(kg)]
    axial: np.ndarray  # (C, R); (0, R) if planar [1/sqrt(kg)]
    observed: np.ndarray  # (O, R) [1/sqrt(kg)]
    stress: np.ndarray  # (places, R) [Pa/(m sqrt(kg))]
    # forces of unit forces on the points along normal, tangential and axial, each (C, R)
    forces: tuple[np.ndarray, ...]
    counts: tuple[int, int, int]  # rows of the disk's real modes, of complex modes, of pairs
    points: np.ndarray  # corresponding points of all blades (N, P) int; (1, C): not known
    diameters: np.ndarray  # nodal diameters of every row (R,) int; (0,) unless `Modes.blades`
    blade: np.ndarray  # (N·J, R) `Blades.modes`, blade by blade [1/s]; (0, R) without
    blade_forces: np.ndarray  # forces by unit forces along these, likewise
    bent: np.ndarray  # (N·p, R) amplitudes of bent modes (`model.second_order`) [-]; (0, R) without
    bent_forces: np.ndarray  # forces by unit forces along these, likewise


class Modes(NamedTuple):
    """Mass-normalised modes of one sample, by increasing frequency."""

    omega: np.ndarray  # (K,) [rad/s]
    normal: np.ndarray  # (C, K) outward displacement of the contact points [1/sqrt(kg)]
    tangential: np.ndarray  # (C, K) displacement of the points towards +theta [1/sqrt(kg)]
    axial: np.ndarray  # (C, K) along the casing's generator; (0, K) if planar [1/sqrt(kg)]
    observed: np.ndarray  # (O, K) displacements whose largest is the amplitude [1/sqrt(kg)]
    shapes: np.ndarray  # (m, K) on the coordinates of the reduced model
    speed: float = 0.0  # speed of rotation to which omega and shapes belong [rad/s]
    stiffening: np.ndarray = np.zeros((0, 0))  # (0 or 2, K) slopes of omega^2 over W^2 and W^4
    stress: np.ndarray = np.zeros((0, 0))  # (R, K) at the places of the interface [Pa/(m sqrt(kg))]
    pairs: Pairs = NO_PAIRS  # pairs of casing modes, beside the modes of the disk
    waves: Waves | None = None  # complex modes that replace some real ones; None: all are real
    blades: Blades | None = None  # blades that deviate from these modes; None: none do
    # (N·p, K) amplitudes of bent modes, blade by blade (`model.second_order`) [-]; (0, K) without
    bent: np.ndarray = np.zeros((0, 0))

    @property
    def n_rows(self) -> int:
        """Number of rows of a motion: K, plus one for each complex mode and two for each pair."""
        more = len(self.waves.rows) if self.waves else 0
        return len(self.omega) + more + 2 * len(self.pairs.omega)

    @property
    def real(self) -> np.ndarray:
        """Indices of the modes that no complex mode replaces; they come first in a motion."""
        every = np.arange(len(self.omega))
        return np.delete(every, self.waves.rows) if self.waves else every

    @property
    def rows(self) -> Rows:
        """What the kernel integrates: the rows of a motion."""
        waves, real, n_casing = self.waves, self.real, 2 * len(self.pairs.omega)

        def whole(disk: np.ndarray, side: str = "motion", casing: Any = None) -> np.ndarray:
            """Motion per unit of every row, or force on it; side: the method of `Waves`."""
            parts = [disk]
            if waves:
                disk = disk.reshape(-1, len(self.omega))
                parts = [disk[:, real], getattr(waves, side)(disk)]
            if n_casing:
                parts.append(np.zeros((len(disk), n_casing)) if casing is None else casing)
            return np.hstack(parts) if len(parts) > 1 else disk

        beside = self.pairs.normal, self.pairs.tangential, None
        along = self.normal, self.tangential, self.axial
        normal, tangential, axial = map(whole, along, ["motion"] * 3, beside)
        size = np.abs(waves.eigenvalue) if waves else np.zeros(0)
        omega = [self.omega[real], np.repeat(size, 2), np.repeat(self.pairs.omega, 2)]
        points, blade = np.arange(len(self.normal))[None], np.zeros((0, len(self.omega)))
        bent = self.bent if len(self.bent) else blade
        if self.blades:
            points, blade = self.blades.points, self.blades.modes.reshape(-1, len(self.omega))
        return Rows(
            omega=np.concatenate(omega),
            normal=normal,
            tangential=tangential,
            axial=axial,
            observed=whole(self.observed),
            stress=whole(self.stress),
            forces=tuple(map(whole, along, ["force"] * 3, beside)),
            counts=(len(omega[0]), len(omega[1]), len(omega[2])),
            points=points,
            diameters=self.diameters_of_rows,
            blade=whole(blade),
            blade_forces=whole(blade, "force"),
            bent=whole(bent),
            bent_forces=whole(bent, "force"),
        )

    @property
    def diameters_of_rows(self) -> np.ndarray:
        """Nodal diameters of all rows of a motion (n_rows,) int; (0,) unless blades deviate."""
        if self.blades is None:
            return np.zeros(0, dtype=int)
        h, n_blades = self.blades.diameters, len(self.blades.deviation)
        in_air = h[self.waves.rows] if self.waves else h[:0]
        around = self.pairs.n_waves % n_blades
        twice = np.concatenate([in_air, np.minimum(around, n_blades - around)])
        return np.concatenate([h[self.real], np.repeat(twice, 2)])

    def of_rows(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Modal coordinates of disk (..., K) and casing (..., 2J), from rows (..., n_rows)."""
        disk, casing = np.split(rows, [self.n_rows - 2 * len(self.pairs.omega)], axis=-1)
        if self.waves is None:
            return disk, casing
        real = self.real
        position = np.empty((*rows.shape[:-1], len(self.omega)))
        position[..., real] = disk[..., : len(real)]
        position[..., self.waves.rows] = self.waves.coordinates(disk[..., len(real) :])
        return position, casing

    def at_rest(self, position: np.ndarray) -> np.ndarray:
        """Rows of a motion (n_rows,) for a disk that rests at modal coordinates (K,)."""
        still = np.zeros(2 * len(self.pairs.omega))
        if self.waves is None:
            return np.concatenate([position, still])
        part = position[self.waves.rows]
        return np.concatenate([position[self.real], self.waves.parts(part, 0.0 * part), still])

    def damping_ratios(self, damping: float | Damping) -> np.ndarray:
        """Damping ratios of all rows of a motion [-]; damping: ratios of the real modes."""
        of_disk = ratios_of(damping, self.omega)[self.real]
        in_air = np.repeat(self.waves.damping_ratio, 2) if self.waves else np.zeros(0)
        return np.concatenate([of_disk, in_air, np.repeat(self.pairs.damping_ratio, 2)])

    def omega_at(self, speed: npt.ArrayLike) -> np.ndarray:
        """Angular eigenfrequencies (..., K) [rad/s] at speeds of rotation (...) [rad/s].

        They are of first order in the change of stiffness: the shapes stay as at `Modes.speed`,
        which makes a second-order error in a frequency.
        """
        if not len(self.stiffening):
            return self.omega
        change = powers(speed, self.speed) @ self.stiffening
        return np.sqrt(np.maximum(self.omega**2 + change, 0.0))

    def at(self, speed_hz: float) -> "Modes":
        """Modes with the frequencies at a speed of rotation [Hz]; see `omega_at`."""
        speed = 2 * np.pi * speed_hz
        waves = self.waves and self.waves.at(powers(speed, self.speed))
        return self._replace(omega=self.omega_at(speed), speed=speed, waves=waves)

    @property
    def fixed(self) -> "Modes":
        """These modes of a disk whose stiffness is that of their speed at all speeds."""
        waves = self.waves and self.waves._replace(slopes=self.waves.slopes[:0])
        return self._replace(stiffening=self.stiffening[:0], waves=waves)

    @classmethod
    def planar(cls, omega: np.ndarray, normal: np.ndarray, tangential: np.ndarray) -> "Modes":
        """K modes of a planar structure, given by its contact points (C, K) alone."""
        none = np.zeros((0, len(omega)))
        return cls(omega, normal, tangential, none, tangential, np.eye(len(omega)))


def powers(speed: npt.ArrayLike, less: float) -> np.ndarray:
    """W² and W⁴ (..., 2) at speeds W (...) [rad/s], less those of another speed [rad/s]."""
    exponents = np.array([2, 4])
    return np.asarray(speed, dtype=float)[..., None] ** exponents - less**exponents


def craig_bampton(disk: Disk, n_modes: int) -> ReducedModel:
    """Reduce a disk to its contact points and the modes of the disk with these points held.

    n_modes: fixed-interface modes to keep, from 0 to all, rounded up to whole families.
    Source: Joachim, Nyssen, Batailly (2020), section 2.1.
    """
    n_modes = families.whole(n_modes, len(disk.blade_dof))
    basis = _craig_bampton_basis(disk, n_modes)
    mass, stiffness = project(disk.mass, basis), project(disk.stiffness, basis)
    blade_basis = basis[disk.blade_dof]  # (N, nb, m)
    blade_stiffness = project(disk.blade_stiffness, blade_basis)
    normal, tangential = basis[disk.contact_dof.T]
    angle, radius, blade = disk.contact_angle, disk.contact_radius, disk.contact_blade
    interface = planar_interface(angle, radius, normal, tangential, blade)
    stress = disk.blade_stress @ blade_basis  # (N, 2, m)
    faces = np.repeat(np.arange(len(stress)), stress.shape[1])
    interface = interface._replace(stress=np.concatenate(stress), stress_blade=faces)
    return reduced_model(mass, stiffness, blade_stiffness, basis, interface)


def reduced_model(
    mass: np.ndarray,
    stiffness: np.ndarray,
    blade_stiffness: np.ndarray,
    basis: np.ndarray,
    interface: Interface,
    speed: float = 0.0,
    stiffening: tuple = (),
) -> ReducedModel:
    """Make a ReducedModel with its tuned modes; the parameters are its members.

    stiffening: K1 and K2 on the coordinates, each (m, m); (): the stiffness is that of one speed.
    """
    eigenvalues, modes = eigh(stiffness, mass)
    tuned = modes, eigenvalues, project(blade_stiffness, modes)
    slopes = tuple(project(k, modes) for k in stiffening)
    return ReducedModel(mass, stiffness, blade_stiffness, basis, interface, *tuned, speed, slopes)


def mistuned_modes(
    reduced: ReducedModel, deviation: np.ndarray, speed: float | None = None
) -> Modes:
    """Modes of one mistuned sample on the basis of the tuned disk.

    deviation: (N,) relative change of each blade's stiffness [-].
    speed: of rotation, for frequencies and shapes [rad/s]; None: that of the reduced model.
    Source: Joachim, Nyssen, Batailly (2020), equation (3).
    """
    change = np.tensordot(deviation, reduced.modal_blade_stiffness, axes=1)
    np.einsum("ii->i", change)[:] += reduced.tuned_eigenvalues
    speed = reduced.speed if speed is None else speed
    faster = powers(speed, reduced.speed)
    for part, slope in zip(faster, reduced.stiffening, strict=False):
        change += part * slope
    eigenvalues, vectors = np.linalg.eigh(change)
    shapes = reduced.tuned_modes @ vectors
    interface = reduced.interface
    # for the same motion a stiffer blade has a higher stress, as its sections carry a higher force
    stiffer = 1.0 + np.asarray(deviation)[interface.stress_blade]
    stress = interface.stress if len(interface.stress) else np.zeros((0, len(shapes)))
    slopes = [np.einsum("ik,ik->k", vectors, k @ vectors) for k in reduced.stiffening]
    stiffening = np.array(slopes).reshape(-1, len(eigenvalues))
    air = reduced.air and reduced.air.at(faster)
    return Modes(
        omega=np.sqrt(np.maximum(eigenvalues, 0)),
        **{name: getattr(interface, name) @ shapes for name in MOTIONS},
        shapes=shapes,
        speed=speed,
        stiffening=stiffening,
        stress=stiffer[:, None] * (stress @ shapes),
        pairs=reduced.casing.seen_from(interface.angle) if reduced.casing else NO_PAIRS,
        waves=complex_modes(air, vectors, eigenvalues, stiffening) if air else None,
    )


def blade_stiffness(reduced: ReducedModel, deviation: np.ndarray, modes: Modes) -> np.ndarray:
    """Stiffness of every blade in the modes of a mistuned sample (N, K, K) [rad2/s2].

    reduced, deviation: parameters with which `mistuned_modes` made the modes.
    """
    return project((1.0 + deviation)[:, None, None] * reduced.blade_stiffness, modes.shapes)


def _craig_bampton_basis(disk: Any, n_modes: int) -> Any:
    """Static response to each contact dof, then fixed-interface modes (n, 2 n_c + n_modes)."""
    mass, stiffness = disk.mass, disk.stiffness
    boundary = disk.contact_dof.T.ravel()  # all u_r, then all u_t
    inside = np.setdiff1d(np.arange(len(mass)), boundary)
    K_ii = stiffness[np.ix_(inside, inside)]
    K_ib = stiffness[np.ix_(inside, boundary)]
    n_boundary = len(boundary)
    basis = np.zeros((len(mass), n_boundary + n_modes))
    basis[boundary, np.arange(n_boundary)] = 1
    basis[inside, :n_boundary] = -cho_solve(cho_factor(K_ii), K_ib)
    if n_modes > 0:
        M_ii = mass[np.ix_(inside, inside)]
        basis[inside, n_boundary:] = _families(K_ii, M_ii, n_modes, len(disk.blade_dof))
    return basis


def _families(K: Any, M: Any, n_modes: int, n_blades: int) -> Any:
    """Lowest modes in whole families; K and M have their rows sector by sector, in its frame."""
    values, modes = eigh(K, M, subset_by_index=[0, n_modes - 1])
    sectors = modes.reshape(n_blades, -1, n_modes)
    if families.choose(values, sectors, n_modes // n_blades, are_all=True) is not None:
        return modes
    values, modes = eigh(K, M)
    sectors = modes.reshape(n_blades, -1, len(K))
    return modes @ families.choose(values, sectors, n_modes // n_blades, are_all=True)


def project(matrices: Any, basis: np.ndarray) -> np.ndarray:
    """Symmetric basis^T matrix basis (..., m, m); matrices: (..., n, n), or one sparse (n, n)."""
    projected = np.swapaxes(basis, -1, -2) @ matrices @ basis
    return (projected + np.swapaxes(projected, -1, -2)) / 2
