"""Second order of imported blades, held against large displacements of solid elements."""

import numpy as np
import pytest

from evidence.blisk.mesh import sector
from evidence.truth.hexahedra import SMALL, about, matrices, sector_arrays, stored
from hpcrub.commands import import_bending, import_model
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, bending, bent_blades, neutral, reduced
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cartesian
from hpcrub.model.imported.reduced import inner_rows
from hpcrub.model.imported.second_order import second_order
from hpcrub.results import model_file

P = 3
BLADE = SMALL._replace(span=4, thickness=8.0)


def blade_arrays(nodes, elements, root, tips, K=None):
    """Arrays of a model file of one blade alone, its root held."""
    stiffness, mass = matrices(nodes, elements)
    node, direction = np.divmod(np.arange(3 * len(nodes)), 3)
    arrays = {
        "hpcrub_model": np.array(1),
        "kind": np.array("disk"),
        "nodes": nodes,
        "dof": np.column_stack([node, direction + 1]),
        "fixed": (3 * root[:, None] + np.arange(3)).ravel(),
        "contact_node": tips,
    }
    return arrays | stored(K=stiffness if K is None else K, M=mass)


class Alone:
    """One blade alone: nodes [m], elements, nodes of root and tip, modes (n, 3, P) in x, y, z."""

    def __init__(self, nodes, elements, root, tips):
        self.nodes, self.elements, self.root, self.tips = nodes, elements, root, tips
        self.model = neutral.from_arrays(blade_arrays(nodes, elements, root, tips))
        self.free = np.setdiff1d(np.arange(3 * len(nodes)), self.model.fixed)
        self.K, self.M = (a[self.free][:, self.free].tocsc() for a in matrices(nodes, elements))
        self.squares, phi = lowest_modes(self.K, self.M, P)
        self.phi = np.zeros((3 * len(nodes), P))
        self.phi[self.free] = phi
        self.phi = self.phi.reshape(-1, 3, P)

    def bent(self, eps=1e-4):
        """What `bending` makes of these."""
        return bending.of_blade(self.model, self.shapes(eps))

    def shapes(self, eps=1e-4):
        """The blade bent into its modes, as far as eps [m] at most."""
        shapes = []
        for mode in range(P):
            moved = eps / np.abs(self.phi[..., mode]).max() * self.phi[..., mode]
            both = [about(self.nodes, self.elements, sign * moved)[0] for sign in (1, -1)]
            models = [
                neutral.from_arrays(
                    blade_arrays(self.nodes, self.elements, self.root, self.tips, K)
                )
                for K in both
            ]
            shapes.append(bending.BentShape(moved, *models))
        return shapes

    def rest(self, load):
        """Displacements (n, 3) at rest under a load (n, 3) [N], by Newton's method."""
        moved = np.zeros_like(self.nodes)
        for _ in range(20):
            K, inner = about(self.nodes, self.elements, moved)
            left = (load - inner).ravel()[self.free]
            step = np.zeros(3 * len(self.nodes))
            step[self.free] = np.linalg.solve(K[self.free][:, self.free].toarray(), left)
            moved = moved + step.reshape(-1, 3)
            if np.abs(step).max() < 1e-13:
                return moved
        raise AssertionError("no rest")


@pytest.fixture(scope="module")
def twisted():
    """The blade of a twisted, tapered blisk."""
    mesh = sector(BLADE)
    elements = mesh.elements[mesh.blade_elements]
    used, numbers = np.unique(elements, return_inverse=True)
    rim = np.unique(np.delete(mesh.elements, mesh.blade_elements, axis=0))
    root, tips = (np.searchsorted(used, a) for a in (np.intersect1d(used, rim), mesh.sets["tip"]))
    return Alone(mesh.nodes[used] / 1e3, numbers.reshape(elements.shape), root, tips)


def test_a_blade_bent_by_its_modes_rests_where_the_second_order_says(twisted):
    """Truth: Newton's method on the same elements; the error is of third order, an eighth a half.

    A load on the modes alone bends the blade by s: w^2 s + s C s / 2 = load.
    """
    bent, errors = twisted.bent(), []
    signs = np.sign(np.einsum("cda,cda->a", tip_motion(twisted, twisted.phi), bent.modes))
    first = np.array([0.004, 0.001, 0.0005]) / np.abs(twisted.phi[twisted.tips]).max(axis=(0, 1))
    for size in (1.0, 0.5, 0.25):
        wanted = size * signs * first  # of the modes of `bent`
        s = wanted - np.einsum("abc,b,c->a", bent.coupling, wanted, wanted) / 2 / twisted.squares
        force = (twisted.phi @ (signs * wanted * twisted.squares)).ravel()
        load = np.zeros(3 * len(twisted.nodes))
        load[twisted.free] = twisted.M @ force[twisted.free]
        exact = tip_motion(twisted, twisted.rest(load.reshape(-1, 3))[..., None])[..., 0]
        told = bent.modes @ s - np.einsum("cdab,a,b->cd", bent.tips, s, s) / 2
        errors.append([np.abs(told - exact).max(), np.abs(bent.modes @ wanted - exact).max()])
    third, second = np.array(errors).T
    np.testing.assert_allclose(second[:-1] / second[1:], 4.0, rtol=0.15)
    np.testing.assert_allclose(third[:-1] / third[1:], 8.0, rtol=0.15)
    assert third[0] < 0.1 * second[0]


