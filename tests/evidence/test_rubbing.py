"""The animation of a disk in its casing: its frames and its tips."""

import numpy as np
from PIL import Image

from evidence import rubbing
from hpcrub.commands import run as cli
from hpcrub.studies import open_result


def test_an_animation_has_its_frames_and_tips_that_rub_lie_on_the_casing(folder, monkeypatch):
    """Radial distances of tips and casing have one scale; the tip has moved around by a little."""
    (folder / "a.yaml").write_text(
        "study: time_response\noutput: a.h5\nspeeds: {from_hz: 34.45, to_hz: 34.45}\n"
        "history: {duration_s: 0.3}\ncasing: {n_bumps: 4}\n"
    )
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    monkeypatch.setattr(rubbing, "FRAMES", 12)
    assert rubbing.main(["a.h5"]) is None
    with Image.open("a_rubbing.gif") as moving:
        assert 9 < moving.n_frames <= 12  # equal neighbours are kept once, for longer
    film, found = rubbing.film(open_result("a.h5")), []
    for frame in range(12):
        casing, *blades, sparks, _ = film._func(frame)
        # no blade ends inside the disk, which would hide it
        assert min(np.hypot(*blade.get_xy().T).max() for blade in blades) > rubbing.HUB + 0.1
        around, radius = (f(*casing.get_xy().T[::-1]) for f in (np.arctan2, np.hypot))
        x, y = sparks.get_data()
        room = np.interp(np.arctan2(y, x), np.unwrap(around), radius, period=2 * np.pi)
        found += list(zip(np.hypot(x, y), room, strict=True))
    tips, casing = np.array(found).T
    assert len(tips) > 5
    np.testing.assert_allclose(tips, casing, atol=0.02)  # of a clearance drawn as 0.07
