"""What the pages say is what the program has: tables, fields of the log, exit codes, links."""

import importlib.util
import json
import re

import pytest

from hpcrub import errors
from hpcrub.run.runlog import RunLog, Work
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
    fields = json.loads((tmp_path / "a.runs.jsonl").read_text("utf-8"))
    assert set(fields) <= set(re.findall(r"`(\w+)`", (REFERENCE / "logs.md").read_text("utf-8")))


def test_every_exit_code_is_on_its_page():
    codes = {error.exit_code for error in vars(errors).values() if hasattr(error, "exit_code")}
    page = (REFERENCE / "exit_codes.md").read_text("utf-8")
    assert codes | {0} == {int(code) for code in re.findall(r"^\| (\d+) \|", page, re.MULTILINE)}


@pytest.mark.parametrize("page", ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"])
def test_links_of_pages_outside_the_site_lead_somewhere(page):
    links = LINK.findall((ROOT / page).read_text("utf-8"))
    assert [link for link in links if not (ROOT / link).exists()] == []
