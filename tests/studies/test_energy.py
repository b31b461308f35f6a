"""The study that takes its samples from an earlier contact study: energy.

Truth: the strain energy of every blade on the full finite-element model.
"""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from evidence.truth import section
from hpcrub import plot
from hpcrub.commands import inspect
from hpcrub.commands import run as cli
from hpcrub.commands.plot import main as draw_figures
from hpcrub.config import schema as config
from hpcrub.config import yaml_text
from hpcrub.contact import status
from hpcrub.errors import InputError
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sweep import Motion, run_sweep
from hpcrub.results.layout import DONE, FAILED
from hpcrub.setup.disks import run_deviation
from hpcrub.setup.problem import build_model, build_problem
from hpcrub.studies import energy, open_result
from hpcrub.studies.contact.study import require_complete
from tests.plot.stored import File
from tests.program import TINY, computed, error_lines, whole


def test_a_source_may_have_keys_of_other_studies():
    """The same input as of a checklist or a search: it was refused."""
    text = "checklist: {disks: 4}\npatterns: {kept: 3}\nthreshold: {probability: 0.1}\n"
    source = File(TINY + text, samples__status=np.full((2, 2), DONE))
    require_complete(source, config.Config.from_yaml(TINY))
    with pytest.raises(InputError, match="casing.n_bumps: 4 in the file, 5 asked for"):
        require_complete(source, config.Config.from_yaml(TINY + "casing: {n_bumps: 5}\n"))


@pytest.fixture(scope="module")
def origin(tmp_path_factory):
    """A contact study of 6 samples on two levels."""
    text = TINY.replace("samples: 2", "samples: 6").replace("step: 1", "step: 2")
    return computed(tmp_path_factory.mktemp("origin"), text, output="source.h5")


@pytest.fixture
def folder(origin, tmp_path, monkeypatch):
    """A working folder with source.h5."""
    shutil.copy(origin, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*options, samples=2, sources=("source.h5",)):
    """Exit code of an energy study of so many samples that starts from source.h5."""
    keys = yaml_text.parse(TINY) | {"mistuning": {}, "convergence": {}, "study": "energy"}
    keys |= {"sources": [*sources], "output": "energy.h5", "energy": {"samples": samples}}
    keys |= {"limits": {"stress_mpa": 100}}
    Path("energy.yaml").write_text(json.dumps(keys))
    return cli.main(["energy.yaml", *options])


def change(path, dataset, where, value):
    with h5py.File(path, "r+", locking=False) as file:
        file[dataset][where] = value


def test_energies_are_those_of_the_full_model(folder):
    assert run(samples=3) == 0
    file = open_result("energy.h5")
    with open_result("source.h5") as source:
        values = np.sort(source.read("samples/amplification"), axis=None)[::-1]
    np.testing.assert_array_equal(file.read("amplification"), values[:3])
    assert (file.read("point_status") > 0).all()
    deviations = file.read("deviation")
    assert (deviations[1] != deviations[2]).all()
    for sample in (1, 2):
        expected = largest_energies(file.config, deviations[sample])
        np.testing.assert_allclose(file.read("energy_j", sample), expected, rtol=1e-9)
    expected = largest_energies(file.config, run_deviation(file.config, 0))
    np.testing.assert_allclose(file.read("tuned/energy_j"), expected, rtol=1e-9)
    assert (folder / "energy.png").exists()
    stress = largest_stress(file.config, deviations[1], 0)
    assert file.read("stress_pa", 1)[0] == pytest.approx(stress, rel=1e-9)
    assert any(line.startswith("largest stress ") for line in energy.STUDY.report(file))
    file.close()

    with open_result("energy.h5", mode="r+") as file:
        before = energy.amplification(file)
        lost = {"energy_j": np.nan, "stress_pa": np.nan, "point_reason": status.TOO_LARGE}
        file.write(lost, 1)
        np.testing.assert_array_equal(energy.amplification(file), [before[0], np.nan, before[2]])
        first, *_, last = energy.STUDY.report(file)
        assert first.startswith("3 of 12 points: diverged")
        assert "nan" not in last  # of one disk that is lost all had been
        plot.energy("energy.h5")
        file.write({"tuned/energy_j": np.nan}, ())
        assert list(energy.STUDY.report(file))[-1].startswith("by strain energy: not known")
        plot.energy("energy.h5")


