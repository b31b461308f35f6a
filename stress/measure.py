"""``python -m stress.measure``: what docs/steady_state.md says, and its figure (ten minutes)."""

import re
from pathlib import Path

from stress import histories, monte_carlo, steady_state

DOCS = Path(__file__).parents[1] / "docs"
SAMPLES = 64  # of every level, contact
POOL = 20_000  # linear amplifications
REPETITIONS = 2000


def main():
    """Simulate, compare, write."""
    h = histories.simulate(SAMPLES, print)
    contact = steady_state.amplifications(h, steady_state.judge(h, steady_state.PAPER))
    populations = [
        ("linear", monte_carlo.linear_amplifications(POOL), (100, 500, 2000), REPETITIONS),
        ("contact", contact[-1], (40,), REPETITIONS),
    ]
    tables = {
        "tests": steady_state.table(h),
        "studies": monte_carlo.table(populations),
    }
    steady_state.draw(h, DOCS / "figures" / "steady_state.png")
    page = DOCS / "steady_state.md"
    text = page.read_text(encoding="utf-8")
    for name, table in tables.items():
        block = re.compile(f"(?<=<!-- {name} -->\n).*?(?=<!-- end of {name} -->)", re.DOTALL)
        text = block.sub(lambda _, table=table: table + "\n", text)
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
