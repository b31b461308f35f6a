"""The mesh of the fan from sections, and its reduction by cyclic symmetry.

The sections here are those of a straight blade of our own between two cones: what the mesh must do
with them is known. The reduction is held against the full sector: modes of the reduced model are
no lower than the exact ones, and all boundary and fixed-interface modes together are exact.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.calculix import POISSON, YOUNG
from evidence.rotor67 import frequencies, mesh, numbers, reduction, sections, stress
from evidence.truth.hexahedra import sector_arrays
from hpcrub.commands import import_model
from hpcrub.model.imported import cyclic, neutral
from hpcrub.model.imported.assembly import pair_sides
from hpcrub.model.imported.stress import COMPONENTS, von_mises
from hpcrub.results import model_file

FAN = "inputs/rotor67/rotor67.h5"
N_BLADES, CHORD, THICK = 22, 0.06, 0.004
ROWS, POINTS = 6, 101


@pytest.fixture(name="blade")
def sections_of_a_straight_blade(tmp_path):
    """Sections between a hub and a casing that narrow along the flow."""
    share = np.linspace(-0.5, 1.5, POINTS)
    on = (share >= 0) & (share <= 1)
    axial = np.tile(CHORD * share, (ROWS, 1))
    hub, casing = 0.1 + 0.1 * axial[0], 0.24 - 0.05 * axial[0]
    span = np.linspace(0.0, 1.0, ROWS)[:, None]
    radius = hub + span * (casing - hub)
    thick = np.where(on, THICK * np.sqrt(np.clip(1 - (2 * share - 1) ** 2, 0, 1)), 0.0)
    path = tmp_path / "sections.npz"
    first, last = np.flatnonzero(on)[[0, -1]]
    np.savez(path, axial_m=axial, radius_m=radius, r_theta_upper_m=np.tile(thick / 2, (ROWS, 1)),
             tangential_thickness_m=np.tile(thick, (ROWS, 1)), leading_edge=first,
             trailing_edge=last, n_blades=N_BLADES)  # fmt: skip
    return sections.read(path)


def test_mesh_of_sections(blade):
    """The sides pair, the tip keeps its clearance from the cone, the thickness is the section's."""
    made = mesh.sector(blade, mesh.Size(7, 4))
    low, high = made.sets["low"], made.sets["high"]
    assert pair_sides(made.nodes, low, high, N_BLADES)[2] < 1e-9
    tip = made.nodes[made.sets["tip"]]
    cone = 240.0 + 0.05 * tip[:, 2]  # z runs against the flow
    gap = (cone - np.hypot(tip[:, 0], tip[:, 1])) / np.hypot(1.0, 0.05)
    np.testing.assert_allclose(gap, sections.CLEARANCE, rtol=2e-3)  # the chord of a thin tip
    assert len(tip) == 8
    blade_nodes = made.nodes[np.unique(made.elements[made.blade_elements])]
    arc = np.hypot(*blade_nodes[:, :2].T) * np.arctan2(blade_nodes[:, 1], blade_nodes[:, 0])
    assert np.abs(arc).max() == pytest.approx(1e3 * THICK / 2, rel=2e-3)


def test_stress_recovered_from_displacements(blade):
    """A turned and stretched blade has the stress of the stretch; a bent one that of its curvature.

    Curvature k about y is a quadratic displacement, which the 20-node element knows exactly.
    """
    made = mesh.sector(blade, mesh.Size(7, 4))
    elements = made.elements[made.blade_elements]
    corner = np.unique(elements[:, :8])
    turn, along = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0], 1.001
    stretch = np.diag([along**-POISSON, along**-POISSON, along])
    moved = made.nodes @ (turn @ stretch - np.eye(3)).T
    inside = stress.by_rotation(made.nodes, elements, moved)
    found = stress.at_corners(inside, elements, len(made.nodes))
    np.testing.assert_allclose(von_mises(found[corner]), YOUNG * (along - 1), rtol=3e-3)
    k, (x, y, z) = 1e-6, made.nodes.T
    moved = k * np.column_stack([(POISSON * (y**2 - x**2) - z**2) / 2, -POISSON * x * y, x * z])
    gradient = stress.gradients(made.nodes, elements, moved)
    strain = (gradient + gradient.swapaxes(-1, -2)) / 2
    found = stress.at_corners(stress.elastic(strain), elements, len(made.nodes))
    expected = YOUNG * k * x[corner, None, None] * np.diag([0, 0, 1])
    np.testing.assert_allclose(found[corner], expected, atol=1e-3 * YOUNG * k * x.max())
    dof = np.array([(n, d) for n in range(len(made.nodes)) for d in (1, 2, 3)])
    rows = stress.operator(made.nodes, elements, dof) @ (1e-3 * moved.ravel())
    for place, component in enumerate(COMPONENTS):
        ours = found[corner][:, *component]
        np.testing.assert_allclose(rows[place::6], ours, atol=1e-9 * np.abs(found[corner]).max())


