"""Result files among people's tools: xarray, netCDF, pandas, hpcrub's own reader and `inspect`."""

import subprocess
import sys

import h5py
import netCDF4
import numpy as np
import pytest
import xarray

import hpcrub
from hpcrub import studies
from hpcrub.__main__ import main as program
from hpcrub.commands import inspect
from hpcrub.errors import InputError
from hpcrub.results import layout
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import running_percentiles
from hpcrub.studies import STUDIES
from hpcrub.studies.contact import layout as contact_file
from hpcrub.studies.contact.layout import AMPLIFICATION, LINEAR
from tests.program import ROOT, TINY, lay_out, names_in, refusal


@pytest.fixture(params=STUDIES)
def any_study(request, tmp_path, monkeypatch):
    """Path of a result file of every study, nothing computed yet."""
    text = f"study: {request.param}\n"
    text += TINY.replace("to_hz: 34.4", "to_hz: 34.0") if "time_response" in text else TINY
    text += "history: {duration_s: 0.6}\nspectrum: {window_s: 0.2}\nenergy: {samples: 2}\n"
    if STUDIES[request.param].n_sources:
        source = tmp_path / "source.h5"
        with ResultFile(lay_out(source), mode="r+") as file:
            contact_file.write_tuned(file, dict.fromkeys(contact_file.names(file, "tuned"), 1.0))
            for level, sample in np.ndindex(2, 2):
                numbers = {"deviation": np.zeros(12), "amplification": 1.0, "status": layout.DONE}
                contact_file.write_sample(file, level, sample, numbers)
        text += f"sources: [{source}]\n"
    return lay_out(tmp_path / "a.h5", text)


def groups(path):
    """{group: {name: shape}} of all datasets."""
    found = {}
    with h5py.File(path) as file:
        for name in names_in(file):
            group, _, short = name.rpartition("/")
            found.setdefault(f"/{group}", {})[short] = file[name].shape
    return found


def test_xarray_and_netcdf_open_the_file_of_every_study(any_study):
    expected = groups(any_study)
    with xarray.open_datatree(any_study, engine="h5netcdf") as tree:
        for group, datasets in expected.items():
            assert set(datasets) <= set(tree[group].variables), group
            for name, shape in datasets.items():
                array = tree[group][name]
                assert array.shape == shape
                assert {"units", "long_name"} <= set(array.attrs), name
                assert not [d for d in array.dims if d.startswith(("phony", "axis_", "dim_"))]
    with netCDF4.Dataset(any_study) as file:
        for group, datasets in expected.items():
            for name, shape in datasets.items():
                variable = file[f"{group}/{name}"]
                assert variable.shape == shape
                assert len(variable.dimensions) == len(shape)
                assert not [d for d in variable.dimensions if d.startswith("phony")]
                assert variable.units


@pytest.fixture
def done(path):
    """A contact file of two levels, two samples, three speeds, of which one sample is done."""
    with studies.open_result(path, mode="r+") as file:
        numbers = {"deviation": np.arange(12.0), "amplification": 1.5, "status": layout.DONE}
        contact_file.write_sample(file, 1, 0, numbers | {"amplitude_m": np.array([1.0, 2.0, 3.0])})
    return path


def test_tables_have_a_row_for_each_sample_and_each_point(done):
    with hpcrub.open(done) as file:
        samples, points = file.to_dataframe(), file.to_dataframe("points")
        assert file.to_dataframe("samples/amplitude_m").equals(points)
        with pytest.raises(InputError, match="no table 'nothing'; there are"):
            file.to_dataframe("nothing")
    assert samples.index.names == ["half_range", "sample"]
    assert len(samples) == 4
    row = samples.loc[(0.04, 0)]
    assert (row["amplification"], row["status"]) == (1.5, layout.DONE)
    assert row["deviation_12"] == 11.0
    assert points.index.names == ["half_range", "sample", "speeds_hz"]
    np.testing.assert_array_equal(points.loc[(0.04, 0), "amplitude_m"], [1.0, 2.0, 3.0])
    assert samples.index.equals(points.groupby(level=[0, 1]).first().index)


