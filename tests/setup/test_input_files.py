"""What has been measured and comes in files: read once, refused clearly, kept in the result."""

import numpy as np
import pytest

from hpcrub import plot
from hpcrub.commands import run as cli
from hpcrub.config import parts
from hpcrub.config.casing import CasingMode
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.imported.readers import text as texts
from hpcrub.setup import input_files
from hpcrub.setup.disks import deviation, fixed_disks, run_deviation, sigma_of
from hpcrub.studies import open_result
from tests.program import TINY, refusal, run_here

PROFILE = "angle_deg,radius_change_mm\n0,-0.5\n90,0\n180,-0.4\n270,0.1\n"


def resolved(path, **casing):
    return input_files.resolved(Config(casing={"profile_csv": str(path)} | casing))


def test_a_profile_is_read_into_the_configuration(tmp_path):
    path = tmp_path / "casing.csv"
    path.write_text(
        "# made by hand\nradius_change_mm, angle_deg\n-0.4, 180\n0.1, 270\n\n-0.5, 0\n0, 90\n"
        "-0.5, 360\n"
    )
    config = resolved(path, smoothing_mm=0)
    assert config.casing.profile_deg == (0.0, 90.0, 180.0, 270.0)
    assert config.casing.profile_mm == (-0.5, 0.0, -0.4, 0.1)
    assert config.casing.bump_height_mm == 0.0  # of the default bumps: they do not come along
    path.unlink()  # the configuration has all
    again = input_files.resolved(Config.from_yaml(config.to_yaml()))
    assert again == config
    height = again.casing.profile.height(np.radians([0.0, 45.0, 270.0]))
    np.testing.assert_allclose(height, [5e-4, 2.5e-4, -1e-4], rtol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "\ufeffangle_deg;radius_change_mm\r\n0;-0,5\r\n90;1,5e-1\r\n",  # a spreadsheet in Europe
        "angle_deg\tradius_change_mm\n0\t-0.5\n90\t0.15\n",
        "# made, by hand;\n  angle_deg   radius_change_mm\n\n  0.0  -0.5 \n 90.0   0.15\n",
        '"angle_deg","radius_change_mm"\n"0", "-0.5"\n90 ,0.15\n,,\n',
    ],
)
def test_columns_are_separated_as_programs_do_it(tmp_path, text):
    """Semicolons were refused as one column, and blanks as "is not a number"."""
    path = tmp_path / "casing.csv"
    path.write_bytes(text.encode())
    names, values = texts.table(path)
    assert names == ("angle_deg", "radius_change_mm")
    np.testing.assert_array_equal(values, [[0.0, -0.5], [90.0, 0.15]])


OF_THREE = {"disk": {"n_blades": 3}, "reduction": {"n_modes": 9}}
WAVES = "diameters,damping_ratio,frequency_shift\n0,0.005,0\n1,4e-7,1e-9\n-1,0.005,0\n"
TABLES = {
    "aero.waves_csv": WAVES,
    "casing.clearance_hz_mm": "speed_hz,clearance_mm\n1,0.2500001\n50.123456789,4e-7\n",
    "casing.profile_csv": PROFILE + "300,4e-7\n",
    "casing.modes_csv": ",".join(CasingMode.model_fields) + "\n2,100.12345678,4e-7,1e-8,4e-7\n",
}


@pytest.mark.parametrize("key", TABLES)
def test_no_number_of_a_table_is_rounded(tmp_path, key):
    """A damping ratio of 4e-7 became 0, and every disk fluttered."""
    (tmp_path / "table.csv").write_text(TABLES[key])
    config = Config(**OF_THREE).replace({key: str(tmp_path / "table.csv")})
    config = input_files.with_tables(config)
    assert Config.from_yaml(config.to_yaml()) == config
    given = {float(cell) for line in TABLES[key].split()[1:] for cell in line.split(",")}
    assert given <= {*numbers_in(config.model_dump()), -1.0}  # a wave that travels backward


def numbers_in(value):
    """All numbers in nested lists and mappings."""
    if isinstance(value, dict | list | tuple):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from numbers_in(inner)
    elif isinstance(value, float | int):
        yield value


@pytest.mark.parametrize("key", TABLES)
def test_a_table_that_is_far_too_long_is_refused_before_it_is_read(tmp_path, monkeypatch, key):
    """100,000 lines took 39 s to be refused."""
    names, row = TABLES[key].split("\n")[:2]
    (tmp_path / "table.csv").write_text(names + ("\n" + row) * 3602)
    monkeypatch.setattr(texts, "_number", None)  # what takes the time
    config = Config().replace({key: str(tmp_path / "table.csv")})
    assert "table.csv: more than " in refusal(input_files.with_tables, config)


@pytest.mark.parametrize("digits", ["1_0", "\u0661", "0x1", "1e"])
def test_digits_that_python_alone_reads_are_no_number(tmp_path, digits):
    (tmp_path / "modes.csv").write_text(TABLES["casing.modes_csv"].replace("2,", f"{digits},", 1))
    config = Config(casing={"modes_csv": str(tmp_path / "modes.csv")})
    assert f"line 2: {digits!r} is not a number" in refusal(input_files.with_tables, config)


