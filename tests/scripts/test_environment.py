"""environment.yml asks conda for what pyproject.toml asks pip for."""

import re
import tomllib

import yaml

from tests.program import ROOT

CONDA_NAMES = {"matplotlib-base": "matplotlib"}
SPECIFICATION = re.compile(r"([\w-]+) ?(>=[\d.]+)?")


def specifications(lines):
    """{name: lower bound or None} of dependencies such as numpy>=2.0."""
    found = {}
    for line in lines:
        name, bound = SPECIFICATION.match(line).groups()
        found[CONDA_NAMES.get(name, name.lower())] = bound
    return found


def test_conda_installs_what_the_package_needs():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    needed = specifications(project["dependencies"] + project["optional-dependencies"]["mpi"])
    environment = yaml.safe_load((ROOT / "environment.yml").read_text("utf-8"))["dependencies"]
    by_conda = specifications(line for line in environment if isinstance(line, str))
    assert {name: by_conda.get(name) for name in needed} == needed
    assert set(by_conda) - set(needed) == {"python", "pip", "openmpi"}
    assert environment[-1] == {"pip": ["--editable .[dev]"]}  # the rest, and hpcrub itself
