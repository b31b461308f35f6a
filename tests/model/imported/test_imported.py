"""Imported disks: solid elements integrated by the tests, one sector against the whole disk.

Contact along the normals of a cone: one mass on three springs inside a conical casing.

The casing is a circle that presses the mass inwards by d along its normal n = (c, 0, s). The mass
has the stiffness k_r, k_t, k_z. At rest, with friction mu against +theta,

    u = -lam K^-1 (n + mu t),    n u = -d,    so lam = d / (c^2 / k_r + s^2 / k_z).

Without friction it slides freely along the generator e = (-s, 0, c), held to n u = -d, and vibrates
there about its rest with w^2 = (s^2 k_r + c^2 k_z) / m.
"""

import re

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh, eigvalsh
from scipy.optimize import brentq

from evidence.truth.hexahedra import SMALL, disk_arrays, sector_arrays
from hpcrub.commands import import_model
from hpcrub.errors import InputError
from hpcrub.model import crossings
from hpcrub.model.casing import CasingShape
from hpcrub.model.imported import (
    assembly,
    checks,
    craig_bampton,
    cyclic,
    frames,
    neutral,
    reduced,
)
from hpcrub.model.imported.arrays import stored
from hpcrub.model.imported.neutral import polynomial, stiffness_at
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import Motion
from hpcrub.results import model_file
from tests.program import refusal, whole

N = SMALL.n_sectors


@pytest.fixture(scope="module")
def sector():
    return neutral.from_arrays(sector_arrays())


@pytest.fixture(scope="module")
def disk():
    return assembly.assemble(neutral.from_arrays(disk_arrays()))


def dense_frequencies(K, M, n):
    return np.sqrt(eigh(K.toarray(), M.toarray(), eigvals_only=True)[:n]) / (2 * np.pi)


def test_disk_of_sectors_is_the_disk_meshed_whole(sector, disk):
    """The same mesh, assembled by element and by sector: the same eigenvalues."""
    turned = assembly.assemble(sector)
    assert turned.mass.shape == disk.mass.shape
    f, g = (dense_frequencies(d.stiffness[0], d.mass, 30) for d in (turned, disk))
    np.testing.assert_allclose(f, g, rtol=1e-9)
    blades = (d.row_blade[d.row[d.contact_node, 0]] for d in (turned, disk))
    np.testing.assert_array_equal(*blades)
    rows = (neutral.contact_rows(d).ravel() for d in (turned, disk))  # in the same order around
    seen, whole = (np.linalg.inv(d.stiffness[0].toarray())[np.ix_(at, at)]
                   for d, at in zip((turned, disk), rows, strict=True))  # fmt: skip
    np.testing.assert_allclose(seen, whole, atol=1e-9 * np.abs(whole).max())


