"""The basis that mistuned disks share, against the modes of every disk by itself.

A small disk of solid elements, integrated by the tests (`evidence.truth.hexahedra`), with odd and
even numbers of blades. Truth: eigenvalues of the mistuned matrices; the matrices of a blade; the
motion of the tuned disk's modes.
"""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigvalsh

from evidence.truth.hexahedra import SMALL, disk_arrays
from hpcrub.model.aero import Curve, air_of
from hpcrub.model.damping import state_matrix
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.model.imported.cyclic import tuned_diameters
from hpcrub.model.interface import corresponding
from hpcrub.model.reduction import ReducedModel, mistuned_modes
from hpcrub.model.tuned_basis import tuned_basis

WIDE = np.array([0.5, -0.5, 0.1, -0.3, 0.4, 0.0])  # deviations [-]
KINDS = pytest.mark.parametrize(("n_blades", "by_modes"), [(5, False), (6, True), (4, False)])


@cache
def small_disk(n_blades: int = 5, by_modes: bool = False, n_families: int = 4) -> ReducedModel:
    """Blades with two contact points each, whose order is not that of the blades."""
    arrays = disk_arrays(SMALL._replace(n_sectors=n_blades), lean=0.3)
    arrays |= {name: arrays[name].reshape(n_blades, -1).T.ravel()
               for name in ("contact_node", "contact_blade")}  # fmt: skip
    disk = assembly.assemble(neutral.from_arrays(arrays))
    K1 = 0.3 * disk.mass + 1e-7 * disk.blade_stiffness  # the same on every sector
    spun = disk._replace(stiffness=(disk.stiffness[0], K1, -1e-9 * K1))
    model, _ = reduced.reduce_disk(spun, n_families * n_blades)
    return reduced.reduced_model(model, 0.0, by_modes)


def with_stress(model: ReducedModel) -> ReducedModel:
    """The model with three places of stress on each blade."""
    face = model.interface
    rows = np.concatenate([face.normal + face.axial, face.tangential[face.blade != -1]])
    places = np.concatenate([face.blade, face.blade])
    kept = np.r_[: len(face.blade), len(face.blade) : len(face.blade) + face.n_blades]
    return model._replace(
        interface=face._replace(stress=1e11 * rows[kept], stress_blade=places[kept])
    )


def in_air(model: ReducedModel) -> tuple[ReducedModel, np.ndarray]:
    """The model in air that differs from wave to wave, and the eigenvalues that it asks (N,)."""
    face, n = model.interface, model.interface.n_blades
    r = np.arange(n)
    curve = Curve(
        0, 0.01 + 0.004 * np.cos(2 * np.pi * r / n + 1.0), 2e-3 * np.sin(2 * np.pi * r / n)
    )
    on_blades = (face.tangential @ model.tuned_modes)[corresponding(face.blade)].transpose(1, 0, 2)
    air = air_of(curve, model.tuned_eigenvalues, tuned_diameters(model), on_blades)
    wanted = np.sqrt(air.squared) * (-curve.damping_ratio + 1j * (1.0 + curve.frequency_shift))
    return model._replace(air=air), wanted


def stiffness_of(modes):
    """Stiffness of a mistuned disk in the modes of its basis (K, K)."""
    blades = modes.blades
    change = np.einsum("b,bjk,bjl->kl", blades.deviation, blades.modes, blades.modes)
    return np.diag(modes.omega**2) + change


def test_a_disk_of_fewer_families_than_are_looked_at_keeps_them_all(monkeypatch):
    """It lost all deviations of its blades."""
    monkeypatch.setattr("hpcrub.model.tuned_basis.FAMILIES", 99)
    model, deviation = small_disk(5), 0.05 * np.sin(np.arange(5.0))
    found = np.sqrt(eigvalsh(stiffness_of(tuned_basis(model, 0.05).modes_of(deviation))))
    exact = mistuned_modes(model, deviation).omega
    assert np.abs(found / exact - 1.0).max() < 1e-5


