"""The notebook of the tutorial runs from first to last cell, and finds a range of speeds."""

import json

from tests.program import ROOT

DOCS = ROOT / "docs"


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
