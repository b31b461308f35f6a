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


MESH = "frequency of the blade alone"
TIP = "clearance of the tip, normal to the casing", "motion of the tip by rotation"
BENT = tuple(
    f"error of a bent blade's tip along the casing's normal, to {order} order"
    for order in ("first", "second")
)
CONCLUSIONS = (
    "median of A_nl/A_lin", "share of A_nl above A_lin", "rank correlation of A_nl and A_lin",
)  # fmt: skip


def write(found: dict) -> None:
    """Write the tables anew; found: Number by (quantity, at)."""
    edges = [f"{what}, {edge} edge [mm]" for what in ("clearance", "motion")
             for edge in ("leading", "trailing")]  # fmt: skip
    # families of a number of diameters, at rest and then at speed
    families = [f"{k} {where}" for where in ("at rest", "at speed") for k in range(1, 5)]
    limits = [q for q in dict.fromkeys(q for q, _ in found) if q.startswith("share of fans above")]
    levels = dict.fromkeys(number.at for number in _rows(found, *CONCLUSIONS))
    page.replace(
        PAGE,
        mesh=_table(["chord x span x thickness", *(f"mode {k} [Hz]" for k in range(1, 6))],
                    [(n.at.split(", ")[1].removesuffix(" elements"), f"{n.value:.1f}")
                     for n in _rows(found, MESH)]),
        tip=_table(["speed", *edges],
                   [(n.at.split(", ")[0], f"{n.value:.2f}") for n in _rows(found, *TIP)]),
        families=_table(["diameters", *families],
                        [(n.at.split(", ")[2].split()[0], f"{n.value:.1f}")
                         for n in _rows(found, "natural frequency")]),
        crossings=_crossings(found),
        # what CalculiX's displacements say of stresses at the design speed
        stress=_table(["at the design speed", "value"],
                      [(n.quantity, f"{n.value:.3g} {n.unit}") for n in found.values()
                       if n.at.startswith("of the blade")]),
        percentiles=_fans(found, PERCENTILES),
        # shares of fans above limits, by where they run
        limits=_table(["fans", *limits], [(n.at, _interval(n)) for n in _rows(found, *limits)]),
        damping=_fans(found, DAMPING),
        conclusions=_table(["of the fans", *levels],
                           [(n.quantity, _interval(n)) for n in _rows(found, *CONCLUSIONS)]),
        coated=_coated(found),
        bent=_table(["bent", "first order [mm]", "second order [mm]"],
                    [(n.at, f"{n.value:.3f}") for n in found.values() if n.quantity in BENT]),
        wear=_fans(found, WEAR),
    )  # fmt: skip


def _rows(found, *quantities):
    return [n for quantity in quantities for n in found.values() if n.quantity == quantity]


def _grouped(cells):
    """Rows of a table of cells (first column, text), in the order in which they begin."""
    rows: dict = {}
    for first, text in cells:
        rows.setdefault(first, []).append(text)
    return [[first, *texts] for first, texts in rows.items()]


def _table(heads, cells):
    return page.table(heads, _grouped(cells))


def _crossings(found):
    rows = []
    for number in _rows(found, "speed of a crossing"):
        order, family, diameters = (words.split() for words in number.at.split(", "))
        rows.append([order[-1], family[-1], diameters[0], f"{number.value:.1f}",
                     f"{100 * number.value / (16_043 / 60):.1f} %"])  # fmt: skip
    heads = ["engine order", "family", "nodal diameters", "speed [Hz]", "of the design speed"]
    return page.table(heads, rows)


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
