"""The result file: its layout is a contract, and nothing unsound is ever taken for a result."""

import multiprocessing
import shutil
import subprocess

import h5py
import numpy as np
import pytest

from hpcrub import config, layout, storage, studies
from hpcrub.errors import InputError
from hpcrub.statistics import running_intervals, running_percentiles

V, N_SAMPLES, S, N_BLADES, K = 2, 2, 3, 12, 2
CONTRACT = {
    "speeds_hz": (S,),
    "half_range": (V,),
    "sigma": (V,),
    "tuned/frequencies_hz": (36,),
    "tuned/amplitude_m": (S,),
    "tuned/time_s": (S,),
    "tuned/point_status": (S,),
    "tuned/point_reason": (S,),
    "tuned/max_sweeps": (S,),
    "tuned/run_peaks_m": (9,),
    "tuned/localisation": (S,),
    "tuned/peak_amplitude_m": (),
    "tuned/reference_amplitude_m": (),
    "tuned/peak_speed_hz": (),
    "tuned/linear_amplitude_m": (),
    "samples/status": (V, N_SAMPLES),
    "samples/deviation": (V, N_SAMPLES, N_BLADES),
    "samples/amplitude_m": (V, N_SAMPLES, S),
    "samples/time_s": (V, N_SAMPLES, S),
    "samples/localisation": (V, N_SAMPLES, S),
    "samples/point_status": (V, N_SAMPLES, S),
    "samples/point_reason": (V, N_SAMPLES, S),
    "samples/max_sweeps": (V, N_SAMPLES, S),
    "samples/peak_amplitude_m": (V, N_SAMPLES),
    "samples/peak_speed_hz": (V, N_SAMPLES),
    "samples/amplification": (V, N_SAMPLES),
    "samples/linear_amplitude_m": (V, N_SAMPLES),
    "samples/linear_amplification": (V, N_SAMPLES),
    "statistics/contact/samples_seen": (K,),
    "statistics/contact/percentile": (V, 3, K),
    "statistics/contact/mean_of_percentile": (V, 3, K),
    "statistics/contact/convergence_error": (V, 3, K),
    "statistics/contact/percentile_low": (V, 3, K),
    "statistics/contact/percentile_high": (V, 3, K),
    "statistics/linear/samples_seen": (K,),
    "statistics/linear/percentile": (V, 3, K),
    "statistics/linear/mean_of_percentile": (V, 3, K),
    "statistics/linear/convergence_error": (V, 3, K),
    "statistics/linear/percentile_low": (V, 3, K),
    "statistics/linear/percentile_high": (V, 3, K),
}


@pytest.fixture
def path(tmp_path, tiny_config):
    path = tmp_path / "result.h5"
    storage.lay_out(path, tiny_config)
    return path


def test_layout_is_the_contract(path):
    found = {}
    with h5py.File(path, "r") as file:
        file.visititems(
            lambda name, item: found.update({name: item.shape}) if hasattr(item, "shape") else None
        )
    assert found == CONTRACT


@pytest.mark.skipif(not shutil.which("h5ls"), reason="h5ls is not installed")
def test_h5ls_shows_the_contract(path):
    listing = subprocess.run(["h5ls", "-r", path], capture_output=True, text=True, check=True)
    found = {}
    for line in listing.stdout.splitlines():
        name, kind, *shape = line.split(maxsplit=2)
        if kind == "Dataset":
            text = shape[0].strip("{}").replace("SCALAR", "")
            found[name[1:]] = tuple(int(n) for n in text.split(",") if n)
    assert found == CONTRACT


def test_every_dataset_says_what_it_is(path):
    with h5py.File(path, "r") as file:
        for name in CONTRACT:
            assert file[name].attrs["units"]
            assert file[name].attrs["description"]


def test_everything_is_allocated_and_empty(path):
    with h5py.File(path, "r") as file:
        for name in CONTRACT:
            assert file[name].chunks is None
            assert file[name].id.get_offset() is not None
        assert np.isnan(file["samples/amplitude_m"][()]).all()
        assert (file["samples/status"][()] == 0).all()
        assert file["sigma"][:] == pytest.approx(np.array([0.02, 0.04]) / np.sqrt(3))
        np.testing.assert_allclose(file["speeds_hz"], [34.0, 34.2, 34.4])
        np.testing.assert_array_equal(file["statistics/linear/samples_seen"], [1, 2])


def test_dimension_scales(path):
    with h5py.File(path, "r") as file:
        amplitude = file["samples/amplitude_m"]
        assert [d.label for d in amplitude.dims] == ["level", "sample", "speed"]
        assert amplitude.dims[0][0] == file["half_range"]
        assert amplitude.dims[2][0] == file["speeds_hz"]
        percentile = file["statistics/contact/percentile"]
        assert percentile.dims[2][0] == file["statistics/contact/samples_seen"]
        np.testing.assert_array_equal(percentile.attrs["percentiles"], [1, 50, 99])


def test_root_attributes(path, tiny_config):
    with h5py.File(path, "r") as file:
        attributes = dict(file.attrs)
    stored = config.Config.from_yaml(attributes.pop("config"))
    assert not config.differences(stored, tiny_config)
    assert attributes["seed"] == 2020
    assert attributes["program_version"]
    assert "T" in attributes["created"]
    assert {"numpy_version", "numba_version", "h5py_version"} <= attributes.keys()


