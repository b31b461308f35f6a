"""Write the tables of README.md anew from what the program has: keys, output, studies, figures."""

import re
from pathlib import Path

from hpcrub.config.schema import key_table
from hpcrub.plot import FIGURES
from hpcrub.results.layout import LAYOUT
from hpcrub.studies import STUDIES

README = Path(__file__).parents[1] / "README.md"


def updated(text):
    """The README text with all tables as the program has them now.

    Raises:
        ValueError: a table's markers are not in the text exactly once.
    """
    keys = [(f"`{k.path}`", f"`{k.default}`", k.allowed, k.description) for k in key_table()]
    data = [
        (f"`{d.name}`", ", ".join(d.dimensions) or "one value", d.units, d.description)
        for d in LAYOUT
    ]
    all_studies = [(f"`{name}`", s.figures, s.what) for name, s in STUDIES.items()]
    figures = [
        (f"`{name}`", ", ".join(f.studies), f.paper, f.what, "yes" if f.several else "")
        for name, f in FIGURES.items()
    ]
    text = _replace(text, "studies", ("study", "figures of the paper", "what"), all_studies)
    head = "figure", "of the study", "in the paper", "shows", "several files"
    text = _replace(text, "figures", head, figures)
    text = _replace(text, "keys", ("key", "default", "allowed", "meaning"), keys)
    return _replace(text, "datasets", ("dataset", "dimensions", "unit", "meaning"), data)


def _replace(text, name, head, rows):
    lines = [head, ("---",) * len(head), *rows]
    table = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    block = f"<!-- {name} -->\n{table}\n<!-- end of {name} -->"
    pattern = re.compile(rf"<!-- {name} -->.*?<!-- end of {name} -->", re.DOTALL)
    text, found = pattern.subn(lambda match: block, text)
    if found != 1:
        raise ValueError(f"{found} places for the table of {name} in README.md, not one")
    return text


if __name__ == "__main__":
    README.write_text(updated(README.read_text(encoding="utf-8")), encoding="utf-8")
