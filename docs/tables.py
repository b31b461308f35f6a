"""Write the tables of docs/reference/ from the program: keys, datasets, studies, figures.

`python docs/tables.py` does it; a test fails when a page and the program differ.
"""

import re
from pathlib import Path

from hpcrub import plot, studies
from hpcrub.config.schema import Config, load_runs
from hpcrub.config.text import key_table

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "reference"


def updated(name, text):
    """The text of one page with its table as the program has it now.

    Parameters
    ----------
    name : str
        Name of the page and of its table, one of `TABLES`.
    text : str
        The page, with the table between two comments.

    Raises
    ------
    ValueError
        The comments are not in the text exactly once.
    """
    block = f"<!-- {name} -->\n{TABLES[name]()}\n<!-- end of {name} -->"
    pattern = re.compile(rf"<!-- {name} -->.*?<!-- end of {name} -->", re.DOTALL)
    text, found = pattern.subn(lambda match: block, text)
    if found != 1:
        raise ValueError(f"{found} places for the table of {name}, not one")
    return text


def keys():
    """One table for every section of the input."""
    sections = {}
    for key in key_table(Config):
        section = key.path.rpartition(".")[0].partition(".")[0]
        allowed = "one of the [studies](studies.md)" if key.path == "study" else key.allowed
        row = f"`{key.path}`", key.description, f"`{key.default}`", allowed
        sections.setdefault(section, []).append(row)
    head = "key", "meaning", "default", "allowed"
    return "\n\n".join(
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
    return "\n\n".join(parts)


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
            study.figures,
            f"`{example_file(name)}`",
        )
        for name, study in studies.STUDIES.items()
    ]
    return table(
        ("study", "what it computes", "sections of its own", "figures of the paper", "example"),
        rows,
    )


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


def table(head, rows):
    """A Markdown table."""
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


TABLES = {"keys": keys, "datasets": datasets, "studies": study_list, "figures": figures}

if __name__ == "__main__":
    for name in TABLES:
        page = FOLDER / f"{name}.md"
        page.write_text(updated(name, page.read_text(encoding="utf-8")), encoding="utf-8")
