"""What can be computed: every study is a module with a `STUDY`, and one line in `STUDIES`.

In: a `Config`. Out: a result file that is laid out, then filled by the ranks. Imports all rooms but
`plot` and `commands`. `docs/developing_a_study.md` shows how to add a study.
"""

import difflib

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.studies import (
    branches,
    casing,
    contact,
    cross,
    damping,
    energy,
    interaction_map,
    linear,
    modal,
    time_response,
)
from hpcrub.studies.study import Study

STUDIES: dict[str, Study] = {
    module.STUDY.name: module.STUDY
    for module in (
        contact,
        modal,
        casing,
        linear,
        time_response,
        interaction_map,
        energy,
        cross,
        damping,
        branches,
    )
}


def find(config: Config) -> Study:
    """The study of a configuration. Raises InputError when there is none of that name."""
    if config.study not in STUDIES:
        near = difflib.get_close_matches(config.study, STUDIES, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise InputError(f"study: {config.study!r} is not one of {', '.join(STUDIES)}{hint}")
    return STUDIES[config.study]


def check(config: Config) -> Config:
    """The configuration itself, if its keys fit its study. Raises InputError."""
    problems = list(find(config).all_problems(config))
    if problems:
        more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        raise InputError(problems[0] + more)
    return config
