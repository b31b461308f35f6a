"""`make validate` must fail when a case does."""

from types import SimpleNamespace

import numpy as np
import pytest

from evidence.validation import __main__, report


@pytest.mark.parametrize(
    ("error", "code"), [(1e-3, 0), (0.01, 0), (0.0101, 1), (np.nan, 1), (np.inf, 1)]
)
def test_a_failing_case_makes_the_exit_code_non_zero(tmp_path, capsys, error, code):
    def case(name, error):
        verdicts = [report.at_most("error", error, 0.01)]
        return SimpleNamespace(__name__=name, section=lambda folder: (f"## {name}", verdicts))

    assert __main__.main([case("sound", 0.0), case("other", error)], tmp_path) == code
    page = (tmp_path / "validation.md").read_text()
    assert page.index("## sound") < page.index("## other")
    assert ("FAILED" in page) == ("FAILED" in capsys.readouterr().out) == bool(code)


def test_an_order_is_held_against_both_of_its_bounds():
    size = np.array([1.0, 0.5, 0.25])
    for low, high, passed in ((1.9, 2.1, True), (2.1, np.inf, False), (0.9, 1.1, False)):
        assert report.order("error", size, 3.0 * size**2, low, high).passed is passed


def test_every_case_is_run():
    names = {case.__name__.rpartition(".")[2] for case in __main__.CASES}
    folder = __main__.Path(__main__.__file__).parent
    cases = {p.stem for p in folder.glob("*.py") if "def section(" in p.read_text()}
    assert names == cases
