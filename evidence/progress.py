"""How far a long program is and how long it will take, in whole lines that a log can bear."""

import time

from hpcrub.ranks.progress import INTERVAL, SHARE, duration


def followed(items, what, n_total=None, names=None):
    """Yield the items of one part of a program, and print how many of them are done.

    what: the part, as the line names it; n_total: how many items there are, if they have no length.
    names: what each item is called. They are for few, long items: a line goes before each of them.
    Without names there is a line when the part begins, when it ends, and every few seconds between.
    """
    n_total = len(items) if n_total is None else n_total
    began = shown = time.monotonic()
    print(_line(what, 0, n_total, 0.0, names), flush=True)
    for n_done, item in enumerate(items, 1):
        yield item
        now = time.monotonic()
        due = now - shown > max(INTERVAL, SHARE * (now - began))
        if names or due or n_done == n_total:
            shown = now
            print(_line(what, n_done, n_total, now - began, names), flush=True)


def _line(what, n_done, n_total, seconds, names):
    text = f"{what}: {n_done} of {n_total} done"
    if n_done:
        text += f" in {duration(seconds)}"
    if 0 < n_done < n_total:
        text += f", about {duration(seconds / n_done * (n_total - n_done))} left"
    return text + (f"; next: {names[n_done]}" if names and n_done < n_total else "")