def tip_motion(blade, field):
    """Radial, tangential and axial parts (C, 3, k) at the tips of displacements (n, 3, k)."""
    nodes = blade.nodes[blade.tips] * [1.0, -1.0, 1.0]  # turned back
    return to_cartesian(nodes, field[blade.tips])


@pytest.fixture(scope="module")
def blisk(twisted):
    """Arrays of one sector of a blisk of this blade, with its second order."""
    own = neutral.from_arrays(sector_arrays(BLADE))
    told = bending.onto(own, twisted.model, twisted.bent()).bent
    return sector_arrays(BLADE) | bent_blades.stored(told)


@pytest.fixture(scope="module")
def fan(blisk):
    """The whole disk and its reduced model."""
    disk = assembly.assemble(neutral.from_arrays(blisk))
    return disk, *reduced.reduce_disk(disk, 150)


def test_amplitudes_of_all_blades_are_those_of_the_modes_of_the_file(fan, blisk):
    """A disk that moves as one blade alone in its mode has the amplitude one there, by its sign."""
    disk, small, basis = fan
    told = second_order(small)
    assert told.participation.shape == (BLADE.n_sectors, P, basis.shape[1])
    for blade in range(BLADE.n_sectors):
        mine = small.contact_blade == blade
        rows = neutral.contact_rows(disk)[:, mine].T  # (tips, 3)
        inner = inner_rows(disk)[blade]
        for mode in range(P):
            K, M = (a[inner][:, inner].tocsc() for a in (disk.stiffness[0], disk.mass))
            field = np.zeros(len(disk.dof))
            field[inner] = lowest_modes(K, M, P)[1][:, mode]
            field *= np.sign((field[rows] * small.bent.modes[mine, :, mode]).sum())
            kept = np.linalg.solve(small.mass, basis.T @ (disk.mass @ field))
            amplitude = told.participation @ kept
            assert amplitude[blade, mode] == pytest.approx(1.0, abs=0.05)
            assert np.abs(np.delete(amplitude.ravel(), P * blade + mode)).max() < 0.1


def test_signs_do_not_depend_on_what_stiffens_the_disk(fan):
    """Modes of blades at rest, and the stiffness of a disk at one speed: the same signs."""
    small = fan[1]
    spun = small._replace(stiffness=(small.stiffness[0] + 4e6 * small.mass,))
    told, other = second_order(small), second_order(spun)
    np.testing.assert_array_equal(told.participation, other.participation)
    flipped = small.bent._replace(modes=-small.bent.modes)
    turned = second_order(small._replace(bent=flipped))
    np.testing.assert_array_equal(turned.participation, -told.participation)


def test_units_and_sense_of_rotation_change_numbers_and_not_the_blade(blisk, fan):
    """Radial parts stay, tangential and axial ones turn round with the axes; C has none."""
    length, mass, time = 1e3, 1e-3, 1e3  # of a model in mm, t, ms
    there = dict(blisk)
    for name, power in (("K", 2), ("M", 0), ("K_blade", 2)):
        there[f"{name}/data"] = mass / time**power * blisk[f"{name}/data"]
    there["nodes"] = blisk["nodes"] * length
    there["second_order_tips"] = blisk["second_order_tips"] / (mass * length)
    there["second_order_modes"] = blisk["second_order_modes"] / np.sqrt(mass)
    there["second_order_blade"] = blisk["second_order_blade"] / (length * np.sqrt(mass) * time**2)
    there["units"] = np.array("mm t ms")
    own, other = neutral.from_arrays(blisk).bent, neutral.from_arrays(there).bent
    for a, b in zip(own, other, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12 * np.abs(a).max())
    flip = np.array([1.0, -1.0, -1.0])
    back = neutral.from_arrays(blisk | {"turns": np.array(-1)}).bent
    np.testing.assert_array_equal(back.tips, flip[:, None, None] * own.tips)
    np.testing.assert_array_equal(back.modes, flip[:, None] * own.modes)
    np.testing.assert_array_equal(back.coupling, own.coupling)
    again = neutral.from_arrays(neutral.to_arrays(fan[1])).bent
    for a, b in zip(fan[1].bent, again, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-14)  # means of sums that are rounded


