"""Rooms import only from rooms before them, and no module imports in a circle.

Looked up in the syntax of every module, so that an import within a function counts as well.
"""

import ast
import re
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "hpcrub"
ROOMS = [
    "errors", "model", "contact", "response", "statistics", "config", "results", "ranks", "setup",
    "effects", "runs", "studies", "plot", "commands",
]  # fmt: skip
# `import_module` loads a room after `ranks`, or a figure, when it is asked for, for time alone;
# and the studies, which are the modules of their folder
LAZY = {"hpcrub.__main__", "hpcrub.plot", "hpcrub", "hpcrub.studies"}


def name_of(path):
    """Dotted name of a module of the package."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in PACKAGE.rglob("*.py")}


@cache
def tree(name):
    return ast.parse(MODULES[name].read_text("utf-8"))


@cache
def imports(name):
    """All modules that a module imports, and whether it has an `import_module` of the package."""
    found, dynamic = set(), False
    for node in ast.walk(tree(name)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            # `from a import b` imports the module a.b where there is one, and a itself else
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {n if n in MODULES else node.module for n in names}
        if isinstance(node, ast.Call) and "import_module" in ast.dump(node.func):
            dynamic |= "hpcrub" in ast.dump(node.args[0])
    return found - {name}, dynamic


def room(name):
    parts = name.split(".")
    return parts[1] if name in MODULES and len(parts) > 1 and parts[1] in ROOMS else None


def test_a_room_imports_only_from_rooms_before_it():
    wrong = []
    for name in MODULES:
        found, dynamic = imports(name)
        assert not dynamic or name in LAZY
        if room(name):  # else the program itself
            later = ROOMS[ROOMS.index(room(name)) + 1 :]
            wrong += [f"{name} imports {other}" for other in found if room(other) in later]
    assert not wrong


def test_files_and_functions_are_short_but_those_that_a_page_names():
    page = (PACKAGE.parent / "docs/architecture.md").read_text("utf-8")
    sizes = page.partition("## Sizes")[2].partition("\n## ")[0]
    named = {name.rpartition(".")[2] for name in re.findall(r"`([\w.]+)`", sizes)}
    for name, path in MODULES.items():
        assert len(path.read_text("utf-8").splitlines()) <= 400, path
        functions = [n for n in ast.walk(tree(name)) if isinstance(n, ast.FunctionDef)]
        long = {f.name for f in functions if f.end_lineno - f.lineno >= 40}
        assert long <= named, path


def test_the_page_names_the_modules_of_every_room():
    page = (PACKAGE.parent / "docs/architecture.md").read_text("utf-8")
    modules = page.partition("## The modules")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `([a-z_/]+)` \| (.*) \|$", modules, re.MULTILINE)
    assert len(rows) > 10
    for room, text in rows:
        named = set(re.findall("`([a-z_0-9]+)`", text))
        files = {path.stem for path in (PACKAGE / room).glob("[!_]*.py")}
        below = {path.stem for path in (PACKAGE / room).rglob("[!_]*.py")}
        assert (files - named, named - below) == (set(), set()), room


def test_evidence_needs_no_tests():
    modules = (PACKAGE.parent / "evidence").rglob("*.py")
    assert [p for p in modules if "from tests" in p.read_text("utf-8")] == []


def test_statistics_needs_no_physics():
    found = set().union(*(imports(n)[0] for n in MODULES if room(n) == "statistics"))
    others = {n for n in found & set(MODULES) if room(n) not in ("statistics", "errors")}
    assert others <= {"hpcrub.contact.jit", "hpcrub.contact.status"}


def test_no_module_imports_in_a_circle():
    # the package itself loads what a notebook asks for, and gives all others their version
    graph = {name: imports(name)[0] & set(MODULES) - {"hpcrub"} for name in MODULES}
    del graph["hpcrub"]
    list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the modules


def test_one_module_imports_mpi_and_one_hdf5():
    for library, owner in (("mpi4py", "hpcrub.ranks.parallel"), ("h5py", "hpcrub.results.storage")):
        users = [m for m in MODULES if any(n.split(".")[0] == library for n in imports(m)[0])]
        assert users == [owner]
