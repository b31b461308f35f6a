"""Input files: what is read as what.

Numbers follow YAML 1.2: 1e-6 is a number, `no` is not a boolean, 010 is ten. That what is written
by `to_yaml` is read back bit by bit, test_fuzz shows.
"""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pydantic import ValidationError

from evidence.truth.disk import LOAD, MATERIAL, disk_section, reference_scene
from hpcrub.config import sections
from hpcrub.config.schema import Config
from hpcrub.config.text import key_table
from hpcrub.config.yaml_text import MAX_CHARACTERS
from hpcrub.errors import InputError
from tests.program import ROOT, load, refusal

INPUTS = sorted((ROOT / "inputs").glob("*.yaml"))
TWELVE = "[210, 211, 212, 213, 214, 215, 209, 208, 207, 206, 205, 204]"


def read(text):
    return Config.from_yaml(text)


def test_defaults_in_si_units_are_the_reference_disk():
    """Those that all tests of the physics use, written down without an input file."""
    c, disk, scene = read("study: contact"), disk_section(), reference_scene()
    assert (c, len(c.speeds.values_hz)) == (Config(), 41)
    blade = vars(disk).pop("blade")
    sections = [
        (c.disk, vars(disk)),
        (c.disk.blade, vars(blade)),
        (c.material, vars(MATERIAL) | {"damping_ratio": scene.damping_ratio}),
        (c.casing, {name: getattr(scene.casing, name) for name in ("n_bumps", "bump_height")}),
        (c, {"clearance": scene.clearance}),
        (c.casing, {"growth_time": scene.ramp_time}),
        (c.contact, {"friction": scene.friction}),
        (c.forcing, {"amplitude": LOAD}),
        (c.time, {"step_s": 3.3e-5}),
        (c.steady_state, {"first_check": 0.5, "max_time": 2.0}),
    ]
    for section, expected in sections:
        for name, value in expected.items():
            assert getattr(section, name) == pytest.approx(value, rel=1e-15), name
    np.testing.assert_allclose(c.mistuning.half_range, [0.01, 0.02, 0.03, 0.04], rtol=1e-15)


@pytest.mark.parametrize("text", ["1e-6", "1E-6", "1.0e-6", "+1e-06", "0.000001", ".1e-5"])
def test_numbers_in_scientific_notation(text):
    assert read(f"time: {{step_s: {text}}}").time.step_s == 1e-6


@pytest.mark.parametrize(("text", "value"), [("5e3", 5000), ("5000.0", 5000), ("010", 10)])
def test_whole_numbers(text, value):
    samples = read(f"mistuning: {{samples: {text}}}").mistuning.samples
    assert samples == value
    assert isinstance(samples, int)


@given(
    start=st.integers(1, 100_000),
    step=st.integers(1, 5_000),
    n=st.integers(1, 300),
    rest=st.integers(0, 5_000),
)  # thousandths of Hz
@example(10_000, 10, 7001, 0)
def test_any_decimal_grid_has_the_points_one_counts_by_hand(start, step, n, rest):
    """Both ends are included whatever the rounding, the upper one where the steps lead to it."""
    rest %= step
    end = start + step * (n - 1)
    low, last, high = (x / 1000 for x in (start, end, end + rest))
    speeds = sections.Speeds(from_hz=low, to_hz=high, step_hz=step / 1000)
    assert len(speeds.values_hz) == speeds.n_values == n
    np.testing.assert_allclose(speeds.values_hz, low + step / 1000 * np.arange(n), rtol=1e-12)
    assert speeds.values_hz[-1] <= speeds.to_hz
    assert rest or speeds.values_hz[-1] == last


def test_pattern_is_one_sample_of_one_level_relative_to_the_modulus_of_the_input():
    pattern = f"mistuning: {{pattern_unit: gpa, pattern: {TWELVE}}}"
    c = read("material: {young_modulus_gpa: 2e2}\n" + pattern)
    assert c.mistuning.samples == 1
    np.testing.assert_allclose(c.mistuning.half_range, [15 / 200])
    np.testing.assert_allclose(c.pattern_deviation[:3], [0.05, 0.055, 0.06])
    assert read(c.to_yaml()) == c


def test_table2_is_the_papers_in_reversed_order():
    c = load(next(p for p in INPUTS if p.stem == "table2"))
    paper = [2.0701, 2.0627, 2.0695, 2.1683, 2.0809, 2.1421]
    paper += [2.1164, 2.0166, 2.1256, 2.0328, 2.0391, 2.1193]
    np.testing.assert_allclose(c.mistuning.pattern, 100 * np.array(paper)[::-1], rtol=1e-12)


def test_effective_configuration_has_every_key():
    casing = {
        "harmonics": [{"order": 2}],
        "modes": [{"waves": 2, "frequency_hz": 100, "modal_mass_kg": 100}],
    }
    text = Config(casing=casing, aero={"influence": [{"blades": 0}]}).to_yaml()
    for key in key_table(Config):
        assert f"{key.path.rsplit('.', 1)[-1]}:" in text


def test_load_names_the_output_after_the_input(tmp_path):
    path = tmp_path / "my disk.yaml"
    path.write_text("study: contact\n")
    assert load(path).output == "results/my disk.h5"
    assert load(path, ["output=x.h5"]).output == "x.h5"


