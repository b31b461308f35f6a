"""Air between the blades, from its keys to the reduced model."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.setup.aero import curve_of
from hpcrub.setup.input_files import with_tables
from hpcrub.setup.problem import build_problem
from tests.program import refusal

DIAMETERS = [0, 1, 2, 3, 4, 5, 6, -5, -4, -3, -2, -1]  # wave r = 0 … 11 of twelve blades
TABLE = "diameters,damping_ratio,frequency_shift\n" + "".join(
    f"{h},{0.005 + 0.0001 * h},{0.0002 * h}\n" for h in DIAMETERS
)


def waves(**changed):
    """All waves of twelve blades; changed: of the first one with one nodal diameter."""
    ways = {-1: "backward", 0: "neither", 1: "forward"}
    found = [
        {"diameters": abs(h), "travels": "neither" if h == 6 else ways[np.sign(h)]}
        for h in DIAMETERS
    ]
    found[1] |= changed
    return {"waves": found}


def test_waves_of_a_table_are_in_the_order_of_their_way_around(tmp_path):
    (tmp_path / "waves.csv").write_text(TABLE)
    config = with_tables(Config(aero={"waves_csv": str(tmp_path / "waves.csv")}))
    curve = curve_of(config)
    np.testing.assert_allclose(curve.damping_ratio, 0.005 + 0.0001 * np.array(DIAMETERS))
    np.testing.assert_allclose(curve.frequency_shift, 0.0002 * np.array(DIAMETERS))
    assert build_problem(config).reduced.air is not None
    assert build_problem(Config()).reduced.air is None


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (waves(diameters=7), "7 nodal diameters, travels: forward, is no wave of 12 blades"),
        (waves(travels="neither"), "1 nodal diameters, travels: neither, is no wave of 12 blades"),
        (waves(travels="backward"), "1 nodal diameters, travels: backward, is given twice"),
        (waves(diameters=0), "0 nodal diameters, travels: forward, is no wave of 12 blades"),
        ({"waves": waves()["waves"][:-1]}, "1 nodal diameters, travels: backward, is missing; 12 "
         "blades have 12 waves"),
        ({"influence": [{"blades": 1}, {"blades": -11}]}, "1 blades ahead is given twice"),
        ({"influence": [{"blades": 500}]}, "500 blades ahead; a disk of 12 blades has none"),
        ({"influence": [{"blades": 1}]} | waves(), "cannot be combined with aero.influence"),
    ],
)  # fmt: skip
def test_waves_that_are_not_those_of_the_disk_are_refused(keys, message):
    with pytest.raises(InputError, match=message):
        Config(aero=keys)


def test_a_family_that_the_reduced_model_does_not_have_is_refused():
    config = Config(aero={"family": 9, "influence": [{"blades": 0}]})
    assert "aero.family: the reduced model has no family 9" in refusal(build_problem, config)
