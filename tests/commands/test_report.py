"""`hpcrub report`: a page that stands alone and says what the result file says."""

import errno
import html
import os
import re
import shutil
from pathlib import Path

import h5py
import pytest

from hpcrub.__main__ import main
from hpcrub.commands import report
from hpcrub.commands.report import render, repeating
from hpcrub.config.schema import Config
from hpcrub.errors import HpcrubError, InputError
from hpcrub.results import layout
from hpcrub.runs import execution, result_files
from hpcrub.studies import open_result, run_of
from hpcrub.studies.contact import findings
from tests.program import TINY, lay_out, run_here


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Results of a contact study with a name that HTML must not take for its own, and a linear."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "contact.yaml").write_text(TINY)
    (folder / "linear.yaml").write_text("study: linear\nmistuning: {samples: 20}\n")
    harder = "contact.yaml --output c.h5 --set contact.friction=0.2"
    for words in ("contact.yaml --output a<b>.h5", "linear.yaml --output linear.h5", harder):
        assert run_here(*words.split(), folder=folder) == 0
    return folder


@pytest.fixture
def undrawn(monkeypatch):
    """Reports without figures, which take most of the time."""
    monkeypatch.setattr(report, "of_study", lambda *_, **__: iter(()))


def pictures(page):
    return re.findall(r'src="([^"]*)"', page)


def test_the_page_has_the_verdict_and_the_numbers_of_the_file(folder):
    page = render([str(folder / "a<b>.h5")])
    with open_result(folder / "a<b>.h5") as file:
        verdict = findings.verdict(file).lines
    assert verdict[0][1:] in html.unescape(page)
    for line in verdict[1:]:
        assert line in html.unescape(page)
    with h5py.File(folder / "a<b>.h5", "r") as file:
        tuned = 1e3 * float(file["tuned/reference_amplitude_m"][()])
    assert f"tuned {tuned:.2f} mm" in page
    assert "speeds.from_hz" in page  # which differs from its default
    assert "casing.n_bumps</td>" not in page  # which does not
    assert "The casing does not vibrate" in page
    # of Gaussian bumps of H = 1.25 mm and w = 0.157 rad at H/e: √(2/e) H/w on a radius of 500 mm
    assert "slope, up to 0.014 beside a friction of 0.15" in page


def test_the_page_stands_alone_and_names_are_no_markup(folder):
    page = render([str(folder / "a<b>.h5")])
    assert pictures(page)
    assert all(source.startswith("data:image/") for source in pictures(page))
    assert "http" not in re.sub(r'src="[^"]*"', "", page)
    assert "a<b>" not in page
    assert "a&lt;b&gt;.h5" in page


@pytest.mark.long
def test_of_several_files_it_says_in_which_keys_they_differ(folder, capsys):
    paths = [str(folder / "a<b>.h5"), str(folder / "c.h5")]
    assert main(["report", *paths, "--output", str(folder / "both.html")]) == 0
    assert "both.html" in capsys.readouterr().out
    page = (folder / "both.html").read_text()
    row = '<td class="key">contact.friction</td><td>0.15</td><td>0.2</td>'
    assert row in page
    assert page.count('<td class="key">contact.friction</td>') == 2  # and in what c.h5 was asked
    assert "2 results compared" in page


def test_all_keys_in_which_files_differ_are_told(folder, tmp_path, undrawn):
    """Of two files with other bumps, blades and damping it told "$n_d$ = 3" alone."""
    changed = {"casing.n_bumps": 3, "disk.n_blades": 9, "material.damping_ratio": 0.004}
    options = [word for key, value in changed.items() for word in ("--set", f"{key}={value}")]
    arguments = "linear.yaml", "--output", tmp_path / "other.h5", *options
    assert run_here(*arguments, folder=folder) == 0
    page = render([str(folder / "linear.h5"), str(tmp_path / "other.h5")])
    usual = Config().by_path()
    for key, value in changed.items():
        assert f'<td class="key">{key}</td><td>{usual[key]}</td><td>{value}</td>' in page
    assert "$" not in re.sub(r'src="[^"]*"', "", page)


def test_the_input_on_the_page_repeats_the_study(folder, undrawn):
    texts = {
        "a<b>.h5": (folder / "contact.yaml").read_text(),
        "oval": "casing: {harmonics: [{order: 2, amplitude_mm: 0.3}], bump_height_mm: 1.25}\n",
        "rare": "study: rare\nlimits: {amplitude_mm: 9, probability_below: 0.1}\n",
        "elastic": "contact: {law: elastic, casing_stiffness_n_per_m: 1e7}\n",
        "pattern": "mistuning: {pattern: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, -12]}\n",
    }
    for text in texts.values():
        config = Config.from_yaml(text)
        assert Config.from_yaml(repeating(config)) == config
    page = html.unescape(render([str(folder / "a<b>.h5")]))
    (printed,) = re.findall(r'<pre class="input">(.*?)</pre>', page, re.DOTALL)
    with open_result(folder / "a<b>.h5") as file:
        again = Config.from_yaml(printed).replace({"output": file.config.output})
        assert again == file.config


