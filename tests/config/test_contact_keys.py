"""What is refused of the keys that say how blades meet the casing: clearances, laws, coating."""

import pytest

from hpcrub.config.schema import Config
from hpcrub.errors import InputError

CLEARANCE = [
    ("clearance_hz_mm: [[33, 0.3], [35, 0.2]]", "points from 33 to 35 Hz say nothing of all"),
    ("clearance_hz_mm: [[34, 0.3], [36, 0.2]]", "points from 34 to 36 Hz say nothing of all"),
    ("clearance_hz_mm: [[33, 0.3], [36, 0.2], [36, 0.1]]", "the speeds of the points are not incr"),
    ("clearance_hz_mm: [[33, 0.3], [36, -0.2]]", "-0.2 mm at 36 Hz; a clearance from 0"),
    ("clearance_hz_mm: [[20, -0.3], [33, 0.1], [36, 0.2]]", "-0.3 mm at 20 Hz; a clearance from 0"),
    ("clearance_hz_mm: [[33, 0.3]]", "[[33, 0.3]] is not a list of 2 to 1000 values, each a list"),
    ("clearance_hz_mm: 0.3", "each a list of 2 values, each a number, or a file name, or null"),
    ("clearance_hz_mm: [[33, 0], [36, a]]", "clearance_hz_mm[1][1]: 'a' is not a number (clear"),
    ("clearance_polynomial_mm: [3.4, -0.1]", "gone; give points of the curve as casing.clearance_"),
    ("blade_clearance_mm: [0, 0.1]", "2 values given for the 12 blades of the disk"),
    (
        "blade_clearance_mm: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -0.3]",
        "-0.3 with 0.25 mm of the casing leaves less than no clearance",
    ),
]
LAW = [
    ("coating: {thickness_mm: 0}", "coating.thickness_mm: 0 is out of range, allowed is a number"),
    ("coating: {hardening_mpa: -1}", "below 0 the forces of a step would not be unique"),
    ("coating: {tip_area_mm2: 0}", "0 is out of range, allowed is a number above 0 and up to 100,"),
    (
        "law: abradable, coating: {yield_mpa: 1000}",
        "yield_mpa: 1000 is not below contact.coating.young_gpa, 1: such a coating is pressed flat",
    ),
    ("coating: {yield_mpa: 10}", "coating.yield_mpa: goes with contact.law: abradable, not rigid"),
    ("law: elastic", "casing_stiffness_n_per_m: goes with contact.law: elastic, and is not given"),
    ("casing_stiffness_n_per_m: 1e8", "goes with contact.law: elastic or abradable, not rigid"),
    (
        "law: abradable, casing_damping_ns_per_m: 3",
        "casing_damping_ns_per_m: goes with contact.casing_stiffness_n_per_m",
    ),
]
WRONG = [f"casing: {{{keys}}}" for keys, _ in CLEARANCE] + [f"contact: {{{k}}}" for k, _ in LAW]
WORDS = [words for _, words in CLEARANCE + LAW]


@pytest.mark.parametrize(("text", "words"), list(zip(WRONG, WORDS, strict=True)), ids=WORDS)
def test_wrong_inputs(text, words):
    with pytest.raises(InputError) as caught:
        Config.from_yaml(text)
    assert words in str(caught.value)


def test_a_tip_that_springs_back_takes_short_steps_unless_told_otherwise():
    rigid, given = Config(), Config(contact={"law": "abradable"}, time={"step_s": 2e-5})
    coated = rigid.replace({"contact.law": "abradable"})
    assert coated.time.step_s < given.time.step_s == 2e-5 < rigid.time.step_s
    assert coated.replace({"contact.law": "rigid"}) == rigid
    assert Config.from_yaml(coated.to_yaml()).time == coated.time


def test_speeds_that_go_on_from_others_have_no_coating():
    with pytest.raises(InputError, match="abradable does not fit study: branches, in which"):
        Config.from_yaml("study: branches\ncontact: {law: abradable}")


def test_a_model_file_does_not_know_the_area_of_a_tip():
    with pytest.raises(InputError, match="how large the tip of a blade is; give its area"):
        Config.from_yaml("disk: {model: any.h5}\ncontact: {law: abradable}")