def test_nodal_diameters_of_a_sector_are_all_modes_of_the_disk(sector, disk):
    """Single for 0 (and N/2) diameters, double for the others."""
    found = [cyclic.sector_frequencies(sector, h, 4) for h in range(N // 2 + 1)]
    found = np.sort(np.concatenate([found[0], *(np.repeat(f, 2) for f in found[1:])]))
    exact = dense_frequencies(disk.stiffness[0], disk.mass, 12)
    np.testing.assert_allclose(found[:12], exact, rtol=1e-8)


def test_modes_of_rows_without_mass_are_those_of_the_rows_condensed(disk):
    """As of the inner nodes of CalculiX's C3D8I; truth: static condensation (Guyan), exact here."""
    K, n = disk.stiffness[0].toarray()[:150, :150], 100
    M = np.zeros((150, 150))
    M[:n, :n] = disk.mass.toarray()[:n, :n]
    values, modes = craig_bampton.lowest_modes(sp.csc_array(K), sp.csc_array(M), 8)
    condensed = K[:n, :n] - K[:n, n:] @ np.linalg.solve(K[n:, n:], K[n:, :n])
    np.testing.assert_allclose(values, eigvalsh(condensed, M[:n, :n])[:8], rtol=1e-9)
    np.testing.assert_allclose(modes.T @ M @ modes, np.eye(8), atol=1e-9)


def test_craig_bampton_converges_from_above_and_keeps_static_displacements(disk):
    """Rayleigh-Ritz: no reduced frequency is below the disk's; statics of contact loads exact."""
    exact = dense_frequencies(disk.stiffness[0], disk.mass, 10)
    errors = []
    for n_modes in (0, 20, 60):
        model, basis = reduced.reduce_disk(disk, n_modes)
        values = eigh(model.stiffness[0], model.mass, eigvals_only=True)[:10]
        errors.append((np.sqrt(values) / (2 * np.pi) / exact - 1).max())
        assert (np.sqrt(values) / (2 * np.pi) / exact - 1).min() > -1e-9
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-4
    rows = neutral.contact_rows(disk).ravel()
    load = np.zeros(disk.mass.shape[0])
    load[rows[3]] = 1.0
    static = np.linalg.solve(disk.stiffness[0].toarray(), load)
    small = basis @ np.linalg.solve(model.stiffness[0], basis.T @ load)
    np.testing.assert_allclose(small[rows], static[rows], rtol=1e-8, atol=1e-12 * abs(static).max())


def test_reduced_model_in_cartesian_rows_has_the_same_interface_and_diameters(disk):
    """Contact rows turned to x, y by hand, and turned back by the importer."""
    model, _ = reduced.reduce_disk(disk, 5)
    face = reduced.interface(model)
    m, C = len(model.dof), len(model.contact_node)
    c, s = np.cos(face.angle), np.sin(face.angle)
    T = np.eye(m)  # Cartesian coordinates to cylindrical ones
    i, j = np.arange(C), C + np.arange(C)
    T[i, i], T[i, j], T[j, i], T[j, j] = c, s, -s, c
    arrays = neutral.to_arrays(model)
    arrays |= {"frame": np.array("cartesian"), "M": T.T @ model.mass @ T}
    arrays |= {"K": T.T @ model.stiffness[0] @ T, "K_blade": T.T @ model.blade_stiffness @ T}
    back = frames.to_cylindrical(neutral.from_arrays(arrays))
    for name in ("mass", "blade_stiffness"):
        a, b = getattr(back, name), getattr(model, name)
        np.testing.assert_allclose(a, b, atol=1e-12 * abs(b).max())
    np.testing.assert_allclose(reduced.interface(back).normal, face.normal)
    tables = [cyclic.frequencies_by_diameter(m, 0.0) for m in (neutral.from_arrays(arrays), model)]
    np.testing.assert_allclose(*tables, rtol=1e-9)


def test_stiffness_at_three_speeds_is_its_polynomial(sector):
    """K0 + W^2 K1 + W^4 K2 is found again from its values, and used at a fourth speed."""
    K0 = sector.stiffness[0]
    K1, K2 = 3.0 * sector.mass, 1e-8 * K0
    speeds = 2 * np.pi * np.array([10.0, 120.0, 300.0])
    at = [stiffness_at((K0, K1, K2), w) for w in speeds]
    found = polynomial(at, speeds)
    w = 2 * np.pi * 200.0
    exact = stiffness_at((K0, K1, K2), w)
    assert abs(stiffness_at(found, w) - exact).max() < 1e-12 * abs(exact).max()


def test_a_file_without_k2_is_one_whose_k2_is_zero(sector):
    """It may be left out; such a model could not be written or followed over the speed."""
    stiffness = sector.stiffness[0], sector.mass, sector.mass
    arrays = neutral.to_arrays(sector._replace(stiffness=stiffness))
    model = neutral.from_arrays({k: v for k, v in arrays.items() if not k.startswith("K2")})
    back = neutral.from_arrays(neutral.to_arrays(model))
    assert abs(back.stiffness[1] - sector.mass).max() == 0.0
    assert abs(back.stiffness[2]).max() == 0.0


def test_stiffness_of_turned_blades_is_not_that_between_them(sector):
    """A disk turned by degrees from speed to speed has its frequencies at each, but not between.

    Turning all displacements about z leaves mass and frequencies; the parabola through the entries
    of the turned matrices has others. Without turning it is exact.
    """
    speeds = np.array([0.0, 500.0, 900.0])

    def error(degrees):
        at = []
        for angle in np.deg2rad(degrees):
            c, s = np.cos(angle), np.sin(angle)
            one = sp.csr_array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            R = sp.kron(sp.eye_array(len(sector.nodes)), one).tocsr()
            at.append((R.T @ sector.stiffness[0] @ R).tocsr())
        model = sector._replace(stiffness=polynomial(at, speeds))
        return cyclic.between_speeds(model, speeds)[0]

    assert abs(error([0.0, 0.0, 0.0])) < 1e-9
    assert abs(error([0.0, 1.5, 6.0])) > 0.01


def test_units_of_the_file_do_not_matter(sector, disk):
    """mm, t, s: matrices in N/mm and t; and the speeds' polynomial in ms."""
    arrays = sector_arrays() | {"units": np.array("mm t ms")}
    arrays["nodes"] = arrays["nodes"] * 1e3
    arrays["K/data"] = arrays["K/data"] / 1e9  # t/ms2 is 1e9 N/m
    arrays["K_blade/data"] = arrays["K_blade/data"] / 1e9
    arrays["M/data"] = arrays["M/data"] / 1e3
    for part in ("data", "indices", "indptr"):
        arrays[f"K0/{part}"] = arrays.pop(f"K/{part}")
        arrays[f"K1/{part}"] = arrays[f"M/{part}"]
    model = neutral.from_arrays(arrays)
    assert abs(model.stiffness[1] - sector.mass).max() < 1e-12 * sector.mass.max()
    assert checks.check(model).mass == pytest.approx(checks.check(sector).mass, rel=1e-12)
    f = cyclic.sector_frequencies(model, 1, 2)
    np.testing.assert_allclose(f, cyclic.sector_frequencies(sector, 1, 2), rtol=1e-10)


def use(arrays):
    model = neutral.from_arrays(arrays)
    checks.check(model)
    assembly.assemble(model)
    if model.kind == "sector":
        cyclic.frequencies_by_diameter(model, 0.0)


def entry(values, place, factor):
    """A copy with one value times the factor."""
    return np.where(np.arange(len(values)) == place, factor * values, values)


@pytest.mark.parametrize("side", ["low", "high"])
def test_a_contact_node_of_two_sectors_is_named_once(side):
    """The rows of one side are those of the other one; low and high may be exchanged."""
    arrays = sector_arrays()
    arrays |= {"contact_node": [*arrays["contact_node"], *arrays[side][-1:]]}
    arrays |= {"contact_blade": np.zeros(len(arrays["contact_node"]), int)}
    model = neutral.from_arrays(arrays)._replace(blade_stiffness=None)
    if side == "low":
        assert len(assembly.assemble(model).contact_node) == N * len(arrays["contact_node"])
        return
    with pytest.raises(InputError, match="on the side of the sector that the next one has"):
        assembly.assemble(model)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (lambda a: {"K/data": entry(a["K/data"], 1, 1.5)}, "K: not symmetric"),
        (lambda a: {"M/data": entry(a["M/data"], 3, np.nan)}, "M: holds numbers that are not fin"),
        (lambda a: {"n_sectors": np.array(N + 1)}, "the sides do not pair"),
        (lambda a: {"contact_node": [*a["contact_node"], a["low"][-1]]}, "nodes lie on the tips"),
        (lambda a: {"nodes": 1e3 * a["nodes"]}, "the contact nodes lie at a radius of 220 m"),
        (lambda a: {"units": np.array("mm kg s")}, "the contact nodes lie at a radius of 0.0"),
        (lambda a: {"M/data": 1e-3 * a["M/data"]}, "units: a mass of"),  # kg in place of t
        (lambda a: {"K/data": 1e6 * a["K/data"]}, "units: the first natural frequency"),  # ms
        (lambda a: {"dof": np.roll(a["dof"], 1, axis=0)}, "a rigid motion causes forces"),
        (lambda a: {"M/data": None}, "M: this array is missing"),
        (lambda a: {"fixed": None}, "the disk is not held"),
        (lambda a: {"stifness": a["fixed"]}, "stifness: no array of a model file has this name"),
        (lambda a: {"low": a["low"] + 1000}, "low: there is no node"),
        (lambda a: {f"K_blade/{p}": a[f"K/{p}"] for p in ("data", "indices", "indptr")}, "hang to"),
    ],
)
def test_what_cannot_be_right_is_said_in_one_sentence(changes, words):
    arrays = sector_arrays()
    arrays |= changes(arrays)
    there = {name: values for name, values in arrays.items() if values is not None}
    assert words in refusal(use, there)


