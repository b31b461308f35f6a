"""Studies of model files: the planar disk through a file, keys that the file fills in, refusals."""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.hexahedra import SMALL, sector_arrays
from evidence.truth.planar import planar_arrays
from hpcrub import studies
from hpcrub.__main__ import main as program
from hpcrub.commands import import_model
from hpcrub.config import resolution
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.disk import build_disk
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.results import model_file
from hpcrub.setup import imported, input_files, plausibility
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_model, build_problem
from hpcrub.studies import modal
from tests.program import refusal, swept

SECTOR = "disk: {model: sector.h5}\n"


@pytest.fixture
def sector(folder):
    """The working folder, with the model file of a sector."""
    model_file.write("sector.h5", sector_arrays())
    return folder


def read(text):
    return imported.resolved(Config.from_yaml(text))


def study_of(arrays, text=""):
    """Config of a study of the model file model.h5, which holds these arrays from now on."""
    model_file.write("model.h5", arrays, overwrite=True)
    return read("disk: {model: model.h5}\n" + text)


def reduced_arrays(n_modes=6):
    disk = assembly.assemble(neutral.from_arrays(sector_arrays()))
    return neutral.to_arrays(reduced.reduce_disk(disk, n_modes)[0])


def test_contact_of_the_planar_disk_is_that_of_its_model_file(folder):
    """A mistuned disk over two revolutions: to rounding, which its impacts enlarge."""
    text = "reduction: {n_modes: 24}\n"
    text += "steady_state: {first_check_s: 0.01, max_time_s: 0.06, window_revolutions: 1}"
    built_in = Config.from_yaml(text)
    ours = study_of(planar_arrays(build_disk(built_in.disk, built_in.material)), text)
    assert ours.n_coordinates == built_in.n_coordinates
    assert ours.disk.n_blades == 12
    blades = np.linspace(-0.01, 0.01, 12)
    found = [swept(config, blades, [34.0, 34.5]) for config in (built_in, ours)]
    assert (found[0].amplitude > 1e-3).all()
    assert (found[0].max_sweeps > 0).all()
    np.testing.assert_allclose(found[1].amplitude, found[0].amplitude, rtol=1e-5)
    np.testing.assert_allclose(found[1].localisation, found[0].localisation, rtol=1e-4)


def test_rows_of_a_rotation_at_contact_nodes_are_no_direction(folder):
    """Beams have rows x, y and a rotation; the study ended after its work with a traceback."""
    brief = "reduction: {n_modes: 24}\n"
    disk = build_disk(Config().disk, Config().material)
    arrays = planar_arrays(disk)
    tips = disk.contact_dof[:, 1] + 1
    assert (arrays["dof"][tips] == (-1, 0)).all()  # rows of their own
    arrays["dof"][tips] = np.column_stack([arrays["contact_node"], np.full(len(tips), 6)])
    config = study_of(arrays, brief)
    assert config.n_coordinates == Config.from_yaml(brief).n_coordinates
    assert len(build_problem(config).reduced.tuned_eigenvalues) == config.n_coordinates


def test_nodes_with_a_clearance_of_their_own_get_the_step_of_both_together(folder):
    """It was "inf steps per bump width", and too long a step, where nodes stand out by 21.5 mm."""
    arrays, text = sector_arrays(), "casing: {bump_height_mm: 0.155, clearance_mm: %g}"
    one = neutral.from_arrays(arrays | {"contact_clearance": np.ones(2)}).contact_clearance[0]
    out = -21.5e-3 / one  # in the units of the file
    plain = study_of(arrays, text % 0.1)
    near = study_of(arrays | {"contact_clearance": np.full(2, out)}, text % 21.6)
    assert resolution.bump_time(near) == pytest.approx(resolution.bump_time(plain))
    assert near.step == pytest.approx(plain.step)


def test_nodes_of_all_blades_meet_the_same_strips_of_a_coating(folder):
    """Places are rounded where a mesh is written; each blade met strips of its own."""
    arrays = reduced_arrays()
    arrays["nodes"] += 5e-6 * np.random.default_rng(6).uniform(-1, 1, arrays["nodes"].shape)
    config = study_of(arrays, "contact: {law: abradable, coating: {tip_area_mm2: 420}}")
    scene = build_problem(config).scene
    assert (config.disk.n_strips, scene.n_strips) == (2, 2)
    at = scene.interface.axial_position
    np.testing.assert_array_equal(scene.interface.strip, at > 0.0)


