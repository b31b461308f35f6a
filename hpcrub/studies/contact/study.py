"""The contact study: what its result file holds, what it says of itself, who else reads it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError
from hpcrub.results.layout import DONE, PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.runs import result_files
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Run, Study
from hpcrub.runs.verdict import is_usable
from hpcrub.setup.disks import sigma_of
from hpcrub.setup.plausibility import steady_problems
from hpcrub.setup.problem import build_problem
from hpcrub.statistics.percentiles import first_converged, judged_error
from hpcrub.studies import worn
from hpcrub.studies.contact.file import read_trust
from hpcrub.studies.contact.layout import MOST_LINES, SCALES, kinds, layout
from hpcrub.studies.contact.layout import (
    MOST_LINES,
    SCALES,
    amplitude_in_words,
    kinds,
    layout,
)
