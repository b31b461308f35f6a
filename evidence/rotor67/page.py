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


def _grouped(cells):
    """Rows of a table of cells (first column, text), in the order in which they begin."""
    rows: dict = {}
    for first, text in cells:
        rows.setdefault(first, []).append(text)
    return [[first, *texts] for first, texts in rows.items()]


def _meshes(found):
    alone = _rows(found, "frequency of the blade alone")
    rows = _grouped(
        (n.at.split(", ")[1].removesuffix(" elements"), f"{n.value:.1f}") for n in alone
    )
    heads = [f"mode {k} [Hz]" for k in range(1, len(rows[-1]))]
    return page.table(["chord x span x thickness", *heads], rows)


def _tip(found):
    quantities = "clearance of the tip, normal to the casing", "motion of the tip by rotation"
    both = [number for quantity in quantities for number in _rows(found, quantity)]
    heads = [f"{what}, {edge} edge [mm]" for what in ("clearance", "motion")
             for edge in ("leading", "trailing")]  # fmt: skip
    rows = _grouped((n.at.split(", ")[0], f"{n.value:.2f}") for n in both)
    return page.table(["speed", *heads], rows)


def _families(found):
    # families of a number of diameters, at rest and then at speed
    numbers = _rows(found, "natural frequency")
    rows = _grouped((n.at.split(", ")[2].split()[0], f"{n.value:.1f}") for n in numbers)
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
    rows = _grouped(
        (number.at, _interval(number, digits))
        for quantity, digits in columns.values()
        for number in _rows(found, quantity)
    )
    rows = [
        [*reversed(at.removeprefix("percentile ").split(", ")), *cells]
        for at, *cells in rows
        if len(cells) == len(columns)
    ]
    return page.table(["blades", "percentile", *columns], rows)


def _limits(found):
    """Shares of fans above limits, by where they run."""
    shares = [n for n in found.values() if n.quantity.startswith("share of fans above")]
    heads = dict.fromkeys(number.quantity for number in shares)
    return page.table(["fans", *heads], _grouped((n.at, _interval(n)) for n in shares))


def _conclusions(found):
    """Rows: what is asked; columns: levels of mistuning."""
    quantities = (
        "median of A_nl/A_lin", "share of A_nl above A_lin", "rank correlation of A_nl and A_lin",
    )  # fmt: skip
    asked = [number for quantity in quantities for number in _rows(found, quantity)]
    levels = dict.fromkeys(number.at for number in asked)
    return page.table(["of the fans", *levels], _grouped((n.quantity, _interval(n)) for n in asked))


def _coated(found):
    """Tuned fan by speed, before the rigid casing and the coating."""
    rigid = {n.at: f"{n.value:.2f}" for n in _rows(found, "amplitude of the tuned fan in contact")}
    depth = {n.at: f"{n.value:.3f}" for n in _rows(found, "worn depth of the tuned fan")}
    heads = ["speed", "rigid casing [mm]", "coating: largest amplitude [mm]", "worn depth [mm]"]
    rows = [
        [n.at, rigid.get(n.at, ""), f"{n.value:.2f}", depth[n.at]]
        for n in _rows(found, "largest amplitude of the tuned fan on a coating")
    ]
    return page.table(heads, rows)


def _interval(number, digits=2):
    low, high = ("?" if x != x else f"{x:.{digits}f}" for x in (number.low, number.high))
    return f"{number.value:.{digits}f} ({low} to {high})"
