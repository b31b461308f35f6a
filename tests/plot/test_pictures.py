"""Pictures in files: their names, what they may replace, and what never fails a study.

Truth: the rules of the page docs/reference/figures.md.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hpcrub import plot
from hpcrub.commands import plot as command
from hpcrub.commands import run as cli
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.plot import pictures
from hpcrub.results.storage import ResultFile
from hpcrub.studies import files
from tests.program import ROOT, error_lines


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def modal(tmp_path_factory):
    """A finished modal study."""
    path = tmp_path_factory.mktemp("modal") / "modal.h5"
    (path.parent / "modal.yaml").write_text(f"study: modal\noutput: {path}\n")
    assert cli.main([str(path.parent / "modal.yaml"), "--no-figures"]) == 0
    return path


def casing(path):
    """A result file of a casing study that has been computed."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    config = Config.from_yaml(f"study: casing\noutput: {path}")
    files.lay_out(path, config)
    with ResultFile(path, mode="r+") as file:
        for name in ("inward_m", "gap_m", "growth"):
            file.write({name: np.linspace(0, 1e-3, file.read(name).size)}, ())
    return path


def draw(*arguments):
    return command.main([str(argument) for argument in arguments])


def test_the_main_figure_is_named_as_the_result_others_after_themselves(modal, folder):
    assert draw(modal, "--out", "all") == 0
    assert {p.name for p in (folder / "all").iterdir()} == {
        "modal.png", "modal_safe.png", "modal_shapes.png",
    }  # fmt: skip
    assert draw(modal, "--out", "all", "--figure", "shapes", "--mode", 4) == 0
    assert (folder / "all" / "modal_shapes_mode_4.png").exists()
    assert draw(modal, "--out", "vector", "--figure", "safe", "--format", "pdf") == 0
    assert (folder / "vector" / "modal_safe.pdf").read_bytes().startswith(b"%PDF")


def test_one_mode_leaves_the_picture_of_all_modes_alone(modal, folder):
    assert draw(modal, "--out", ".", "--figure", "shapes") == 0
    whole = Path("modal_shapes.png").read_bytes()
    assert draw(modal, "--out", ".", "--mode", 4) == 0
    assert Path("modal_shapes.png").read_bytes() == whole
    assert Path("modal_shapes_mode_4.png").read_bytes() != whole


def test_an_animation_is_a_period_of_pictures(modal, folder):
    assert draw(modal, "--out", ".", "--figure", "animation", "--mode", 4) == 0
    with Image.open("modal_animation_mode_4.gif") as moving:
        assert 20 < moving.n_frames <= 30  # equal neighbours are kept once, for longer
    assert draw(modal, "--out", ".", "--figure", "animation", "--mode", 400) == 2
    assert draw(modal, "--out", ".", "--figure", "animation", "--mode", 4) == 0  # its own again


def test_a_mode_is_for_figures_that_show_one(modal, folder, capsys):
    assert draw(modal, "--figure", "disk", "--mode", 3) == 2
    assert "--mode 3: figure disk does not show a mode" in capsys.readouterr().err
    assert draw(casing("casing.h5"), "--mode", 3) == 2
    assert "no figure of casing.h5 shows a mode" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_a_picture_of_somebody_else_stays(folder, capsys, kind):
    path, picture = casing("photo.h5"), Path(f"photo.{kind}")
    picture.write_bytes(b"a photo")
    assert draw(path, "--format", kind) == 2
    (line,) = error_lines(capsys.readouterr().err)
    assert f"photo.{kind} is not a picture of hpcrub: --overwrite replaces it" in line
    assert picture.read_bytes() == b"a photo"
    assert draw(path, "--format", kind, "--overwrite") == 0
    assert draw(path, "--format", kind) == 0  # its own it replaces without being asked to
    assert not list(folder.glob("*hpcrub-part*"))


