"""What a run takes of the memory, and that this machine has it."""

import os

import pytest

from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.runs import memory
from tests.program import ROOT, load


@pytest.fixture
def laptop(monkeypatch):
    """This machine has 16 GiB of memory."""
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 2**22, "SC_PAGE_SIZE": 2**12}.get)


@pytest.mark.parametrize(
    "text",
    [
        "mistuning: {samples: 1000000000000}",
        "disk: {n_blades: 200, blade: {n_elements: 50}}",
        "speeds: {from_hz: 1e-6, to_hz: 1e-6}",
        "time: {step_s: 1e-12}",
        "contact: {law: abradable}\ntime: {step_s: 1e-10}",
        "study: interaction_map\nhistory: {duration_s: 1000}\ntime: {step_s: 1e-9}",
    ],
)
def test_what_this_machine_cannot_hold_is_refused_before_work(laptop, text):
    with pytest.raises(InputError, match="not enough memory: this study needs .* are there"):
        memory.check(studies.run_of(Config.from_yaml(text)))


def test_the_paper_fits_a_laptop(laptop):
    memory.check(studies.run_of(load(ROOT / "inputs" / "paper_nd4.yaml")))
