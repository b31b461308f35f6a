"""Parts of a study, put together again: the bits of the whole study, and never a false mixture."""

import os
import re
import shutil
import signal

import h5py
import numpy as np
import pytest

from hpcrub import __version__
from hpcrub.__main__ import main as program
from hpcrub.commands import merge
from hpcrub.config import parts
from hpcrub.config import schema as config
from hpcrub.errors import InputError
from hpcrub.results import provenance
from hpcrub.results.layout import PENDING
from hpcrub.runs import result_files
from hpcrub.studies import open_result, run_of
from hpcrub.studies.shared import merge as merging
from tests.program import TINY, datasets, error_lines, lay_out, load, refusal, run_here

STUDY = TINY.replace("samples: 2", "samples: 5") + "output: whole.h5\n"


def attributes(path):
    """Attributes of the root and of all datasets, less the time and the file's own place."""
    with h5py.File(path, "r") as file:
        found = {"": dict(file.attrs)}
        file.visititems(lambda name, item: found.update({name: dict(item.attrs)}))
    found[""].pop("created")
    found[""]["config"] = re.sub(rb"output: \S*", b"", found[""]["config"])
    for values in found.values():  # references to other datasets differ from file to file
        for name in ("DIMENSION_LIST", "REFERENCE_LIST"):
            values.pop(name, None)
    return {name: {k: np.asarray(v).tolist() for k, v in a.items()} for name, a in found.items()}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder with a study, and the same in three ranges of samples."""
    folder = tmp_path_factory.mktemp("parts")
    (folder / "study.yaml").write_text(STUDY)
    for part in ([], *(["--part", f"{k}/3"] for k in (1, 2, 3))):
        assert run_here("study.yaml", *part, folder=folder) == 0
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    """A copy of that folder, the merged file not yet there; the working folder."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    (tmp_path / "whole.h5").rename(tmp_path / "single.h5")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def assert_nothing_is_left(folder):
    """A merge, done or refused, leaves neither its lock nor an unfinished file."""
    assert {p.suffix for p in folder.iterdir()} <= {".h5", ".yaml", ".jsonl"}


def assert_merged_is_single():
    assert datasets("whole.h5") == datasets("single.h5")
    assert attributes("whole.h5") == attributes("single.h5")


THREE = [f"whole.part-{k}-of-3.h5" for k in (1, 2, 3)]


@pytest.mark.parametrize("names", [THREE, THREE[::-1], [*THREE, "single.h5"]])
def test_merged_is_the_single_run_to_the_bit(folder, names, capsys):
    """In any order, and overlapping."""
    assert merge.main(["whole.h5", *names]) == 0
    assert "whole.h5: 10 of 10 samples" in capsys.readouterr().out
    assert_merged_is_single()
    assert_nothing_is_left(folder)


def test_what_no_part_has_stays_pending_and_is_resumed(folder, capsys):
    assert merge.main(["whole.h5", THREE[0], THREE[2]]) == 0
    assert "6 of 10 samples" in capsys.readouterr().out
    with open_result("whole.h5") as file:
        pending = file.status == PENDING
        known = np.isfinite(file.read("statistics/contact/amplification", (0, 0)))
    np.testing.assert_array_equal(pending, [[False, True, True, False, False]] * 2)
    np.testing.assert_array_equal(known, [True, False, False, False, False])
    assert run_here("study.yaml", "--status") == 75
    assert run_here("study.yaml", "--resume") == 0
    assert run_here("study.yaml", "--status") == 0
    assert datasets("whole.h5") == datasets("single.h5")


def test_a_study_goes_on_with_more_samples(folder, capsys):
    """What a smaller study has computed is not computed again, and the rest joins it to the bit."""
    fewer = ["study.yaml", "--output", "the fewer.h5"]
    assert run_here(*fewer, "--set", "mistuning.samples=3") == 0
    assert run_here(*fewer, "--resume") == 2
    room = f"--samples 5 NEW.h5 '{folder}/the fewer.h5' makes room"
    assert room in error_lines(capsys.readouterr().err)[0]
    assert merge.main(["whole.h5", "the fewer.h5", "--samples", "5"]) == 0
    out = capsys.readouterr().out
    assert "whole.h5: 6 of 10 samples" in out
    assert "--output whole.h5 --set mistuning.samples=5 --resume computes the others" in out
    assert run_here("study.yaml", "--resume") == 0
    assert_merged_is_single()


@pytest.mark.parametrize("key", [{"study": "linear"}, {"convergence.stop_when_converged": True}])
def test_room_is_offered_only_where_merge_makes_it(tmp_path, key):
    """It was offered to every study, and refused by merge."""
    fewer = config.Config.from_yaml(TINY).replace(key)
    path = lay_out(tmp_path / "fewer.h5", fewer)
    line = refusal(open_result, path, fewer.replace({"mistuning.samples": 3}))
    assert line.endswith("mistuning.samples: 2 in the file, 3 asked for")
    with pytest.raises(InputError):
        merging.merge(tmp_path / "more.h5", [path], samples=3)


