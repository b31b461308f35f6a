"""A contact law of one's own, named in an input: the bits of Python on any ranks, and refusals.

The law is that of `inputs/spring_law.py`, which `tests.contact.laws.test_laws` holds against an
exact motion.
"""

import shutil

import numpy as np
import pytest

from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_problem
from inputs.spring_law import Spring
from tests.program import ROOT, TINY, computed, contents, datasets, load, run_here, run_on
from tests.studies.common import refused_study

TEXT = f'{TINY}contact: {{own_law: "spring.py:Spring", friction: 0}}\n'
WRONG = {
    "none.py:Spring": "none.py: cannot be read (No such file",
    "spring.py:Soft": "spring.py has no class Soft",
    "spring.py:np": "np of spring.py lacks per_lane, allocate",
    "broken.py:Spring": "broken.py: ZeroDivisionError: division by zero",
    "spring.txt:Spring": "'spring.txt:Spring' is not",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with an input, its law and the results of one rank."""
    folder = tmp_path_factory.mktemp("own_law")
    (folder / "spring.py").write_text((ROOT / "inputs/spring_law.py").read_text("utf-8"))
    (folder / "broken.py").write_text("1 / 0\n")
    computed(folder, TEXT)
    return folder


def test_a_study_is_what_python_computes_with_the_law(folder, monkeypatch):
    monkeypatch.setattr(Spring, "k", 1e7)  # another test has a spring of its own
    config = load(folder / "study.yaml").replace({"contact.own_law": None})
    problem = build_problem(config)
    modes = modes_of(config, problem, deviation(config, 0, 0))
    with_law = problem.scene._replace(law=Spring)
    own = run_sweep(modes, with_law, config.speeds.values_hz).amplitude
    rigid = run_sweep(modes, problem.scene, config.speeds.values_hz).amplitude
    study = contents(folder / "one.h5")["samples/amplitude_m"][0, 0]
    np.testing.assert_array_equal(study, own)
    assert not np.array_equal(study, rigid)


def test_two_ranks_give_the_same_bits(folder):
    run_on(2, "study.yaml", "--output", "two.h5", folder=folder)
    assert datasets(folder / "two.h5") == datasets(folder / "one.h5")


@pytest.mark.parametrize(("own", "message"), WRONG.items())
def test_what_is_no_law_is_refused(folder, capsys, own, message):
    assert message in refused_study(folder, TEXT, f"contact.own_law={own}", capsys)


def test_a_law_replaces_the_rigid_casing_alone(folder, capsys):
    message = refused_study(folder, TEXT, "contact.law=abradable", capsys)
    assert "goes with contact.law: rigid, not abradable" in message


def test_a_study_does_not_go_on_with_a_law_that_has_changed(folder, tmp_path, capsys):
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    with (tmp_path / "spring.py").open("a") as file:
        file.write("# changed\n")
    assert run_here("study.yaml", "--output", "one.h5", "--resume", folder=tmp_path) == 2
    assert "contact.own_law_sha256" in capsys.readouterr().err