def test_directions_are_those_of_a_conical_casing(fan):
    """Normal and generator are the radial and the axial direction turned by the cone's angle."""
    small, angle = fan[1], 0.3
    normal = np.tile([np.cos(angle), 0.0, -np.sin(angle)], (len(small.contact_node), 1))
    flat, cone = second_order(small), second_order(small._replace(contact_normal=normal))
    c, s = np.cos(angle), np.sin(angle)
    radial, tangential, axial = flat.shortening.swapaxes(0, 1)
    turned = np.stack([c * radial - s * axial, tangential, c * axial + s * radial], axis=1)
    np.testing.assert_allclose(cone.shortening, turned, rtol=1e-12)
    np.testing.assert_allclose(cone.curvature, c * flat.curvature, rtol=1e-12)
    np.testing.assert_array_equal(cone.observed, flat.observed)


def folder_of(twisted, folder, unit):
    """The folder of --second-order, its tables in a unit [m]."""
    one = twisted.model._replace(blade_stiffness=twisted.model.stiffness[0])
    model_file.write(folder / "blade.h5", neutral.to_arrays(one))
    for number, shape in enumerate(twisted.shapes(), 1):
        for name in ("forwards", "backwards"):
            arrays = neutral.to_arrays(getattr(shape, name))
            model_file.write(folder / f"{name}_{number}.h5", arrays)
        table = np.column_stack([twisted.nodes, shape.moved])[::-1] / unit
        names = ",".join(import_bending.COLUMNS)
        np.savetxt(folder / f"bent_{number}.csv", table, delimiter=",", header=names, comments="")
    return folder


def test_a_folder_of_a_bent_blade_is_imported(twisted, blisk, tmp_path, capsys):
    """The command makes of files what the library makes of the same blade, in any unit."""
    model_file.write(tmp_path / "sector.h5", sector_arrays(BLADE))
    options = ["--second-order", str(folder_of(twisted, tmp_path, 1e-3)), "--table-units", "mm t s"]
    out = tmp_path / "out.h5"
    command = ["model", str(tmp_path / "sector.h5"), *options, "--output", str(out)]
    assert import_model.main(command) == 0
    assert "shortens a blade by" in capsys.readouterr().out
    for name in (bent_blades.TIPS, bent_blades.BLADE, bent_blades.MODES):
        told, exact = model_file.read(out)[name], blisk[name]
        np.testing.assert_allclose(told, exact, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("bent_1.csv", "x,y,z,ux,uy,uz\n0,0,0,1,1,1\n", "no row for the node at"),
        ("bent_1.csv", None, "there is no"),
        ("bent_2.csv", "bent_1.csv", "bent shape 2 is not mode 2 of the blade"),
        ("forwards_1.h5", "sector.h5", "one blade alone is expected"),
    ],
)
def test_a_folder_that_cannot_be_right_is_refused(twisted, tmp_path, name, text, message):
    model_file.write(tmp_path / "sector.h5", sector_arrays(BLADE))
    folder = folder_of(twisted, tmp_path, 1.0)
    if text is None:
        (folder / name).unlink()
    elif (folder / text).exists():
        (folder / name).write_bytes((folder / text).read_bytes())
    else:
        (folder / name).write_text(text)
    model = neutral.from_arrays(sector_arrays(BLADE))
    with pytest.raises(InputError, match=message):
        import_bending.with_second_order(model, folder, 1.0)


def changed(name, change):
    return lambda arrays: arrays | {name: change(arrays[name].copy())}


def unequal(values):
    values[..., 0, 1] *= 1.1
    return values


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (changed("second_order_tips", unequal), "second_order_tips: not symmetric"),
        (changed("second_order_blade", unequal), "second_order_blade: not symmetric"),
        (changed("second_order_tips", lambda a: -a), "second_order_tips: the blade becomes longer"),
        (changed("second_order_tips", lambda a: 1e3 * a), "shorter by .* are the units"),
        (changed("second_order_tips", lambda a: 1e-3 * a), "shorter by .* are the units"),
        (changed("second_order_blade", lambda a: 1e3 * a), "second_order_blade: .* are the units"),
        (changed("second_order_tips", lambda a: a[1:]), "second_order_tips: of 9, and there"),
        (changed("second_order_modes", lambda a: a[:, :, :0]), "modes: 0 modes, 1 to 6"),
        (changed("second_order_modes", lambda a: a[:, :, [0, 2, 1]]), "mode 1 does not move"),
        (lambda a: {k: v for k, v in a.items() if "_tips" not in k}, "second_order_tips: this"),
        (lambda a: {k: v for k, v in a.items() if "blade_" not in k}, "modes: 3 modes, .* have 0"),
    ],
)  # fmt: skip
def test_a_second_order_that_cannot_be_right_is_refused(fan, spoil, message):
    arrays = neutral.to_arrays(fan[1]._replace(blade_stiffness=None))
    with pytest.raises(InputError, match=message):
        second_order(neutral.from_arrays(spoil(arrays)))
