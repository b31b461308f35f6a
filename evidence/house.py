"""How large the house is, and how its rooms lean on each other.

Prints, for every tree given (this one without any), the lines of the package and of everything
beside it, modules, the median and the longest file, the longest functions, and the imports between
rooms. A room is a folder of the package; in a package without rooms every module is one.
"""

import argparse
import ast
import statistics
import subprocess
from collections import Counter
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
TEXT = {".py", ".md", ".sh", ".sbatch", ".yaml", ".toml", ".c", ".cff", ".txt", ".ipynb", ""}


class Function(NamedTuple):
    """One function of the package."""

    lines: int
    name: str


def files(root):
    """Text files of a tree that git knows, or all of them where it knows none."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=root, capture_output=True, text=True
    )
    known = [root / name for name in listed.stdout.splitlines()] or list(root.rglob("*"))
    return [path for path in known if path.suffix in TEXT and path.is_file()]


def lines(path):
    """Lines of a file."""
    return len(path.read_text(encoding="utf-8", errors="replace").splitlines())


def functions(path):
    """Functions of a module, decorators and docstrings included."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            start = min([node.lineno, *(d.lineno for d in node.decorator_list)])
            yield Function(node.end_lineno - start + 1, f"{path.name}:{node.name}")


def imported(path, package):
    """Modules of the package that a module imports, as dotted names below the package."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == package.name:
            base = node.module.split(".")[1:]
            yield from (".".join([*base, alias.name]) for alias in node.names)
        elif isinstance(node, ast.Import):
            names = (alias.name.split(".") for alias in node.names)
            yield from (".".join(name[1:]) for name in names if name[0] == package.name)


def room(name):
    """Room of a dotted name below the package."""
    return name.split(".")[0]


def arrows(modules, package):
    """{(room, room that it imports): number of imports}, between different rooms."""
    found = Counter()
    for path in modules:
        here = ".".join(path.relative_to(package).with_suffix("").parts)
        for target in imported(path, package):
            if target and room(target) != room(here) and exists(package, room(target)):
                found[room(here), room(target)] += 1
    return found


def exists(package, name):
    """Whether a room or a module of this name is in the package (else it is a name of its root)."""
    return (package / name).is_dir() or (package / f"{name}.py").exists()


def circles(found):
    """Pairs of rooms that import each other, by any way round."""
    reach = {a: {b for x, b in found if x == a} for a, _ in found}
    for _ in reach:
        reach = {a: s | {c for b in s for c in reach.get(b, ())} for a, s in reach.items()}
    return sorted(a for a, s in reach.items() if a in s)


def report(root):
    """Text about one tree."""
    package = root / "hpcrub"
    known = files(root)
    modules = [path for path in known if package in path.parents and path.suffix == ".py"]
    counts = {path: lines(path) for path in known}
    beside = Counter()
    for path in known:
        if package not in path.parents:
            parts = path.relative_to(root).parts
            beside[parts[0] if len(parts) > 1 else "(top level)"] += counts[path]
    size = sorted(counts[path] for path in modules)
    most = max(modules, key=counts.get)
    longest = sorted((f for path in modules for f in functions(path)), reverse=True)
    found = arrows(modules, package)
    rooms = {room(".".join(p.relative_to(package).with_suffix("").parts)) for p in modules}
    return "\n".join(
        [
            f"{root}",
            f"  hpcrub/            {sum(size):7,} lines in {len(modules)} modules",
            f"  everything else    {sum(beside.values()):7,} lines: "
            + ", ".join(f"{name} {n:,}" for name, n in beside.most_common()),
            f"  median file        {statistics.median(size):7,.0f} lines; "
            f"largest {counts[most]} ({most.relative_to(root)}); "
            f"above 400: {sum(n > 400 for n in size)}",
            f"  longest function   {longest[0].lines:7,} lines ({longest[0].name}); "
            f"above 40: {sum(f.lines > 40 for f in longest)} of {len(longest)}",
            f"  import arrows      {len(found):7,} between {len(rooms)} rooms; "
            f"rooms in a circle: {', '.join(circles(found)) or 'none'}",
        ]
    )


def main():
    """Print the report of every tree asked for."""
    parser = argparse.ArgumentParser(prog="python -m evidence.house", description=__doc__)
    parser.add_argument("root", nargs="*", type=Path, default=[ROOT], help="trees to look at")
    for root in parser.parse_args().root:
        print(report(root.resolve()))


if __name__ == "__main__":
    main()
