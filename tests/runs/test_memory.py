"""Memory of a study: foretold, and refused before work where this machine has less."""

import os
import tracemalloc

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
        "disk: {n_blades: 200, blade: {n_elements: 50}}",
        "speeds: {from_hz: 1e-6, to_hz: 1e-6}",
        "study: threshold\nthreshold: {tolerance: 1e-3}\nmistuning: {samples: 1000000}",
        "time: {step_s: 2e-12}",
        "contact: {law: abradable}\ntime: {step_s: 1e-10}",
        "study: interaction_map\nhistory: {duration_s: 1000}\ntime: {step_s: 1e-9}",
    ],
)
def test_what_this_machine_cannot_hold_is_refused_before_work(laptop, text):
    with pytest.raises(InputError, match="not enough memory: this study needs .* are there"):
        memory.check(studies.run_of(Config.from_yaml(text)))


def peak_of(function, *arguments):
    """Most memory that Python and NumPy hold while a function runs [bytes], and what it returns."""
    tracemalloc.start()
    try:
        returned = function(*arguments)
        return tracemalloc.get_traced_memory()[1], returned
    finally:
        tracemalloc.stop()


def compute(run, prepared):
    return list(run.study.compute(run.config, prepared, 0, lambda: None))


@pytest.mark.parametrize(("speed", "longest"), [(34, 0.8), (5000, 0.04)])
def test_a_history_takes_no_more_memory_than_is_told(speed, longest, monkeypatch):
    """It took 1.4 times as much, and 1.1 times at 5,000 Hz, where a block has a record.

    The garbage of Python shifts the peak by 0.1 MB, which is small beside what the history adds.
    """
    monkeypatch.setattr(memory, "COMPILING", 0)
    took, told = [], []
    for times in (0.3, 0.3, 1.0):  # the first one loads what all need
        keys = {"study": "time_response", "history": {"duration_s": times * longest}}
        run = studies.run_of(Config(speeds={"from_hz": speed, "to_hz": speed}, **keys))
        took.append(peak_of(compute, run, run.prepare())[0])
        told.append(memory.estimate(run))
    assert 0.5 < (took[2] - took[1]) / (told[2] - told[1]) < 1.0


def test_the_paper_fits_a_laptop():
    run = studies.run_of(load(ROOT / "inputs" / "paper_nd4.yaml"))
    assert 1e8 < memory.estimate(run) < 4e9
