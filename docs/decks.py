"""The decks of the tutorial "Your own disk, from one sector", from the one deck that you have.

    python decks.py fan.inp --blade BLADE --fixed BORE --low LOW --high HIGH --sectors 18 \\
        --speeds 80 120

fan.inp holds nodes, elements, sets, materials and solid sections of one sector, in mm, t and s, for
CalculiX or Abaqus; its own steps and supports are left out. Beside it are written sector.inp and
blade_alone.inp, and for every speed [Hz] state_HZ.inp and sector_HZ.inp.
"""

import argparse
import math
from pathlib import Path

STORE = "*FREQUENCY, SOLVER=MATRIXSTORAGE\n10\n*END STEP\n"
STATE = """\
*SURFACE, NAME=SLOW, TYPE=NODE
{low}
*SURFACE, NAME=SHIGH, TYPE=NODE
{high}
*TIE, NAME=SIDES, CYCLIC SYMMETRY
SLOW, SHIGH
*CYCLIC SYMMETRY MODEL, N={sectors}, NGRAPH=1, TIE=SIDES
0., 0., 0., 0., 0., 1.
*BOUNDARY
HELD, 1, 3
*STEP, NLGEOM
*STATIC
{load}*NODE PRINT, NSET={low}
U
*NODE PRINT, NSET={high}
U
*END STEP
"""
MOVED = """\
*STEP, NLGEOM
*STATIC
*INCLUDE, INPUT=moved_{hz}.inp
{load}*END STEP
*STEP, PERTURBATION
*BOUNDARY, OP=NEW
{fixed}, 1, 3
"""
LOAD = "*DLOAD\nEALL, CENTRIF, {:.12g}, 0., 0., 0., 0., 0., 1.\n"
KEPT = "NODE", "NSET", "MATERIAL", "ELASTIC", "DENSITY", "EXPANSION", "ORIENTATION"


def main(argv=None):
    options = parser().parse_args(argv)
    folder, blocks = options.deck.parent, list(blocks_of(options.deck))
    elements, elsets = elements_of(blocks)
    if options.blade.upper() not in elsets:
        raise SystemExit(f"there is no element set {options.blade}; there are {', '.join(elsets)}")
    low, high, fixed = (
        nodes_of(blocks, name) for name in (options.low, options.high, options.fixed)
    )
    if len(low) != len(high) or not fixed - low:
        raise SystemExit("the sides need as many nodes, and the held set nodes beside the low side")
    disk = model(blocks, elements, elsets, set(elements))
    held = f"*BOUNDARY\n{options.fixed}, 1, 3\n"
    decks = {
        "sector": disk + held + "*STEP\n" + STORE,
        "blade_alone": model(blocks, elements, elsets, elsets[options.blade.upper()])
        + "*STEP\n"
        + STORE,
    }
    # the tie moves the low side: what is held there would be held twice
    inner = f"*NSET, NSET=HELD\n{lines_of(sorted(fixed - low))}"
    for hz in options.speeds:
        names = vars(options) | {"hz": hz, "load": LOAD.format((2.0 * math.pi * float(hz)) ** 2)}
        decks[f"state_{hz}"] = disk + inner + STATE.format(**names)
        decks[f"sector_{hz}"] = disk + held + MOVED.format(**names) + STORE
    for name, text in decks.items():
        (folder / f"{name}.inp").write_text(text, "ascii")
        print(folder / f"{name}.inp")


def parser():
    top = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    top.add_argument("deck", type=Path)
    top.add_argument("--blade", required=True, help="element set of the blade")
    for name in ("fixed", "low", "high"):
        top.add_argument(f"--{name}", required=True, help="node set")
    top.add_argument("--sectors", required=True, type=int)
    top.add_argument("--speeds", nargs="*", default=[], metavar="HZ")
    return top


def blocks_of(path):
    """(keyword, options, its line, data lines) of the model in a deck, before its first step."""
    block = None
    for line in filter(
        None, map(str.strip, path.read_text("utf-8", errors="replace").splitlines())
    ):
        if line.startswith("**"):
            continue
        if not line.startswith("*"):
            block[3].append(line)
            continue
        if block:
            yield block
        keyword, *rest = [word.strip() for word in line[1:].split(",")]
        named = dict(word.upper().replace(" ", "").partition("=")[::2] for word in rest)
        block = keyword.upper(), named, line, []
        if block[0] == "INCLUDE":
            yield from blocks_of(path.parent / line.partition("=")[2].strip())
            block = None
        elif block[0] == "STEP":
            return
    if block:
        yield block


def elements_of(blocks):
    """{label: (type, nodes)} of all elements, and {name: labels} of their sets."""
    elements, elsets = {}, {}
    for keyword, named, _, data in blocks:
        if keyword == "ELEMENT":
            words, found = [], set()
            for line in data:
                words += [word for word in line.replace(" ", "").split(",") if word]
                if not line.endswith(","):
                    elements[int(words[0])] = named["TYPE"], words[1:]
                    found.add(int(words[0]))
                    words = []
            elsets.setdefault(named.get("ELSET", "EALL"), set()).update(found)
        elif keyword == "ELSET":
            elsets.setdefault(named["ELSET"], set()).update(members(named, data, elsets))
    return elements, elsets


def nodes_of(blocks, name):
    """Numbers of the nodes of a set."""
    sets = {}
    for keyword, named, _, data in blocks:
        if keyword == "NSET":
            sets.setdefault(named["NSET"], set()).update(members(named, data, sets))
    if name.upper() not in sets:
        raise SystemExit(f"there is no node set {name}; there are {', '.join(sets)}")
    return sets[name.upper()]


def members(named, data, sets):
    """Numbers that the lines of a set name, one by one, as ranges, or by other sets."""
    rows = [[word.strip() for word in line.split(",") if word.strip()] for line in data]
    if "GENERATE" in named:
        ranges = [[int(word) for word in row] for row in rows]
        return set().union(*(range(first, last + 1, *step) for first, last, *step in ranges))
    words = [word for row in rows for word in row]
    return set().union(*(sets.get(word.upper()) or [int(word)] for word in words))


def model(blocks, elements, elsets, kept):
    """Text of nodes, sets and materials, and of some of the elements with their sections."""
    text = "".join("\n".join([line, *data, ""]) for word, _, line, data in blocks if word in KEPT)
    for kind in sorted({elements[label][0] for label in kept}):
        text += f"*ELEMENT, TYPE={kind}, ELSET=EALL\n"
        for label in sorted(kept):
            if elements[label][0] == kind:
                text += lines_of([label, *elements[label][1]], goes_on=True)
    for number, (keyword, named, line, data) in enumerate(blocks):
        if keyword == "SOLID SECTION" and (mine := elsets[named["ELSET"]] & kept):
            text += f"*ELSET, ELSET=OF_{number}\n{lines_of(sorted(mine))}"
            rest = [word for word in line.split(",")[1:] if "ELSET" not in word.upper()]
            text += "\n".join([",".join([f"*SOLID SECTION, ELSET=OF_{number}", *rest]), *data, ""])
    return text


def lines_of(numbers, goes_on=False):
    """Numbers, ten in a line; goes_on: a comma at the end of all lines but the last."""
    rows = [", ".join(map(str, numbers[k : k + 10])) for k in range(0, len(numbers), 10)]
    return (",\n" if goes_on else "\n").join(rows) + "\n"


if __name__ == "__main__":
    main()