@pytest.mark.parametrize("factor", [1e3, 1e300])
def test_stiffness_of_blades_in_other_units_is_refused_by_the_import(disk, factor):
    small, _ = reduced.reduce_disk(disk, 20, 0.0)
    for model in (disk, small):
        with np.errstate(over="ignore"):
            huge = model._replace(blade_stiffness=factor * model.blade_stiffness)
        assert "times K at row" in refusal(checks.check, huge)
    assert "of which it must be a part" in refusal(reduced.reduced_model, huge, 0.0)


def test_contact_points_of_blades_correspond_by_their_places():
    """A list of nodes has no order; the places of real nodes are not exact, either."""
    arrays, rng = disk_arrays(), np.random.default_rng(4)
    noise = 1e-6 * rng.standard_normal(arrays["nodes"].shape)
    clearance = 1e-4 * rng.random(len(arrays["contact_node"]))
    shuffled = rng.permutation(len(clearance))
    listed = {"contact_clearance": clearance, "nodes": arrays["nodes"] + noise}
    spoilt = {name: (arrays | listed)[name][shuffled]
              for name in ("contact_node", "contact_blade", "contact_clearance")}  # fmt: skip
    found = neutral.from_arrays(arrays | listed | spoilt)
    clearances = dict(zip(arrays["contact_node"], clearance, strict=True))
    assert found.contact_clearance.tolist() == [clearances[node] for node in found.contact_node]
    assert (found.contact_blade == spoilt["contact_blade"]).all()
    model = reduced.reduced_model(reduced.reduce_disk(assembly.assemble(found), 20)[0], 0.0)
    points = np.column_stack([model.interface.radius, model.interface.axial_position])
    like, _ = cyclic.of_blades(points[None], model.interface.blade, model.interface.angle)
    assert np.ptp(like, axis=1).max() < 1e-5
    assert sorted(cyclic.tuned_diameters(model)[:N]) == [0, 1, 1, 2, 2]


