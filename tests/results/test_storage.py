"""The result file: its layout is a contract, and nothing unsound is ever taken for a result."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from hpcrub import studies
from hpcrub.config import schema as config
from hpcrub.errors import HpcrubError, InputError, WriteError
from hpcrub.results import layout, model_file, ownership, storage
from hpcrub.runs import result_files
from hpcrub.studies.contact import layout as contact_file
from hpcrub.studies.contact import study as contact_study
from tests.program import ROOT, TINY, error_lines, lay_out, names_in, refusal, run_here

SHAPES = {  # some datasets of two levels, two samples, three speeds, twelve blades
    "speeds_hz": (3,),
    "tuned/run_amplitude_m": (9, 3),
    "tuned/peak_amplitude_m": (),
    "samples/status": (2, 2),
    "samples/deviation": (2, 2, 12),
    "samples/amplitude_m": (2, 2, 3),
    "statistics/contact/amplification": (2, 3, 2),
}


def test_the_file_has_the_datasets_of_its_study_and_no_others(path, tiny_config):
    run = studies.run_of(tiny_config)
    with h5py.File(path, "r") as file:
        expected = {line.name for line in run.datasets()} | set(run.scales().values())
        assert set(names_in(file)) == expected
        assert {name: file[name].shape for name in SHAPES} == SHAPES


def test_everything_is_allocated_and_empty(path):
    with h5py.File(path, "r") as file:
        for name in names_in(file):
            assert file[name].chunks is None
            assert file[name].id.get_offset() is not None
        assert np.isnan(file["samples/amplitude_m"][()]).all()
        assert (file["samples/status"][()] == 0).all()
        assert file["sigma"][:] == pytest.approx(np.array([0.02, 0.04]) / np.sqrt(3))
        np.testing.assert_allclose(file["speeds_hz"], [34.0, 34.2, 34.4])
        np.testing.assert_array_equal(file["statistics/samples_seen"], [1, 2])


def test_root_attributes(path, tiny_config):
    with h5py.File(path, "r") as file:
        attributes = dict(file.attrs)
    stored = config.Config.from_yaml(attributes.pop("config"))
    assert not config.differences(stored, tiny_config)
    assert attributes["seed"] == 2020
    assert attributes["program_version"]
    assert b"T" in attributes["created"]
    assert {"numpy_version", "numba_version", "h5py_version"} <= attributes.keys()


class Full:
    """A dataset that has no place on its disk."""

    def __setitem__(self, where, value):
        raise OSError(errno.ENOSPC, "No space left on device")


def test_a_sample_is_done_only_once_all_of_it_is_written(path, monkeypatch):
    """The disk fills up, or the job is killed, before any of its datasets."""
    file = storage.ResultFile(path, mode="r+")
    names = contact_file.names(file, "samples")
    values, dataset = dict.fromkeys(names, 1) | {"status": layout.DONE}, file._dataset
    for last in names:
        full = {f"samples/{last}": Full()}
        with monkeypatch.context() as patch:
            patch.setattr(file, "_dataset", lambda name, full=full: full.get(name) or dataset(name))
            with pytest.raises(HpcrubError, match="No space left"):
                contact_file.write_sample(file, 1, 0, values)
        assert file.status[1, 0] == 0, last
    contact_file.write_sample(file, 1, 0, values)
    assert file.status[1, 0] == layout.DONE
    file.close()


def inside(change):
    """Function that changes the content of a result file."""

    def spoil(path):
        with h5py.File(path, "r+", locking=False) as file:
            change(file)

    return spoil


def times(values):
    """Function that puts other times in place of those of the samples."""

    def change(file):
        del file["samples/time_s"]
        file["samples/time_s"] = values

    return inside(change)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (Path.unlink, "No such file or directory"),
        (lambda path: (path.unlink(), os.mkfifo(path)), "is neither a file nor a folder"),
        (lambda path: path.write_text("hello"), "file signature not found"),
        (lambda path: path.write_bytes(path.read_bytes()[:-1000]), "truncated file"),
        (lambda path: h5py.File(path, "w").close(), "is not a result file of hpcrub"),
        (inside(lambda file: file.attrs.update(layout=99)), "has layout 99 (hpcrub"),
        (inside(lambda file: file.attrs.update(config="n: [1")), "configuration cannot be read"),
        (times(np.zeros((2, 2, 4000))), "time_s is float64[2, 2, 4000], not float64[2, 2, 3]"),
        (times(np.zeros((2, 2, 3), "f4")), "time_s is float32[2, 2, 3], not float64[2, 2, 3]"),
        (inside(lambda file: file.pop("samples/time_s")), "has no dataset samples/time_s"),
        (inside(lambda file: file["samples/status"].write_direct(np.full((2, 2), 7, "i1"))),
         "is damaged: it holds a status 7"),
    ],
)  # fmt: skip
def test_unsound_files_are_refused(path, tiny_config, spoil, message):
    spoil(path)
    line = refusal(studies.open_result, path, tiny_config)
    assert message in line
    assert str(path) in line


AMPLITUDE = "samples/amplitude_m"
PRECIOUS = 8 * 12  # bytes of the amplitudes of two levels, two samples, three speeds


def replaced(make):
    """Function that puts something else in the place of the samples' amplitudes."""
    return inside(lambda file: (file.pop(AMPLITUDE), make(file)))