def test_keys_that_the_model_file_fills_in(sector):
    config = read(SECTOR + "reduction: {n_modes: 7}")
    d = config.disk
    assert (d.n_blades, d.n_contact_nodes, d.n_directions) == (5, 10, 3)
    assert d.tip_radius_mm == pytest.approx(SMALL.tip)
    assert config.n_coordinates == 40  # 7 modes are two families of 5 blades
    assert Config.from_yaml(config.to_yaml()) == config  # without the file
    assert study_of(reduced_arrays(7)).reduction.n_modes == 10


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("disk: {model: none.h5}", "none.h5: cannot be read"),
        ("mistuning: {pattern: [1, 2, 3]}", "3 values given for the 5 blades"),
        ("mistuning: {pattern_unit: hz, pattern: [1, 1, 1, 1, 9]}", "less than 100 % is allowed"),
    ],
)
def test_keys_that_do_not_fit_are_refused(sector, keys, words):
    with pytest.raises(InputError, match=words):
        read(keys if "model" in keys else SECTOR + keys)


MEASURED = SECTOR + "mistuning: {by: cantilever_modes, pattern_unit: hz, pattern: "


def test_measured_frequencies_deviate_from_their_mean(sector):
    config = read(MEASURED + "[99, 101, 100, 102, 98]}")
    exact = np.array([0.99, 1.01, 1.0, 1.02, 0.98]) ** 2 - 1
    np.testing.assert_allclose(config.pattern_deviation, exact, rtol=1e-12)
    problem = build_problem(config)
    tuned, mistuned = (modes_of(config, problem, d).omega for d in (np.zeros(5), exact))
    assert 0.005 < abs(mistuned[:5] / tuned[:5] - 1).max() < 0.02


def test_measured_frequencies_come_from_a_table(sector):
    sector.joinpath("bench.csv").write_text("99,101,100,102,98\n100,101,100,99,100\n")
    config = input_files.resolved(Config.from_yaml(MEASURED + "bench.csv}"))
    listed = read(MEASURED + "[99, 101, 100, 102, 98]}")
    problem = build_problem(config)
    assert config.mistuning.samples == 2
    assert problem.reduced.blade_stiffness.any()
    np.testing.assert_array_equal(deviation(config, 0, 0), listed.pattern_deviation)


def test_changed_model_file_is_refused(sector):
    config = read(SECTOR + "reduction: {n_modes: 4}")
    model_file.write("sector.h5", sector_arrays() | {"n_sectors": np.array(6)}, overwrite=True)
    with pytest.raises(InputError, match="is not the file that this configuration was made of"):
        build_problem(config)


def test_blades_without_stiffness_of_their_own_cannot_be_mistuned(folder):
    arrays = {k: v for k, v in sector_arrays().items() if not k.startswith("K_blade")}
    config = study_of(arrays, "reduction: {n_modes: 4}")
    with pytest.raises(InputError, match="has no K_blade"):
        studies.run_of(config).prepare()
    problem = build_problem(config)
    with pytest.raises(InputError, match="has no K_blade"):  # nor by whoever does not ask before
        modes_of(config, problem, deviation(config, 0, 0))


def modal_of(arrays, text=""):
    config = study_of(arrays, f"study: modal\n{text}")
    pieces = modal.STUDY.compute(config, build_model(config), 0, None)
    values = {name: found for name, _, found in pieces}
    lengths = studies.run_of(config).sizes()
    for line in modal.STUDY.layout(config):
        shape = tuple(lengths[d] for d in line.dimensions)
        assert np.shape(values.get(line.name, [])) == shape
    return values


def test_modes_of_a_model_file_are_those_of_its_matrices(folder):
    """Frequencies by a dense solution; shapes are those of the disk on all nodes of its surface."""
    arrays = sector_arrays() | {"surface": np.array([[0, 1, 2, 3]])}
    found = modal_of(arrays, "reduction: {n_modes: 30}")
    disk = assembly.assemble(neutral.from_arrays(arrays))
    values, vectors = eigh(disk.stiffness[0].toarray(), disk.mass.toarray())
    n = len(found["full/frequencies_hz"])
    exact = np.sqrt(values) / (2 * np.pi)
    np.testing.assert_allclose(found["full/frequencies_hz"], exact[:n], rtol=1e-6)
    np.testing.assert_allclose(found["reduced/frequencies_hz"][:5], exact[:5], rtol=1e-3)
    assert sorted(found["full/nodal_diameters"][:5]) == [0, 1, 1, 2, 2]  # of 5 blades
    assert 0.5 < found["blade_share"] < 1.0
    single = int(np.argmin(found["reduced/nodal_diameters"][:5]))
    u = np.append(vectors[:, np.argmin(found["full/nodal_diameters"][:5])], 0.0)
    on = np.union1d(disk.surface, disk.contact_node)
    radial, tangential, axial = u[disk.row[on]].T
    theta = np.arctan2(disk.nodes[on, 1], disk.nodes[on, 0])
    c, s = np.cos(theta), np.sin(theta)
    xyz = np.stack([c * radial - s * tangential, s * radial + c * tangential, axial], axis=1)
    xyz /= np.linalg.norm(xyz, axis=1).max()
    shape = found["shapes"][single]
    np.testing.assert_allclose(shape, np.sign((shape * xyz).sum()) * xyz, atol=1e-2)
    np.testing.assert_allclose(found["position_m"], disk.nodes[on])


