"""The generated parts of the pages in docs/: tables, and the text between two comments."""

import argparse
import os
import platform
import re
from pathlib import Path

from evidence import progress

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"


def table(heads, rows):
    """Markdown table; rows of strings or numbers (of a float, three digits)."""
    cells = [[f"{x:.3g}" if isinstance(x, float) else str(x) for x in row] for row in rows]
    lines = [heads, ["---"] * len(heads), *cells]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def updated(path, **parts):
    """A page with texts {name: Markdown} between `<!-- name -->` and `<!-- end of name -->`."""
    text = path.read_text(encoding="utf-8")
    for name, part in parts.items():
        place = re.compile(f"(?<=<!-- {name} -->\n).*?(?=<!-- end of {name} -->)", re.DOTALL)
        text, n_found = place.subn(lambda _, part=part: part.rstrip("\n") + "\n", text)
        if n_found != 1:
            raise ValueError(f"{path}: {n_found} places for {name}")
    return text


def replace(path, **parts):
    """Write the `updated` page."""
    path.write_text(updated(path, **parts), encoding="utf-8")


def sections(program, about, path, found_by, on_machine=True, argv=None):
    """Measure sections of a page, all or those that the command line names; each is then written.

    program: its name in this package; about: its text for --help; found_by: {name: function}, which
    returns texts {part: Markdown}, in the page name_part; on_machine: name the machine, too.
    """
    parser = argparse.ArgumentParser(prog=f"python -m evidence.{program}", description=about)
    parser.add_argument("sections", nargs="*", choices=[*found_by, []], help="all by default")
    chosen = parser.parse_args(argv).sections or list(found_by)
    for name in progress.followed(chosen, "sections", names=chosen):
        parts = found_by[name]() | ({"machine": measured()} if on_machine else {})
        replace(path, **{f"{name}_{part}": text for part, text in parts.items()})


def measured():
    """The sentence that names the machine: cores, processor with its widest vectors, Python."""
    return f"Measured with {machine()}."


def machine():
    """Cores, processor with its widest vectors, and Python, in words."""
    about = Path("/proc/cpuinfo")
    flags = about.read_text() if about.exists() else ""
    widest = [name for name in ("avx512f", "avx2") if name in flags]
    kind = " with ".join([platform.machine(), *widest[:1]])
    return f"{os.cpu_count()} cores ({kind}), Python {platform.python_version()}"