def test_blades_are_numbered_around_the_disk_either_way():
    """Laws of neighbours and patterns go by the numbers; 0, 2, 4, 1, 3 goes around, but twice."""
    arrays = disk_arrays()
    for order in ([0, 1, 2, 3, 4], [3, 2, 1, 0, 4], [2, 3, 4, 0, 1]):
        use(arrays | {"contact_blade": np.array(order)[arrays["contact_blade"]]})
    twice = [0, 3, 1, 4, 2], "1 lies 2"
    for order, words in (([1, 0, 2, 3, 4], "2 lies 1"), ([0, 1, 3, 2, 4], "2 lies 3"), twice):
        spoilt = arrays | {"contact_blade": np.array(order)[arrays["contact_blade"]]}
        assert f"contact_blade: {words} pitches beyond" in refusal(use, spoilt)


def test_energy_of_a_blade_is_that_of_its_cantilever_modes_and_of_its_root(disk):
    """With all cantilever modes: u'K u = q' Lambda q + root' (Guyan stiffness) root, any u."""
    blade = 1
    rows = np.flatnonzero(disk.row_blade == blade)
    inner = reduced.inner_rows(disk)[blade]
    root = np.setdiff1d(rows, inner)
    assert len(root) == 3 * (SMALL.through + 1) * (SMALL.axial + 1)
    u = np.random.default_rng(2).standard_normal((disk.mass.shape[0], 3))
    frequencies, q = reduced.cantilever(disk, u, len(inner))
    modal = reduced.modal_stiffness(frequencies, q)[blade]
    K = disk.blade_stiffness.toarray()
    K_ri, K_ii = K[np.ix_(root, inner)], K[np.ix_(inner, inner)]
    guyan = K[np.ix_(root, root)] - K_ri @ np.linalg.solve(K_ii, K_ri.T)
    whole = u[rows].T @ K[np.ix_(rows, rows)] @ u[rows]
    np.testing.assert_allclose(modal + u[root].T @ guyan @ u[root], whole, rtol=1e-8)


def test_component_mode_mistuning_gives_the_frequencies_of_the_mistuned_disk(disk):
    """One family of blade modes, blades a few percent off: the first family of the whole disk."""
    deviation = 0.04 * np.array([1.0, -0.5, 0.2, -1.0, 0.7])
    K = disk.stiffness[0].toarray()
    for blade, change in enumerate(deviation):
        rows = np.flatnonzero(disk.row_blade == blade)
        K[np.ix_(rows, rows)] += change * disk.blade_stiffness[rows][:, rows].toarray()
    exact = np.sqrt(eigh(K, disk.mass.toarray(), eigvals_only=True)[:N])
    model, _ = reduced.reduce_disk(disk, 80)
    part = reduced.modal_stiffness(model.blade_frequencies[:, :3], model.participation[:, :3])
    K_r = model.stiffness[0] + np.tensordot(deviation, part, axes=1)
    found = np.sqrt(eigh(K_r, model.mass, eigvals_only=True)[:N])
    tuned = np.sqrt(eigh(model.stiffness[0], model.mass, eigvals_only=True)[:N])
    assert abs(found / exact - 1).max() < 0.05 * abs(tuned / exact - 1).max()