def test_modes_of_a_reduced_file_are_drawn_at_its_contact_nodes(folder):
    arrays = reduced_arrays(12)
    found = modal_of(arrays)
    assert found["surface"].shape == (0, 4)
    np.testing.assert_allclose(found["position_m"], arrays["nodes"])
    assert sorted(found["reduced/nodal_diameters"][:5]) == [0, 1, 1, 2, 2]
    np.testing.assert_allclose(np.linalg.norm(found["shapes"], axis=2).max(axis=1), 1.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (lambda a: {"M": -a["M"]}, "M: the mass matrix is not positive definite"),
        (lambda a: {"K": a["K"] + 0j}, "complex128; real numbers for the 40 rows"),
        (lambda a: {"K": -a["K"]}, "the disk is not held"),
        (lambda a: {"K_blade": 50 * a["K_blade"]}, "K_blade: from 0 to 50 of the disk's stiffness"),
        (lambda a: {"K_blade": -a["K_blade"]}, "K_blade: from -1 to"),
        (lambda a: {"contact_clearance": a["contact_clearance"] - 1}, "-1000 mm of node 0 is more"),
        (lambda a: {"contact_node": 0 * a["contact_node"]}, "node 0 is named twice"),
        # each of these changed nothing, or ended the study with a traceback
        (lambda a: {"fixed": np.array([0, 1])}, "fixed: 2 rows are held, none is allowed"),
        (lambda a: {n: a[n][:3] for n in ("blade_frequencies_hz", "blade_participation")},
         "blade_frequencies_hz: of 3 blades, contact_blade names 5"),
    ],
)  # fmt: skip
def test_reduced_models_that_cannot_be_right(folder, changes, words):
    arrays = reduced_arrays()
    with pytest.raises(InputError, match=words):
        build_problem(study_of(arrays | changes(arrays)))


def test_a_speed_beyond_those_of_the_matrices_is_named(folder, capsys):
    """K0 - W^2 K0 / W0^2 is that of a disk below W0 alone; its modes at 0 Hz went unnoticed."""
    arrays, limit = reduced_arrays(), 2 * np.pi * 600.0
    falling = {"K0": arrays["K"], "K1": -arrays["K"] / limit**2, "K2": 0 * arrays["K"]}
    falls = {k: v for k, v in arrays.items() if k != "K"} | falling
    text = "speeds: {{from_hz: {}, to_hz: {}, step_hz: 40}}\n"
    build_problem(study_of(falls, text.format(100, 140)))
    for ends, hz in (((800, 900), 850), ((20, 660), 620)):
        with pytest.raises(InputError, match=f"speeds: at {hz} Hz the stiffness of this model is"):
            build_problem(study_of(falls, text.format(*ends)))
    assert program(["import", "model", "model.h5", "--speed-hz", "700"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("hpcrub: error: --speed-hz: at 700 Hz the stiffness of this model")


@pytest.mark.parametrize(("known", "warned"), [([0, 130], True), ([0, 140], False), ([], False)])
def test_speeds_beyond_those_of_the_matrices_are_marked(folder, known, warned):
    """A study from 100 to 140 Hz extrapolated stiffness without a word."""
    arrays = reduced_arrays()
    stiffness = {"K0": arrays.pop("K"), "speeds_hz": np.array(known, dtype=float)}
    stiffness["K1"] = 0.0 * stiffness["K0"]
    config = study_of(arrays | stiffness, "speeds: {from_hz: 100, to_hz: 140, step_hz: 40}")
    found = [w for w in plausibility.warnings(config, build_problem(config)) if "matrices" in w]
    assert [w[:37] for w in found] == ["not resolved: speeds of 100 to 140 Hz"] * warned


def test_blades_may_have_different_numbers_of_contact_nodes(folder):
    arrays = reduced_arrays()
    for name in ("contact_node", "contact_blade", "contact_clearance"):
        arrays[name] = arrays[name][:-1]
    found = modal_of(arrays)
    assert sorted(found["reduced/nodal_diameters"][:5]) == [0, 1, 1, 2, 2]
    assert program(["import", "model", "model.h5"]) == 0


def test_blades_known_by_their_cantilever_modes_are_told_as_that(capsys):
    """The import said that they have nothing, and cannot be mistuned."""
    assert import_model.main(["model", "inputs/rotor67/rotor67.h5", "--speed-hz", "267"]) == 0
    said = capsys.readouterr().out
    assert "6 cantilever modes each alone" in said
    assert "blades' stiffness: none" not in said


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--speed-hz", "nan"], "--speed-hz: nan is not 0 or more"),
        (["--speed-hz=-5"], "--speed-hz: -5 is not 0 or more"),
        (["--reduce=-1"], "--reduce: -1 is not 0 or more"),
        (["--reduce", "3"], "--reduce: this model is reduced already"),
        (["--axis", "x"], "--axis x: cylindrical directions are about z"),
        (["--units", "mm"], 'units: "mm" is not a length'),
        (["--output", "model.mat"], "model.mat: a model file ends with .h5, .hdf5"),
    ],
)
def test_options_of_the_import_that_cannot_be(folder, capsys, options, words):
    model_file.write("reduced.h5", reduced_arrays())
    assert program(["import", "model", "reduced.h5", *options]) == InputError.exit_code
    assert f"hpcrub: error: {words}" in capsys.readouterr().err


