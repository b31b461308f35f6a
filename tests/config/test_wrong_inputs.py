"""One clear line for every input that is wrong: key, value, and what is allowed."""

import pytest

from hpcrub import studies
from hpcrub.config import checks
from hpcrub.config.schema import Config
from hpcrub.config.text import key_table
from hpcrub.runs import execution
from tests.program import refusal

TWELVE = "[210, 211, 212, 213, 214, 215, 209, 208, 207, 206, 205, 204]"


def error_of(text):
    return refusal(lambda: studies.run_of(Config.from_yaml(text)).checked())


WRONG = [
    # unknown keys
    ("disk: {n_bumps: 3}", "disk.n_bumps: unknown key; did you mean casing.n_bumps?"),
    ("casing: {zzz: 3}", "casing.zzz: unknown key; known here: n_bumps, clearance_mm"),
    # types
    ("casing: {n_bumps: true}", "casing.n_bumps: true is not a whole number from 1 up to 1,000"),
    ("casing: {clearance_mm: '5'}", "casing.clearance_mm: '5' is not a number from 0 up to 10,000"),
    ("time: {step_s: 12:30}", "time.step_s: '12:30' is not a number"),
    ("convergence: {stop_when_converged: yes}", "stop_when_converged: 'yes' is not true or false"),
    ("output: 3", "output: 3 is not a file name"),
    ('output: "a/.."', "output: 'a/..' is not a file name"),
    ("output: results/", "output: 'results/' is not a file name"),
    ('output: "a\\nb"', "output: 'a\\nb' is not a file name"),
    ("disk: {least_clearance_mm: 3}", "3.0 goes with disk.model_sha256, which is not given"),
    ("disk: 3", "disk: 3 is not a section with keys such as n_blades"),
    ("casing: {harmonics: [{ordr: 2}]}", "casing.harmonics.ordr: unknown key; did you mean"),
    ("casing: {profile_deg: [0, 1, 2, 3], profile_mm: [0, 0, 0, 0, 0]}",
     "casing.profile_mm: 5 values for 4 angles"),
    ("casing: {profile_deg: [0, 90, 180, 270]}", "goes with casing.profile_mm, which is not given"),
    # ranges
    ("disk: {blade: {thickness_mm: -3}}",
     "disk.blade.thickness_mm: -3 is out of range, allowed is a number above 0"),
    ("material: {damping_ratio: 1}",
     "damping_ratio: 1 is out of range, allowed is a number from 1e-06 and below 1"),
    ("contact: {coating: {thickness_mm: 1e-300}}",  # whose stiffness would be infinite
     "thickness_mm: 1e-300 is out of range, allowed is a number from 0.001 up to 1,000"),
    ("time: {step_s: .nan}", "time.step_s: '.nan' is not a number"),
    ("mistuning: {half_range_percent: []}", "mistuning.half_range_percent: [] is not a list of 1"),
    ("mistuning: {half_range_percent: [1, 100]}",
     "mistuning.half_range_percent[1]: 100 is out of range, allowed is a number from 0 and"),
    # choices
    ("study: wrong", "study: 'wrong' is not one of branches, checklist, contact"),
    # keys that do not fit together
    ("disk: {inner_radius_mm: 200}", "disk.inner_radius_mm: 200.0 is not below disk.hub_radius_mm"),
    ("disk: {hub_radius_mm: 500}", "disk.hub_radius_mm: 500.0 is not below disk.tip_radius_mm"),
    ("reduction: {n_modes: 217}", "reduction.n_modes: 217 is more than the 216 fixed-interface"),
    ("speeds: {from_hz: 36}", "speeds.from_hz: 36.0 is above speeds.to_hz, 35.5"),
    ("speeds: {step_hz: 1e-6}", "speeds.step_hz: 1e-06 gives 2,000,001 speeds; at most 100,000"),
    ("casing: {clearance_hz_mm: [[1, 0.3], [1e5, 0.2]]}\nspeeds: {from_hz: 36}",
     "speeds.from_hz: 36.0 is above speeds.to_hz"),
    ("casing: {clearance_hz_mm: [[1, 0.3], [1e5, 0.2]]}\n"
     "speeds: {from_hz: 1, to_hz: 1e5, step_hz: 1e-6}", "gives 99,999,000,001 speeds; at most"),
    ("steady_state: {max_time_s: 0.4}",
     "steady_state.first_check_s: 0.5 is above steady_state.max"),
    ("convergence: {percentiles: [50, 1]}",
     "percentiles: [50, 1] is not a list of 1 to 20 increasing"),
    ("mistuning: {pattern_unit: gpa, pattern: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]}",
     "mistuning.pattern: 11 values given for the 12 blades of disk.n_blades"),
    (f"mistuning: {{pattern_unit: gpa, pattern: {TWELVE.replace('215', '420')}}}",
     "mistuning.pattern: the stiffness of a blade deviates by 100 % (mistuning.pattern_unit"),
    (f"mistuning: {{half_range_percent: [3], pattern_unit: gpa, pattern: {TWELVE}}}",
     "mistuning.half_range_percent: [3.0] cannot be combined with mistuning.pattern"),
    ("mistuning: {pattern: 210}", "mistuning.pattern: 210 is not a list of 1 to 200 values"),
    ("mistuning: {by: cantilever_modes}", "'cantilever_modes' goes with disk.model, which is n"),
    ("study: run_up\nrun_up: {from_hz: 33, to_hz: 34, hz_per_s: [1, 1000]}",  # nothing but NaN
     "run_up.hz_per_s: a run of 0.001 s is 0.034 revolutions; one is needed"),
    ("study: time_response\nspeeds: {from_hz: 30, to_hz: 31}", "31.0 is not speeds.from_hz, 30.0"),
    ("study: interaction_map\nspectrum: {window_s: 0.001}", "hold fewer than 16 recorded displac"),
    ("speeds: {from_hz: 44,5}", "a key must be a plain name; a decimal comma? write 44.5"),
    ("study: interaction_map\ncasing: {growth_time_s: 0.8}", "the bumps still grow in the last"),
    ("limits: {stress_mpa: 100, static_mpa: 90}", "limits.static_mpa, limits.strength_mpa"),
    ("limits: {stress_mpa: 100, strength_mpa: 90}", "limits.static_mpa, limits.strength_mpa"),
    ("limits: {static_mpa: 9, strength_mpa: 90}", "static_mpa: 9.0 goes with limits.stress_mpa"),
    ("limits: {stress_mpa: 9, static_mpa: 90, strength_mpa: 90}", "strength_mpa: 90 is not above"),
    ("aero: {influence: [{blades: '1'}]}", "aero.influence[0].blades: '1' is not a whole number"),
    ("patterns: {types_percent: [2, 2]}", "patterns.types_percent: [2.0, 2.0] are not different"),
    ("study: rare\nmistuning: {half_range_percent: [0]}", "makes all disks of a rare study alike"),
    # YAML
    ("", "no keys found"),
    ("casing: {n_bumps: 3, n_bumps: 4}", "line 1, column 22: key 'n_bumps' is given twice"),
    ("casing: {n_bumps: 3", "line 1, column 20: expected ',' or '}'"),
    ("output: a.PNG", "output: 'a.PNG' ends as the figures and logs beside a result file do"),
    ("study: &a contact\noutput: *a", "line 2, column 9: aliases (*) are not supported"),
    ("study: !!python/name:os.system", "line 1, column 8: could not determine a constructor"),
    ("study: \x07", "not YAML: unacceptable character"),
    # damping
    ("material: {damping_of: families}", "'families' goes with material.damping_ratios, w"),
    ("material: {damping_bands_hz: [100]}", "[100.0] goes with material.damping_of: bands, not m"),
    ("material: {damping_ratios: [0.1, 0.2, 0.3], damping_of: bands, damping_bands_hz: [100]}",
     "damping_bands_hz: 1 ends of bands given for 3 damping ratios"),
    ("material: {damping_ratios: [0.1, 0.2, 0.3], damping_of: bands, damping_bands_hz: [10, 9]}",
     "damping_bands_hz: [10, 9] is not a list of 1 to 999 increasing values"),
    # distributions of the mistuning
    ("mistuning: {distribution: measured}", "'measured' goes with mistuning.measured_percent, w"),
    ("mistuning: {measured_percent: [1, 2]}", "goes with mistuning.distribution: measured, not un"),
    ("mistuning: {distribution: measured, measured_percent: [0, 0]}", "all values are 0"),
    ("mistuning: {intentional_percent: [1, 2, 3, 4, 5]}", "5 values cannot be repeated around 12"),
    ("mistuning: {intentional_percent: [99, -99]}", "a blade deviates by 103 %"),
    (f"mistuning: {{distribution: normal, pattern: {TWELVE}}}", "combined with mistuning.pattern"),
    # parts of a study
    ("study: linear\npart: {samples: [0, 5]}", "part.samples: a linear study cannot be"),
    ("convergence: {stop_when_converged: true}\npart: {samples: [0, 5]}",
     "cannot be combined with convergence.stop_when_converged"),
    ("part: {samples: [3, 3]}", "part.samples: [3, 3] is no range of the 5000"),
    ("part: {samples: [0]}", "part.samples: [0] is not a list of 2 values"),
    # clearances
    ("casing: {clearance_hz_mm: [[33, 0.3], [35, 0.2]]}", "from 33 to 35 Hz say nothing of all"),
    ("casing: {clearance_hz_mm: [[34, 0.3], [36, 0.2]]}", "from 34 to 36 Hz say nothing of all"),
    ("casing: {clearance_hz_mm: [[33, 0.3], [36, 0.2], [36, 0.1]]}",
     "is not a list of 2 to 1000 increasing values"),
    ("casing: {clearance_hz_mm: [[20, 0.3], [33, -0.1], [36, 0.2]]}", "leaves less than none"),
    ("casing: {clearance_hz_mm: [[33, 0.3]]}",
     "[[33, 0.3]] is not a list of 2 to 1000 increasing values, each a list"),
    ("casing: {clearance_hz_mm: 0.3}",
     "each a list of 2 values, each a number, or a file name, or null"),
    ("casing: {clearance_hz_mm: [[33, 0], [36, a]]}", "[1][1]: 'a' is not a number (clear"),
    ("casing: {blade_clearance_mm: [0, 0.1]}", "2 values given for the 12 blades of the disk"),
    ("casing: {blade_clearance_mm: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -0.3]}",
     "a clearance of 0.25 mm, casing.clearance_offset_mm included, and -0.3 mm"),
    # a casing that vibrates
    ("casing: {ring: {thickness_mm: 5, waves: [3, 3]}}",
     "casing.ring.waves: [3, 3] are not different"),
    ("casing: {ring: {width_mm: 50}}", "ring.width_mm: 50.0 goes with casing.ring.thickness_mm"),
    ("casing: {ring: {thickness_mm: 5}, modes: [{waves: 2, frequency_hz: 9, modal_mass_kg: 9}]}",
     "cannot be combined with casing.r"),
    ("casing: {ring: {thickness_mm: 5}, growth_time_s: 0}", "bumps that overlap the tips"),
    ("casing: {modes: [{waves: 2, frequency_hz: -3}]}", "frequency_hz: -3 is out of range"),
    ("casing: {modes: [{waves: 2, frequency_hz: 90}]}", "casing.modes[0].modal_mass_kg: not given"),
    ("casing: {modes: [{waves: 3, frequency_hz: 50, modal_mass_kg: 9}, "
     "{waves: 3, frequency_hz: 51, modal_mass_kg: 9}]}",
     "n = 3 at 50 and 51 Hz; cos nθ and sin nθ are one pair of one frequency"),
    # laws and coatings
    ("contact: {coating: {tip_area_mm2: 0}}", "allowed is a number above 0 and up to 100,"),
    ("contact: {law: abradable, coating: {yield_mpa: 1000}}",
     "yield_mpa: 1000 is not below contact.coating.young_gpa, 1: such a coating is pressed flat"),
    ("contact: {kinematics: second_order}\ncasing: {ring: {thickness_mm: 5}}",
     "kinematics: 'second_order' cannot be combined with casing.ring.thickness_mm"),
    ("contact: {coating: {yield_mpa: 10}}", "yield_mpa: 10.0 goes with contact.law: abradable, no"),
    ("contact: {law: elastic}", "'elastic' goes with contact.casing_stiffness_n_per_m, which is"),
    ("contact: {casing_stiffness_n_per_m: 1e8}", "contact.law: elastic or abradable, not rigid"),
    ("contact: {law: abradable, casing_damping_ns_per_m: 3}",
     "casing_damping_ns_per_m: 3.0 goes with contact.casing_stiffness_n_per_m"),
    ("study: branches\ncontact: {law: abradable}", "contact.law: rigid or elastic, not abr"),
    ("disk: {model: any.h5}\ncontact: {law: abradable}", "large the tip of a blade is; give its a"),
    ("speeds:\n  from_hz: 44,5", "up to 100,000 (lowest speed of rotation [Hz]); "
     "did you mean 44.5?"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), WRONG, ids=[text[:40] for text, _ in WRONG])