def test_cyclic_matrices_are_those_of_their_waves():
    """A cyclic matrix from its parts has the parts' eigenvalues, double ones twice."""
    rng = np.random.default_rng(1)
    n, m = 7, 3
    parts = []
    for diameters in range(n // 2 + 1):
        a = rng.normal(size=(m, m)) + 1j * (diameters > 0) * rng.normal(size=(m, m))
        parts.append(a @ a.conj().T)
    whole = reduction.whole(parts, n).reshape(n * m, n * m)
    np.testing.assert_allclose(whole, whole.T, atol=1e-12)
    values = [np.linalg.eigvalsh(part) for part in parts]
    expected = np.sort(np.concatenate([values[0], *(np.tile(v, 2) for v in values[1:])]))
    np.testing.assert_allclose(np.linalg.eigvalsh(whole), expected, rtol=1e-9, atol=1e-9)


def test_reduction_of_a_sector():
    """Reduced frequencies come down to the exact ones; at another speed they are that speed's."""
    model = neutral.from_arrays(sector_arrays())
    stiffer = model._replace(stiffness=(1.21 * model.stiffness[0],))
    for n_modes, limit in ((2, 0.2), (8, 0.01)):
        parts, stiffness = reduction.reduce([model, stiffer], 0, n_modes, 3)
        for diameters, (part, at_speeds) in enumerate(zip(parts, stiffness, strict=True)):
            exact = cyclic.sector_frequencies(model, diameters, 3)
            found = [np.sqrt(eigh(k, part.mass, eigvals_only=True)[:3]) / (2 * np.pi)
                     for k in at_speeds]  # fmt: skip
            assert (found[0] >= exact * (1 - 1e-9)).all()
            assert (found[0] <= exact * (1 + limit)).all()
            np.testing.assert_allclose(found[1][:2], 1.1 * found[0][:2], rtol=1e-9)


def test_numbers_of_another_program_are_compared(tmp_path):
    """A file with some of the numbers, without bounds, is held against ours."""
    ours = [numbers.Number("frequency", "mode 1", 100.0, "Hz", 99.0, 101.0)]
    numbers.write(tmp_path / "ours.csv", [*ours, numbers.Number("mass", "", 2.0, "kg")])
    theirs = tmp_path / "theirs.csv"
    Path(theirs).write_text("quantity,at,value\nfrequency,mode 1,102\n", encoding="utf-8")
    (row,) = numbers.compare(numbers.read(theirs), numbers.read(tmp_path / "ours.csv"))
    assert row[2:] == (102.0, 100.0, pytest.approx(2.0), False)


def test_numbers_of_fewer_fans_are_within_where_intervals_meet():
    """A percentile of few fans has its own interval, whose ends may be unknown."""
    nan = float("nan")
    ours = {("A", ""): numbers.Number("A", "", 1.05, "1", nan, 1.06)}
    for low, high, within in ((nan, 1.2, True), (1.055, 1.2, True), (1.07, 1.2, False)):
        theirs = {("A", ""): numbers.Number("A", "", 1.1, "1", low, high)}
        ((*_, found),) = numbers.compare(theirs, ours)
        assert found is within


def test_the_model_file_is_a_fan_that_can_be_mistuned(capsys):
    """Import of the file says that its blades have cantilever modes, not that they have nothing."""
    assert import_model.main(["model", FAN, "--speed-hz", "267"]) == 0
    said = capsys.readouterr().out
    assert "6 cantilever modes each alone" in said
    assert "blades' stiffness: none" not in said
    assert "22 blades, 6 to 6 contact nodes each" in said


def test_orders_are_natural_frequencies_at_the_speeds_of_the_crossings():
    """Interpolated frequencies had put them up to 0.05 Hz away; numbers.csv has the same ones."""
    fan, told = neutral.from_arrays(model_file.read(FAN)), []
    for family, diameters, order, speed in frequencies.near_design(fan):
        own = frequencies.families(fan, speed / frequencies.SPEED)[diameters, family - 1]
        assert own == pytest.approx(order * speed, rel=1e-9)
        told.append((f"engine order {order}, family {family}, {diameters} diameters", speed))
    rows = [n for n in numbers.read(numbers.TABLE).values() if n.quantity == "speed of a crossing"]
    assert [n.at for n in rows] == [at for at, _ in told]
    np.testing.assert_allclose([n.value for n in rows], [s for _, s in told], rtol=2e-6)
