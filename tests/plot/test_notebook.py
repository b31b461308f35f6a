"""Figures as a notebook uses them: a path or an open file, a figure of one's own, words, notes.

Truth: the words a reader expects, and that all that is written lies inside the figure.
"""

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib import rcParams

import hpcrub
from evidence.truth.hexahedra import sector_arrays
from hpcrub import plot
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.results import model_file
from tests.plot.drawn import words
from tests.plot.stored import PATTERN, PHYSICS, contact_file
from tests.program import TINY, lay_out


def test_a_figure_of_a_path_or_of_an_open_file(tmp_path):
    path = lay_out(tmp_path / "modal.h5", "study: modal")
    drawn = hpcrub.plot.casing(str(path))
    drawn[1].set_xlim(0, 90)  # they are the user's to change
    assert [line.get_label() for line in drawn[0].get_lines()][0] == "deformed casing"
    with hpcrub.open(path) as file:
        assert len(hpcrub.plot.casing(file)) == 3
        assert file["shapes"].size  # an open file stays open


def test_the_users_style_and_figures_stay(random):
    file = contact_file(random)
    before = dict(rcParams)
    plot.summary(file)
    assert dict(rcParams) == before
    mine = plt.figure(figsize=(9, 3))
    left, right = mine.subfigures(1, 2)
    assert all(panel.figure is left for panel in plot.summary(file, figure=left))
    plot.percentiles(file, figure=right)
    assert tuple(mine.get_size_inches()) == (9, 3)


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda file: plot.linear(file), "figure linear is for the study linear"),
        (lambda file: plot.wear(file), "figure wear is for a coating that wears"),
        (lambda file: plot.summary([file, file]), "figure summary shows one result file, 2 are"),
        (lambda file: plot.compare([]), "shows one result file, 0 are given"),
        (lambda file: plot.percentiles(file, figure=plt.figure().add_subplot()),
         "figure: a Figure or SubFigure is drawn into, not Axes"),
        (lambda file: plot.summary(file, mode=1), "figure summary does not show a mode"),
    ],
)  # fmt: skip
def test_wrong_calls_say_what_is_wrong(random, draw, message):
    with pytest.raises(InputError, match=message):
        draw(contact_file(random))
    pattern = contact_file(random, PHYSICS + PATTERN, (1, 1))
    with pytest.raises(InputError, match="is for random samples, and this is one explicit"):
        plot.percentiles(pattern)


def assert_nothing_clipped(figure):
    """Legends and titles end inside the figure, and no legend lies over an axis' words."""
    figure.draw_without_rendering()
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    assert legends
    for artist in [*legends, *(axes.title for axes in figure.axes if axes.get_title())]:
        (x0, y0), (x1, y1) = artist.get_window_extent().get_points()
        assert figure.bbox.x0 <= x0 < x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= y0 < y1 <= figure.bbox.y1
    for legend in figure.legends:
        for axes in figure.axes:
            words_of_x = axes.xaxis.get_tightbbox()
            assert words_of_x is None or not legend.get_window_extent().overlaps(words_of_x)


OF_CONTACT = [
    f for f in plot.FIGURES if "contact" in f.about.studies and f.about.needs in ("", "random")
]
SEVERAL = [(f, 4 if f.about.several else 1) for f in OF_CONTACT]


@pytest.mark.parametrize(("figure", "n_files"), SEVERAL, ids=lambda v: getattr(v, "__name__", v))
@pytest.mark.long
def test_nothing_is_clipped(random, figure, n_files):
    files = [contact_file(random, f"{TINY}casing: {{n_bumps: {3 + n}}}\n") for n in range(n_files)]
    axes = np.ravel(figure(files if n_files > 1 else files[0]))
    assert_nothing_clipped(axes[0].figure)


@pytest.mark.parametrize("name", ["summary", "percentiles"])  # without and with a legend of all
def test_warnings_of_a_file_stand_below_its_figure(random, name):
    file, draw = contact_file(random), getattr(plot, name)
    file.warnings = ["first", "second"]
    figure = np.ravel(draw(file))[0].figure
    assert_nothing_clipped(figure)
    assert {"first", "second"} <= set(figure.legends[0].get_title().get_text().split("\n"))


def test_an_error_of_0_leaves_a_gap_on_a_logarithmic_axis(random):
    found = [[0.02, 0.0, 0.01], [0.0, 0.0, 0.003], [0.05, 0.04, 0.03]]
    errors = np.concatenate([np.full((3, 9), np.nan), found], axis=1)[None]
    file = contact_file(random, TINY.replace("[2, 4]", "[2]"), (1, 40))
    file.values["statistics/samples_seen"] = np.arange(10, 130, 10)
    file.values["statistics/contact/convergence_error"] = errors
    panels = plot.convergence_errors(file)
    drawn = [np.nan_to_num(panel.get_lines()[0].get_ydata()[9:], nan=-1.0) for panel in panels]
    np.testing.assert_allclose(drawn, [[2.0, -1.0, 1.0], [-1.0, -1.0, 0.3], [5.0, 4.0, 3.0]])
    np.testing.assert_allclose(panels[0].get_lines()[-1].get_ydata(), 0.5)
    assert "target" in words(panels[0])


@pytest.fixture(scope="module")
def sector(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "sector.h5"
    model_file.write(path, sector_arrays())
    return path


@pytest.fixture(scope="module")
def disk(sector):
    return assembly.assemble(neutral.from_arrays(model_file.read(sector)))


def test_contact_nodes_are_drawn_at_their_places(sector, disk):
    axes = hpcrub.plot.model(sector)
    (drawn,) = [np.transpose(line.get_data_3d()) for line in axes.get_lines()]
    np.testing.assert_allclose(drawn, 1e3 * disk.nodes[disk.contact_node])
    numbers = [str(blade + 1) for blade in range(disk.n_blades)]
    assert [text.get_text() for text in axes.texts] == numbers


def test_a_reduced_model_in_a_figure_of_ones_own(disk, tmp_path):
    small, _ = reduced.reduce_disk(disk, 4)
    path = tmp_path / "reduced.h5"
    model_file.write(path, neutral.to_arrays(small))
    mine = plt.figure()
    axes = hpcrub.plot.model(path, figure=mine)
    assert axes.figure is mine
    assert len(axes.texts) == disk.n_blades
