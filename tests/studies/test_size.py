"""What a study takes, and that this machine has it."""

import os
import shutil
from types import SimpleNamespace

import pytest

from hpcrub.config import schema as config
from hpcrub.errors import InputError
from hpcrub.studies import size
from tests.program import ROOT, load

HUGE = "mistuning: {samples: 1000000}\nspeeds: {from_hz: 10, to_hz: 90, step_hz: 0.001}"


def laptop(monkeypatch):
    """This machine has 16 GiB of memory and 100 GB of free disk."""
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 2**22, "SC_PAGE_SIZE": 2**12}.get)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=100e9))


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (HUGE, "not enough disk: .* GB of disk .* GB of memory .* are there"),
        ("mistuning: {samples: 1000000000000}", "not enough disk: .* GB of memory"),
        ("disk: {n_blades: 200, blade: {n_elements: 50}}", "not enough memory"),
        ("speeds: {from_hz: 1e-9, to_hz: 1e-9}", "not enough memory"),
        ("time: {step_s: 1e-12}", "not enough memory"),
        ("time: {step_s: 1e-300}", "not enough memory"),
        (
            "study: interaction_map\nhistory: {duration_s: 1000}\ntime: {step_s: 1e-9}",
            "not enough memory",
        ),
    ],
)
def test_what_this_machine_cannot_hold_is_refused_before_work(tmp_path, monkeypatch, text, what):
    laptop(monkeypatch)
    with pytest.raises(InputError, match=what):
        size.check(config.Config.from_yaml(text), tmp_path / "not yet" / "huge.h5")
    assert list(tmp_path.iterdir()) == []


def test_the_paper_fits_a_laptop(tmp_path, monkeypatch):
    laptop(monkeypatch)
    size.check(load(ROOT / "inputs" / "paper_nd4.yaml"), tmp_path / "paper.h5")


@pytest.mark.parametrize(
    ("path", "reason"),
    [("/proc/nope/x.h5", "No such file or directory"), ("closed/x.h5", "Permission denied")],
)
def test_a_place_where_nothing_can_be_written_is_no_full_disk(tmp_path, path, reason):
    if path.startswith("closed") and os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(InputError, match=rf"^cannot write .*x\.h5: {reason}$"):
        size.check(config.Config(), tmp_path / path)
