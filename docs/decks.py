"""The decks of the tutorial "Your own disk, from one sector", from the one deck that you have.

    python decks.py fan.inp --blade BLADE --fixed BORE --low LOW --high HIGH --sectors 18 \\
        --speeds 80 120

fan.inp holds nodes, elements, sets, materials and solid sections of one sector, in mm, t and s, for
CalculiX or Abaqus. Its own steps and supports are left out; what else is, is said. A model with
other parts (equations, masses, shells, turned nodes) is refused. Beside it are written sector.inp
and blade_alone.inp, and for every speed [Hz] state_HZ.inp and sector_HZ.inp.
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
COPIED = "NODE", "MATERIAL", "ELASTIC", "DENSITY", "EXPANSION", "ORIENTATION"
READ = "NSET", "ELSET", "ELEMENT", "SOLID SECTION"
LEFT_OUT = (  # have no part in the matrices of a sector alone
    "HEADING", "PREPRINT", "RESTART", "BOUNDARY", "SURFACE", "AMPLITUDE", "PHYSICAL CONSTANTS",
    "DAMPING", "CONDUCTIVITY", "SPECIFIC HEAT", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY",
    "INSTANCE", "END INSTANCE",
)  # fmt: skip


def main(argv=None):
    options = parser().parse_args(argv)
    folder, blocks = options.deck.parent, list(blocks_of(options.deck))
    check(options.deck, blocks)
    elements, elsets = elements_of(blocks)
    blade = picked(elsets, options.blade, "element set")
    sets = sets_of(blocks)
    low, high, fixed = (
        picked(sets, name, "node set") for name in (options.low, options.high, options.fixed)
    )
    if len(low) != len(high) or not fixed - low:
        raise SystemExit("the sides need as many nodes, and the held set nodes beside the low side")
    disk = model(blocks, elements, elsets, sets, set(elements))
    held = f"*BOUNDARY\n{options.fixed}, 1, 3\n"
    decks = {
        "sector": disk + held + "*STEP\n" + STORE,
        "blade_alone": model(blocks, elements, elsets, sets, blade) + "*STEP\n" + STORE,
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
    """(keyword, options, data lines) of the model in a deck, before its first step."""
    block = None
    for line in filter(
        None, map(str.strip, path.read_text("utf-8", errors="replace").splitlines())
    ):
        if line.startswith("**"):
            continue
        if not line.startswith("*"):
            block[2].append(line)
            continue
        if block:
            yield block
        keyword, *rest = [word.strip() for word in line[1:].split(",")]
        pairs = (word.partition("=")[::2] for word in rest)
        named = {key.strip().upper(): name_of(value) for key, value in pairs}
        block = " ".join(keyword.upper().split()), named, []
        if block[0] == "INCLUDE":
            yield from blocks_of(path.parent / line.partition("=")[2].strip().strip('"'))
            block = None
        elif block[0] == "STEP":
            return
    if block:
        yield block


def name_of(text):
    """A name as CalculiX can read it: capitals, no quotes, no blanks."""
    return "_".join(text.strip().strip('"').upper().split())


def check(path, blocks):
    """Stop where the model has parts that would be lost, and say what is left out."""
    words = [word for word, *_ in blocks]
    for word, named, data in blocks:
        moves = word == "INSTANCE" and (data or words.count(word) > 1)
        how = next(
            (f", {key}" for key in ("INPUT", "SYSTEM") if key in named and word in COPIED), ""
        )
        if moves or how or word not in COPIED + READ + LEFT_OUT:
            raise SystemExit(
                f"{path}: *{word}{how} would be lost; take it out if the sector's matrices can do "
                "without it, write it in another way, or make the decks by hand"
            )
    lost = ", ".join(f"*{word}" for word in dict.fromkeys(words) if word in LEFT_OUT)
    print(f"left out: {lost or 'nothing'}, and all steps")


def elements_of(blocks):
    """{label: (type, nodes)} of all elements, and {name: labels} of their sets."""
    elements, elsets = {}, {}
    for keyword, named, data in blocks:
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


def sets_of(blocks):
    """{name: numbers} of all sets of nodes."""
    sets = {}
    for keyword, named, data in blocks:
        if keyword in ("NODE", "NSET") and (name := named.get("NSET")):
            if "ELSET" in named:
                raise SystemExit(f"*NSET, ELSET={named['ELSET']} is not read; list the nodes")
            numbers = members(named, data, sets) if keyword == "NSET" else labels(data)
            sets.setdefault(name, set()).update(numbers)
    return sets


def labels(data):
    return {int(line.partition(",")[0]) for line in data}


def picked(sets, name, what):
    if name_of(name) not in sets:
        raise SystemExit(f"there is no {what} {name}; there are {', '.join(sets)}")
    return sets[name_of(name)]


def members(named, data, sets):
    """Numbers that the lines of a set name, one by one, as ranges, or by other sets."""
    rows = [[word.strip() for word in line.split(",") if word.strip()] for line in data]
    if "GENERATE" in named:
        ranges = [[int(word) for word in row] for row in rows]
        return set().union(*(range(first, last + 1, *step) for first, last, *step in ranges))
    words = [word for row in rows for word in row]
    found = (
        [int(word)] if word.isdigit() else picked(sets, word, "set that another set names")
        for word in words
    )
    return set().union(*found)


def model(blocks, elements, elsets, sets, kept):
    """Text of nodes, sets and materials, and of some of the elements with their sections."""
    copied = [(line_of(word, named), data) for word, named, data in blocks if word in COPIED]
    text = "".join("\n".join([line, *data, ""]) for line, data in copied)
    text += "".join(f"*NSET, NSET={name}\n{lines_of(sorted(sets[name]))}" for name in sets)
    for kind in sorted({elements[label][0] for label in kept}):
        text += f"*ELEMENT, TYPE={kind}, ELSET=EALL\n"
        for label in sorted(kept):
            if elements[label][0] == kind:
                text += lines_of([label, *elements[label][1]], goes_on=True)
    alone = set(kept)
    for number, (keyword, named, data) in enumerate(blocks):
        if keyword != "SOLID SECTION":
            continue
        whole = picked(elsets, named.get("ELSET", ""), "element set of a *SOLID SECTION:")
        if mine := whole & kept:
            alone -= mine
            text += f"*ELSET, ELSET=OF_{number}\n{lines_of(sorted(mine))}"
            text += "\n".join([line_of(keyword, named | {"ELSET": f"OF_{number}"}), *data, ""])
    if alone:
        raise SystemExit(f"element {min(alone)} has no *SOLID SECTION, so no material")
    return text


def line_of(word, named):
    """The line of a keyword with its options."""
    return ", ".join([f"*{word}", *(f"{k}={value}" if value else k for k, value in named.items())])


def lines_of(numbers, goes_on=False):
    """Numbers, ten in a line; goes_on: a comma at the end of all lines but the last."""
    rows = [", ".join(map(str, numbers[k : k + 10])) for k in range(0, len(numbers), 10)]
    return (",\n" if goes_on else "\n").join(rows) + "\n"


if __name__ == "__main__":
    main()