def test_overrides_replace_keys(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("study: contact\ncasing: {n_bumps: 4}\n")
    changes = ["casing.n_bumps=3", "disk.blade.lean_deg=-1e1", "time.scheme=central_difference"]
    changes += ["mistuning.half_range_percent=[1, 2]", "convergence.stop_when_converged=true"]
    c = load(path, changes)
    assert c.casing.n_bumps == 3
    assert c.disk.blade.lean_deg == -10
    assert c.mistuning.half_range_percent == (1, 2)
    assert c.convergence.stop_when_converged
    assert c.time.scheme == "central_difference"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("casing.n_bumps", "override 'casing.n_bumps' is not of the form key.path=value"),
        ("=3", "override '=3' is not of the form key.path=value"),
        ("casing..n_bumps=3", "is not of the form key.path=value"),
        ("study.x=3", "override 'study.x=3': study.x: the input has no such section"),
        ("casing={n_bumps: 3}", "give one key at a time"),
        ("casing.n_bumps=[1", "override 'casing.n_bumps=[1': line 1, column 3: expected"),
        ("casing.n_bumps=", "casing.n_bumps: null is not a whole number from 1 up to 1,000"),
        ("casing.n_bump=3", "casing.n_bump: unknown key; did you mean casing.n_bumps?"),
    ],
)
def test_wrong_overrides(tmp_path, override, message):
    path = tmp_path / "a.yaml"
    path.write_text("study: contact\n")
    line = refusal(load, path, [override])
    assert message in line
    assert line.startswith(f"{path}: ")


def test_what_a_result_file_keeps_of_long_tables_is_read_back():
    """A measured casing and a table of clearances: laid out, and then refused as too long."""
    angles = [round(k / 10 + 1e-6, 6) for k in range(3600)]
    speeds = [[round(20 + k / 50 + 1e-6, 6), 5.123456] for k in range(1000)]
    shape = {"profile_deg": angles, "profile_mm": [-3.123456] * 3600, "clearance_hz_mm": speeds}
    waves = [{"diameters": abs(h), "travels": "forward" if h > 0 else "backward"} for h in
             (*range(-99, 0), *range(1, 100))]  # fmt: skip
    waves += [{"diameters": 0}, {"diameters": 100}]
    c = Config(casing=shape, aero={"waves": waves}, disk={"n_blades": 200})
    assert read(c.to_yaml()) == c


def test_unreadable_files(tmp_path):
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x80 not text")
    long = tmp_path / "long.yaml"
    long.write_text("#" * (MAX_CHARACTERS + 1))
    for path, reason in [
        (tmp_path / "none.yaml", "cannot be read (No such file or directory)"),
        (tmp_path, "cannot be read (Is a directory)"),
        (binary, "cannot be read ('utf-8' codec can't decode"),
        (long, "longer than the 500,000 characters allowed for an input"),
    ]:
        assert reason in refusal(load, path)


def test_not_a_number_from_python_is_refused():
    for value in (float("nan"), float("inf")):
        with pytest.raises(ValidationError):
            sections.Time(step_s=value)


def _with_spike(degrees):
    angle = [0.0, 100.0, 100.0 + degrees / 2, 100.0 + degrees, 200.0]
    points = f"profile_deg: {angle}, profile_mm: [0, 0, -2, 0, 0]"
    return f"casing: {{{points}, smoothing_mm: 0, clearance_mm: 0.9}}"


def test_a_spike_of_a_measured_casing_decides_the_step_or_is_refused():
    """32 steps over the part of it that stands beyond the clearance, half of them at least."""
    config = Config.from_yaml(_with_spike(0.5))
    beyond = 0.25 * 1.1 / 2.0  # [deg] half width of the triangle there
    in_a_step = 360 * config.speeds.to_hz * config.step
    assert 0.5 < in_a_step * 32 / (2 * beyond) < 2.0
    with pytest.raises(InputError, match="casing: its narrowest crest needs"):
        Config.from_yaml(_with_spike(0.002))


def test_speeds_in_revolutions_per_minute_are_kept_in_hertz():
    config = Config.from_yaml("speeds: {from_rpm: 2010, to_rpm: 2130, step_rpm: 3}")
    same = Config.from_yaml("speeds: {from_hz: 33.5, to_hz: 35.5, step_hz: 0.05}")
    assert config == same
    assert Config.from_yaml(config.to_yaml()) == config
    both = "speeds: {from_rpm: 2010, from_hz: 33.5}"
    told = refusal(Config.from_yaml, both)
    assert told.startswith("speeds.from_rpm: 2010 and speeds.from_hz: 33.5 are both given")
    assert "speeds.to_rpm: 'on' is not a number" in refusal(
        Config.from_yaml, "speeds: {to_rpm: on}"
    )


def test_a_casing_has_the_values_of_its_material_unless_they_are_given():
    def ring(keys):
        return Config.from_yaml(f"casing: {{ring: {{thickness_mm: 10, {keys}}}}}")

    titanium = ring("material: titanium")
    assert titanium.casing.ring.young_modulus == 114e9
    assert titanium.casing.ring.density_kg_m3 == 4430
    assert ring("material: titanium, density_kg_m3: 4500").casing.ring.density_kg_m3 == 4500
    nickel = titanium.replace({"casing.ring.material": "nickel"})
    assert nickel.casing.ring.young_modulus_gpa == 200
    assert ring("width_mm: 50").casing.ring.density_kg_m3 == 7800
    assert Config.from_yaml(nickel.to_yaml()) == nickel


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("casing.harmonics[1].order", "no such element of a list, counted from 0"),
        ("casing.harmonics.order", "no such element of a list, counted from 0 as in [0]"),
        ("casing.n_bumps[0]", "the input has no such section"),
        ("[]", "unknown key"),
    ],
)
def test_an_element_of_a_list_that_is_not_there_is_refused(path, told):
    config = Config.from_yaml("casing: {n_bumps: 3, harmonics: [{order: 2, amplitude_mm: 0.3}]}")
    assert config.replace({"casing.harmonics[0].order": 5}).casing.harmonics[0].order == 5
    assert told in refusal(config.replace, {path: 3})
