"""Contact beside linear amplification, sample by sample, of an earlier contact study."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.stats import gaussian_kde, norm, rankdata

from hpcrub.config.schema import Config
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.studies.sources import amplifications, complete
from hpcrub.studies.study import Poll, Study, Values

N_GRID = 80  # points of the density along each axis
_LEVEL, _BOUNDS = ("level",), ("level", "bound")
LAYOUT = (
    Dataset("sigma", _LEVEL, "1", "standard deviation of a blade's stiffness"),
    Dataset("contact", ("level", "sample"), "1", "contact amplification A_nl; NaN: none"),
    Dataset("linear", ("level", "sample"), "1", "linear amplification A_lin; NaN: none"),
    Dataset("share", _LEVEL, "1", "share of the samples with A_nl > A_lin"),
    Dataset("share_interval", _BOUNDS, "1", "its 95 % interval (Wilson)"),
    Dataset("rank_correlation", _LEVEL, "1", "Spearman's rank correlation of A_nl and A_lin"),
    Dataset("rank_correlation_interval", _BOUNDS, "1", "its 95 % interval (Bonett and Wright)"),
    Dataset("grid_contact", ("level", "x"), "1", "A_nl at which the density is given"),
    Dataset("grid_linear", ("level", "y"), "1", "A_lin at which the density is given"),
    Dataset("density", ("level", "x", "y"), "1", "density of the samples, largest is 1"),
)
SCALES = {"level": "sigma"}


def _source(config):
    return config.sources[0]


def sizes(config: Config) -> dict[str, int]:
    """Length of every dimension that the source does not tell."""
    return {"bound": 2, "x": N_GRID, "y": N_GRID}


def source_sizes(config: Config) -> dict[str, int]:
    """Length of the others, as in the source."""
    file = complete(_source(config))
    n_levels, n_samples = file.status().shape
    file.close()
    return {"level": n_levels, "sample": n_samples}


def constants(config: Config) -> dict[str, Any]:
    """The levels of the source."""
    file = complete(_source(config))
    sigma = file.read("sigma")
    file.close()
    return {"sigma": sigma}


def prepare(config: Config) -> Any:
    """Amplifications of the source. Raises InputError when it is not complete."""
    return amplifications(_source(config))


def compute(config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
    """Shares, correlations and densities of every level."""
    yield "contact", (), problem[0]
    yield "linear", (), problem[1]
    for level, (contact, linear) in enumerate(zip(*problem, strict=True)):
        known = np.isfinite(contact) & np.isfinite(linear)
        contact, linear, n = contact[known], linear[known], int(known.sum())
        above = int(np.count_nonzero(contact > linear))
        yield "share", level, above / n if n else np.nan
        yield "share_interval", level, share_interval(above, n)
        if n > 3:
            r = np.corrcoef(rankdata(contact), rankdata(linear))[0, 1]
            yield "rank_correlation", level, r
            yield "rank_correlation_interval", level, rank_interval(r, n)
            yield from _density(level, contact, linear)


def share_interval(above: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Wilson's interval of a share, above of n."""
    if n == 0:
        return np.nan, np.nan
    z = norm.ppf(0.5 + confidence / 2)
    p, centre = above / n, (above + z * z / 2) / (n + z * z)
    half = z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return max(0.0, centre - half), min(1.0, centre + half)


def rank_interval(r: float, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of Spearman's correlation r of n pairs (Bonett and Wright 2000)."""
    z = norm.ppf(0.5 + confidence / 2)
    half = z * np.sqrt((1 + r * r / 2) / (n - 3))
    at = np.arctanh(np.clip(r, -1 + 1e-12, 1 - 1e-12))
    return np.tanh(at - half), np.tanh(at + half)


def _density(level, contact, linear):
    grids = []
    for values in (contact, linear):
        # three standard deviations of the kernel (by Scott's rule): no contour is cut off
        margin = 3.0 * values.std() * len(values) ** (-1 / 6) + 1e-6
        grids.append(np.linspace(values.min() - margin, values.max() + margin, N_GRID))
    yield "grid_contact", level, grids[0]
    yield "grid_linear", level, grids[1]
    pairs = np.vstack([contact, linear])
    if np.linalg.matrix_rank(np.cov(pairs)) == 2:
        mesh = np.array(np.meshgrid(*grids, indexing="ij")).reshape(2, -1)
        density = gaussian_kde(pairs)(mesh).reshape(N_GRID, N_GRID)
        yield "density", level, density / density.max()


def report(file: ResultFile) -> Iterator[str]:
    """Share and correlation of every level."""
    for level, sigma in enumerate(file.read("sigma")):
        low, high = 100 * file.read("share_interval", level)
        yield (
            f"sigma = {100 * sigma:.2f} %: A_nl > A_lin for "
            f"{100 * file.read('share', level):.1f} % of the samples [{low:.1f}, {high:.1f}]"
        )
        low, high = file.read("rank_correlation_interval", level)
        r = file.read("rank_correlation", level)
        yield f"    rank correlation {r:.3f} [{low:.3f}, {high:.3f}]"


STUDY = Study(
    name="cross",
    figures="15",
    what="contact beside linear amplification, sample by sample",
    layout=lambda config: LAYOUT,
    scales=SCALES,
    sizes=sizes,
    constants=constants,
    source_sizes=source_sizes,
    prepare=prepare,
    n_sources=1,
    has_disk=False,
    compute=compute,
    report=report,
)