def virtual(file):
    source = h5py.VirtualSource("other.h5", AMPLITUDE, (2, 2, 3))
    layout = h5py.VirtualLayout((2, 2, 3), "f8")
    layout[...] = source
    file.create_virtual_dataset(AMPLITUDE, layout)


@pytest.mark.parametrize(
    ("put", "name"),
    [
        (lambda file: file.create_dataset(AMPLITUDE, (2, 2, 3), "f8",
                                          external=[("precious.dat", 0, PRECIOUS)]), AMPLITUDE),
        (virtual, AMPLITUDE),
        (lambda file: file.update({AMPLITUDE: h5py.ExternalLink("other.h5", AMPLITUDE)}),
         AMPLITUDE),
        (lambda file: file.update({AMPLITUDE: h5py.ExternalLink("pipe", "/")}), AMPLITUDE),
        (lambda file: (file.create_dataset("my/own", data=np.zeros((2, 2, 3))),
                       file.update({AMPLITUDE: h5py.SoftLink("/my/own")})), AMPLITUDE),
        (lambda file: (file.move("samples", "mine"),
                       file.update(samples=h5py.SoftLink("/mine"))), "samples"),
        (lambda file: (file.pop("samples"),
                       file.update(samples=h5py.ExternalLink("other.h5", "samples"))), "samples"),
    ],
)  # fmt: skip
def test_nothing_is_written_outside_the_file_that_was_named(folder, capfd, put, name):
    """`--resume` wrote new samples into whatever file an external dataset or a link led to."""
    Path("a.yaml").write_text(TINY + "output: a.h5\n")
    lay_out(folder / "other.h5")
    os.mkfifo("pipe")
    Path("precious.dat").write_bytes(np.zeros(12).tobytes())
    replaced(put)(lay_out(folder / "a.h5", (folder / "a.yaml").read_text()))
    names = ["a.h5", "other.h5", "precious.dat"]
    before = [Path(file).read_bytes() for file in names]
    assert run_here("a.yaml", "--resume") == 2
    said = f"{folder / 'a.h5'}: {name} is a link, or its data is stored elsewhere"
    assert error_lines(capfd.readouterr().err) == [f"hpcrub: error: {said}"]
    assert [Path(file).read_bytes() for file in names] == before
    for open_ in (studies.open_result, contact_study.open_contact):  # of merge, energy, and figures
        assert f"{name} is a link" in refusal(open_, folder / "a.h5")


def test_what_people_add_to_a_file_stays_and_harms_nothing(folder):
    """Links are not listed, and not followed: at the end of one is a pipe."""
    Path("a.yaml").write_text(TINY + "output: a.h5\n")
    path = lay_out(folder / "a.h5", (folder / "a.yaml").read_text())
    os.mkfifo("pipe")
    with h5py.File(path, "r+", locking=False) as file:
        file["my/pipe"] = h5py.ExternalLink("pipe", "/")
        file["my/circle"] = h5py.SoftLink("/my")
        file["samples/nowhere"] = h5py.SoftLink("/nothing")
        file.create_dataset("my/data", 3, "f8", external=[("my.dat", 0, 24)])
        file["samples/mine"] = "text"
        file.attrs["note"] = "mine"
        file["samples/time_s"].attrs["note"] = ["a", "list"]
    Path("my.dat").write_bytes(np.arange(3.0).tobytes())
    assert run_here("a.yaml", "--resume") == 0
    with studies.open_result(path) as file:
        assert (file.status == layout.DONE).all()
        assert file.attributes["note"] == "mine"
        assert {"my/data", "samples/mine"} <= {*file.names()}
        assert not {"my/pipe", "samples/nowhere"} & {*file.names()}
        np.testing.assert_array_equal(file.read("my/data"), [0.0, 1.0, 2.0])
    with h5py.File(path, "r") as file:
        assert set(file["my"]) == {"pipe", "circle", "data"}


