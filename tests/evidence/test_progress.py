"""The lines that tell how far a long program of ``evidence/`` is."""

import pytest

from evidence import progress


@pytest.fixture
def clock(monkeypatch):
    """Seconds of a clock that stands still until a test moves it: clock[0]."""
    seconds = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: seconds[0])
    return seconds


def test_lines_are_whole_rare_and_know_the_time_left(clock, capsys):
    """100 items of 2 s: a line after every third of them, later after more; none in between."""
    for _ in progress.followed(range(100), "cases"):
        clock[0] += 2.0
    written = capsys.readouterr().out
    lines = written.splitlines()
    assert "\r" not in written
    assert written.endswith("\n")
    assert lines[0] == "cases: 0 of 100 done"
    assert lines[1] == "cases: 3 of 100 done in 6 s, about 3.23 min left"  # 97 of 2 s
    assert lines[-1] == "cases: 100 of 100 done in 3.33 min"
    assert len(lines) < 100 / 3


def test_long_items_are_named_before_they_begin(clock, capsys):
    """A line goes before each item, however short the one before it was."""
    said = []
    for _ in progress.followed(iter("ab"), "parts", 2, names=["one", "two"]):
        said.append(capsys.readouterr().out)
        clock[0] += 1.0
    assert said == ["parts: 0 of 2 done; next: one\n",
                    "parts: 1 of 2 done in 1 s, about 1 s left; next: two\n"]  # fmt: skip
    assert capsys.readouterr().out == "parts: 2 of 2 done in 2 s\n"