def test_percentiles_and_the_tuned_disk_are_tables_by_short_names(done):
    """In all readers a percentile is the coordinate, and what it is of the variable."""
    found = running_percentiles(np.array([1.0, 3.0]), (1, 50, 99), 1, 1.96)
    with studies.open_result(done, mode="r+") as file:
        for kind in (AMPLIFICATION, LINEAR):
            contact_file.write_statistics(file, kind, 1, found)
        contact_file.write_tuned(file, {"amplitude_m": np.array([4.0, 5.0, 6.0])})
    with hpcrub.open(done) as file:
        percentiles, tuned = file.to_dataframe("percentiles"), file.to_dataframe("tuned")
    assert percentiles.index.names == ["half_range", "percentile", "samples_seen"]
    row = percentiles.loc[(0.04, 50.0, 2)]
    assert (row["amplification"], row["linear_amplification"]) == (2.0, 2.0)
    assert tuned.index.names == ["speeds_hz"]
    assert tuned["amplitude_m"].to_dict() == {34.0: 4.0, 34.2: 5.0, 34.4: 6.0}
    with xarray.open_datatree(done, engine="h5netcdf") as tree:
        contact = tree["statistics/contact"]
        assert float(contact["amplification"].sel(half_range=0.04, percentile=50)[-1]) == 2.0
        assert not {"mode", "run"} & set(tree["samples"].coords)


def test_what_people_want_of_an_open_file(done, monkeypatch):
    with hpcrub.open(done) as file:
        assert file.config.mistuning.samples == 2
        np.testing.assert_array_equal(file.status, [[0, 0], [1, 0]])
        assert file["samples/amplification"][1, 0] == 1.5
        assert "samples/amplification" in file
        assert "nothing" not in file
        with pytest.raises(KeyError, match="no dataset nothing"):
            file["nothing"]
        assert file.units("samples/time_s") == "s"
        assert file.dimensions("samples/deviation") == ("half_range", "sample", "blade")
        with monkeypatch.context() as changed:  # as after a changed bit; it was a traceback
            changed.setattr(h5py.Dataset, "name", None)
            assert file.dimensions("sigma") == ("axis_0",)
        assert file.attributes["seed"] == 2020
        assert set(file) > {"samples/amplitude_m", "tuned/amplitude_m"}
        with xarray.open_datatree(done, engine="h5netcdf"):  # at the same time
            assert file["tuned/peak_amplitude_m"] != 0.0
    with xarray.open_datatree(done, engine="h5netcdf"), hpcrub.open(done):
        pass


def test_a_closed_file_is_told_as_that(path):
    """It had no tables, and was damaged."""
    with hpcrub.open(path) as file:
        pass
    for use in (file.to_dataframe, lambda: file["samples/status"]):
        assert "is closed" in refusal(use)


def test_a_file_that_is_being_written_is_read(done):
    with studies.open_result(done, mode="r+") as writer, hpcrub.open(done) as file:
        contact_file.write_sample(writer, 0, 0, {"status": layout.DONE})
        assert file["samples/amplification"][1, 0] == 1.5


def test_import_is_fast_and_needs_no_mpi():
    """Nothing heavy is loaded before it is asked for, and mpi4py never."""
    program = (
        "import sys, hpcrub\n"
        "early = set(sys.modules)\n"
        "hpcrub.open\n"
        "print(sorted(early & {'numpy', 'h5py', 'numba', 'pandas', 'xarray', 'matplotlib'}))\n"
        "print(sorted({'mpi4py', 'numba', 'matplotlib', 'pandas'} & set(sys.modules)))\n"
        "import hpcrub.commands.run, hpcrub.studies\n"  # every rank loads these
        "print(sorted({'matplotlib', 'scipy.stats', 'scipy.signal'} & set(sys.modules)))"
    )
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout == "[]\n[]\n[]\n"


def test_long_attributes_are_cut(path):
    with h5py.File(path, "r+") as file:
        file.attrs["many"] = np.arange(100_000)
        file.attrs["note"] = "two\nlines"
    with hpcrub.open(path) as file:
        text = "\n".join(inspect.description(file))
    assert "note: two\\nlines" in text
    assert max(map(len, text.splitlines())) < 1000


def test_all_files_are_described_and_the_worst_is_the_exit_code(path, capsys):
    other = path.with_name("other.h5")
    other.write_text("hello")
    assert program(["inspect", str(other), str(path)]) == 2
    out, err = capsys.readouterr()
    assert err.startswith(f"hpcrub: error: cannot open {other} as HDF5: ")
    assert "done: 0 of 4 samples" in out
    assert "mistuning.samples: 2 here, 5000 by default" in out


def test_a_command_that_is_misspelt_is_told_the_right_one(capsys):
    assert program(["runn", "own.yaml"]) == 2
    assert "runn is no command and no file; did you mean hpcrub run?" in capsys.readouterr().err