def test_a_file_of_another_version_with_this_layout_is_read(path):
    with h5py.File(path, "r+") as file:
        file.attrs["program_version"] = "0.0.9"
    studies.open_result(path).close()


def everything(path, names):
    """All that a reader of hpcrub may take from a file."""
    with studies.open_result(path) as file:
        found = {name: np.asarray(file.read(name)).tobytes() for name in names}
        return found | {"attributes": file.attributes}


def test_damaged_metadata_is_found(path):
    """HDF5's checksums: what is read in spite of a changed bit is what was written. References
    from axes to their scales, which no reader here follows, have none."""
    with h5py.File(path, "r") as file:
        names = names_in(file)
    before, content = everything(path, names), path.read_bytes()
    guarded = np.ones(len(content), bool)
    with h5py.File(path, "r") as file:
        for name in names:
            start, size = file[name].id.get_offset(), file[name].id.get_storage_size()
            guarded[start : start + size] = False
    n_refused = 0
    for at in np.random.default_rng(1).choice(np.flatnonzero(guarded), 40):
        spoilt = bytearray(content)
        spoilt[at] ^= 1 << (at % 8)
        path.write_bytes(spoilt)
        try:
            assert everything(path, names) == before
        except InputError:
            n_refused += 1
    assert n_refused > 20


def test_a_result_file_is_no_model_file_whatever_is_written_in_it(path):
    """It "cannot be read ('ascii' codec can't decode ...)"."""
    with h5py.File(path, "r+") as file:
        file["note"] = np.bytes_("u²/2R".encode())
    line = refusal(model_file.require_free, path, True)
    assert line.endswith("is no model file, and is not replaced; choose another output")


def test_a_failed_replacement_leaves_the_old_file(path, monkeypatch):
    before = path.read_bytes()
    monkeypatch.setattr(storage, "_attach_scales", lambda *_: (_ for _ in ()).throw(OSError("no")))
    with pytest.raises(InputError, match="cannot write"):
        lay_out(path)
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_a_quota_is_a_message_and_leaves_nothing(tmp_path):
    """In a process of its own: HDF5 used to crash it at its end."""
    program = f"""if True:
        import resource, sys
        sys.path.insert(0, {str(ROOT)!r})
        from hpcrub.errors import InputError
        from tests.program import lay_out
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, -1))
        try:
            lay_out({str(tmp_path / "a.h5")!r})
        except InputError as error:
            print(error)
    """
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("cannot write " + str(tmp_path / "a.h5") + ": File too large\n")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_laid_out_has_no_holes(path):
    """A disk that fills up later would have no room for what is written into them."""
    found = path.stat()
    assert 512 * found.st_blocks >= found.st_size


def test_size_is_foretold(path, tiny_config):
    foretold = result_files.file_size(studies.run_of(tiny_config))
    assert path.stat().st_size == pytest.approx(foretold, abs=32768)


def test_a_file_that_the_disk_or_somebody_has_taken_away_is_told(tmp_path, monkeypatch):
    path = tmp_path / "a.h5"
    with pytest.raises(HpcrubError, match=r"a\.h5 was removed or moved while this job ran"):
        ownership.require_kept(path)
    path.touch()
    ownership.require_kept(path)

    def fail(file):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(WriteError, match=r"cannot write .*a\.h5: Input/output error"):
        ownership.require_kept(path)


def test_the_system_is_asked_for_the_reason_that_mpi_io_drops(tmp_path):
    error = RuntimeError("Can't write data (file write failed)")
    assert ownership.unwritable(error, "/dev/full") == "No space left on device"
    (tmp_path / "sound").write_bytes(b"abc")
    assert ownership.unwritable(error, tmp_path / "sound") == str(error)
    assert (tmp_path / "sound").read_bytes() == b"abc"
