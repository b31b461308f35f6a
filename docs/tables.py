"""Write what pages say of the program: keys, datasets, studies, figures, the quick start.

`python -m docs.tables` does it; a test fails when a page and the program differ.
"""

import numpy as np

import hpcrub
from evidence.page import DOCS, ROOT, replace, table
from hpcrub import plot, studies
from hpcrub.config.schema import Config, load_runs
from hpcrub.config.text import key_table
from hpcrub.contact.status import AVERAGED, STEADY
from hpcrub.studies.contact.second_order import PEAK


def keys():
    """One table for every section of the input."""
    sections = {}
    for key in key_table(Config):
        section = key.path.rpartition(".")[0].partition(".")[0]
        allowed = "one of the [studies](studies.md)" if key.path == "study" else key.allowed
        row = f"`{key.path}`", key.description, f"`{key.default}`", allowed
        sections.setdefault(section, []).append(row)
    head = "key", "meaning", "default", "allowed"
    return "\n".join(
        f"## {f'`{section}`' if section else 'Top level'}\n\n{table(head, rows)}"
        for section, rows in sections.items()
    )


def datasets():
    """One table for the result file of every study, as its example input makes it.

    And what a coating, or a casing that vibrates, adds to it.
    """
    parts = []
    for name in studies.STUDIES:
        config = example(name)
        bare = studies.run_of(config).datasets()
        parts.append(f"## `{name}`\n\n{_lines(bare)}")
        vibrates = config.replace({"casing.ring.thickness_mm": 20.0})
        if added := [line for line in studies.run_of(vibrates).datasets() if line not in bare]:
            words = "Of a casing that vibrates (`casing.ring`, `casing.modes`) also"
            parts.append(f"{words}:\n\n{_lines(added)}")
        if name != "branches":  # which no coating fits
            coated = studies.run_of(config.replace({"contact.law": "abradable"})).datasets()
            if added := [line for line in coated if line not in bare]:
                parts.append(f"On a coating (`contact.law: abradable`) also:\n\n{_lines(added)}")
    return "\n".join(parts)


def _lines(datasets):
    head = "dataset", "meaning", "dimensions", "unit"
    rows = [
        (f"`{d.name}`", d.description, ", ".join(d.dimensions) or "one value", d.units)
        for d in datasets
    ]
    return table(head, rows)


def study_list():
    """One row for every study."""
    rows = [
        (
            f"`{name}`",
            study.what,
            ", ".join(f"`{section}`" for section in study.sections),
            paper_figures(name),
            f"`{example_file(name)}`",
        )
        for name, study in studies.STUDIES.items()
    ]
    return table(
        ("study", "what it computes", "sections of its own", "figures of the paper", "example"),
        rows,
    )


def paper_figures(study):
    """Numbers of the figures of the paper that show this study alone."""
    papers = [f.about.paper for f in plot.FIGURES if f.about.studies == (study,) and f.about.paper]
    return ", ".join(map(str, sorted(int(n) for paper in papers for n in paper.split(", "))))


def figures():
    """One row for every figure."""
    rows = [
        (
            f"`{f.__name__}`",
            ", ".join(f.about.studies),
            f.about.what,
            f.about.paper,
            "yes" if f.about.several else "",
        )
        for f in plot.FIGURES
    ]
    return table(("figure", "of the study", "shows", "in the paper", "several files"), rows)


def example_file(study):
    """The example input of a study."""
    return f"inputs/{'quickstart' if study == 'contact' else study}.yaml"


def example(study):
    """The configuration of a study's example input."""
    return load_runs(ROOT / example_file(study))[0]


def quickstart():
    """What the quick start finds, in the words of the first page."""
    with hpcrub.open(DOCS / "examples/quickstart.h5") as file:
        kinds = "amplification", "linear_amplification"
        (two, two_linear), (four, four_linear) = (
            [np.median(file[f"samples/{kind}"][level]) for kind in kinds] for level in (0, 1)
        )
        peaks = file["samples/peak_amplitude_m"]
        tuned, worst = (1e3 * size for size in (file["tuned/reference_amplitude_m"], peaks.max()))
        bent = 1e3 * file[PEAK][0]
        share = np.mean(np.isin(file["samples/point_status"], (STEADY, AVERAGED)))
        seconds = np.median(file["samples/time_s"])
    return (
        f"Half of the disks whose blades lie within ±2 % vibrate more than {two:.2f} times as much "
        f"as the tuned disk, where the linear analysis expects {two_linear:.2f} times; within ±4 % "
        f"it is {four:.2f} against {four_linear:.2f}. The tips of this academic disk move by "
        f"{tuned:.0f} mm, and by {worst:.0f} mm in the worst of the {peaks.size} disks: more than "
        "a real blade would bear and small displacements, which are the paper's, describe (and "
        f"than the second order can tell, to which the tuned disk moves by {bent:.0f} mm). "
        f"{100 * share:.1f} % of the points end with a motion whose mean amplitude is known and in "
        f"which no wave grows, most of them after {seconds:.1f} s."
    )


REFERENCE = {"keys": keys, "datasets": datasets, "studies": study_list, "figures": figures}
TABLES = {name: (DOCS / f"reference/{name}.md", make) for name, make in REFERENCE.items()}
TABLES["quickstart"] = ROOT / "README.md", quickstart

if __name__ == "__main__":
    for name, (path, make) in TABLES.items():
        replace(path, **{name: make()})