def test_a_file_of_several_speeds_knows_them_after_its_reduction_too(sector, tmp_path, capsys):
    """Its crossings had no star, and what was written of it did not tell the speeds."""
    arrays = neutral.to_arrays(sector)
    at = {"speeds_hz": np.array([0.0, 200.0, 600.0])}
    for name, speed in zip(neutral.AT_SPEEDS, at["speeds_hz"], strict=True):
        spun = sector.stiffness[0] + 0.3 * (2 * np.pi * speed) ** 2 * sector.mass
        at |= stored(name, sp.csr_array(sp.triu(spun)))
    whole = {name: a for name, a in arrays.items() if name.partition("/")[0] != "K"} | at
    names = [str(tmp_path / name) for name in ("at_speeds.h5", "reduced.h5")]
    model_file.write(names[0], whole)
    said = []
    for name, more in zip(names, (["--reduce", "10", "--output", names[1]], []), strict=True):
        assert import_model.main(["model", name, *more]) == 0
        out = capsys.readouterr().out
        said.append(re.findall(r"n_d = \d+: [\d.]+\*?", out))
        assert "extrapolated beyond 0 to 600 Hz" in out
    for found in said:
        hz = [float(words.split(": ")[1].rstrip("*")) for words in found]
        assert [words.endswith("*") for words in found] == [value > 600.0 for value in hz]
        assert min(hz) < 600.0 < max(hz)


def test_first_crossing_is_where_the_first_frequency_is_the_engine_order(sector):
    """Bisection of f(W) - n W on the full sector, speed by speed; rotation stiffens unevenly."""
    n_rows = len(sector.dof)
    K1 = sp.diags_array(np.linspace(0.0, 0.6, n_rows)) @ sector.mass
    K1 = (K1 + K1.T) / 2
    spun = sector._replace(stiffness=(sector.stiffness[0], K1, -1e-9 * K1))
    for speed in (0.0, 2 * np.pi * 150.0):
        pencils = list(cyclic.pencils(spun, sorted({0.0, speed})))
        for diameters, order in ((2, 2), (1, N - 1), (0, N)):

            def beyond(hz, h=diameters, n=order):
                return cyclic.sector_frequencies(spun, h, 1, 2 * np.pi * hz)[0] - n * hz

            exact = brentq(beyond, 0.0, 3.0 * beyond(0.0) / order)
            found = crossings.speeds(*pencils[diameters], order)[0] / (2 * np.pi)
            assert found == pytest.approx(exact, rel=2e-5 if speed else 2e-3)


def test_a_single_blade_meets_an_order_where_its_quadratic_says_or_never():
    """f0^2 + B W^2 = n^2 W^2: W = f0 / sqrt(n^2 - B), and never for B above n^2."""
    K, M = np.array([[4e4]]), np.array([[2.0]])
    for order, slope in ((1, 0.7), (2, 0.7), (2, 3.9)):
        (found,) = crossings.speeds((K, slope * M), M, order)
        assert found == pytest.approx(np.sqrt(2e4 / (order**2 - slope)), rel=1e-12)
    assert len(crossings.speeds((K, 1.2 * M), M, 1)) == 0
    (alone,) = crossings.speeds((K,), M, 3)
    assert alone == pytest.approx(np.sqrt(2e4) / 3, rel=1e-12)