@KINDS
def test_mistuned_disks_have_the_frequencies_of_their_own_modes(n_blades, by_modes):
    """In the six lowest families; what is left out of a blade's motion has the second order."""
    model, reference = small_disk(n_blades, by_modes), 0.5
    basis, n = tuned_basis(model, reference), 6 * n_blades
    assert len(basis.modes.omega) == len(model.mass)
    for deviation in (WIDE, np.zeros(6), np.full(6, reference), -0.2 * WIDE):
        exact = mistuned_modes(model, deviation[:n_blades]).omega[:n]
        found = np.sqrt(eigvalsh(stiffness_of(basis.modes_of(deviation[:n_blades]))))[:n]
        error = 6e-6 * (np.abs(deviation[:n_blades]).max() / 0.05) ** 2
        np.testing.assert_allclose(found, exact, rtol=max(error, 1e-11))


@KINDS
def test_rows_repeat_from_blade_to_blade_and_are_those_of_the_disk(n_blades, by_modes):
    """Blade by blade the two modes of a pair turn by 2πh/N, and a single mode keeps or turns over.

    The shapes are modes of the disk of stiffer blades, and the rows their motion.
    """
    reference = 0.3
    model = with_stress(small_disk(n_blades, by_modes))
    modes, face = tuned_basis(model, reference).modes, model.interface
    blades, omega = modes.blades, modes.omega
    h, of_stress = blades.diameters, corresponding(face.stress_blade)
    assert np.bincount(h).tolist() == [len(h) // n_blades * (1 if 2 * k % n_blades == 0 else 2)
                                       for k in range(n_blades // 2 + 1)]  # fmt: skip
    stiffness = model.stiffness + reference * model.blade_stiffness.sum(axis=0)
    low = np.abs(blades.modes[0]).max(axis=0) > 0.0
    for matrix, values in ((model.mass, np.ones_like(omega)), (stiffness, omega**2)):
        seen = modes.shapes.T @ matrix @ modes.shapes / np.outer(values, values) ** 0.5
        assert np.abs(seen[low][:, low] - np.eye(len(omega))[low][:, low]).max() < 1e-5
    known = {name: (getattr(modes, name)[blades.points], blades.points)
             for name in ("normal", "tangential", "axial")}  # fmt: skip
    known["observed"] = modes.observed[blades.observed], blades.observed
    known["stress"] = modes.stress[of_stress], of_stress
    for name, (rows, place) in known.items():
        exact = (getattr(face, name) @ modes.shapes)[place]
        assert np.abs(rows - exact).max() < 1e-6 * np.abs(exact).max()
    known["blade"] = blades.modes, None
    for rows, _ in known.values():
        turned = np.empty_like(rows)
        for k in range(len(h)):
            angle = 2.0 * np.pi * h[k] / n_blades
            if 2 * h[k] % n_blades == 0:
                turned[:, :, k] = np.cos(angle) * rows[:, :, k]
                continue
            first = (k - np.searchsorted(h, h[k])) % 2 == 0
            other = rows[:, :, k + 1 if first else k - 1]
            turned[:, :, k] = np.cos(angle) * rows[:, :, k] + np.sin(angle) * (
                -other if first else other
            )
        np.testing.assert_allclose(
            np.roll(rows, -1, axis=0), turned, atol=1e-12 * np.abs(rows).max()
        )


def test_a_disk_that_does_not_repeat_itself_has_no_basis():
    """One point that lies elsewhere, a point or a place of stress more, a family not whole."""
    model = small_disk(5)
    face = model.interface
    moved = face.normal.copy()
    moved[3] *= 1.01
    assert tuned_basis(model, 0.1) is not None
    assert tuned_basis(model._replace(interface=face._replace(normal=moved)), 0.1) is None
    other = "stress", "stress_blade", "stress_static", "second_order"
    parts = {name: part for name, part in face._asdict().items() if name not in other}
    more = face._replace(
        **{name: np.append(part, part[:1], axis=0) for name, part in parts.items()}
    )
    assert corresponding(more.blade).size < len(more.blade)
    assert tuned_basis(model._replace(interface=more), 0.1) is None
    stressed = with_stress(model).interface
    assert tuned_basis(model._replace(interface=stressed), 0.1) is not None
    fewer = stressed._replace(stress=stressed.stress[1:], stress_blade=stressed.stress_blade[1:])
    assert tuned_basis(model._replace(interface=fewer), 0.1) is None
    n = len(model.mass) - 1
    cut = model._replace(
        tuned_modes=model.tuned_modes[:, :n],
        tuned_eigenvalues=model.tuned_eigenvalues[:n],
        modal_blade_stiffness=model.modal_blade_stiffness[:, :n, :n],
    )
    assert tuned_basis(cut, 0.1) is None


def test_a_blade_stiffer_than_the_reference_is_refused():
    basis = tuned_basis(small_disk(5), 0.1)
    basis.modes_of(np.array([0.1, -0.5, 0.0, 0.05, 0.1]))
    with pytest.raises(ValueError, match="by more than the reference, 0.1"):
        basis.modes_of(np.array([0.1, -0.5, 0.0, 0.05, 0.11]))


@pytest.mark.parametrize("n_blades", [5, 6])
def test_frequencies_of_other_speeds_are_those_of_the_matrices_there(n_blades):
    """Exactly where rotation couples no families, else with an error of the second order.

    It does not depend on how stiff the reference is.
    """
    model = small_disk(n_blades)
    one = np.eye(len(model.mass))
    softer = model._replace(stiffening=(40.0 * one, -1e-5 * one))
    assert np.abs(model.stiffening[0] - np.diag(np.diag(model.stiffening[0]))).max() > 0.1
    for disk, part in ((softer, 0.0), (model, 0.2)):
        for deviation in (0.1 * WIDE[:n_blades], np.zeros(n_blades)):
            rest = mistuned_modes(disk, deviation).omega[:n_blades]
            for hz, reference in ((50.0, 0.05), (50.0, 0.5), (200.0, 0.05), (200.0, 0.5)):
                exact = mistuned_modes(disk, deviation, 2.0 * np.pi * hz).omega[:n_blades]
                change = np.abs(exact / rest - 1.0).max()
                modes = tuned_basis(disk, reference).modes_of(deviation).at(hz)
                found = np.sqrt(eigvalsh(stiffness_of(modes)))[:n_blades]
                assert change > 2e-3
                bound = 6e-6 * (np.abs(deviation).max() / 0.05) ** 2 + 1e-10
                bound += part * change * (change + np.abs(deviation).max())
                assert np.abs(found / exact - 1.0).max() < bound


def in_air_alone(modes, stiffness, n):
    """Eigenvalues of the lowest n motions of a disk in air without contact [1/s]."""
    K, D, family = stiffness.copy(), np.zeros_like(stiffness), np.ix_(*[modes.waves.rows] * 2)
    K[family] += modes.waves.stiffness
    D[family] = modes.waves.damping
    values = 1e4 * np.linalg.eigvals(state_matrix(D, K, 1e4))
    return sorted(values[values.imag > 0.0], key=lambda value: value.imag)[:n]


@pytest.mark.parametrize("reference", [0.0, 0.1])
def test_mistuned_disks_in_air_are_damped_as_their_own_modes(reference):
    """Air takes the frequency of a tuned blade, not that of each: 2 % of damping at 10 %."""
    model, n = in_air(small_disk(5))[0], 5
    deviation = np.minimum(0.05 * WIDE[:n], reference)
    own = mistuned_modes(model, deviation)
    exact = np.array(in_air_alone(own, np.diag(own.omega**2), n))
    modes = tuned_basis(model, reference).modes_of(deviation)
    found = np.array(in_air_alone(modes, stiffness_of(modes), n))
    np.testing.assert_allclose(found.imag, exact.imag, rtol=2e-5)
    np.testing.assert_allclose(found.real, exact.real, rtol=2e-2)
