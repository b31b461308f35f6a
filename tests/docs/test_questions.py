"""docs/questions.md: what it tells the reader to write and to type is what the program takes."""

import re
import shlex

import pytest

from hpcrub import plot
from hpcrub.config import yaml_text
from hpcrub.config.schema import load_runs
from tests.program import ROOT

PAGE = ROOT / "docs" / "questions.md"
TEXT = PAGE.read_text(encoding="utf-8")
QUESTIONS = {part.partition("\n")[0]: part for part in TEXT.split("\n## ")[1:]}
BLOCK = re.compile(r"(?:^`(inputs/\S+)`:\n\n)?^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(text, language):
    """(file that a block claims to be or "", content) of the fenced blocks."""
    return [(name, body) for name, kind, body in BLOCK.findall(text) if kind == language]


def commands(text):
    """Words of all commands that call Python."""
    lines = "".join(body for _, body in blocks(text, "")).replace("\\\n", " ").splitlines()
    return [words for words in map(shlex.split, lines) if "python" in words]


@pytest.mark.parametrize("question", QUESTIONS)
def test_a_question_has_an_input_a_command_and_a_figure(question, tmp_path):
    text = QUESTIONS[question]
    inputs = blocks(text, "yaml")
    figures = re.findall(r"!\[.+?\]\((.+?)\)", text)
    assert inputs
    assert figures
    assert commands(text)
    for figure in figures:
        assert (PAGE.parent / figure).exists()
    for name in re.findall(r"inputs/[\w.-]+", text):
        assert (ROOT / name).exists(), name
    for name, body in inputs:
        copied = tmp_path / "input.yaml"
        copied.write_text(body, encoding="utf-8")
        assert load_runs(copied)
        if name:
            assert yaml_text.parse(body) == yaml_text.parse((ROOT / name).read_text("utf-8")), name


@pytest.mark.parametrize("words", commands(TEXT), ids=" ".join)
def test_the_commands_are_accepted(words):
    if "main.py" in words:
        changes = [words[i + 1] for i, word in enumerate(words) if word == "--set"]
        assert load_runs(ROOT / words[words.index("main.py") + 1], changes)
    if "--figure" in words:
        assert words[words.index("--figure") + 1] in [figure.__name__ for figure in plot.FIGURES]
