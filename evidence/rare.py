"""Double sampling and extrapolations held against brute force: python -m evidence.rare FOLDER.

1. Contact: full results and first looks of 20,000 planar disks at 16 speeds; from these, studies
   are drawn again and again, with the cost of a full result as it is and as at 41 speeds.
2. Linear amplification of 1,000,000 disks: what distributions that are fitted to 1,000 of them say
   of the values that one of 1,000 and one of 10,000 exceeds.

What is computed is kept in FOLDER, block by block. 70 minutes on one core.
"""

import argparse
from pathlib import Path

import numpy as np

from evidence.progress import followed
from hpcrub.config.schema import Config
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_problem
from hpcrub.statistics.rare import Goal, Rule, count, estimate, extrapolated, n_needed, plan
from hpcrub.studies.contact.amplification import linear_amplitude
from hpcrub.studies.rare import GROWTH, PILOT, early_time

N_CONTACT, N_LINEAR, STUDIES, BLOCK = 20_000, 1_000_000, 40, 250
MOST = 400_000  # disks of a study


def contact(samples):
    """Full and early amplitudes [m], and simulated times of full ones [s], of a range (n, 3, S)."""
    keys = {"from_hz": 33.7, "to_hz": 35.2, "step_hz": 0.1}
    config = Config(speeds=keys, mistuning={"half_range_percent": [4], "samples": samples.stop})
    problem, speeds = build_problem(config), config.speeds.values_hz
    end, steady = early_time(config), problem.scene.steady
    early = problem.scene._replace(steady=steady._replace(first_check=end, max_time=end))
    found = []
    for sample in samples:
        modes = modes_of(config, problem, deviation(config, 0, sample))
        full = run_sweep(modes, problem.scene, speeds)
        found.append((full.amplitude, run_sweep(modes, early, speeds).amplitude, full.time))
    return np.array(found)


def linear(samples):
    """Linear amplitudes of a range of disks (n,) [m]."""
    config = Config(mistuning={"half_range_percent": [4], "samples": samples.stop})
    problem = build_problem(config)
    disks = (modes_of(config, problem, deviation(config, 0, sample)) for sample in samples)
    return np.array([linear_amplitude(config, problem, modes) for modes in disks])


def kept(path, compute, n, block):
    """Results of n disks, those computed before and the others now, which are kept block by block.

    compute: samples to an array, a row for each.
    """
    parts = [np.load(path)] if path.exists() else []
    first = sum(map(len, parts))
    for start in followed(range(first, n, block), f"{path.stem}, blocks of {block:,} disks"):
        parts.append(compute(range(start, min(start + block, n))))
        np.save(path, np.concatenate(parts))
    return np.concatenate(parts)[:n]


def study(look, severity, costs, goal, rng):
    """One study of disks drawn from a population: n, estimate, disks in full, cost over plain."""
    order, drawn = rng.integers(0, len(look), MOST), rng.uniform(size=MOST)
    look, severity, inclusion, rule = look[order], severity[order], np.ones(PILOT), Rule()
    n_looks = PILOT
    while True:
        n = len(inclusion)
        known = np.where(drawn[:n] < inclusion, severity[:n], np.nan)
        counts = count(known > 1.0, inclusion)
        if goal.is_met(counts):
            break
        if rule != Rule() or n == PILOT:
            rule = plan(look[:n], known, np.zeros(n, dtype=bool), inclusion, costs, goal).rule
        more = rule.inclusion(look[n : int(np.ceil(GROWTH * n))])
        inclusion = np.concatenate([inclusion, more])
        n_looks += len(more) * (rule != Rule())
    found = estimate(counts)
    half = (found[2] - found[1]) / 2.0 / found[0]
    plain = n_needed(Goal(half, None), found[0], found[0], 1.0) * costs[1]
    cost = n_looks * costs[0] + np.isfinite(known).sum() * costs[1]
    return n, *found, np.isfinite(known).sum(), cost / plain


def contact_table(full, early, time):
    """Rows on bias, coverage and cost of studies of the contact disks."""
    rng, size = np.random.default_rng(0), full.max(axis=1)
    yield (
        "| P | speeds looked at | a full result costs | mean estimate / P | intervals that hold P "
        "| disks in full of all | cost over plain |"
    )
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for chance in (0.05, 0.02, 0.005, 0.001):
        limit = np.sort(size)[-int(chance * len(size)) - 1]
        truth = (size > limit).mean()
        for speeds in (np.arange(16), np.arange(1, 16, 2)):
            look = early[:, speeds].max(axis=1) / limit
            for words, times in (("16 speeds", 1.0), ("as 41 speeds", 41 / 16)):
                costs = 0.4 * len(speeds), times * time.sum(axis=1).mean()
                runs = [
                    study(look, size / limit, costs, Goal(0.3, None), rng) for _ in range(STUDIES)
                ]
                n, mean, low, high, n_full, cost = np.array(runs).T
                held = ((low <= truth) & (truth <= high)).mean()
                yield (
                    f"| {truth:g} | {len(speeds)} | {words} | {mean.mean() / truth:.3f} ± "
                    f"{mean.std() / truth / np.sqrt(STUDIES):.3f} | {100 * held:.0f} % | "
                    f"{n_full.sum() / n.sum():.2f} | {np.mean(cost):.2f} |"
                )


def linear_table(size):
    """Rows on extrapolations of linear amplitudes."""
    rng, chances = np.random.default_rng(0), (1e-3, 1e-4)
    at = np.quantile(size, 1.0 - np.array(chances))
    parts = [rng.choice(size, 1000) for _ in range(100)]
    found = [extrapolated(part, np.ones(1000), at, runs=1) for part in parts]
    yield "| distribution fitted to 1,000 disks | said of P = 0.001 | said of P = 0.0001 |"
    yield "| --- | --- | --- |"
    for name in found[0]:
        ends = np.percentile([one[name][1] for one in found], [5, 50, 95], axis=0).T
        cells = (f"{m:.1e} ({a:.1e} to {b:.1e})" for a, m, b in ends)
        yield f"| {name} | {' | '.join(cells)} |"


def main():
    """Compute what FOLDER lacks, and print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="where disks are kept")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    found = kept(folder / "contact.npy", contact, N_CONTACT, BLOCK)
    print("\n".join(contact_table(*found.transpose(1, 0, 2))))
    print("\n".join(linear_table(kept(folder / "linear.npy", linear, N_LINEAR, 40 * BLOCK))))


if __name__ == "__main__":
    main()