def test_a_file_has_no_fewer_samples_than_its_parts(folder):
    with pytest.raises(InputError, match=r"--samples: 4 is too few, .*3-of-3.h5 has 5 a level"):
        merging.merge("whole.h5", THREE, samples=4)
    with pytest.raises(InputError, match="not enough memory: this study needs 128,000"):
        merging.merge("whole.h5", THREE, samples=10**12)
    assert not (folder / "whole.h5").exists()


def test_a_merged_file_takes_further_parts(folder):
    merging.merge("whole.h5", THREE[:1])
    merging.merge("whole.h5", ["whole.h5", *THREE[1:]], overwrite=True)
    assert_merged_is_single()


def test_an_unfinished_sample_is_not_taken(folder):
    """Its data may be half written: only the status declares it whole."""
    with h5py.File(THREE[1], "r+") as file:
        file["samples/status"][0, 0] = PENDING
        file["samples/amplitude_m"][0, 0] = -1.0
    assert merging.merge("whole.h5", THREE) == (9, 10)
    with open_result("whole.h5") as file:
        assert np.isnan(file.read("samples/amplitude_m", (0, 1))).all()


def test_parts_that_have_not_begun(folder):
    warnings = attributes("single.h5")[""]["warnings"]  # as a run lays them out, for the verdict
    for k in (1, 2):
        run = run_of(parts.cut(load("study.yaml"), k, 3))
        result_files.lay_out(f"{k}.h5", run, {"warnings": warnings})
    assert merging.merge("whole.h5", ["1.h5", "2.h5"]) == (0, 10)
    with open_result("whole.h5") as file:
        assert not run_of(file.config).study.has_tuned(file)
    assert run_here("study.yaml", "--resume") == 0
    assert datasets("whole.h5") == datasets("single.h5")


@pytest.fixture
def another_program(monkeypatch):
    """From now on another program text runs."""
    monkeypatch.setattr(provenance, "program_text", lambda: "f" * 16)


def programs_of(path):
    with open_result(path) as file:
        return file.attributes["program_text"].split(", ")


def test_what_other_programs_have_computed_is_mixed_only_when_told(folder, capsys, another_program):
    """And then the file names them all. An installed program, without git, knows no revision: that
    was a KeyError."""
    assert run_here("study.yaml", "--part", "2/3", "--overwrite") == 0
    for name in THREE:
        with h5py.File(name, "r+") as file:
            file.attrs.pop("git_revision", None)
    line = refused(capsys, "whole.h5", *THREE)
    assert "computed by different programs" in line
    assert "f" * 16 in line
    assert "--allow-mixed" in line
    assert not (folder / "whole.h5").exists()
    assert merge.main(["whole.h5", *THREE, "--allow-mixed"]) == 0
    assert len(programs_of("whole.h5")) == 2
    assert "f" * 16 in programs_of("whole.h5")
    assert datasets("whole.h5") == datasets("single.h5")


def test_resume_refuses_what_another_program_has_begun(folder, capfd, another_program):
    assert merge.main(["whole.h5", THREE[0], THREE[2]]) == 0
    assert run_here("study.yaml", "--resume") == 2
    (line,) = error_lines(capfd.readouterr().err)
    assert f"was begun by another program: hpcrub {__version__} (revision " in line
    assert "--allow-mixed" in line
    assert run_here("study.yaml", "--status") == 75  # reading never refuses
    before = programs_of("whole.h5")
    assert run_here("study.yaml", "--resume", "--allow-mixed") == 0
    assert programs_of("whole.h5") == [*before, "f" * 16]
    assert datasets("whole.h5") == datasets("single.h5")
    assert run_here("study.yaml", "--resume") == 0  # complete: nothing is computed


def test_a_merge_harms_none_of_its_parts(folder, capsys):
    """Not even one that a killed merge has left."""
    name = "whole.h5.hpcrub-merge"
    shutil.copy(THREE[0], name)
    before = (folder / name).read_bytes()
    assert "rename it to use it" in refused(capsys, "whole.h5", name, *THREE[1:])
    assert (folder / name).read_bytes() == before
    (folder / name).write_text("mine")
    assert "is not replaced" in refused(capsys, "whole.h5", *THREE)
    assert (folder / name).read_text() == "mine"


def test_an_interrupted_merge_is_one_line_and_leaves_nothing(folder, capsys, monkeypatch):
    monkeypatch.setattr(merging, "_copy", lambda *_: os.kill(os.getpid(), signal.SIGINT))
    assert program(["merge", "whole.h5", *THREE]) == 75
    assert capsys.readouterr().err == "hpcrub: stopped: SIGINT came\n"
    assert not list(folder.glob("whole.h5*"))