def test_crossing_of_a_reduced_disk_does_not_depend_on_the_speed_of_its_modes(disk):
    K1 = 0.3 * disk.mass + 2e-8 * disk.blade_stiffness  # the same on every sector
    small, _ = reduced.reduce_disk(disk._replace(stiffness=(disk.stiffness[0], K1)), 20, 0.0)
    found = []
    for speed in (0.0, 2 * np.pi * 200.0):
        model = reduced.reduced_model(small, speed)
        face = model.interface
        tips = np.array([rows @ model.tuned_modes for rows in (face.normal, face.tangential)])
        diameters = cyclic.diameters_of(tips, face.blade, face.angle)
        found.append(crossings.of_disk(model, diameters, N + 2))
        at = model.speed**2 - (2 * np.pi * found[-1]) ** 2
        K = model.stiffness - at * small.stiffness[1]
        squares = eigh(K, model.mass, eigvals_only=True)
        order = 2 * np.pi * (N + 2) * found[-1]
        assert abs(np.sqrt(squares) / order - 1).min() < 1e-6
    assert found[0] == pytest.approx(found[1], rel=1e-6)


MASS, STIFFNESS = 0.3, np.array([4e5, 7e5, 1.5e5])
C, S, PRESSED = np.cos(0.4), np.sin(0.4), 1e-4


def one_mass(normal=(C, 0.0, S)):
    return {
        "hpcrub_model": np.array(1),
        "kind": np.array("reduced"),
        "M": MASS * np.eye(3),
        "K": np.diag(STIFFNESS),
        "nodes": np.array([[0.2, 0.0, 0.03]]),
        "dof": np.array([[0, 1], [0, 2], [0, 3]]),
        "contact_node": np.array([0]),
        "contact_clearance": np.array([-PRESSED]),
        "contact_normal": np.array([normal]),
    }


def motion_of(friction, damping, duration, start=None):
    """Times, displacements u_r, u_t, u_z (R, 3) and normal force (R,) at one speed."""
    model = reduced.reduced_model(neutral.from_arrays(one_mass()), 0.0)
    modes = mistuned_modes(model, np.zeros(1))
    scene = Scene(model.interface, damping, CasingShape(1, 0.0), 0.0, 1e-3, friction, step=2e-6)
    speed = np.array([80.0])
    motion = Motion.at_rest(1, 3)
    if start is not None:
        motion.position[0] = np.linalg.solve(modes.shapes, start)
    names = "time", "position", "normal_force"
    time, position, force = whole(modes, scene, speed, duration, *names, motion=motion)
    return time[:, 0], position[:, :, 0] @ modes.shapes.T, force[:, 0, 0]


def test_a_mass_pressed_by_a_cone_rests_where_statics_say():
    mu = 0.3
    _, u, force = motion_of(mu, 0.1, 0.5)
    expected = PRESSED / (C**2 / STIFFNESS[0] + S**2 / STIFFNESS[2])
    np.testing.assert_allclose(force[-50:], expected, rtol=1e-6)
    rest = -expected * np.array([C, mu, S]) / STIFFNESS
    np.testing.assert_allclose(u[-1], rest, rtol=1e-6)


def test_a_mass_held_by_a_cone_vibrates_along_its_generator():
    generator, normal = np.array([-S, 0.0, C]), np.array([C, 0.0, S])
    w = np.sqrt(generator**2 @ STIFFNESS / MASS)
    middle = PRESSED * (generator * STIFFNESS @ normal) / (generator**2 @ STIFFNESS)
    start = middle + 0.2 * PRESSED
    time, u, force = motion_of(0.0, 0.0, 0.05, -PRESSED * normal + start * generator)
    assert (force > 0.0).all()
    np.testing.assert_allclose(u @ normal, -PRESSED, rtol=1e-9)
    np.testing.assert_allclose(u[:, 1], 0.0, atol=1e-12)
    exact = middle + (start - middle) * np.cos(w * time)
    np.testing.assert_allclose(u @ generator, exact, atol=2e-3 * abs(start - middle))


@pytest.mark.parametrize("normal", [(2.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (C, S, 0.0)])
def test_vectors_that_are_no_normals_of_a_casing_are_refused(normal):
    with pytest.raises(InputError, match="contact_normal: unit vectors"):
        neutral.from_arrays(one_mass(normal))


def test_normals_go_through_a_file_and_a_cylinder_needs_none():
    model = neutral.from_arrays(one_mass())
    back = neutral.from_arrays(neutral.to_arrays(model))
    np.testing.assert_array_equal(back.contact_normal, [[C, 0.0, S]])
    face = reduced.reduced_model(back, 0.0).interface
    np.testing.assert_allclose([face.normal, face.axial], [[[C, 0.0, S]], [[-S, 0.0, C]]])
    assert "contact_normal" not in neutral.to_arrays(neutral.from_arrays(one_mass((1.0, 0.0, 0.0))))
