"""A coating in the input of studies in which nothing wears."""

import pytest

from tests.program import TINY, computed


@pytest.mark.parametrize("study", ["linear", "modal"])
def test_a_study_without_motion_says_nothing_of_the_coating(tmp_path, study, capsys):
    """It ended with exit code 2, "no dataset wear/largest_amplitude_m", when all was computed."""
    text = f"{TINY}study: {study}\ncontact: {{law: abradable}}\n"
    computed(tmp_path, text.partition("\n")[2], "--no-figures")
    assert "worn" not in capsys.readouterr().out
