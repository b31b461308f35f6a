"""What the pages say is what the program has and takes: tables, exit codes, links, notebooks.

The example of the page on developing a study is added to a copy of the tree as the page says.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

from docs import tables
from evidence.page import updated
from hpcrub import errors, plot
from hpcrub.config import yaml_text
from hpcrub.config.schema import Config, load_runs
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.ranks.runlog import RunLog, Work
from hpcrub.setup.problem import build_model
from tests.program import ENVIRONMENT, ROOT

DOCS = ROOT / "docs"
REFERENCE = DOCS / "reference"
LINK = re.compile(r"\]\((?!https?:|#)([^)#]+)")
BLOCK = re.compile(r"(?:^`(inputs/\S+)`:\n\n)?^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("name", tables.TABLES)
def test_tables_are_in_step_with_the_program(name):
    path, make = tables.TABLES[name]
    assert updated(path, **{name: make()}) == path.read_text("utf-8"), "run `make reference`"


def test_every_field_of_the_log_is_on_its_page(tmp_path):
    RunLog(tmp_path / "a.h5", 1).end(Work(), 0)
    lines = (tmp_path / "a.runs.jsonl").read_text("utf-8").splitlines()
    fields = {name for line in lines for name in json.loads(line)}
    assert fields <= set(re.findall(r"`(\w+)`", (REFERENCE / "logs.md").read_text("utf-8")))


def test_every_exit_code_is_on_its_page():
    codes = {error.exit_code for error in vars(errors).values() if hasattr(error, "exit_code")}
    page = (REFERENCE / "exit_codes.md").read_text("utf-8")
    assert codes | {0} == {int(code) for code in re.findall(r"^\| (\d+) \|", page, re.MULTILINE)}


@pytest.mark.parametrize("page", ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"])
def test_links_of_pages_outside_the_site_lead_somewhere(page):
    links = LINK.findall((ROOT / page).read_text("utf-8"))
    assert [link for link in links if not (ROOT / link).exists()] == []


def blocks(text, language):
    """(file that a block claims to be or "", content) of the fenced blocks."""
    return [(name, body) for name, kind, body in BLOCK.findall(text) if kind == language]


def code(page, language):
    """Blocks of code of a page."""
    return [body for _, body in blocks((DOCS / page).read_text("utf-8"), language)]


def test_the_path_of_a_number_leads_to_an_amplitude():
    block, *_ = code("architecture.md", "python")
    names = {}
    exec(block, names)
    assert names["result"].amplitude.min() > names["config"].clearance


def test_arrivals_at_probes_have_the_motion_of_the_tip(tmp_path, monkeypatch):
    """At the moment of its arrival a tip is deflected by what tip timing makes of it."""
    (tmp_path / "results").mkdir()
    example = DOCS / "examples" / "time_response.h5"
    shutil.copy(example, tmp_path / "results")
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code("tip_timing.md", "python")[0], names)
    table, n_probes = names["table"], len(names["PROBES_DEG"])
    with h5py.File(example) as file:
        time, motion = file["time_s"][()], file["tangential_m"][-1]
    turns = names["speed_hz"] * np.ptp(time)
    assert len(table) == pytest.approx(turns * motion.shape[1] * n_probes, rel=0.05)
    for row in table.sample(20, random_state=1).itertuples():
        tip = np.interp(row.arrival_s, time, motion[:, row.blade - 1])
        assert row.deflection_m == pytest.approx(tip, rel=1e-6, abs=1e-9)
        passed = row.revolution + names["PROBES_DEG"][row.probe - 1] / 360
        at_rest = (row.blade - 1) / 12 + names["speed_hz"] * row.arrival_s
        assert at_rest + tip / (2 * np.pi * names["radius"]) == pytest.approx(passed, abs=1e-9)
    assert (tmp_path / "arrivals.csv").read_text().startswith("blade,probe,revolution,arrival_s")


TEXT = (DOCS / "questions.md").read_text(encoding="utf-8")
QUESTIONS = {part.partition("\n")[0]: part for part in TEXT.split("\n## ")[1:]}


def commands(text):
    """Words of all commands that call Python."""
    lines = "".join(body for _, body in blocks(text, "")).replace("\\\n", " ").splitlines()
    return [words for words in map(shlex.split, lines) if "python" in words]


@pytest.mark.parametrize("question", QUESTIONS)
def test_a_question_has_an_input_a_command_and_a_figure(question, tmp_path):
    text = QUESTIONS[question]
    inputs = blocks(text, "yaml")
    assert all([inputs, "![" in text, commands(text)])
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


def test_the_notebook_leads_to_a_decision(monkeypatch, capsys):
    monkeypatch.chdir(DOCS)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = {}
    for cell in json.loads((DOCS / "decision.ipynb").read_text("utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    # the tuned disk alone would have left out speeds at which a mistuned one vibrates too much
    avoided = names["speed"][names["first"]], names["speed"][names["last"]]
    assert avoided[0] < names["tuned_high"].min()
    assert avoided[1] > names["tuned_high"].max()
    assert f"to be avoided: {avoided[0]:.1f} to {avoided[1]:.1f} Hz" in capsys.readouterr().out


@pytest.mark.long
def test_a_figure_leaves_a_notebook_as_it_was(tmp_path):
    """Notebooks draw by a backend that turns the interactive mode on, and need it for the next."""
    (tmp_path / "inline.py").write_text(
        "from matplotlib import interactive\n"
        "from matplotlib.backends.backend_agg import FigureCanvasAgg as FigureCanvas\n"
        "interactive(True)\n",
        "utf-8",
    )
    code = (
        "import hpcrub, matplotlib\n"
        "hpcrub.plot.casing(hpcrub.Config())\n"
        "assert matplotlib.is_interactive()"
    )
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    environment = {**os.environ, "MPLBACKEND": "module://inline", "PYTHONPATH": path}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the program with the module of the page beside the other studies."""
    tree = tmp_path_factory.mktemp("tree")
    shutil.copytree(ROOT / "hpcrub", tree / "hpcrub")
    shutil.copy(ROOT / "main.py", tree)
    (module,) = code("developing_a_study.md", "python")
    (tree / "hpcrub/studies/frequencies.py").write_text(module, encoding="utf-8")
    return tree


def run(tree, *arguments):
    """Output of Python in the copy, which ends well and without a word of error."""
    settings = {"env": os.environ | ENVIRONMENT | {"PYTHONPATH": str(tree)}, "text": True}
    done = subprocess.run([sys.executable, *arguments], cwd=tree, capture_output=True, **settings)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_the_example_is_a_study(tree):
    text = code("developing_a_study.md", "yaml")[0].replace("samples: 1000", "samples: 3")
    (tree / "a.yaml").write_text(text + "reduction: {n_modes: 4}\n")
    out = run(tree, "main.py", "a.yaml", "--no-figures")
    assert "sigma = 2.31 %" in out
    with h5py.File(tree / "results/a.h5") as file:
        found = file["frequencies_hz"][()]
    reduced = build_model(Config(reduction={"n_modes": 4})).reduced
    for level, half_range in enumerate((0.01, 0.02, 0.04)):
        drawn = stiffness_deviation(2020, level, 2, 12, half_range)
        omega = mistuned_modes(reduced, drawn).omega
        np.testing.assert_allclose(found[level, 2], omega[:12] / (2 * np.pi), rtol=1e-10)