def refused(capsys, *arguments):
    assert program(["merge", *arguments]) == 2
    (line,) = error_lines(capsys.readouterr().err)
    return line


def test_other_configurations_are_refused_by_key(folder, capsys):
    other = ["--set", "casing.n_bumps=3", "--set", "mistuning.seed=7"]
    assert run_here("study.yaml", "--part", "2/3", "--output", "other.h5", *other) == 0
    line = refused(capsys, "whole.h5", THREE[0], "other.part-2-of-3.h5")
    assert "casing.n_bumps: 4 in whole.part-1-of-3.h5, 3 in other.part-2-of-3.h5" in line
    assert "mistuning.seed: 2020 in" in line
    assert not (folder / "whole.h5").exists()


def test_another_tuned_disk_is_refused(folder, capsys):
    with h5py.File(THREE[2], "r+") as file:
        file["tuned/amplitude_m"][1] *= 1.0 + 1e-15
    line = refused(capsys, "whole.h5", *THREE)
    assert "tuned disk of whole.part-1-of-3.h5 and of whole.part-3-of-3.h5" in line


def test_overlapping_samples_must_agree(folder, capsys):
    shutil.copy("single.h5", "whole.h5")
    shutil.copy("single.h5", "other.h5")
    with h5py.File("other.h5", "r+") as file:
        file["samples/time_s"][1, 1, 2] += 1e-12
    line = refused(capsys, "whole.h5", *THREE, "other.h5", "--overwrite")
    assert "other.h5 contradicts another part: samples/time_s of level 1" in line
    assert datasets("whole.h5") == datasets("single.h5")  # the old file is not touched
    assert_nothing_is_left(folder)


def test_a_part_is_never_replaced_by_the_whole(folder, capsys):
    """Without the name of the whole, the first part would be: its samples would be lost."""
    for parts_left in (THREE[1:], THREE):
        line = refused(capsys, THREE[0], *parts_left, "--overwrite")
        assert "part-1-of-3.h5 is a part of a study and is not replaced" in line
    assert merge.main(["whole.h5", *THREE]) == 0
    assert_merged_is_single()
    assert "--overwrite replaces it" in refused(capsys, "whole.h5", *THREE)
    assert merge.main(["whole.h5", *THREE, "--overwrite"]) == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("study: modal", "is of the study modal, which has no parts"),
        ("convergence: {stop_when_converged: true}", "stops when it has converged"),
    ],
)
def test_no_part_of_anything(folder, capsys, text, message):
    assert message in refused(capsys, "whole.h5", lay_out("none.h5", text))


def test_a_part_cannot_pass_for_the_study(folder, capfd):
    (folder / "energy.yaml").write_text(f"study: energy\nsources: [{THREE[0]}]")
    assert run_here("energy.yaml") == 2
    assert "is a part; merge all parts" in capfd.readouterr().err


def test_a_finished_part_is_known_without_work(folder, capfd):
    assert run_here("study.yaml", "--part", "2/3", "--status") == 0
    assert "whole.part-2-of-3.h5: 4 of 4 samples" in capfd.readouterr().out
    assert run_here("study.yaml", "--part", "2/5", "--status") == 75
    assert "whole.part-2-of-5.h5: not there yet" in capfd.readouterr().out
    assert run_here("study.yaml", "--part", "2/3", "--status", "--set", "casing.n_bumps=3") == 2


@pytest.mark.parametrize("count", [1, 7, 23])
def test_parts_cover_everything_once(count):
    whole = config.Config.from_yaml("mistuning: {samples: 23}")
    seen = np.zeros(23, dtype=int)
    outputs = set()
    for number in range(1, count + 1):
        part = parts.cut(whole, number, count)
        assert config.Config.from_yaml(part.to_yaml()) == part
        assert part.replace({"part.samples": None, "output": whole.output}) == whole
        seen[part.samples] += 1
        outputs.add(part.output)
        assert len(part.samples) - 23 // count in (0, 1)
        with pytest.raises(InputError, match="cannot be cut again"):
            parts.cut(part, 1, 2)
    assert (seen == 1).all()
    assert len(outputs) == count


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("0/3", "is not of the form K/N"),
        ("4/3", "is not of the form K/N"),
        ("1", "is not of the form K/N"),
        ("1/2 --output=/", "output: '/' is not a file name"),
        ("1/6", "5 samples cannot be cut into 6 parts"),
    ],
)
def test_wrong_parts_are_one_line(folder, capfd, part, message):
    assert run_here("study.yaml", *f"--part={part}".split()) == 2
    (line,) = error_lines(capfd.readouterr().err)
    assert message in line
