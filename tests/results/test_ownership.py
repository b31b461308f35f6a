"""Names of result files: one job at a time, and nothing of somebody else is replaced."""

import multiprocessing
import os
import shutil

import h5py
import numpy as np
import pytest

from hpcrub.errors import HpcrubError, InputError
from hpcrub.results import ownership, storage

FOREIGN = ["text", "HDF5", "folder", "fifo", "device", "dangling"]


@pytest.mark.parametrize("kind", FOREIGN)
def test_what_is_not_ours_is_never_replaced(tmp_path, tiny_config, kind):
    path = tmp_path / "precious"
    if kind == "text":
        path.write_text("export PATH")
    if kind == "HDF5":
        h5py.File(path, "w").close()
    if kind == "folder":
        path.mkdir()
    if kind == "fifo":
        os.mkfifo(path)
    if kind == "device":
        path.symlink_to("/dev/null")
    if kind == "dangling":
        path.symlink_to("nowhere/result.h5")
    before = path.lstat()
    if kind == "dangling":  # a link is followed, and what it names can be made
        storage.lay_out(path, tiny_config)
        storage.check(tmp_path / "nowhere" / "result.h5")
    else:
        with pytest.raises(InputError, match="is not a result file of this hpcrub"):
            storage.lay_out(path, tiny_config)
    assert [p.name for p in tmp_path.iterdir() if p.name != "nowhere"] == ["precious"]
    assert os.path.samestat(path.lstat(), before)


def test_our_own_and_empty_files_are_replaced(path, tiny_config):
    link = path.with_name("link.h5")
    link.symlink_to(path)
    for content in (b"", path.read_bytes()[:3000]):  # a truncated one, too
        path.write_bytes(content)
        storage.lay_out(link, tiny_config)
        storage.check(path)
    assert link.is_symlink()


def try_lock(path, queue):
    try:
        ownership.Lock(path).release()
        queue.put("free")
    except InputError as error:
        queue.put(str(error))


def test_a_second_job_is_kept_out(tmp_path):
    path, context = tmp_path / "result.h5", multiprocessing.get_context("spawn")
    queue = context.Queue()
    lock = ownership.Lock(path)
    for expected in (f"{path} is in use by another job", "free"):
        process = context.Process(target=try_lock, args=(path, queue))
        process.start()
        assert queue.get(timeout=30) == expected
        process.join()
        lock.release()
    assert not lock.path.exists()


def test_one_file_under_two_names_is_locked_once(tmp_path):
    (tmp_path / "link.h5").symlink_to("result.h5")
    lock, other = ownership.Lock(tmp_path / "result.h5"), tmp_path / "link.h5"
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=try_lock, args=(other, queue))
    process.start()
    assert queue.get(timeout=30) == f"{other} is in use by another job"
    process.join()
    lock.release()


def test_a_lock_releases_only_itself(tmp_path):
    """The folder was removed and made again, and another job has begun in it."""
    lock = ownership.Lock(tmp_path / "result.h5")
    lock.path.unlink()
    lock.path.write_text("of another job")
    lock.release()
    assert lock.path.exists()


@pytest.mark.parametrize("how", ["kept", "moved", "removed", "replaced"])
def test_a_file_whose_name_was_taken_is_put_back(tmp_path, tiny_config, how):
    path, values = tmp_path / "results" / "a.h5", {"amplitude_m": np.arange(3.0), "status": 1}
    storage.lay_out(path, tiny_config)
    file = storage.ResultFile(path, mode="r+")
    if how == "moved":
        path.parent.rename(tmp_path / "old")
    if how in ("removed", "replaced"):
        shutil.rmtree(path.parent)
    if how == "replaced":
        path.parent.mkdir()
        path.write_text("foreign")
    file.write_sample(1, 1, values)
    file.close()
    found = path
    if how == "replaced":
        with pytest.raises(HpcrubError, match="was replaced by another file"):
            file.put_back()
        assert path.read_text() == "foreign"
        found = path.with_name("a.h5.rescued.h5")
    else:
        assert file.put_back() == (how != "kept")
    file = storage.ResultFile.open(found)
    np.testing.assert_array_equal(file.read("samples/amplitude_m", (1, 1)), values["amplitude_m"])
    file.close()


def test_every_rescued_file_is_kept(tmp_path, tiny_config):
    path = tmp_path / "a.h5"
    for number in (1.0, 2.0, 3.0):
        path.unlink(missing_ok=True)
        storage.lay_out(path, tiny_config)
        file = storage.ResultFile.open(path, mode="r+")
        path.unlink()
        path.write_text("foreign")
        file.write_sample(1, 1, {"amplitude_m": np.full(3, number), "status": 1})
        file.close()
        with pytest.raises(HpcrubError, match="what it has computed is in"):
            file.put_back()
    for number, name in enumerate(("rescued", "rescued-2", "rescued-3"), start=1):
        file = storage.ResultFile.open(f"{path}.{name}.h5")
        assert file.read("samples/amplitude_m", (1, 1, 0)) == number
        file.close()
