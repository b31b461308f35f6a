"""Every study in one place. `STUDIES` names them; each is a module with the same few members.

- LAYOUT, SCALES: datasets of its result file, and which of them give a dimension its values
- sizes(config): length of every dimension, as far as the configuration tells it
- source_sizes(config): of the others, which `cross` and `damping` have from their sources
- constants(config): {dataset: values} known before any computation
- prepare(config): what every rank needs, made once on rank 0

and, all but `contact`, whose samples have an order and a statistic of their own (`hpcrub.study`),

- KERNEL: whether it marches in time
- n_tasks(config): number of independent tasks
- compute(problem, task, poll): [(dataset, where, values)] of one task
- report(file): lines about the results
- cost(config): time steps of all its speeds together

`tasks.TaskStudy` hands the tasks to the ranks, writes what they compute, and resumes.
"""

from importlib import import_module
from typing import NamedTuple

from hpcrub.results.layout import MOST_PROGRAMS, PROGRAMS, Dataset, computed_by

STATUS = Dataset("status", ("task",), "1", "tasks: 0 pending, 1 done", "u1")


class Entry(NamedTuple):
    """One line of the list of studies, for people."""

    module: str
    figures: str  # of the paper
    what: str
    has_sources: bool = False
    has_disk: bool = True  # of its own


STUDIES = {
    "contact": Entry(
        "contact", "7 to 13", "frequency response in contact, Monte-Carlo percentiles"
    ),
    "modal": Entry("modal", "1, 2", "the disk, its mode shapes, SAFE diagram"),
    "casing": Entry("casing", "1, 3", "casing, clearance and bumps", has_disk=False),
    "linear": Entry("linear", "4", "linear amplification, percentiles over σ and n_d"),
    "time_response": Entry("time_response", "5", "one simulation in full"),
    "interaction_map": Entry("interaction_map", "6", "spectra over a wide range of speeds"),
    "energy": Entry("energy", "14", "amplification of the blades' strain energy", True),
    "cross": Entry(
        "cross", "15", "contact beside linear amplification, sample by sample", True, False
    ),
    "damping": Entry(
        "damping", "16", "percentiles of contact studies with different damping", True, False
    ),
    "branches": Entry("branches", "17", "coexisting stable motions, from several initial states"),
}


def find(config):
    """The module of a configuration's study."""
    return import_module(f"hpcrub.studies.{STUDIES[config.study].module}")


def is_tasks(config):
    """Whether the study is a list of independent tasks."""
    return config.study != "contact"


def layout(config):
    """Datasets of the result file, the index scales of its dimensions aside."""
    if is_tasks(config):
        own = (*find(config).LAYOUT, computed_by("computed_by", ("task",)), STATUS)
    else:
        own = find(config).LAYOUT
    return (*own, PROGRAMS)


def scales(config):
    """{dimension: name of its scale}; {group}: a scale of its own in every group."""
    dimensions = {d: d for line in layout(config) for d in line.dimensions}
    return dimensions | find(config).SCALES


def sizes(config):
    """Length of every dimension of the layout; for this it may have to look into the sources."""
    module = find(config)
    found = module.source_sizes(config) if hasattr(module, "source_sizes") else {}
    return known_sizes(config) | found


def known_sizes(config):
    """Length of every dimension that the configuration alone tells."""
    module = find(config)
    tasks = {"task": module.n_tasks(config)} if is_tasks(config) else {}
    return module.sizes(config) | tasks | {"program": MOST_PROGRAMS}


def fingerprints(config):
    """{path: hexadecimal digits} of what the study has from its sources."""
    if not STUDIES[config.study].has_sources:
        return {}
    fingerprint = import_module("hpcrub.studies.sources").fingerprint
    return {path: fingerprint(path) for path in config.sources}