def test_results_of_one_name_do_not_share_a_picture(folder, capsys):
    first, second = casing("a/x.h5"), casing("b/x.h5")
    assert draw(first, second, "--out", "all", "--figure", "casing") == 0
    assert {p.name for p in Path("all").iterdir()} == {"a_x.png", "b_x.png"}
    assert draw(first, "--out", "one") == 0
    assert draw(second, "--out", "one") == 2
    assert "one/x.png shows other results: --overwrite replaces it" in capsys.readouterr().err
    Path("one").rename("moved")  # with results and pictures moved together nothing is foreign
    assert draw(first, "--out", "moved") == 0


def test_one_picture_that_cannot_be_written_does_not_keep_the_others(modal, folder, capsys):
    Path("modal_safe.png").mkdir()
    assert draw(modal, "--out", ".") == 2
    assert "modal_safe.png is not a picture of hpcrub" in capsys.readouterr().err
    assert Path("modal.png").exists()
    assert Path("modal_shapes.png").exists()


def test_odd_numbers_are_told_and_faults_of_the_program_are_seen(folder, capsys, monkeypatch):
    path = casing("casing.h5")

    def fail_with(error):
        def figure(file, ax=None):
            raise error

        figure.about = plot.casing.about
        return figure

    for error in (ValueError("odd"), IndexError("odd")):
        monkeypatch.setattr(command, "find", lambda name, e=error: fail_with(e))
        assert draw(path, "--figure", "casing") == 1
        assert "its numbers are odd" in capsys.readouterr().err
    for error in (TypeError("wrong"), KeyError("wrong"), AttributeError("wrong")):
        monkeypatch.setattr(command, "find", lambda name, e=error: fail_with(e))
        with pytest.raises(type(error)):
            draw(path, "--figure", "casing")


@pytest.mark.parametrize(
    "environment",
    [{"MPLBACKEND": "nonsense"}, {"MPLBACKEND": "QtAgg", "DISPLAY": ":99"},
     {"MATPLOTLIBRC": "latex"}],
    ids=["unknown", "screen", "usetex"],
)  # fmt: skip
def test_what_is_inherited_does_not_fail_a_study(folder, environment):
    Path("latex").mkdir()
    Path("latex/matplotlibrc").write_text("text.usetex: True\nbackend: TkAgg\n")
    Path("casing.yaml").write_text("study: casing\noutput: casing.h5\n")
    done = subprocess.run(
        [sys.executable, ROOT / "main.py", "casing.yaml"], env=os.environ | environment,
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "casing.png" in done.stdout.partition("figure:  ")[2]
    assert "Traceback" not in done.stderr
    with Image.open("casing.png") as picture:
        assert picture.info["Description"].startswith(pictures.MARK)


def test_a_figure_never_fails_a_study(folder, monkeypatch, capfd):
    def fail(*_, **__):
        raise RuntimeError("no room for glyphs")

    Path("casing.yaml").write_text("study: casing\noutput: casing.h5\n")
    monkeypatch.setattr(pictures, "draw", fail)
    assert cli.main(["casing.yaml"]) == 0
    assert "no figure: RuntimeError: no room for glyphs" in capfd.readouterr().out
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    Path("casing.png").write_bytes(b"a photo")
    Path("casing.h5").unlink()
    assert cli.main(["casing.yaml"]) == 0
    assert "casing.png is not a picture of hpcrub" in capfd.readouterr().out
    assert Path("casing.png").read_bytes() == b"a photo"


def test_a_figure_that_is_not_there(folder):
    with pytest.raises(InputError, match="no figure 'sumary'; there are summary, family"):
        plot.find("sumary")


def test_the_numbers_in_names_stay(folder):
    """r_0.25 and r_0.50, without .h5: the name does not end at its first point."""
    found = [
        pictures._targets(plot.summary, [[name]], None, None)[0].name
        for name in ("r_0.25", "r_0.50.h5")
    ]
    assert found == ["r_0.25", "r_0.50"]
