"""How far a long program is and how long it will take, in whole lines that a log can bear."""

import time

from hpcrub.config.schema import Config
from hpcrub.ranks.progress import Progress


def followed(items, what, n_total=None, names=None):
    """Yield the items of one part of a program, and print how many of them are done.

    what: the part, as the line names it; n_total: how many items there are, if they have no length.
    names: what each item is called, for few, long items: a line goes before each of them.
    """
    n_total, shown = len(items) if n_total is None else n_total, Progress(Config())
    for n_done, item in enumerate(items, 1):
        if names:
            shown.say(f"{what}: {names[n_done - 1]}")
        yield item
        each = (time.monotonic() - shown.began) / n_done
        shown.part(what, n_done, n_total, each * (n_total - n_done))