def test_wrong_inputs(text, message):
    assert message in error_of(text)


IDLE = [
    ("sources: [b.h5]",
     "sources: ['b.h5'] has no effect: it goes with study: energy or run_up, not modal"),
    ("casing: {clearance_mm: 0.3, clearance_hz_mm: [[33, 0.3], [36, 0.2]]}",
     "clearance_mm: 0.3 has no effect: it cannot be combined with casing.clearance_hz_mm"),
    ("casing: {clearance_mm: 0.3, clearance_s_mm: [[0, 0.3], [9, 0.2]]}",
     "clearance_mm: 0.3 has no effect: it cannot be combined with casing.clearance_s_mm"),
    ("limits: {amplitude_mm: 9}",
     "limits.amplitude_mm: 9.0 has no effect: it goes with study: contact or run_up or threshold"),
    ("limits: {stress_mpa: 350}",
     "limits.stress_mpa: 350.0 has no effect: it goes with study: contact or run_up or threshold"),
    ("convergence: {stop_when_converged: true}", "no effect: it goes with study: contact, not mod"),
    ("casing: {smoothing_mm: 9}", "casing.profile_csv or casing.profile_mm, which is no"),
    ("material: {damping_ratio: 0.01, damping_ratios: [0.02]}", "combined with material.damping_r"),
    ("steady_state: {rule: last_window, max_error: 0.1}", "rule: ensemble, not last_window"),
    ("steady_state: {confirmations: 3}", "confirmations: 3 has no effect: it goes with"),
    ("mistuning: {truncation: 2}", "mistuning.truncation: 2.0 has no effect: it goes with"),
    ("mistuning: {pattern_unit: hz}", "mistuning.pattern_unit: 'hz' has no effect: it goes with"),
    ("limits: {stress_mpa_per_mm: 9}", "it goes with limits.stress_mpa, which is not given"),
    ("limits: {probability_below: 0.01}", "no effect: it goes with study: rare, not modal"),
    # percent typed as a ratio
    ("material: {damping_ratio: 0.3}", "units: material.damping_ratio: 0.3 is 30 % of critical"),
    ("aero: {influence: [{damping_ratio: -0.2}]}", "units: aero.influence: 0.2 is 20 % of crit"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), IDLE, ids=[text[:40] for text, _ in IDLE])