def largest_energies(config, deviation):
    """Energies [J] on the full model, over the window after the steady state, (speeds, blades)."""
    problem, speeds = build_problem(config), config.speeds.values_hz
    modes = mistuned_modes(problem.reduced, deviation)
    motion = Motion.at_rest(len(speeds), len(modes.omega))
    run_sweep(modes, problem.scene, speeds, motion=motion)
    (q,) = whole(modes, problem.scene, speeds, 3 / speeds.max(), "position", motion=motion)
    disk, reduced = build_model(config)
    u = np.einsum("nk,rks->rsn", reduced.basis @ modes.shapes, q)
    blades = zip(deviation, disk.blade_dof, disk.blade_stiffness, strict=True)
    found = [(1 + d) / 2 * np.einsum("rsi,ij,rsj->rs", u[:, :, n], k, u[:, :, n])
             for d, n, k in blades]  # fmt: skip
    return np.max(found, axis=1).T


def largest_stress(config, deviation, speed):
    """Stress [Pa] of the last window, from the forces that hold the blades at their roots."""
    problem, (disk, reduced) = build_problem(config), build_model(config)
    modes, speed_hz = mistuned_modes(reduced, deviation), config.speeds.values_hz[speed]
    end = run_sweep(modes, problem.scene, [speed_hz]).time[0] * speed_hz
    rows = section.root_stress(disk, config.disk, reduced.basis @ modes.shapes, deviation)
    rows = rows.reshape(-1, len(modes.omega))
    window = end - config.steady_state.window_revolutions, end
    return section.largest(modes, problem.scene, speed_hz, *window, rows)


def test_amplification_of_the_energy_is_largest_over_largest():
    values = {
        "tuned/energy_j": np.array([[1.0, 4.0], [np.nan, 3.0]]),
        "energy_j": np.array([[[2.0, 5.0], [6.0, 1.0]], [[0.5, np.nan], [1.0, 0.2]]]),
    }
    found = energy.amplification(SimpleNamespace(read=values.get))
    np.testing.assert_array_equal(found, [6.0 / 4.0, 1.0 / 4.0])


def test_a_study_of_energies_needs_a_source(folder, capfd):
    assert run(sources=()) == 2
    assert "0 result files given, energy needs 1" in capfd.readouterr().err


@pytest.mark.parametrize(
    "change",
    ["material.damping_ratio=0.004", "casing.n_bumps=3", "speeds.to_hz=34.2", "time.step_s=1e-05",
     "reduction.n_modes=60"],
)  # fmt: skip
def test_a_source_of_other_physics_is_refused(folder, capfd, change):
    assert run("--set", change) == 2
    key, value = change.split("=")
    (line,) = error_lines(capfd.readouterr().err)
    assert f"{key}: " in line
    assert f" in the file, {value} asked for" in line


def test_energy_needs_as_many_finished_samples_as_it_is_to_take(folder, capfd):
    assert run("--dry-run", samples=12) == 0
    assert "estimated run time" in capfd.readouterr().out
    largest = open_result("source.h5").read("samples/amplification").argmax()
    where = tuple(map(int, np.unravel_index(largest, (2, 6))))
    change("source.h5", "samples/status", where, FAILED)
    for samples in (12, 100):
        capfd.readouterr()
        assert run(samples=samples) == 2
        expected = f"energy.samples: {samples} is more than the 11 finished samples of source.h5"
        assert expected in capfd.readouterr().err
    keys = {"study": "energy", "sources": ["source.h5"], "energy.samples": 11}
    found = energy.STUDY.constants(config.Config.from_yaml(TINY).replace(keys))
    places = list(zip(found["level"], found["number"], strict=True))
    assert len(set(places)) == 11
    assert where not in places
    assert (np.diff(found["amplification"]) <= 0.0).all()


def test_a_result_file_alone_is_enough(folder, capfd):
    """Figures, --status and inspect need no source; to go on needs the sources as they were."""
    assert run("--no-figures") == 0
    before = Path("energy.h5").read_bytes()
    Path("source.h5").rename("elsewhere.h5")
    assert draw_figures(["energy.h5"]) == 0
    assert Path("energy.png").exists()
    assert inspect.main(["energy.h5"]) == 0
    assert run("--status") == 0
    capfd.readouterr()
    assert run("--resume") == 2
    assert "source.h5 as HDF5: No such file" in capfd.readouterr().err

    Path("elsewhere.h5").rename("source.h5")
    assert run("--resume", "--no-figures") == 0
    level, number = (int(open_result("energy.h5").read(name)[0]) for name in ("level", "number"))
    change("source.h5", "samples/deviation", (level, number, 3), 0.01)
    capfd.readouterr()
    assert run("--resume") == 2
    assert "sources: source.h5 has changed since" in capfd.readouterr().err
    assert Path("energy.h5").read_bytes() == before