def test_a_contact_node_that_stands_out_meets_the_bumps(folder):
    """Its own clearance, 0.3 mm less, takes it to bumps that end 0.2 mm below the others."""
    arrays = sector_arrays()
    own = np.zeros(len(arrays["contact_node"]))
    own[1] = -3e-4
    text = "casing: {bump_height_mm: 0.5, clearance_mm: 0.7}"
    config = study_of(arrays | {"contact_clearance": own}, text)
    width = np.sqrt(np.log(0.5 / 0.4)) * 0.2 * 2 * np.pi / config.casing.n_bumps
    assert resolution.width_of_bump(config) == pytest.approx(width)


MPA = "--table-units", "mm t s"


@pytest.mark.parametrize(
    ("stress", "static", "units", "words"),
    [
        (60.0, 250.0, None, "--table-units: the tables do not tell their units"),
        (60.0, 250.0, "mm t", '--table-units: "mm t" is not a length'),
        (60.0, 0.0, "m kg s", "MPa per mm of a tip in the first family, which no blade has"),
        (6e10, 0.0, "mm t s", "MPa per mm of a tip in the first family, which no blade has"),
        (6e10, 250.0, "m kg s", "stress_static: up to 0.00025 MPa"),
        (60.0, -1e8, "mm t s", "stress_static: up to 1e+08 MPa; 0.01 to 10,000 MPa"),
        (0.0, 250.0, "mm t s", "stress: the row of place 0 is zero"),
    ],
)
def test_a_stress_that_no_blade_has_is_refused(folder, stress, static, units, words):
    """MPa were taken as Pa, because the import had written the model file in m kg s."""
    arrays = {
        "hpcrub_model": np.array(1), "kind": np.array("reduced"), "M": np.eye(4),
        "K": 1e6 * np.eye(4), "nodes": np.array([[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]]),
        "dof": np.array([[0, 1], [0, 2], [1, 1], [1, 2]]), "contact_node": np.array([0, 1]),
        "contact_blade": np.array([0, 1]),
    }  # fmt: skip
    model_file.write("plain.h5", arrays)
    (folder / "stress.csv").write_text(f"0,0,{stress},0,0\n")
    (folder / "static.csv").write_text(f"{static}\n")
    options = ["model", "plain.h5", "--stress", "stress.csv", "--static", "static.csv"]
    options += ["--table-units", units] if units else []
    assert words in refusal(import_model.main, options)


