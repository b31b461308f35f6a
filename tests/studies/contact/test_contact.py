"""The study on one rank, in this process: what it computes, what it stores, what it refuses."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from hpcrub.commands import run as cli
from hpcrub.contact import status
from hpcrub.errors import InputError
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import sweep
from hpcrub.response.sweep import SweepResult
from hpcrub.results import samples
from hpcrub.results.layout import DONE, FAILED
from hpcrub.setup import disks
from hpcrub.setup import problem as study
from hpcrub.studies import energy, open_result
from hpcrub.studies.contact import STUDY, amplification, findings, survey
from hpcrub.studies.contact import layout as contact_file
from hpcrub.studies.contact.layout import AMPLIFICATION, LINEAR
from hpcrub.studies.contact.summary import interval_table, level_table, point_lines
from tests.program import TINY, contents, datasets, error_lines, load, run_here


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Folder of a finished tiny study."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "tiny.yaml").write_text(TINY + "output: results/tiny.h5\n", encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert cli.main(["tiny.yaml"]) == 0
    return folder


@pytest.fixture
def file(finished):
    """Its open result file."""
    with open_result(finished / "results/tiny.h5") as file:
        yield file


@pytest.fixture
def copied(finished, folder):
    """The working folder, with a copy of all that."""
    shutil.copytree(finished, folder, dirs_exist_ok=True)
    return folder


def test_a_study_leaves_its_file_figure_and_log(finished):
    names = ["tiny.h5", "tiny.png", "tiny.runs.jsonl"]
    assert sorted(p.name for p in (finished / "results").iterdir()) == names


def test_amplifications_are_peaks_over_the_reference(file):
    assert (file.status == DONE).all()
    peaks = file.read("samples/amplitude_m").max(axis=2)
    np.testing.assert_array_equal(file.read("samples/peak_amplitude_m"), peaks)
    reference, runs = file.read("tuned/reference_amplitude_m"), file.read("tuned/run_peaks_m")
    assert (reference, runs[0]) == (np.sort(runs)[4], file.read("tuned/peak_amplitude_m"))
    np.testing.assert_array_equal(file.read("samples/amplification"), peaks / reference)


def test_the_summary_has_the_percentiles_of_every_level(file):
    columns = cells(interval_table(file, [AMPLIFICATION, LINEAR]))
    for level in range(2):
        for column, name in ((2, "amplification"), (4, "linear_amplification")):
            percentiles = np.percentile(file.read(f"samples/{name}", level), [1, 50, 99])
            words = columns[column][3 * level :][:3]
            assert [float(word) for word in words] == pytest.approx(percentiles, abs=5.1e-4)


def test_without_mistuning_nothing_is_amplified(tiny, folder):
    equal = "mistuning.half_range_percent=[0]", "mistuning.reference=symmetric"
    assert run_here(tiny, *(f"--set={key}" for key in equal)) == 0
    with open_result("results/tiny.h5") as file:
        peak = file.read("tuned/peak_amplitude_m")
        assert (file.read("samples/peak_amplitude_m") == peak).all()  # the same bits
        expected = peak / file.read("tuned/reference_amplitude_m")
        assert (file.read("samples/amplification") == expected).all()
        assert (file.read("samples/linear_amplification") == 1.0).all()


def cells(table):
    return [list(column.cells) for column in table.columns]


def test_failed_points_are_told_in_words(copied):
    file = open_result("results/tiny.h5", mode="r+")
    most = max(file.read("samples/max_sweeps").max(), file.read("tuned/max_sweeps").max())
    assert 1 < most < 50
    said = list(point_lines(survey.survey(file)))
    assert said == [f"contact forces: at most {most} sweeps of the solver in a step"]
    codes = np.array([status.JAMMING, status.NOT_FINITE, status.JAMMING], np.uint8)
    contact_file.write_sample(file, 1, 1, {"point_reason": codes, "status": DONE})
    one, two, _ = point_lines(survey.survey(file))  # three speeds, the tuned disk, four samples
    assert one == "1 of 15 points: diverged: a displacement is not finite"
    assert two.startswith("2 of 15 points: diverged: jamming")
    file.close()


def test_diverged_points_have_no_peak():
    speeds = np.array([1.0, 2.0, 3.0, 4.0])
    amplitude = np.array([0.1, 9.0, 0.3, np.nan])
    result = SweepResult.empty(4)
    result = replace(result, amplitude=amplitude, point_status=np.array([1, 3, 2, 1], np.uint8))
    assert amplification.peak(result, speeds) == (0.3, 3.0)
    result = replace(result, point_status=np.full(4, 3, np.uint8))
    assert np.isnan(amplification.peak(result, speeds)).all()


@pytest.mark.parametrize("how", ["LinAlgError", "diverged"])
def test_a_failed_sample_is_noted_and_left_out(tiny, folder, monkeypatch, capfd, how):
    solve, whole_sweeps = disks.mistuned_modes, sweep.run_sweeps
    bad = disks.stiffness_deviation(2020, 1, 0, 12, 0.04)

    def broken_solver(reduced, deviation, *speed):
        if how == "LinAlgError" and np.array_equal(deviation, bad):
            raise np.linalg.LinAlgError("Eigenvalues did not converge")
        return solve(reduced, deviation, *speed)

    def broken_sweeps(asked, scene, speeds_hz, *more, **options):
        for k, result in whole_sweeps(asked, scene, speeds_hz, *more, **options):
            if how == "diverged" and np.array_equal(
                asked[k].modes.omega, solve(REDUCED, bad).omega
            ):
                result = replace(result, point_status=np.full(len(speeds_hz), 3, np.uint8))
            yield k, result

    REDUCED = study.build_problem(load(tiny)).reduced
    monkeypatch.setattr(disks, "mistuned_modes", broken_solver)
    monkeypatch.setattr(sweep, "run_sweeps", broken_sweeps)
    assert run_here(tiny) == 0
    out = capfd.readouterr().out
    assert "level 1, sample 0 failed: " in out
    assert "1 (+1 failed)" in out
    with open_result("results/tiny.h5") as file:
        np.testing.assert_array_equal(file.status, [[DONE, DONE], [FAILED, DONE]])
        np.testing.assert_array_equal(file.read("samples/deviation", (1, 0)), bad)
        percentile = file.read("statistics/contact/amplification", 1)
        assert np.isnan(percentile[:, 0]).all()
        np.testing.assert_array_equal(percentile[:, 1], file.read("samples/amplification", (1, 1)))


def said(file):
    found = survey.survey(file)
    tables = cells(level_table(file, found)), cells(interval_table(file, [AMPLIFICATION, LINEAR]))
    return [*tables, *point_lines(found), *findings.verdict(file).lines, *STUDY.report(file)]


@pytest.mark.parametrize(("criterion", "n"), [("standard_error", 3), ("interval", 6)])
def test_stops_when_converged_and_stays_so(criterion, n, tiny, folder, capfd, monkeypatch):
    """With a generous target it stops at the fewest values allowed or, by the interval of a median,
    when both of its ends are known: 0.5**n is below the normal tail at 2. A resume adds none."""
    keys = {"stop_when_converged": "true", "target_error": 1, "percentiles": [50], "z": 2}
    few = [f"--set=convergence.{key}={value}" for key, value in keys.items()]
    few += ["--set=mistuning.samples=12", "--set=mistuning.half_range_percent=[4]"]
    few += [f"--set=convergence.criterion={criterion}"]
    monkeypatch.setattr("hpcrub.statistics.percentiles.MIN_VALUES", 3)
    assert run_here(tiny, *few) == 0
    with open_result("results/tiny.h5") as file:
        np.testing.assert_array_equal(file.status, [[DONE] * n + [0] * (12 - n)])
        known = np.isfinite(file.read("statistics/linear/linear_amplification", (0, 0)))
    np.testing.assert_array_equal(known, np.arange(12) < n)
    before = datasets("results/tiny.h5")
    first = contents("results/tiny.h5")["statistics/contact/convergence_error"]
    assert run_here(tiny, *few, "--status") == 0
    assert run_here(tiny, *few, "--resume") == 0
    assert datasets("results/tiny.h5") == before
    with open_result("results/tiny.h5", mode="r+") as file:  # as more ranks would have computed it
        tables = said(file)
        more = {"amplification": 9.0, "linear_amplification": 9.0, "status": DONE}
        more |= {"peak_amplitude_m": 1.0, "point_status": np.full(3, status.DIVERGED)}
        contact_file.write_sample(file, 0, n, more)
        contact_file.write_sample(file, 0, n + 1, {"status": FAILED})
        assert said(file) == tables
        assert max(map(len, samples.of_levels(file, "amplification"))) == n
        keys = {"study": "energy", "sources": [str(file.path)], "energy.samples": 1}
        assert energy.STUDY.constants(file.config.replace(keys))["number"] < n
    error = "statistics/contact/convergence_error"
    assert run_here(tiny, *few, "--resume") == 0
    np.testing.assert_array_equal(contents("results/tiny.h5")[error], first)


def test_a_study_without_a_result_does_not_end_as_if_it_had_one(tiny, folder, capfd, monkeypatch):
    def broken(reduced, deviation, *speed):
        if deviation.max() > 1e-3:  # not the runs of the tuned disk
            raise np.linalg.LinAlgError("Eigenvalues did not converge")
        return mistuned_modes(reduced, deviation, *speed)

    monkeypatch.setattr(disks, "mistuned_modes", broken)
    assert run_here(tiny) == 1
    (line,) = error_lines(capfd.readouterr().err)
    assert line.startswith("hpcrub: error: all 4 samples have failed")
    with open_result("results/tiny.h5") as file:
        assert (file.status == FAILED).all()


def test_a_study_shorter_than_a_step_of_the_convergence_ends_well(tiny, folder):
    short = "--set=convergence.step=10", "--set=convergence.stop_when_converged=true"
    assert run_here(tiny, *short) == 0
    assert run_here(tiny, *short, "--status") == 0


def test_dry_run_touches_nothing(tiny, folder, capfd):
    assert run_here(tiny, "--dry-run") == 0
    out = capfd.readouterr().out
    for key in ("computes:", "output:", "memory:", "measured:", "estimated run time:"):
        assert key in out
    assert not (folder / "results").exists()
    assert run_here(tiny, "--dry-run", "--set=casing.clearance_mm=2") == 0
    out = capfd.readouterr().out
    assert "nan" not in out
    assert "the bumps do not reach the blades" in out


def test_an_existing_result_is_kept_unless_told(copied, capfd):
    tiny = "tiny.yaml"
    assert run_here(tiny) == 2
    (line,) = error_lines(capfd.readouterr().err)
    assert "--resume" in line
    assert "--overwrite" in line
    assert run_here(tiny, "--set", "casing.n_bumps=3", "--resume") == 2
    (line,) = error_lines(capfd.readouterr().err)
    assert "casing.n_bumps: 4 in the file, 3 asked for" in line
    assert run_here(tiny, "--set", "casing.n_bumps=3", "--overwrite") == 0


def test_stability_limit_counts_the_stiffest_sample(tiny_config):
    tuned = study.build_problem(tiny_config).reduced.tuned_eigenvalues[-1]
    limit = 2 / np.sqrt(1.04 * tuned)

    def build(scheme, step):
        study.build_problem(tiny_config.replace({"time.scheme": scheme, "time.step_s": step}))

    build("central_difference", 0.9999 * limit)
    with pytest.raises(InputError, match=f"is not below {limit:.4g} s, the stability limit"):
        build("central_difference", 1.0001 * limit)
    build("exact_modal", 2 * limit)  # needs no limit


@pytest.mark.parametrize(
    "shape", ["casing.clearance_mm=2", "casing.harmonics=[{order: 2, amplitude_mm: 0.2}]"]
)
def test_no_contact_is_an_answer(tiny, folder, capfd, monkeypatch, shape):
    """It was a failure, exit code 1, and --status stayed at 75; a resume integrates nothing."""
    assert run_here(tiny, "--set", shape) == 0
    monkeypatch.setattr(sweep, "run_sweeps", lambda *_, **__: pytest.fail("nothing is to be done"))
    assert run_here(tiny, "--set", shape, "--resume") == 0
    assert run_here(tiny, "--set", shape, "--status") == 0
    said = capfd.readouterr()
    assert not error_lines(said.err)
    assert said.out.count("no contact: the casing reaches the blades at no speed") == 2
    with open_result(folder / "results" / "tiny.h5") as file, np.errstate(all="raise"):
        assert np.isnan(survey.unstable_peak(file))  # of 0 over 0, figures had a warning
    found = contents(folder / "results" / "tiny.h5")
    assert not found["samples/peak_amplitude_m"].any()
    assert not found["samples/amplitude_m"].any()


def test_a_reference_that_is_rounding_is_refused(tiny, folder, capfd):
    """Straight blades, a bump for each, no friction: tips move radially, sideways by 1e-15.

    Before any sample is integrated, which might take hours.
    """
    straight = "disk.blade.lean_deg=0", "disk.blade.bow=0", "contact.friction=0"
    keys = (*straight, "casing.n_bumps=12", "speeds.from_hz=12", "speeds.to_hz=12")
    assert run_here(tiny, *(f"--set={key}" for key in keys)) == 1
    said = capfd.readouterr()
    assert "which is rounding" in error_lines(said.err)[-1]
    assert "samples: 1" not in said.out
