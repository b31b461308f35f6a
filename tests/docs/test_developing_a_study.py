"""The example of the page on developing a study: it computes what the page says, as any study."""

import re
from types import ModuleType

import numpy as np
import pytest

from hpcrub import studies
from hpcrub.commands import run as cli
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.studies.files import open_result
from hpcrub.studies.problem import build_model
from tests.program import ROOT

PAGE = (ROOT / "docs/developing_a_study.md").read_text(encoding="utf-8")


def block(language):
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL).group(1)


@pytest.fixture
def example(monkeypatch):
    """The module of the page, in the list."""
    module = ModuleType("frequencies")
    exec(block("python"), module.__dict__)
    monkeypatch.setitem(studies.STUDIES, module.STUDY.name, module.STUDY)
    return module.STUDY


def test_the_example_is_a_study(example, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    text = block("yaml").replace("samples: 1000", "samples: 3") + "reduction: {n_modes: 4}\n"
    (tmp_path / "a.yaml").write_text(text)
    assert cli.main(["a.yaml", "--dry-run"]) == 0
    assert "estimated run time" in capfd.readouterr().out
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    assert "sigma = 2.31 %" in capfd.readouterr().out
    assert cli.main(["a.yaml", "--status"]) == 0
    with open_result("results/a.h5") as file:
        found, reduced = file.read("frequencies_hz"), build_model(file.config).reduced
    for level, half_range in enumerate((0.01, 0.02, 0.04)):
        drawn = stiffness_deviation(2020, level, 2, 12, half_range)
        omega = mistuned_modes(reduced, drawn).omega
        np.testing.assert_array_equal(found[level, 2], omega[:12] / (2 * np.pi))


def test_the_example_has_about_forty_lines():
    assert len([line for line in block("python").splitlines() if line.strip()]) <= 48
