"""What has been measured and comes in files: read once, refused clearly, kept in the result."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.studies import measured
from hpcrub.studies.files import open_result
from tests.program import run

PROFILE = "angle_deg,radius_change_mm\n0,-0.5\n90,0\n180,-0.4\n270,0.1\n"


def resolved(path, **casing):
    return measured.resolved(Config.from_mapping({"casing": {"profile_csv": str(path)} | casing}))


def test_a_profile_is_read_into_the_configuration(tmp_path):
    path = tmp_path / "casing.csv"
    path.write_text(
        "# made by hand\nradius_change_mm, angle_deg\n-0.4, 180\n0.1, 270\n\n-0.5, 0\n0, 90\n"
        "-0.5, 360\n"
    )
    config = resolved(path)
    assert config.casing.profile_deg == (0.0, 90.0, 180.0, 270.0)
    assert config.casing.profile_mm == (-0.5, 0.0, -0.4, 0.1)
    assert config.casing.bump_height_mm == 0.0  # of the default bumps: they do not come along
    path.unlink()  # the configuration has all
    again = measured.resolved(Config.from_yaml(config.to_yaml()))
    assert again == config
    height = again.casing.profile.height(np.radians([0.0, 45.0, 270.0]))
    np.testing.assert_allclose(height, [5e-4, 2.5e-4, -1e-4], rtol=1e-12)


def test_a_profile_of_every_tenth_of_a_degree_can_be_kept(tmp_path):
    path = tmp_path / "casing.csv"
    angle = np.arange(3600) / 10 + 0.0123456789
    change = -0.123456789 * np.cos(np.radians(2 * angle))
    rows = "\n".join(f"{a},{r}" for a, r in zip(angle, change, strict=True))
    path.write_text("angle_deg,radius_change_mm\n" + rows)
    config = resolved(path)
    assert Config.from_yaml(config.to_yaml()) == config
    np.testing.assert_allclose(config.casing.profile_mm, change, atol=5.1e-7)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no table that can be read"),
        ("", "an empty table"),
        ("0,1\n90,0\n180,0\n270,1\n", "a line of numbers instead of the names angle_deg"),
        ("angle,radius\n0,1\n", "angle, radius instead of the names angle_deg, radius_change_mm"),
        ("angle_deg,radius_change_mm\n0,0\n90,x\n", "line 3: 'x' is not a number"),
        ("angle_deg,radius_change_mm\n0,0\n90\n", "line 3 has 1 values, not 2"),
        ("angle_deg,radius_change_mm\n0,0\n90,nan\n", "line 3: 'nan' is not a number"),
        ("angle_deg,radius_change_mm\n0,0\n90,0\n", "has 2 points; 4 to 3,600 are allowed"),
        (PROFILE + "90,1\n", "two points at 90 degrees"),
        (PROFILE + "361,1\n", "angles from 0 to 360 degrees"),
    ],
)
def test_a_profile_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "casing.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=words) as refusal:
        resolved(path)
    assert str(refusal.value).isprintable()


def test_a_result_keeps_its_profile_and_refuses_another(tmp_path):
    (tmp_path / "casing.csv").write_text(PROFILE)
    (tmp_path / "input.yaml").write_text("study: casing\ncasing: {profile_csv: casing.csv}\n")
    arguments = "input.yaml", "--output", "out.h5", "--no-figures"
    code, out, err = run(0, *arguments, folder=tmp_path)
    assert code == 0, err
    assert "profile casing, smallest gap at rest -0.250 mm" in out
    with open_result(tmp_path / "out.h5") as file:
        angle, gap = file.read("angle_rad"), file.read("gap_m")
    expected = 0.25 + np.interp(
        np.degrees(angle), [0, 90, 180, 270, 360], [-0.5, 0, -0.4, 0.1, -0.5]
    )
    np.testing.assert_allclose(1e3 * gap, expected, atol=1e-12)
    assert run(0, *arguments, "--resume", folder=tmp_path)[0] == 0
    (tmp_path / "casing.csv").write_text(PROFILE.replace("-0.4", "-0.3"))
    code, _, err = run(0, *arguments, "--resume", folder=tmp_path)
    assert code == 2
    assert "casing.profile_mm: [-0.5, 0.0, -0.4, 0.1] in the file, [-0.5, 0.0, -0.3, 0.1]" in err
