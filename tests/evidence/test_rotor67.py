"""The model file of rotor 67 that comes along, and the numbers that are told of it."""

import numpy as np
import pytest

from evidence.rotor67 import frequencies, numbers
from hpcrub.commands import import_model
from hpcrub.model.imported import neutral
from hpcrub.results import model_file

FAN = "inputs/rotor67/rotor67.h5"


def test_the_model_file_is_a_fan_that_can_be_mistuned(capsys):
    """Import of the file says that its blades have cantilever modes, not that they have nothing."""
    assert import_model.main(["model", FAN, "--speed-hz", "267"]) == 0
    said = capsys.readouterr().out
    assert "6 cantilever modes each alone" in said
    assert "blades' stiffness: none" not in said
    assert "22 blades, 6 to 6 contact nodes each" in said


def test_orders_are_natural_frequencies_at_the_speeds_of_the_crossings():
    """Interpolated frequencies had put them up to 0.05 Hz away; numbers.csv has the same ones."""
    fan, told = neutral.from_arrays(model_file.read(FAN)), []
    for family, diameters, order, speed in frequencies.near_design(fan):
        own = frequencies.families(fan, speed / frequencies.SPEED)[diameters, family - 1]
        assert own == pytest.approx(order * speed, rel=1e-9)
        told.append((f"engine order {order}, family {family}, {diameters} diameters", speed))
    rows = [n for n in numbers.read(numbers.TABLE).values() if n.quantity == "speed of a crossing"]
    assert [n.at for n in rows] == [at for at, _ in told]
    np.testing.assert_allclose([n.value for n in rows], [s for _, s in told], rtol=2e-6)
