"""A casing that vibrates, from its keys to its modes."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.setup.casing import casing_modes_of, overtaken
from hpcrub.setup.input_files import with_tables
from hpcrub.setup.problem import build_problem
from tests.program import refusal

RING = {"thickness_mm": 20, "radius_mm": 502.5, "waves": [2, 3]}
BREATHING = {"waves": 0, "frequency_hz": 100, "modal_mass_kg": 100}
TABLE = """\
# of the user's own finite elements
waves,frequency_hz,modal_mass_kg,tangential_ratio,damping_ratio
3,143.274,25,-0.333,0.01
2,50.657,16,-0.5,0.02
"""


def test_a_ring_of_the_input_has_the_known_frequencies():
    modes = casing_modes_of(Config(casing={"ring": RING}))
    np.testing.assert_allclose(modes.omega / (2 * np.pi), [50.657, 143.274], rtol=1e-5)
    assert casing_modes_of(Config()) is None


def test_a_ring_stands_at_the_tips_unless_its_radius_is_given():
    inside = casing_modes_of(Config(casing={"ring": {"thickness_mm": 20}}))
    given = casing_modes_of(Config(casing={"ring": {"thickness_mm": 20, "radius_mm": 510}}))
    np.testing.assert_array_equal(inside.omega, given.omega)


def test_modes_of_a_table_are_those_of_a_list(tmp_path):
    (tmp_path / "casing.csv").write_text(TABLE)
    config = with_tables(Config(casing={"modes_csv": str(tmp_path / "casing.csv")}))
    modes = casing_modes_of(config)
    np.testing.assert_array_equal(modes.n_waves, [2, 3])
    np.testing.assert_allclose(modes.omega, 2 * np.pi * np.array([50.657, 143.274]))
    np.testing.assert_allclose(modes.radial, [1 / 4, 1 / 5])
    np.testing.assert_allclose(modes.tangential, [-0.5 / 4, -0.333 / 5])
    np.testing.assert_allclose(modes.damping_ratio, [0.02, 0.01])
    assert build_problem(config).reduced.casing.n_waves.tolist() == [2, 3]


def test_waves_that_the_steps_do_not_resolve_are_refused():
    config = Config(
        casing={"ring": {"thickness_mm": 20, "waves": [2, 150]}}, time={"step_s": 2e-5},
    )  # fmt: skip
    message = refusal(casing_modes_of, config)
    assert "casing.ring.waves: n = 150 passes a blade within" in message


@pytest.mark.parametrize(
    ("casing", "words"),
    [  # both came as far as a traceback, or as a twist of the casing at the breathing frequency
        ({"ring": RING | {"waves": [1, 2], "bed_radial_n_per_m2": 1e-6}},
         "casing.ring.waves: nothing holds the wave n = 1 in a ring of 20 mm on a bed of 1e-06"),
        ({"ring": RING | {"waves": [1, 2]}}, "nothing holds the wave n = 1 in a ring of 20 mm on"),
        ({"ring": RING | {"radius_mm": 400}}, "a ring of 400 mm lies inside the blade tips, which"),
        ({"ring": RING | {"radius_mm": 0.5}}, "a ring of 0.5 mm lies inside the blade tips, which"),
        ({"modes": [BREATHING | {"tangential_ratio": -0.5}]},
         "casing.modes: tangential_ratio of -0.5 at n = 0, where"),
    ],
)  # fmt: skip
def test_waves_that_cannot_be_are_refused(casing, words):
    assert words in refusal(build_problem, Config(casing=casing))


def test_the_casing_counts_in_the_stability_limit_of_central_differences():
    """A step is below 2/ω of the fastest mode, which is the casing's: n = 14 at 9.9 kHz."""
    config = Config(
        casing={"ring": {"thickness_mm": 60, "waves": [2, 14]}},
        speeds={"from_hz": 34, "to_hz": 34}, time={"scheme": "central_difference"},
    )  # fmt: skip
    limit = 2.0 / casing_modes_of(config).omega.max()
    assert config.step > limit
    words = "is not below 3.222e-05 s, the stability limit of central_difference for this disk and"
    assert words in refusal(build_problem, config)
    build_problem(config.replace({"time.step_s": 0.9999 * limit}))
    build_problem(config.replace({"time.scheme": "exact_modal"}))


def test_waves_that_are_overtaken_and_not_followed_are_known():
    """Without stretching a free ring has ω² = EI/(ρAR⁴) n²(n² − 1)²/(n² + 1)."""
    config = Config(casing={"ring": {"thickness_mm": 2, "radius_mm": 501, "waves": [2, 3, 5]}})
    n = np.arange(2, 200)
    omega = 2e-3 / 0.501**2 * np.sqrt(2.1e11 / 7800 / 12 * n**2 * (n**2 - 1) ** 2 / (n**2 + 1))
    slower = n[omega / n < 2 * np.pi * config.speeds.to_hz]
    followed, others = overtaken(config, casing_modes_of(config))
    assert followed.tolist() == [2, 3, 5]
    assert others.tolist() == [4, *range(6, slower.max() + 1)]
    table = {"modes": [BREATHING | {"waves": 3, "frequency_hz": 10}]}
    config = Config(casing=table)
    assert [list(found) for found in overtaken(config, casing_modes_of(config))] == [[3], []]
