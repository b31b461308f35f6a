"""The measurement of scaling runs to its end, with one sample."""

import re

import pytest

from evidence.scaling import __main__ as scaling


@pytest.mark.mpi
def test_the_measurement_ends_with_its_page(capsys):
    assert scaling.main(["--fast"]) == 0
    page = capsys.readouterr().out
    one, two = re.findall(r"^\| ([12]) \| ([\d.]+) \| ([\d.]+) \|", page, re.MULTILINE)
    assert (one[0], two[0]) == ("1", "2")
    assert one[1] == one[2]  # the simulated speed is that of one rank
    efficiency = [float(n) for n in re.findall(r"([\d.]+) %", page.split("as it is", 1)[1])]
    assert all(0.0 < number <= 100.0 for number in efficiency[:2])