def test_written_values_come_back(path, tiny_config):
    values = {name: np.float64(i + 1) for i, name in enumerate(layout.SAMPLE)}
    values |= {"point_status": np.array([1, 2, 3]), "status": layout.DONE}
    tuned = {name: np.float64(i + 1) for i, name in enumerate(layout.TUNED)}
    running = running_percentiles(np.array([1.0, 2.0]), [1, 50, 99], 1, 2.81)
    file = storage.ResultFile.open(path, tiny_config, mode="r+")
    assert file.tuned() is None
    file.write_sample(1, 0, values)
    file.write_tuned(tuned)
    intervals = running_intervals(np.array([1.0, 2.0]), [1, 50, 99], 1, 0.1)
    file.write_statistics("linear", 1, running, intervals)
    file.close()
    file = storage.ResultFile.open(path, tiny_config)
    np.testing.assert_array_equal(file.status(), [[0, 0], [1, 0]])
    assert (file.read("samples/amplitude_m", (1, 0)) == values["amplitude_m"]).all()
    np.testing.assert_array_equal(file.read("samples/point_status", (1, 0)), [1, 2, 3])
    assert np.isnan(file.read("samples/peak_speed_hz", (1, 1)))
    assert file.tuned()["peak_speed_hz"] == tuned["peak_speed_hz"]
    read = file.read("statistics/linear/percentile", 1)
    np.testing.assert_array_equal(read, running.percentile)
    read = file.read("statistics/linear/percentile_high", 1)
    np.testing.assert_array_equal(read, intervals.percentile_high)
    file.close()


def test_data_is_written_before_its_status():
    assert layout.SAMPLE[-1] == "status"
    assert layout.TUNED[-1] == "linear_amplitude_m"


def test_more_samples_than_a_percentile_needs(tmp_path):
    cfg = config.Config.from_yaml("mistuning: {samples: 5}\nconvergence: {step: 10}")
    file = storage.ResultFile.create(tmp_path / "short.h5", cfg)
    assert file.read("statistics/contact/percentile").shape == (4, 3, 0)
    arguments = np.ones(5), [1, 50, 99], 10, 2.81
    file.write_statistics(
        "contact", 0, running_percentiles(*arguments), running_intervals(*arguments)
    )
    file.close()


def spoil(path, action):
    if action == "missing":
        path.unlink()
    if action == "not HDF5":
        path.write_text("hello")
    if action == "truncated":
        with open(path, "r+b") as file:
            file.truncate(path.stat().st_size - 1000)
    if action == "folder":
        path.unlink()
        path.mkdir()
    if action not in ("no program", "version", "shape", "hole", "configuration"):
        return
    with h5py.File(path, "r+") as file:
        if action == "no program":
            del file.attrs["program"]
        if action == "version":
            file.attrs["program_version"] = "0.0.1"
        if action == "configuration":
            file.attrs["config"] = "n_blades: [1"
        if action in ("shape", "hole"):
            del file["samples/time_s"]
        if action == "shape":
            file["samples/time_s"] = np.zeros((2, 2, 4000))


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ("missing", "does not exist"),
        ("folder", "is no file"),
        ("not HDF5", "is not an HDF5 file"),
        ("truncated", "is damaged or truncated"),
        ("no program", "is not a result file of hpcrub"),
        ("version", "was written by hpcrub 0.0.1, this is"),
        ("configuration", "its configuration cannot be read"),
        ("shape", "samples/time_s is float64[2, 2, 4000], not float64[2, 2, 3]"),
        ("hole", "it has no dataset samples/time_s"),
    ],
)
def test_unsound_files_are_refused(path, tiny_config, action, message):
    spoil(path, action)
    with pytest.raises(InputError) as caught:
        storage.check(path, tiny_config)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_another_configuration_is_refused_by_name(path):
    other = config.Config.from_yaml("casing: {n_bumps: 3}")
    with pytest.raises(InputError, match=r"another configuration: .* \(and \d+ more\)"):
        storage.check(path, other)


def test_a_failed_replacement_leaves_the_old_file(path, tiny_config, monkeypatch):
    before = path.read_bytes()
    monkeypatch.setattr(storage, "_attach_scales", lambda *_: (_ for _ in ()).throw(OSError("no")))
    with pytest.raises(InputError, match="cannot write"):
        storage.lay_out(path, tiny_config)
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_a_disk_too_small_is_found_before_work(tmp_path):
    absurd = "mistuning: {samples: 1000000}\nspeeds: {from_hz: 10, to_hz: 90, step_hz: 0.001}"
    with pytest.raises(InputError, match="needs .* GB, but its disk has"):
        storage.lay_out(tmp_path / "huge.h5", config.Config.from_yaml(absurd))
    assert list(tmp_path.iterdir()) == []


def test_size_is_foretold(path, tiny_config):
    assert path.stat().st_size == pytest.approx(studies.file_size(tiny_config), abs=65536)


def try_lock(path, queue):
    try:
        storage.Lock(path).release()
        queue.put("free")
    except InputError as error:
        queue.put(str(error))


def test_a_second_job_is_kept_out(tmp_path):
    path, context = tmp_path / "result.h5", multiprocessing.get_context("spawn")
    queue = context.Queue()
    lock = storage.Lock(path)
    for expected in (f"{path} is in use by another job", "free"):
        process = context.Process(target=try_lock, args=(path, queue))
        process.start()
        assert queue.get(timeout=30) == expected
        process.join()
        lock.release()
    assert not lock.path.exists()
