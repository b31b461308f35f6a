"""Number of samples of a study that asks for a probability, where the input gives none."""

from typing import Any

from hpcrub.statistics.rare import Goal, n_needed

SUPPOSED = 1e-3  # probability that is assumed before anything is known
ENOUGH = 3.0  # a probability so many times smaller than the target can be told from it


def of_question(config: Any) -> int | None:
    """Samples that the question of a threshold or rare study needs; None for any other study."""
    if config.study == "threshold":
        target = config.threshold.probability
        return n_needed(Goal(None, target), target / ENOUGH)
    if config.study == "rare" and (goal := goal_of(config)) != Goal(None, None):
        return n_needed(goal, supposed(config))
    return None


def goal_of(config: Any) -> Goal:
    """Goal at which a rare study ends."""
    return Goal(config.limits.probability_error, config.limits.probability_below)


def supposed(config: Any) -> float:
    """Probability that a rare study is assumed to find."""
    below = config.limits.probability_below
    return SUPPOSED if below is None else below / ENOUGH
