"""The notebook of the tutorial, and figures in a notebook."""

import json
import os
import subprocess
import sys

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
