"""The fan in contact: the studies of inputs/rotor67 on some ranks, their numbers and figures."""

from pathlib import Path

from evidence import pictures, program, rubbing
from evidence.page import ROOT
from evidence.reproduce.rows import above_linear, bounded, done, percentile, tuned_amplitudes
from evidence.rotor67.numbers import Number
from hpcrub.config.schema import load_runs
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.pairs import rank_correlation
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.studies import open_result

INPUTS = ROOT / "inputs" / "rotor67"
STUDIES = (
    "modes", "contact", "interaction_map", "percentiles", "half_damping", "coating", "motion",
)  # fmt: skip
FIGURES = {  # of the results to those of the page
    "modes_safe_diagram": "rotor67_safe",
    "contact": "rotor67_contact",
    "interaction_map": "rotor67_map",
    "coating_wear": "rotor67_wear",
    "motion_rubbing": "rotor67_rubbing",
}
SCALED = "percentiles", "half_damping", "coating"  # studies whose fans a scale makes fewer
FEWEST = 6  # fans of a level: with fewer, a median has no interval of 95 %
PERCENTILES = 1.0, 50.0, 99.0


def numbers(model: Path, scale: float, ranks: int, folder: Path, figures: Path) -> list[Number]:
    """Run all studies; figures go to a folder."""
    found = []
    for study in STUDIES:
        output = folder / f"{study}.h5"
        run(study, model, scale, ranks, output)
        if study == "motion":
            rubbing.draw(output)
        for name, figure in FIGURES.items():
            for drawn in folder.glob(f"{name}.*"):
                if name.startswith(study) and drawn.suffix in (".png", ".gif"):
                    pictures.keep(drawn, figures / f"{figure}{drawn.suffix}")
        with open_result(output) as file:
            if study == "contact":
                found += tuned_of(file, "amplitude", "amplitude of the tuned fan in contact")
            elif study == "percentiles":
                found += percentiles_of(file) + stresses_of(file) + conclusions_of(file)
            elif study == "half_damping":
                found += percentiles_of(file, " at half the damping")
            elif study == "coating":
                found += wear_of(file)
    return found


def run(study: str, model: Path, scale: float, ranks: int, output: Path) -> None:
    """Run a study of INPUTS, or go on with it. Raises CalledProcessError."""
    source = INPUTS / f"{study}.yaml"
    changes = ["--set", f"disk.model={model}"]
    if study in SCALED and scale < 1:
        samples = load_runs(str(source), [])[0].mistuning.samples
        few = max(FEWEST, round(scale * samples))
        changes += ["--set", f"mistuning.samples={few}", "--set", f"convergence.step={few}"]
    program.run(ranks, ROOT / "main.py", source, *changes, "--output", output, "--resume")


def tuned_of(file: ResultFile, name: str, what: str) -> list[Number]:
    """A displacement of the tuned fan at all speeds."""
    values = zip(file.config.speeds.values_hz, file.read(f"tuned/{name}_m"), strict=True)
    return [Number(what, f"{speed:g} Hz", 1e3 * value, "mm") for speed, value in values]


def percentiles_of(file: ResultFile, where: str = "") -> list[Number]:
    """Percentiles of both amplifications at all levels, with 95 % intervals; tuned repeats.

    where: ends the names of the numbers.
    """
    runs, (middle, *ends) = file.read("tuned/run_peaks_m").size, tuned_amplitudes(file)
    found = [
        Number(f"largest amplitude of the tuned fan{where}", f"{runs} runs", middle, "mm", *ends)
    ]
    for kind, name in (("A_nl", "amplification"), ("A_lin", "linear_amplification")):
        found += _percentiles(file, f"amplification {kind}{where}", name, "1")
    return found


def _percentiles(file, quantity, name, unit, times=1.0):
    """Percentiles of a dataset of samples at all levels, with 95 % intervals."""
    found = []
    for level, half_range in enumerate(file.config.mistuning.half_range_percent):
        for p in PERCENTILES:
            value, low, high = (times * x for x in percentile(file, level, p, name))
            at = f"percentile {p:g}, blades within {half_range:g} %"
            found.append(Number(quantity, at, value, unit, low, high))
    return found


def stresses_of(file: ResultFile, where: str = "") -> list[Number]:
    """Percentiles of a fan's largest stress, and the share of fans above the limit.

    Each stress is raised by Goodman's line for what rotation does at its place.
    """
    found = _percentiles(file, f"stress{where}", "peak_stress_pa", "MPa", 1e-6)
    limit = file.config.limits.stress_mpa
    for level, half_range in enumerate(file.config.mistuning.half_range_percent):
        peaks = 1e-6 * done(file, "peak_stress_pa", level)
        above = int((peaks > limit).sum())
        bounds = probability_interval(above, len(peaks), Z_95)
        at = f"blades within {half_range:g} %{where}"
        found.append(Number(f"share of fans above {limit:g} MPa", at, above / len(peaks), "1",
                            *bounds))  # fmt: skip
    return found


def conclusions_of(file: ResultFile) -> list[Number]:
    """What the paper concludes of amplifications, as numbers of these fans at every level.

    Median of A_nl/A_lin, share of fans with A_nl above A_lin, rank correlation of both, with their
    intervals, 95 %.
    """
    found = []
    for level, half_range in enumerate(file.config.mistuning.half_range_percent):
        names, at = ("amplification", "linear_amplification"), f"blades within {half_range:g} %"
        nonlinear, linear = (done(file, name, level) for name in names)
        middle, *ends = bounded(nonlinear / linear, 50.0)
        above, *ends_above = (0.01 * share for share in above_linear(file, level))
        r, *ends_r = rank_correlation(nonlinear, linear)
        found += [
            Number("median of A_nl/A_lin", at, middle, "1", *ends),
            Number("share of A_nl above A_lin", at, above, "1", *ends_above),
            Number("rank correlation of A_nl and A_lin", at, r, "1", *ends_r),
        ]
    return found


def wear_of(file: ResultFile) -> list[Number]:
    """Amplitude and depth of the tuned fan at all speeds; percentiles of both over the fans."""
    largest = "largest amplitude of the tuned fan on a coating"
    found = tuned_of(file, "largest_amplitude", largest)
    found += tuned_of(file, "worn_depth", "worn depth of the tuned fan")
    found += _percentiles(file, "largest amplitude on a coating", "peak_amplitude_m", "mm", 1e3)
    found += _percentiles(file, "largest worn depth", "deepest_m", "mm", 1e3)
    return found + stresses_of(file, " on a coating")