def test_stresses_of_a_table_are_those_of_the_planar_disk(folder):
    """The reduced planar disk as a model file, its stresses as a user's table."""
    brief = "steady_state: {first_check_s: 0.01, max_time_s: 0.2, window_revolutions: 1}\n"
    brief += "limits: {stress_mpa: 100}\n"
    built_in = Config.from_yaml(f"reduction: {{n_modes: 24}}\n{brief}")
    own = build_problem(built_in).reduced
    face, m = own.interface, len(own.mass)
    dof = np.column_stack([np.full(m, -1), np.zeros(m, int)])
    dof[:24] = np.column_stack([np.tile(np.arange(12), 2), np.repeat([1, 2], 12)])
    place = face.radius * np.array([np.cos(face.angle), np.sin(face.angle), 0.0 * face.angle])
    arrays = {
        "hpcrub_model": np.array(1), "kind": np.array("reduced"), "frame": np.array("cylindrical"),
        "nodes": place.T, "dof": dof, "contact_node": np.arange(12),
        "contact_blade": np.arange(12), "M": own.mass, "K": own.stiffness,
        "K_blade": own.blade_stiffness,
    }  # fmt: skip
    model_file.write("plain.h5", arrays)
    in_mpa = np.column_stack([face.stress_blade, 1e-9 * face.stress])  # per mm
    np.savetxt("stress.csv", in_mpa, delimiter=",")
    with pytest.raises(InputError, match="this model file has no stress"):
        read(f"disk: {{model: plain.h5}}\n{brief}")
    options = "model", "plain.h5", "--stress", "stress.csv", "--output", "known.h5"
    assert import_model.main([*options, *MPA]) == 0
    with pytest.raises(InputError, match="known.h5 has stresses of its own"):
        read(f"disk: {{model: known.h5}}\n{brief[:-2]}, stress_mpa_per_mm: 45}}")
    ours = read(f"disk: {{model: known.h5}}\n{brief}")
    assert ours.disk.n_stresses == 24
    how = np.linspace(-0.01, 0.01, 12), [34.0, 34.5]
    found = [swept(config, *how).stress for config in (built_in, ours)]
    assert (found[0] > 1e8).all()
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)

    # Goodman's line, place by place: all stresses are twice as bad beside half of the strength
    np.savetxt("static.csv", np.full(24, 250.0))
    options = "model", "known.h5", "--static", "static.csv", "--output", "static.h5"
    assert import_model.main([*options, *MPA]) == 0
    strong = f"disk: {{model: static.h5}}\n{brief[:-2]}, strength_mpa: "
    twice = swept(read(f"{strong}500}}"), *how)
    np.testing.assert_allclose(twice.stress, 2.0 * found[1], rtol=1e-9)
    for limits, match in (
        ("250", "250 is not above the stress of rotation in the model file, 250"),
        ("500, static_mpa: 9", "knows the stress of rotation"),
    ):
        with pytest.raises(InputError, match=match):
            read(f"{strong}{limits}}}")

    np.savetxt("static.csv", -2.5e8 * (np.arange(24) > 0))  # compression makes nothing better
    assert import_model.main([*options, "--table-units", "m kg s", "--overwrite"]) == 0
    pressed = swept(read(f"{strong}500}}"), *how)
    np.testing.assert_allclose(pressed.stress, found[1], rtol=1e-12)


def test_stresses_are_in_the_units_of_their_file():
    """MPa per mm of a Cartesian node, that lies at an angle of 90 degrees."""
    arrays = {
        "hpcrub_model": np.array(1), "kind": np.array("reduced"), "units": np.array("mm t s"),
        "M": np.eye(2), "K": 1e6 * np.eye(2), "nodes": np.array([[0.0, 200.0, 0.0]]),
        "dof": np.array([[0, 1], [0, 2]]), "contact_node": np.array([0]),
        "stress": np.array([[3.0, 5.0]]), "stress_blade": np.array([0]),
        "stress_static": np.array([7.0]),
    }  # fmt: skip
    face = reduced.interface(to_cylindrical(neutral.from_arrays(arrays)))
    radial, tangential = face.stress[0]
    np.testing.assert_allclose([radial, tangential], [5e9, -3e9])
    again = neutral.from_arrays(neutral.to_arrays(neutral.from_arrays(arrays)))
    np.testing.assert_allclose(again.stress, [[3e9, 5e9]])
    np.testing.assert_allclose(again.stress_static, [7e6])
    sparse = {f"stress/{k}": v for k, v in (("data", [3.0, 5.0]), ("indices", [0, 1]),
                                            ("indptr", [0, 2]))}  # fmt: skip
    dense = {k: v for k, v in arrays.items() if k != "stress"}
    held = neutral.from_arrays(dense | {k: np.array(v) for k, v in sparse.items()})
    np.testing.assert_array_equal(held.stress, [[3e9, 5e9]])  # and mistuned_modes can take it
    assert len(reduced.interface(to_cylindrical(held)).stress) == 1
    for spoilt, match in (
        ({"stress_blade": np.array([0, 0])}, "stress: shape"),
        ({"stress_blade": np.array([1])}, "there is no blade 1"),
        ({"stress": np.ones((1, 3))}, "stress: shape"),
        ({"stress_static": np.ones(2)}, "stress_static: 2 values for 1 places"),
    ):
        with pytest.raises(InputError, match=match):
            neutral.from_arrays(arrays | spoilt)
