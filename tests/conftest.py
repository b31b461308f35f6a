"""Fixtures of all tests: a tiny study, its input file and an empty result file."""

import pytest
from hypothesis import settings

import hpcrub.commands.run  # noqa: F401, before NumPy: its BLAS gets one thread, as in the program
from hpcrub.config import schema as config
from hpcrub.setup.problem import build_problem
from tests.program import TINY, lay_out

# the same examples in every run; how long one takes is no result
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of its own, and the working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def tiny(tmp_path):
    """Path of an input file whose results go to results/tiny.h5 beside it."""
    path = tmp_path / "tiny.yaml"
    path.write_text(TINY + "output: results/tiny.h5\n", encoding="utf-8")
    return path


@pytest.fixture
def tiny_config():
    """Configuration of the tiny study."""
    return config.Config.from_yaml(TINY)


@pytest.fixture(scope="session")
def problem():
    """Problem of the tiny study, for who changes nothing of it."""
    return build_problem(config.Config.from_yaml(TINY))


@pytest.fixture(scope="session")
def reduced(problem):
    """Reduced model of the tiny study."""
    return problem.reduced


@pytest.fixture(scope="session")
def empty(tmp_path_factory):
    """Bytes of an empty result file."""
    return lay_out(tmp_path_factory.mktemp("empty") / "result.h5").read_bytes()


@pytest.fixture
def path(tmp_path, empty):
    """An empty result file."""
    (tmp_path / "result.h5").write_bytes(empty)
    return tmp_path / "result.h5"
