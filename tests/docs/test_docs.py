"""What the pages say is what the program has: tables, fields of the log, exit codes, links."""

import importlib.util
import json
import re
import subprocess

import pytest

from hpcrub import errors
from hpcrub.ranks.runlog import RunLog, Work
from tests.program import ROOT

REFERENCE = ROOT / "docs" / "reference"
LINK = re.compile(r"\]\((?!https?:|#)([^)#]+)")
spec = importlib.util.spec_from_file_location("tables", ROOT / "docs" / "tables.py")
tables = importlib.util.module_from_spec(spec)
spec.loader.exec_module(tables)


@pytest.mark.parametrize("name", tables.TABLES)
def test_tables_are_in_step_with_the_program(name):
    text = (REFERENCE / f"{name}.md").read_text(encoding="utf-8")
    assert tables.updated(name, text) == text, "run `make reference`"


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


def code(page, language):
    """Blocks of code of a page."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def test_tests_that_pages_name_are_there():
    there = "".join(path.read_text("utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    for page in (ROOT / "docs").glob("*.md"):
        named = set(re.findall(r"`(test_\w+)`", page.read_text("utf-8")))
        assert [name for name in named if f"def {name}(" not in there] == [], page.name


def test_the_path_of_a_number_leads_to_an_amplitude():
    (block,) = code("architecture.md", "python")
    names = {}
    exec(block, names)
    assert names["result"].amplitude.min() > names["config"].casing.clearance


def test_the_example_of_a_site_sets_what_the_scripts_read(tmp_path):
    setting = re.compile(r"^(\w+)(?==|\(\))", re.MULTILINE)
    (block,) = (text for text in code("cluster.md", "") if "STOP_BEFORE" in text)
    (tmp_path / "site.sh").write_text(block, "utf-8")
    subprocess.run(["bash", "-n", tmp_path / "site.sh"], check=True)
    known = set(setting.findall((ROOT / "jobs" / "slurm" / "site.sh").read_text("utf-8")))
    assert set(setting.findall(block)) <= known
