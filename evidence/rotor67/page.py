"""The tables of docs/rotor67.md, from the benchmark's numbers."""

from evidence import page

PAGE = page.DOCS / "rotor67.md"

# columns of percentiles over the fans: quantity and digits by heading
PERCENTILES = {
    "A_nl": ("amplification A_nl", 2),
    "A_lin": ("amplification A_lin", 2),
    "stress [MPa]": ("stress", 0),
}
DAMPING = {
    f"{kind}, damping ratio {ratio}": (f"amplification {kind}{where}", 2)
    for kind in ("A_nl", "A_lin")
    for ratio, where in ((0.01, ""), (0.005, " at half the damping"))
}
WEAR = {
    "largest amplitude [mm]": ("largest amplitude on a coating", 2),
    "largest worn depth [mm]": ("largest worn depth", 2),
    "stress [MPa]": ("stress on a coating", 0),
}


def write(found: dict) -> None:
    """Write the tables anew; found: Number by (quantity, at)."""
    page.replace(
        PAGE,
        mesh=_meshes(found),
        tip=_tip(found),
        families=_families(found),
        crossings=_crossings(found),
        stress=_stress(found),
        percentiles=_fans(found, PERCENTILES),
        limits=_limits(found),
        damping=_fans(found, DAMPING),
        conclusions=_conclusions(found),
        coated=_coated(found),
        wear=_fans(found, WEAR),
    )


def _rows(found, quantity):
    return [number for number in found.values() if number.quantity == quantity]


def _meshes(found):
    table: dict = {}
    for number in _rows(found, "frequency of the blade alone"):
        _, mesh = number.at.split(", ")
        table.setdefault(mesh, []).append(f"{number.value:.1f}")
    finest = list(table.values())[-1]
    heads = ["chord x span x thickness", *(f"mode {k + 1} [Hz]" for k in range(len(finest)))]
    return page.table(
        heads, [[mesh.removesuffix(" elements"), *row] for mesh, row in table.items()]
    )


def _tip(found):
    table: dict = {}
    for quantity in ("clearance of the tip, normal to the casing", "motion of the tip by rotation"):
        for number in _rows(found, quantity):
            table.setdefault(number.at.split(", ")[0], []).append(f"{number.value:.2f}")
    heads = [f"{what}, {edge} edge [mm]" for what in ("clearance", "motion")
             for edge in ("leading", "trailing")]  # fmt: skip
    return page.table(["speed", *heads], [[speed, *row] for speed, row in table.items()])


def _families(found):
    table: dict = {}
    for number in _rows(found, "natural frequency"):
        where, family, diameters = number.at.split(", ")
        place = int(diameters.split()[0]), where
        table.setdefault(place, []).append(f"{number.value:.1f}")
    rows = [[h, *table[h, "at rest"], *table[h, where]] for h, where in table if where != "at rest"]
    heads = [f"{k} {where}" for where in ("at rest", "at speed") for k in range(1, 5)]
    return page.table(["diameters", *heads], rows)


def _crossings(found):
    rows = []
    for number in _rows(found, "speed of a crossing"):
        order, family, diameters = (words.split() for words in number.at.split(", "))
        rows.append([order[-1], family[-1], diameters[0], f"{number.value:.1f}",
                     f"{100 * number.value / (16_043 / 60):.1f} %"])  # fmt: skip
    heads = ["engine order", "family", "nodal diameters", "speed [Hz]", "of the design speed"]
    return page.table(heads, rows)


def _stress(found):
    """What CalculiX's displacements say of stresses at the design speed."""
    return page.table(
        ["at the design speed", "value"],
        [[n.quantity, f"{n.value:.3g} {n.unit}"] for n in found.values()
         if n.at.startswith("of the blade")],
    )  # fmt: skip


def _fans(found, columns):
    """Percentiles over the fans, where all columns {heading: (quantity, digits)} know them."""
    table: dict = {}
    for quantity, digits in columns.values():
        for number in _rows(found, quantity):
            table.setdefault(number.at, []).append(_interval(number, digits))
    rows = [
        [*reversed(at.removeprefix("percentile ").split(", ")), *cells]
        for at, cells in table.items()
        if len(cells) == len(columns)
    ]
    return page.table(["blades", "percentile", *columns], rows)


def _limits(found):
    """Shares of fans above limits, by where they run."""
    table: dict = {}
    for number in found.values():
        if number.quantity.startswith("share of fans above"):
            table.setdefault(number.at, {})[number.quantity] = _interval(number)
    heads = list(next(iter(table.values())))
    return page.table(["fans", *heads], [[at, *row.values()] for at, row in table.items()])


def _conclusions(found):
    """Rows: what is asked; columns: levels of mistuning."""
    quantities = (
        "median of A_nl/A_lin", "share of A_nl above A_lin", "rank correlation of A_nl and A_lin",
    )  # fmt: skip
    levels: list[str] = []
    rows = []
    for quantity in quantities:
        numbers = _rows(found, quantity)
        levels = levels or [number.at for number in numbers]
        rows.append([quantity, *map(_interval, numbers)])
    return page.table(["of the fans", *levels], rows)


def _coated(found):
    """Tuned fan by speed, before the rigid casing and the coating."""
    rigid = {n.at: n.value for n in _rows(found, "amplitude of the tuned fan in contact")}
    depth = {n.at: n.value for n in _rows(found, "worn depth of the tuned fan")}
    heads = ["speed", "rigid casing [mm]", "coating: largest amplitude [mm]", "worn depth [mm]"]
    rows = [
        [n.at, _shown(rigid.get(n.at)), _shown(n.value), f"{depth[n.at]:.3f}"]
        for n in _rows(found, "largest amplitude of the tuned fan on a coating")
    ]
    return page.table(heads, rows)


def _shown(value):
    return "" if value is None else f"{value:.2f}"


def _interval(number, digits=2):
    low, high = ("?" if x != x else f"{x:.{digits}f}" for x in (number.low, number.high))
    return f"{number.value:.{digits}f} ({low} to {high})"
