"""The contact study: its result file, its report, and how other studies open the file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.config import study_keys
from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError
from hpcrub.ranks.parallel import Team
from hpcrub.results import samples
from hpcrub.results.layout import DONE, PENDING, Dataset
from hpcrub.results.samples import n_counted
from hpcrub.results.storage import ResultFile
from hpcrub.runs import result_files
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Run, Study
from hpcrub.setup.disks import sigma_of
from hpcrub.statistics.percentiles import first_converged, judged_error
from hpcrub.studies.contact import findings, layout, second_order, summary
from hpcrub.studies.contact.amplification import n_runs
from hpcrub.studies.contact.layout import is_untouched
from hpcrub.studies.contact.limits import limit_lines
from hpcrub.studies.contact.monte_carlo import MonteCarlo

COST_OF_CHECKS = 5  # of a checked disk: half the step takes 2, four times the time 2 to 3
# keys and sections in which a study may differ from the contact study that it starts from
APART = (
    *("study", "sources", "mistuning.", "convergence.", "limits."),
    *(f"{name}." for name, field in Config.model_fields.items()
      if getattr(field.annotation, "__module__", "") == study_keys.__name__),
)  # fmt: skip


class Contact(Study):
    """Frequency responses in contact of many samples."""

    name = "contact"
    what = "frequency response in contact, Monte-Carlo percentiles"
    sections = ("part",)
    scales = {
        "level": "half_range",
        "block": samples.SEEN,
        "mode": "tuned/mode",
        "run": "tuned/run",
    }
    unit = "samples"
    integrates = True
    to_second_order = True
    job = MonteCarlo
    of_tasks = False
    verdict = staticmethod(findings.verdict)
    answer = staticmethod(summary.answer)

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets of the result file."""
        return tuple(layout.layout(config))

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {
            "percentile": len(config.convergence.percentiles),
            "run": config.mistuning.tuned_runs,
            "line": layout.MOST_LINES,
            "friction": 2,
            "bent": second_order.n_disks(config),
            "block": len(config.samples) // config.convergence.step,
        }

    def constants(self, config: Config) -> dict[str, Any]:
        """Levels and sample numbers, known before any computation."""
        n_blocks = self.sizes(config)["block"]
        return {
            "half_range": config.mistuning.half_range[list(config.levels)],
            "sigma": sigma_of(config),
            "sample": np.array(config.samples),
            samples.SEEN: config.convergence.step * np.arange(1, n_blocks + 1),
        }

    def cost(self, config: Config) -> Cost:
        """Cost of every disk at every speed, with those of some disks that are checked."""
        n_disks = len(config.levels) * len(config.samples) + n_runs(config)
        most = config.mistuning.checked_samples
        checked = 1 + sum(n < most for n in config.samples) if most else 0
        bent = second_order.cost(config, second_order.n_disks(config))
        return Cost(n_disks + COST_OF_CHECKS * checked + bent, disks=n_disks)

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        if config.engine_order is None:
            yield (
                "forcing.engine_order: a casing without equal bumps does not say how many periods "
                "the load of the linear response has; give their number"
            )

    def is_enough(self, file: ResultFile) -> bool:
        """Whether a file without all its samples has converged, where that ends the study."""
        convergence = file.config.convergence
        if not convergence.stop_when_converged:
            return False
        names = "convergence_error", "percentile_low", "percentile_high"
        known = {name: file.read(layout.AMPLIFICATION.dataset(name)) for name in names}
        error = judged_error(convergence.criterion, known)
        return first_converged(error, convergence.target_error) is not None

    def has_tuned(self, file: ResultFile) -> bool:
        """Whether the tuned disk is complete; infinite: it flutters in air."""
        return not np.isnan(file.read("tuned/linear_amplitude_m"))

    def complete(self, run: Run, file: ResultFile) -> None:
        """Write the statistics of all samples."""
        MonteCarlo(run, Team(), None, file).update_statistics()

    def report(self, file: ResultFile) -> Iterator[str]:
        """One line: peaks of the tuned disk and at the widest level, amplifications, verdict."""
        if is_untouched(file):
            yield findings.NO_CONTACT
            return
        quantity = layout.AMPLITUDES[layout.amplitude(file.config)]
        text = f"{quantity}: tuned {1e3 * file.read('tuned/reference_amplitude_m'):.2f} mm"
        where = -1, slice(n_counted(file))
        done = file.status[where] == DONE
        if not done.any():
            yield f"{text}, no sample has a result"
            return
        at = file.config.convergence.percentiles if np.count_nonzero(done) > 1 else (50.0,)
        peaks = np.percentile(1e3 * file.read("samples/peak_amplitude_m", where)[done], at)
        text += f", mistuned {' / '.join(f'{peak:.2f}' for peak in peaks)} mm"
        if len(at) > 1:
            text += f" (percentiles {'/'.join(f'{p:g}' for p in at)})"
        verdict = findings.verdict(file)
        if verdict.usable:
            ratios = np.percentile(file.read("samples/amplification", where)[done], at)
            text += f", A_nl {' / '.join(f'{ratio:.3f}' for ratio in ratios)}"
        yield f"{text}; {verdict.words}"

    def conclusion(self, file: ResultFile, usable: bool) -> list[str]:
        """The probabilities of exceeding the limits, if there are limits; else the report."""
        limited = [] if is_untouched(file) else list(limit_lines(file, usable))
        return limited or list(self.report(file))


STUDY = Contact()


def open_contact(path: str | Path) -> ResultFile:
    """Open the file of a contact study, complete or not. Raises InputError for any other file."""

    def check(file: ResultFile) -> None:
        if file.config.study != STUDY.name:
            raise InputError(f"{path} is of the study {file.config.study}, not contact")
        result_files.check(file, Run(STUDY, file.config))

    return ResultFile(path, check=check)


def require_complete(file: ResultFile, config: Config, apart: tuple[str, ...] = APART) -> None:
    """Raise InputError unless an open contact study is complete, with the physics of `config`.

    apart: begins of keys in which both may differ.
    """
    path = file.path
    if file.config.is_part:
        raise InputError(f"sources: {path} is a part; merge all parts (hpcrub merge)")
    n_pending = int(np.count_nonzero(file.status == PENDING))
    if n_pending and not file.config.convergence.stop_when_converged:
        raise InputError(f"sources: {path} still lacks {n_pending} samples; --resume its study")
    if other := [d for d in differences(file.config, config) if not d.startswith(apart)]:
        raise InputError(f"sources: {path} has {'; '.join(other)}")