def test_keys_without_effect_are_named_by_a_run_and_a_dry_run(text, message, folder):
    run = studies.run_of(Config.from_yaml(f"study: modal\noutput: a.h5\n{text}"))
    (warning,) = execution.examine(run, execution.Existing())[1]
    assert message in warning


def test_what_goes_with_what_names_keys_and_sections_that_there_are():
    known = {key.path for key in key_table(Config)}
    known |= {path.rpartition(".")[0] for path in known} - {""}
    for table in (checks.GOES_WITH, checks.USELESS_WITHOUT):
        for other, keys in table.items():
            names = other.removeprefix("no ").partition(": ")[0].split(" or ")
            assert known.issuperset([*names, *(key.partition(": ")[0] for key in keys)])


def test_more_errors_are_counted():
    assert error_of("disk: {n_blades: 0}\ntime: {step_s: 0}\nx: 1").endswith("(and 2 more)")


def test_a_tip_that_springs_back_takes_short_steps_unless_told_otherwise():
    rigid, given = Config(), Config(contact={"law": "abradable"}, time={"step_s": 2e-5})
    coated = rigid.replace({"contact.law": "abradable"})
    assert coated.time.step_s < given.time.step_s == 2e-5 < rigid.time.step_s
    assert coated.replace({"contact.law": "rigid"}) == rigid
    assert Config.from_yaml(coated.to_yaml()).time == coated.time
