"""The reference disk and scene, through the same defaults as the input file."""

from functools import cache

from hpcrub.config.schema import Config
from hpcrub.studies.problem import build_problem


@cache
def reference_problem(n_modes=60):
    """study.Problem of the reference disk, four bumps, exact_modal with 20 µs."""
    return build_problem(
        Config.model_validate(
            {
                "reduction": {"n_modes": n_modes},
                "time": {"scheme": "exact_modal", "step_s": 2e-5},
            }
        )
    )


def reference_reduced():
    """ReducedModel of the reference disk."""
    return reference_problem().reduced


def reference_scene(**changes):
    """Scene of the reference study, with changes."""
    return reference_problem().scene._replace(**changes)
