"""What moves the answer of a contact study: beside runs of the changed input."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.contact.status import STEADY
from hpcrub.results.verdict import Verdict
from hpcrub.setup.disks import deviation, run_deviation
from hpcrub.studies import open_result
from hpcrub.studies.checklist import CHANGES, STUDY, moved
from tests.program import TINY, computed, contents, load, swept

TEXT = TINY + "study: checklist\nchecklist: {disks: 2}\n"
NUMBER = {change.what: number for number, change in enumerate(CHANGES)}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("checklist")
    return folder, contents(computed(folder, TEXT))["peak_amplitude_m"]


@pytest.mark.parametrize(
    ("what", "keys"),
    [
        ("as asked", {}),
        ("half the damping", {"material.damping_ratio": 0.0025}),
        ("clearance 10 % smaller", {"casing.clearance_mm": 0.225}),
    ],
)
def test_a_disk_with_a_change_is_that_of_the_changed_input(found, what, keys):
    folder, size = found
    config = load(folder / "study.yaml").replace({"study": "contact"} | keys)
    level = len(config.mistuning.half_range) - 1
    samples = (deviation(config, level, s) for s in (0, 1))
    for disk, own in enumerate([run_deviation(config, 0), *samples]):
        assert size[NUMBER[what], disk] == swept(config, own).amplitude.max()


@pytest.mark.parametrize("key", ["clearance_mm: 0.25", "clearance_hz_mm: [[30, 0.3], [40, 0.2]]"])
def test_a_smaller_clearance_is_smaller_at_all_speeds(key):
    config = Config.from_yaml(f"{TEXT}casing: {{{key}}}\n")
    changed = config.replace(CHANGES[NUMBER["clearance 10 % smaller"]].values(config))
    before, after = (c.casing.clearances(c.speeds.values_hz) for c in (config, changed))
    np.testing.assert_allclose(after, 0.9 * before, rtol=1e-12)


def test_a_casing_that_vibrates_is_changed_too():
    ring = Config.from_yaml(TEXT + "casing: {ring: {thickness_mm: 20, damping_ratio: 0.01}}\n")
    mode = "{waves: 2, frequency_hz: 90, modal_mass_kg: 9, damping_ratio: 0.02}"
    table = Config.from_yaml(f"{TEXT}casing: {{modes: [{mode}]}}\n")
    halved, thicker, wider = (
        CHANGES[NUMBER[what]].values
        for what in ("half the casing's damping", "ring 10 % thicker", "ring 1 % wider in radius")
    )
    assert ring.replace(halved(ring)).casing.ring.damping_ratio == 0.005
    assert table.replace(halved(table)).casing.modes[0].damping_ratio == 0.01
    assert ring.replace(thicker(ring)).casing.ring.thickness_mm == pytest.approx(22)
    assert ring.replace(wider(ring)).casing.ring.radius_mm == pytest.approx(1.01 * 510)
    rigid = Config.from_yaml(TEXT)
    assert [change(rigid) for change in (halved, thicker, wider)] == [{}] * 3
    assert [change(table) for change in (thicker, wider)] == [{}] * 2


def test_what_the_scene_has_not_is_left_out_and_all_else_is_there(found):
    _, size = found
    nothing = np.isnan(size).all(axis=1)
    assert nothing[NUMBER["coating 20 % harder"]]
    assert np.isfinite(size[~nothing]).all()
    assert np.count_nonzero(~nothing) >= 9


def test_a_change_counts_where_it_is_more_than_chance(found):
    folder, before = found
    changed = np.array([[1.0, 2.0, 4.0], [1.1, 2.2, 4.4], [1.1, 1.8, 4.0], [np.nan] * 3])
    every, chance, nothing = moved(changed)
    np.testing.assert_allclose(every, (0.1, 0.0, 0.1), atol=1e-12)
    np.testing.assert_allclose(chance, (0.0, 4.3027 * 0.1 / np.sqrt(3), 0.1), atol=1e-4)  # t(2)
    assert np.isnan(nothing).all()
    rows = np.repeat([[0.01, 0.02, 0.03]], len(CHANGES), axis=0)
    rows[NUMBER["half the time step"]] *= [1.07, 1.08, 1.09]
    rows[NUMBER["half the damping"]] *= [1.3, 1.31, 1.32]
    rows[NUMBER["twice the modes"]] *= [1.5, 0.5, 1.0]
    rows[NUMBER["friction higher by 0.05"]] = np.inf  # no disk has a result
    with open_result(folder / "one.h5", mode="r+") as file:
        settled = np.full(rows.shape, STEADY)
        file.write({"peak_amplitude_m": rows, "peak_status": settled}, ())
        lines = Verdict.of(STUDY.findings(file)).lines
        file.write({"peak_amplitude_m": before}, ())
    assert "3 of 3 disks have no result with friction higher by 0.05: contact.friction" in lines
    words = "half the time step moves the answer by +8 %"
    assert lines[0].startswith(f"not usable: {words}, ")
    assert lines[1] == f"{words}: time.step_s"
    assert "half the damping moves the answer by +31 %: material.damping_ratio must" in lines[-1]
    open_yet = "twice the modes may move the answer by up to 124 %"  # 0 ± 4.3027 * 0.5/√3
    assert open_yet in lines[0]
    assert any(line.startswith(open_yet) and "more checklist.disks" in line for line in lines)
