"""The largest motion of a study of a few is swept to second order, around its speed."""

import numpy as np
import pytest

from hpcrub.setup.disks import fixed_disks
from hpcrub.setup.problem import to_second_order
from hpcrub.studies import STUDIES, branches, open_result
from tests.program import computed, swept

PATTERN = f"[{', '.join(['1', '-1'] * 6)}]"
TEXT = f"""\
casing: {{n_bumps: 4}}
time: {{step_s: 2e-5}}
mistuning: {{pattern: {PATTERN}}}
"""
KEYS = {
    "time_response": "speeds: {from_hz: 33.2, to_hz: 33.2}\nhistory: {duration_s: 0.3}\n",
    "interaction_map": "speeds: {from_hz: 32.5, to_hz: 36.5, step_hz: 1}\n"
    "history: {duration_s: 0.3}\nspectrum: {window_s: 0.1, max_frequency_hz: 150}\n",
    "branches": "speeds: {from_hz: 33.6, to_hz: 34.4, step_hz: 0.4}\n"
    "branches: {perturbed: 1, perturbation_mm: 5}\n"
    "steady_state: {first_check_s: 0.2, max_time_s: 0.2}\n",
}
AMPLITUDE = {"interaction_map": "mean_amplitude_m"}


@pytest.mark.parametrize("name", KEYS)
def test_it_is_a_sweep_to_second_order_of_that_disk(name, tmp_path, monkeypatch):
    monkeypatch.setattr(branches, "N_WINDOWS", 2)
    path = computed(tmp_path, f"study: {name}\n{TEXT}{KEYS[name]}", "--no-figures")
    with open_result(path) as file:
        found = file.read("second_order_amplitude_m")
        lines = STUDIES[name].verdict(file).lines
        size, config = file.read(AMPLITUDE.get(name, "amplitude_m")), file.config
    disks = fixed_disks(config)
    if name == "branches":  # of one disk, from many states: from rest
        disks, size, found = disks[1:], size[:1], found[:1]
    speeds = config.speeds.values_hz
    size = size.reshape(len(disks), len(speeds))
    row, at = np.unravel_index(size.argmax(), size.shape)
    bent = swept(to_second_order(config), disks[row]).amplitude
    near = abs(speeds / speeds[at] - 1.0) <= 0.04
    assert found[row] == bent[near].max()
    assert np.isnan(np.delete(found, row)).all()
    assert any(line.startswith("to second order") for line in lines)


def test_it_is_left_out_where_it_does_not_matter_or_is_not_asked(tmp_path):
    for more in ("mistuning.checked_samples=0", "casing.clearance_mm=5"):
        text = f"study: time_response\n{TEXT}{KEYS['time_response']}"
        path = computed(tmp_path, text, "--no-figures", "--overwrite", "--set", more)
        with open_result(path) as file:
            assert np.isnan(file.read("second_order_amplitude_m")).all()