def test_the_answer_stands_in_the_box_with_its_limit_and_there_is_room_to_sign(folder, undrawn):
    limits = "limits.amplitude_mm=3", "limits.stress_mpa=200"
    options = [word for limit in limits for word in ("--set", limit)]
    assert run_here("contact.yaml", "--output", "l.h5", *options, folder=folder) == 0
    page = html.unescape(render([str(folder / "l.h5")]))
    box = page[page.index('<div class="verdict') : page.index("</div>")]
    assert re.search(r"±4 %: [0-9] of 2 disks exceed 3 mm", box)
    assert re.search(r"±4 %: [0-9] of 2 disks exceed 200 MPa", box)
    assert "Verdict: " in box
    for word in ("name", "role", "date", "signature", "approved"):
        assert f">{word}</t" in page


@pytest.mark.parametrize(
    ("keys", "words"),
    [({"study": "run_up"}, "Every speed begins at rest"),
     ({"contact.kinematics": "second_order"}, "a blade that bends does not get shorter"),
     ({"contact.kinematics": "second_order"}, "Contact forces are radial"),
     ({"casing.clearance_s_mm": [[0.0, 0.3], [9.0, 0.2]]}, "The clearance is the same")],
)  # fmt: skip
def test_what_a_key_takes_along_is_not_said_to_be_left_out(keys, words):
    assert words in " ".join(report._omitted_effects(Config()))
    assert words not in " ".join(report._omitted_effects(Config().replace(keys)))


def test_a_figure_that_fails_is_told(folder, monkeypatch):
    def broken(*_, **__):
        yield None, HpcrubError("the picture of the samples cannot be written")

    monkeypatch.setattr(report, "of_study", broken)
    page = render([str(folder / "linear.h5")])
    assert "A figure is missing: the picture of the samples cannot be written" in page


def test_another_study_has_its_own_answer(folder, capsys):
    page = render([str(folder / "linear.h5")])
    assert "Percentiles 1/50/99 of the linear amplification" in page
    assert main(["inspect", str(folder / "linear.h5")]) == 0
    assert "percentiles 1/50/99 of the linear amplification" in capsys.readouterr().out


def test_what_is_not_complete_is_not_called_usable_and_what_has_failed_is_over(tmp_path, undrawn):
    """A page to sign said "Usable." of a study without a result, and a warning twice."""
    text = "study: linear\nmistuning: {samples: 20}\nlimits: {probability_below: 0.1}\n"
    run = run_of(Config.from_yaml(f"{text}output: {tmp_path / 'new.h5'}"))
    warning = execution.examine(run, execution.Existing())[1][0]
    result_files.lay_out(tmp_path / "none.h5", run, {"warnings": f"not resolved: {warning}"})
    with pytest.raises(InputError, match="holds no result yet"):
        render([str(tmp_path / "none.h5")])
    with h5py.File(tmp_path / "none.h5", "r+") as file:
        file["status"][0] = layout.DONE
    page = render([str(tmp_path / "none.h5")])
    assert 'class="verdict no">' in page
    assert "Verdict: not complete, 1 of 4 tasks are done; what is there is u" in page
    assert "is not to be signed" in page
    assert page.count(html.escape(warning)) == 1
    with h5py.File(lay_out(tmp_path / "failed.h5"), "r+") as file:
        file["samples/status"][...] = layout.FAILED
    assert "ot complete" not in render([str(tmp_path / "failed.h5")])


def no_space(path, *_, **__):
    path.touch()
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_report_replaces_nothing_but_a_report(folder, capsys, undrawn, monkeypatch):
    """A report replaced a result, and reports of r_0.25 and r_0.50 had one name."""
    for name in ("r_0.25", "r_0.50", "result.html"):
        shutil.copy(folder / "linear.h5", folder / name)
    for _ in range(2):
        assert main(["report", str(folder / "r_0.25")]) == 0
    assert main(["report", str(folder / "r_0.50")]) == 0
    assert {"r_0.25.html", "r_0.50.html"} <= {path.name for path in folder.iterdir()}
    before = (folder / "c.h5").read_bytes()
    os.mkfifo(folder / "pipe")  # to write into it would wait for a reader
    for name in ("c.h5", "pipe"):
        assert main(["report", str(folder / "linear.h5"), "--output", str(folder / name)]) == 2
    assert main(["report", str(folder / "result.html")]) == 0
    with monkeypatch.context() as full:  # it left an empty file, which no report replaced
        full.setattr(Path, "write_text", no_space)
        assert main(["report", str(folder / "linear.h5"), "--output", str(folder / "r.html")]) == 1
    assert not (folder / "r.html").exists()
    assert "is no report, and is not replaced" in capsys.readouterr().err
    assert (folder / "c.h5").read_bytes() == before
    open_result(folder / "result.html").close()
