"""The example of the page on developing a study, added to a copy of the tree as the page says."""

import os
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.setup.problem import build_model
from tests.program import ENVIRONMENT, ROOT

PAGE = (ROOT / "docs/developing_a_study.md").read_text(encoding="utf-8")


def block(language):
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL).group(1)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the program with the module of the page, imported and named in the lists."""
    tree = tmp_path_factory.mktemp("tree")
    shutil.copytree(ROOT / "hpcrub", tree / "hpcrub")
    shutil.copy(ROOT / "main.py", tree)
    (tree / "hpcrub/studies/frequencies.py").write_text(block("python"), encoding="utf-8")
    for name, n_places in (("studies/__init__.py", 2), ("config/study_keys.py", 1)):
        path = tree / "hpcrub" / name
        line = re.compile(r'^( +"?)energy("?,\n)', re.MULTILINE)
        text, n_found = line.subn(r"\g<0>\1frequencies\2", path.read_text("utf-8"))
        assert n_found == n_places
        path.write_text(text, "utf-8")
    return tree


def run(tree, *arguments):
    """Exit code, output and errors of Python in the copy."""
    environment = os.environ | ENVIRONMENT | {"PYTHONPATH": str(tree)}
    words = [sys.executable, *map(str, arguments)]
    done = subprocess.run(words, cwd=tree, env=environment, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def test_the_example_is_a_study(tree):
    text = block("yaml").replace("samples: 1000", "samples: 3") + "reduction: {n_modes: 4}\n"
    (tree / "a.yaml").write_text(text)
    code, out, err = run(tree, "main.py", "a.yaml", "--dry-run")
    assert (code, err) == (0, "")
    assert "estimated run time" in out
    code, out, err = run(tree, "main.py", "a.yaml", "--no-figures")
    assert (code, err) == (0, "")
    assert "sigma = 2.31 %" in out
    with h5py.File(tree / "results/a.h5") as file:
        found = file["frequencies_hz"][()]
    reduced = build_model(Config(reduction={"n_modes": 4})).reduced
    for level, half_range in enumerate((0.01, 0.02, 0.04)):
        drawn = stiffness_deviation(2020, level, 2, 12, half_range)
        omega = mistuned_modes(reduced, drawn).omega
        np.testing.assert_allclose(found[level, 2], omega[:12] / (2 * np.pi), rtol=1e-10)
