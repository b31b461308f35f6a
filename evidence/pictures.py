"""Pictures of the pages: small, and written again only when they show something else.

`python -m evidence.pictures results/x.png docs/figures/y.png` puts a picture there.
"""

import io
import shutil
import sys
from pathlib import Path

import numpy as np
from PIL import Image

COLOURS = 256  # of a PNG; a third of the bytes, and no difference to the eye


def keep(source, target):
    """Put a picture (a path or an open file) to a path, unless one that looks alike is there."""
    if Path(target).suffix != ".png":
        shutil.copy(source, target)
        return
    picture = Image.open(source).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    shown = np.asarray(picture.convert("RGB"))
    there = Image.open(target).convert("RGB") if Path(target).exists() else picture.resize((1, 1))
    if not np.array_equal(np.asarray(there), shown):
        picture.save(target, optimize=True)


def save(figure, target, **how):
    """Draw a Matplotlib figure to a path with `keep`; how: options of `savefig`."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", **how)
    keep(drawn, target)


if __name__ == "__main__":
    keep(*sys.argv[1:])