@pytest.mark.parametrize(
    ("key", "given"),
    [
        ("casing.profile_csv", {"profile_deg": [0, 90, 180, 270], "profile_mm": [0, 1, 0, 1]}),
        ("casing.modes_csv", {"modes": [{"waves": 3, "frequency_hz": 80, "modal_mass_kg": 9}]}),
        ("aero.waves_csv", {"waves": [{"diameters": 0}]}),
    ],
)
def test_numbers_beside_the_table_that_has_others_are_refused(tmp_path, key, given):
    """The table was left unread."""
    (tmp_path / "table.csv").write_text(TABLES[key])
    section, name = key.split(".")
    if name == "waves_csv":
        ways = ((0, "neither"), (1, "forward"), (1, "backward"))
        given = {"waves": [{"diameters": h, "travels": way} for h, way in ways]}
    keys = OF_THREE | {section: given | {name: str(tmp_path / "table.csv")}}
    assert "given beside" in refusal(input_files.with_tables, Config(**keys))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "casing.csv: cannot be read (No such file"),
        ("", "casing.csv: is empty"),
        ("0,1\n90,0\n180,0\n270,1\n", "a line of numbers instead of the names angle_deg"),
        ("angle,radius\n0,1\n", "angle, radius instead of the names angle_deg, radius_change_mm"),
        ("angle_deg,radius_change_mm\n0,0\n90,x\n", "line 3: 'x' is not a number"),
        ("angle_deg,radius_change_mm\n0,0\n90\n", "line 3 has 1 numbers, 2 numbers per"),
        ("angle_deg,radius_change_mm\n0,0\n90,nan\n", "line 3: 'nan' is not a number"),
        (
            "angle_deg,radius_change_mm\n0,0\n90,0\n",
            "casing.profile_deg: [0.0, 90.0] is not a list of 4 to 3600",
        ),
        (PROFILE + "90,1\n", "90.0, 90.0, 180.0, 270.0] is not a list of 4 to 3600 increasing"),
        (PROFILE + "360,1\n", "[0.0, 0.0, 90.0, 180.0, 270.0] is not a list of 4 to 3600 incr"),
        (PROFILE + "361,1\n", "casing.profile_deg[4]: 361.0 is out of range"),
    ],
)
def test_a_profile_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "casing.csv"
    if text is not None:
        path.write_text(text)
    assert words in refusal(resolved, path)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("casing: {profile_csv: /proc/kmsg}", "/proc/kmsg: is empty"),  # reading it would wait
        ("casing: {profile_csv: /dev/zero}", "/dev/zero: is neither a file nor a folder"),
        ("mistuning: {pattern: /dev/zero}", "/dev/zero: is neither a file nor a folder"),
    ],
)
def test_a_table_that_never_ends_is_refused(keys, words):
    assert words in refusal(input_files.resolved, Config.from_yaml(keys))


@pytest.mark.parametrize(
    ("key", "names"),
    [
        ("casing.modes_csv", ",".join(CasingMode.model_fields)),
        ("aero.waves_csv", "diameters,damping_ratio,frequency_shift"),
        ("mistuning.pattern", "one,two"),
    ],
)
def test_a_table_of_names_alone_is_refused(tmp_path, key, names):
    """Without any mode or wave the study went on, to a traceback."""
    (tmp_path / "names.csv").write_text(names + "\n")
    config = Config().replace({key: str(tmp_path / "names.csv")})
    assert "names.csv: there are no numbers in it" in refusal(input_files.resolved, config)


def test_a_result_keeps_its_profile_and_refuses_another(folder, capfd):
    (folder / "casing.csv").write_text(PROFILE)
    casing = "casing: {profile_csv: casing.csv, smoothing_mm: 0}\n"
    (folder / "input.yaml").write_text(f"study: modal\n{casing}")
    arguments = "input.yaml", "--output", "out.h5", "--no-figures"
    assert cli.main(arguments) == 0
    angle, gap = plot.casing(folder / "out.h5")[1].get_lines()[0].get_data()
    expected = 0.25 + np.interp(angle, [0, 90, 180, 270, 360], [-0.5, 0, -0.4, 0.1, -0.5])
    np.testing.assert_allclose(gap, expected, atol=1e-12)
    assert cli.main([*arguments, "--resume"]) == 0
    (folder / "casing.csv").write_text(PROFILE.replace("-0.4", "-0.3"))
    assert cli.main([*arguments, "--resume"]) == 2
    found = "casing.profile_mm: [-0.5, 0.0, -0.4, 0.1] in the file, [-0.5, 0.0, -0.3, 0.1]"
    assert found in capfd.readouterr().err


PATTERNS = np.random.default_rng(9).uniform(-3.0, 3.0, (5, 12)).round(2)


def study_of(path, **mistuning):
    return input_files.resolved(Config(mistuning={"pattern": str(path)} | mistuning))


