"""What is missing is said once: an h5py without MPI, a launcher whose ranks have no mpi4py."""

import sys

import pytest

from tests.program import error_lines, run, run_here

pytestmark = pytest.mark.mpi


def test_an_h5py_without_mpi_is_one_line(tiny, tmp_path):
    lines = [
        "import h5py",
        "from types import SimpleNamespace",
        "h5py.get_config = lambda: SimpleNamespace(mpi=False)",
        "from hpcrub.commands.run import main",
        "raise SystemExit(main())",
    ]
    (tmp_path / "main.py").write_text("\n".join(lines))
    code, _, err = run(2, "tiny.yaml", folder=tmp_path, script="main.py")
    assert code == 2
    (line,) = error_lines(err)
    assert line.startswith("hpcrub: error: this h5py is built without MPI")
    assert "`make setup`" in line
    assert "pip" not in line  # which would build mpi4py too, in tens of gigabytes
    assert not (tmp_path / "results").exists()


def test_without_mpi4py_one_rank_works_and_a_launcher_is_an_error(tiny, monkeypatch, capfd):
    """Several ranks that cannot see each other must not each compute, or write, everything."""
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "3")
    for rank, n_lines in ((0, 1), (1, 0)):
        monkeypatch.setenv("OMPI_COMM_WORLD_RANK", str(rank))
        assert run_here(tiny, folder=tiny.parent) == 2
        lines = error_lines(capfd.readouterr().err)
        assert ["mpi4py" in line for line in lines] == [True] * n_lines
    monkeypatch.delenv("OMPI_COMM_WORLD_SIZE")
    assert run_here(tiny, folder=tiny.parent) == 0
