"""The study that takes its samples from an earlier contact study: energy.

Truth: the strain energy of every blade on the full finite-element model.
"""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from hpcrub.commands import inspect
from hpcrub.commands import run as cli
from hpcrub.commands.plot import main as draw_figures
from hpcrub.config import schema as config
from hpcrub.config import yaml_text
from hpcrub.response import history
from hpcrub.results.layout import FAILED
from hpcrub.setup.problem import build_problem
from hpcrub.studies import energy, open_result
from tests.program import TINY

ONE_SPEED = {"speeds.from_hz": 34.0, "speeds.to_hz": 34.0}


def test_energy_is_taken_over_the_revolutions_of_one_window(monkeypatch):
    """At every speed, whatever its neighbours: a longer look would find a larger energy."""
    spans, integrate = [], history.integrate

    def watched(modes, scene, speeds_hz, *arguments):
        pieces = list(integrate(modes, scene, speeds_hz, *arguments))
        step = pieces[0].time[1] - pieces[0].time[0]
        spans.append((pieces[-1].time[-1] - pieces[0].time[0] + step) * speeds_hz)
        return pieces

    monkeypatch.setattr(history, "integrate", watched)
    cfg = config.Config.from_yaml(TINY).replace({"speeds.to_hz": 36.0, "speeds.step_hz": 2})
    problem = energy.Chosen(build_problem(cfg), np.zeros((1, 12)))
    list(energy.compute(cfg, problem, 0, lambda: None))
    assert np.concatenate(spans) == pytest.approx([3.0, 3.0], rel=1e-9)


@pytest.fixture(scope="module")
def origin(tmp_path_factory):
    """A contact study of 6 samples on two levels."""
    path = tmp_path_factory.mktemp("origin") / "source.h5"
    text = TINY.replace("samples: 2", "samples: 6").replace("step: 1", "step: 2")
    path.with_suffix(".yaml").write_text(text)
    arguments = str(path.with_suffix(".yaml")), "--output", str(path), "--no-figures"
    assert cli.main(arguments) == 0
    return path


@pytest.fixture
def folder(origin, tmp_path, monkeypatch):
    """A working folder with source.h5."""
    shutil.copy(origin, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*options, samples=2):
    """Exit code of an energy study of so many samples that starts from source.h5."""
    keys = yaml_text.parse(TINY) | {"mistuning": {}, "convergence": {}, "study": "energy"}
    keys |= {"sources": ["source.h5"], "output": "energy.h5", "energy": {"samples": samples}}
    Path("energy.yaml").write_text(json.dumps(keys))
    return cli.main(["energy.yaml", *options])


def change(path, dataset, where, value):
    with h5py.File(path, "r+", locking=False) as file:
        file[dataset][where] = value


def test_energy_needs_as_many_finished_samples_as_it_is_to_take(folder, capfd):
    assert run("--dry-run", samples=12) == 0
    assert "stability limit" in capfd.readouterr().out
    largest = open_result("source.h5").read("samples/amplification").argmax()
    where = tuple(map(int, np.unravel_index(largest, (2, 6))))
    change("source.h5", "samples/status", where, FAILED)
    for samples in (12, 100):
        capfd.readouterr()
        assert run(samples=samples) == 2
        expected = f"energy.samples: {samples} is more than the 11 finished samples of source.h5"
        assert expected in capfd.readouterr().err
    keys = {"study": "energy", "sources": ["source.h5"], "energy.samples": 11}
    found = energy.constants(config.Config.from_yaml(TINY).replace(keys))
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
    assert "source.h5 does not exist" in capfd.readouterr().err

    Path("elsewhere.h5").rename("source.h5")
    assert run("--resume", "--no-figures") == 0
    change("source.h5", "samples/linear_amplification", (1, 2), 1.25)
    capfd.readouterr()
    assert run("--resume") == 2
    assert "sources: source.h5 has changed since" in capfd.readouterr().err
    assert Path("energy.h5").read_bytes() == before
