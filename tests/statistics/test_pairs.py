"""Pairs of numbers. Truth: Wilson's interval and Spearman's correlation as scipy has them."""

import numpy as np
import pytest
from scipy import stats

from hpcrub.statistics import pairs


@pytest.mark.parametrize(("above", "n"), [(0, 6), (4, 6), (6, 6), (190, 200)])
def test_the_interval_of_a_share_is_wilsons(above, n):
    interval = stats.binomtest(above, n).proportion_ci(method="wilson")
    assert pairs.share_interval(above, n) == pytest.approx(tuple(interval))


def test_pairs_on_a_line_have_no_density():
    x = np.linspace(1.0, 2.0, 20)
    assert pairs.density(x, 2.0 * x)[2] is None


def test_density_lies_where_the_samples_are():
    """Its mean and its moments about it, for skewed A_nl, are those of samples and kernel."""
    random = np.random.default_rng(2)
    linear = random.normal(1.2, 0.05, 300)
    contact = linear + random.exponential(0.1, 300)
    x, y, weight = pairs.density(contact, linear)
    x, weight = x[:, None], weight / weight.sum()
    mean = np.sum(weight * x), np.sum(weight * y)
    assert mean == pytest.approx([contact.mean(), linear.mean()], rel=1e-3)
    spread = [np.sum(weight * a * b) for a, b in ((x - mean[0], x - mean[0]),
              (x - mean[0], y - mean[1]), (y - mean[1], y - mean[1]))]  # fmt: skip
    wider = np.cov(contact, linear)[[0, 0, 1], [0, 1, 1]] * (1 + 300 ** (-2 / 6))  # by the kernel
    assert spread == pytest.approx(wider, rel=0.02)


def test_rank_interval_covers_as_often_as_it_says():
    random = np.random.default_rng(3)
    true = 6 / np.pi * np.arcsin(0.6 / 2)  # Spearman's correlation of normal pairs
    hits = 0
    for _ in range(400):
        x, y = random.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], 80).T
        found, low, high = pairs.rank_correlation(x, y)
        assert found == pytest.approx(stats.spearmanr(x, y).statistic)
        hits += low <= true <= high
    assert 0.91 < hits / 400 < 0.985
