"""Pictures in files: their names, and what never fails a study.

Truth: the rules of the page docs/reference/figures.md.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from hpcrub import plot
from hpcrub.__main__ import main as program
from hpcrub.commands import run as cli
from hpcrub.plot import pictures
from tests.program import ROOT, lay_out

SMALL = "study: modal\ndisk: {n_blades: 3, blade: {n_elements: 1}}\nreduction: {n_modes: 6}\n"


@pytest.fixture(scope="module")
def modal(tmp_path_factory):
    """A finished modal study."""
    path = tmp_path_factory.mktemp("modal") / "modal.h5"
    (path.parent / "modal.yaml").write_text(f"{SMALL}output: {path}\n")
    assert cli.main([str(path.parent / "modal.yaml"), "--no-figures"]) == 0
    return path


def draw(*arguments):
    return program(["plot", *map(str, arguments)])


def test_the_main_figure_is_named_as_the_result_others_after_themselves(modal, folder):
    assert draw(modal, "--output", "all") == 0
    names = ["modal.png", "modal_mode_shapes.png", "modal_safe_diagram.png"]
    assert sorted(path.name for path in (folder / "all").iterdir()) == names
    assert draw(modal, "--output", "all", "--figure", "mode_shapes", "--mode", 4) == 0
    assert (folder / "all" / "modal_mode_shapes_mode_4.png").exists()
    assert draw(modal, "--output", "vector", "--figure", "safe_diagram", "--format", "pdf") == 0
    assert (folder / "vector" / "modal_safe_diagram.pdf").read_bytes().startswith(b"%PDF")


def test_a_mode_is_for_figures_that_show_one(modal, folder, capsys):
    assert draw(modal, "--figure", "disk", "--mode", 3) == 2
    assert "--mode 3: figure disk does not show a mode" in capsys.readouterr().err
    assert draw(modal, "--figure", "mode_shapes", "--mode", 400) == 2
    assert draw(lay_out("linear.h5", "study: linear"), "--mode", 3) == 2
    assert "no figure of linear.h5 shows a mode" in capsys.readouterr().err


def test_of_many_blades_the_shapes_that_the_file_holds_are_drawn(folder):
    """It holds 48, and 60 blades have more modes in their first family: it was an IndexError."""
    Path("a.yaml").write_text("study: modal\ndisk: {n_blades: 60, blade: {n_elements: 1}}\n")
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    figure = Figure()
    plot.mode_shapes("results/a.h5", figure)
    titles = [int(axes.get_title().split()[0]) for axes in figure.axes if axes.get_title()]
    note = " ".join(legend.get_title().get_text() for legend in figure.legends)
    of = re.search("no shapes of (.*) nodal", note.replace("\n", " "))[1]
    assert sorted(titles + [int(d) for d in of.split(", ")]) == list(range(31))


@pytest.mark.parametrize("study", ["modal", "time_response", "patterns"])
@pytest.mark.long
def test_a_file_without_results_has_no_figure_of_them(folder, capsys, study):
    """It was a traceback."""
    lay_out("empty.h5", f"study: {study}\nhistory: {{duration_s: 0.5}}\n")
    assert draw("empty.h5", "--output", ".") == 2
    error = capsys.readouterr().err
    assert "empty.h5: figure " in error
    assert error.count("nothing is computed") == error.count("\n") > 0
    assert draw("empty.h5", "--figure", "casing") == 0


def test_a_picture_is_replaced_whole(modal, folder):
    picture = Path("modal_safe_diagram.svg")
    picture.write_bytes(b"a photo")
    assert draw(modal, "--output", ".", "--figure", "safe_diagram", "--format", "svg") == 0
    assert picture.read_bytes() != b"a photo"
    assert not list(folder.glob("*hpcrub-part*"))


def test_one_picture_that_cannot_be_written_does_not_keep_the_others(modal, folder, capsys):
    Path("modal_safe_diagram.png").mkdir()
    assert draw(modal, "--output", ".") == 1
    assert "the figure modal_safe_diagram.png: Is a directory" in capsys.readouterr().err
    assert Path("modal.png").exists()
    assert Path("modal_mode_shapes.png").exists()


@pytest.mark.long
def test_what_is_inherited_does_not_fail_a_study(folder):
    environment = {"MPLBACKEND": "nonsense", "MATPLOTLIBRC": "latex"}
    Path("latex").mkdir()
    Path("latex/matplotlibrc").write_text("text.usetex: True\nbackend: TkAgg\n")
    Path("modal.yaml").write_text(SMALL + "output: modal.h5\n")
    done = subprocess.run(
        [sys.executable, ROOT / "main.py", "modal.yaml"], env=os.environ | environment,
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "modal.png" in done.stdout.partition("figure:  ")[2]
    assert "Traceback" not in done.stderr
    assert Path("modal.png").exists()


def test_a_figure_never_fails_a_study(folder, monkeypatch, capfd):
    def fail(*_, **__):
        raise RuntimeError("no room for glyphs")

    Path("modal.yaml").write_text(SMALL + "output: modal.h5\n")
    monkeypatch.setattr(pictures, "draw", fail)
    assert cli.main(["modal.yaml"]) == 0
    assert "no figure: RuntimeError: no room for glyphs" in capfd.readouterr().out