def csv_of(path, values, head=""):
    lines = [",".join(f"{value!r}" for value in row) for row in values.tolist()]
    path.write_text(head + "\n".join(lines) + "\n")
    return path


def test_every_measured_disk_is_a_sample(tmp_path):
    names = ",".join(f"blade {i}" for i in range(12)) + "\n"
    percent = csv_of(tmp_path / "disks.csv", PATTERNS, "# of a rig\n" + names)
    gpa = csv_of(tmp_path / "gpa.csv", 210.0 * (1.0 + PATTERNS / 100))
    hz = csv_of(tmp_path / "hz.csv", 91.0 * np.sqrt(1.0 + PATTERNS / 100))
    config = study_of(percent)
    assert config.mistuning.samples == 5
    assert config.mistuning.half_range_percent == (np.abs(PATTERNS).max(),)
    np.testing.assert_allclose(sigma_of(config), [PATTERNS.std() / 100], rtol=1e-12)
    for sample, row in enumerate(PATTERNS):
        np.testing.assert_array_equal(deviation(config, 0, sample), row / 100)
        np.testing.assert_allclose(
            deviation(study_of(gpa, pattern_unit="gpa"), 0, sample), row / 100, atol=1e-15
        )
        measured_hz = np.sqrt(1.0 + row / 100)
        np.testing.assert_allclose(
            deviation(study_of(hz, pattern_unit="hz"), 0, sample),
            (measured_hz / measured_hz.mean()) ** 2 - 1.0, atol=1e-15,
        )  # fmt: skip
    few = study_of(percent, samples=3)
    assert few.mistuning.samples == 3
    np.testing.assert_allclose(sigma_of(few), [PATTERNS[:3].std() / 100], rtol=1e-12)
    assert input_files.resolved(Config.from_yaml(config.to_yaml())) == config
    part = parts.cut(config, 2, 2)
    np.testing.assert_array_equal(deviation(part, 0, 0), PATTERNS[2] / 100)


@pytest.mark.parametrize(
    ("rows", "keys", "words"),
    [
        (PATTERNS[:, :11], {}, "has 11 columns for the 12 blades of disk.n_blades"),
        (PATTERNS, {"samples": 6}, "samples: 6 asked for, .* has 5 disks"),
        (PATTERNS, {"pattern_unit": "hz"}, "values above 0 are expected in hz"),
        (40 * PATTERNS, {}, "the stiffness of a blade deviates by 1.* less than 100 % is allowed"),
        (PATTERNS, {"half_range_percent": [4]}, "half_range_percent: cannot be combined"),
        (PATTERNS, {"distribution": "normal"}, "combined with mistuning.pattern"),
    ],
)
def test_patterns_that_do_not_fit_are_refused(tmp_path, rows, keys, words):
    with pytest.raises(InputError, match=words):
        study_of(csv_of(tmp_path / "disks.csv", rows), **keys)


def test_a_study_of_one_disk_takes_one_of_many_only(tmp_path):
    config = study_of(csv_of(tmp_path / "disks.csv", PATTERNS)).replace({"study": "branches"})
    with pytest.raises(InputError, match="5 disks, and a study branches is of one"):
        fixed_disks(config)
    first = config.replace({"mistuning.samples": 1})
    np.testing.assert_array_equal(fixed_disks(first), [run_deviation(first, 0), PATTERNS[0] / 100])
    told = Config(study="branches", mistuning={"pattern": PATTERNS[0].tolist()})
    run = run_deviation(told, 0)  # which the blades of a pattern have on top
    assert np.ptp(run) > 5e-5
    np.testing.assert_allclose(fixed_disks(told), [run, PATTERNS[0] / 100 + run], atol=1e-15)


def test_a_study_of_measured_disks_is_that_of_its_patterns(tmp_path, capfd):
    csv_of(tmp_path / "disks.csv", PATTERNS[:2])
    levels = "mistuning: {half_range_percent: [2, 4], samples: 2, checked_samples: 0}"
    for name, pattern in (("all", "disks.csv"), ("one", PATTERNS[1].tolist())):
        text = TINY.replace(levels, f"mistuning: {{pattern: {pattern}, reference: symmetric}}")
        (tmp_path / f"{name}.yaml").write_text(text)
        assert run_here(f"{name}.yaml", "--output", f"{name}.h5", folder=tmp_path) == 0
    with open_result(tmp_path / "all.h5") as many, open_result(tmp_path / "one.h5") as one:
        np.testing.assert_array_equal(many.read("samples/deviation", 0), PATTERNS[:2] / 100)
        for name in ("amplification", "amplitude_m", "linear_amplification"):
            found, alone = (file.read(f"samples/{name}", 0) for file in (many, one))
            assert found[1].tobytes() == alone[0].tobytes()
    csv_of(tmp_path / "disks.csv", PATTERNS[1:3])
    assert run_here("all.yaml", "--output", "all.h5", "--resume", folder=tmp_path) == 2
    err = capfd.readouterr().err
    assert "pattern_sha256" in err or "half_range_percent" in err
