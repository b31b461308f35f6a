"""Who computes what next: nothing is lost, nobody waits for ever; the log."""

import json

import pytest

from hpcrub.ranks import runlog
from hpcrub.ranks.schedule import Assignments, Tasks
from hpcrub.studies.contact.tasks import ContactTasks


@pytest.mark.parametrize("together", [1, 8])
@pytest.mark.parametrize("n_ranks", [1, 2, 3, 16, 1500, 5000])
def test_every_part_of_every_sample_is_handed_out_once(n_ranks, together):
    samples = [(level, sample) for sample in range(300) for level in range(2)]
    tasks = ContactTasks(iter(samples), len(samples), 6, together)
    assignments, seen = Assignments(tasks, n_ranks), []
    for rank in range(1, n_ranks):
        assignments.ask(rank)
    for _ in range(10_000):
        given = list(assignments.answers())
        if own := assignments.own():
            given.append((0, [own]))
        if assignments.finished():
            break
        for rank, some in given:
            seen += assignments.done(rank, len(some))
            if rank:
                assignments.ask(rank)
    found = {}
    for task in seen:
        assert len(task.places) <= (together if task.n_parts == 1 else 1)
        for place in task.places:
            found.setdefault(place, []).append((task.part, task.n_parts))
    assert set(found) == set(samples)
    for parts in found.values():
        assert sorted(parts) == [(i, len(parts)) for i in range(len(parts))]


def test_last_tasks_go_to_ranks_that_have_none():
    assignments = Assignments(Tasks(range(5)), 2)
    assignments.ask(1)
    assert list(assignments.answers()) == [(1, [0])]
    assignments.ask(1)  # it begins its last task
    assert list(assignments.answers()) == [(1, [1])]
    assert assignments.own() == 2
    assert assignments.done(1, 1) == [0]
    assignments.ask(1)
    assert list(assignments.answers()) == []  # two are left for two ranks: not ahead
    assert assignments.done(1, 1) == [1]
    assignments.ask(1)
    assert list(assignments.answers()) == [(1, [3])]


def runs(path):
    return list(map(json.loads, path.read_text().splitlines()))


def test_a_run_log_grows_by_one_run_after_another(tmp_path):
    for code, message in ((75, "SIGTERM came"), (0, "")):
        log = runlog.RunLog(tmp_path / "x.h5", 4)
        log.phase("samples")
        log.end(runlog.Work(7, 1000, 0.5, 0.1) + runlog.Work(1, 0, 0.0, 0.0), code, message)
    lines = runs(tmp_path / "x.runs.jsonl")
    assert [line["event"] for line in lines] == ["start", "end", "start", "end"]
    assert lines[0]["ranks"] == 4
    stopped, done = lines[1::2]
    assert (stopped["exit_code"], stopped["exit_reason"]) == (75, "stopped")
    assert stopped["message"] == "SIGTERM came"
    assert (done["exit_code"], done["exit_reason"], done["ranks"]) == (0, "done", 4)
    assert done["done_in_this_run"] == 8
    assert done["steps_per_second_and_core"] == 2000
    assert done["core_seconds"] == pytest.approx(4 * done["wall_seconds"], abs=2e-3)
    assert set(done["phases"]) == {"lay-out", "samples"}


def test_steps_that_nobody_counts_are_not_said_to_be_none(tmp_path):
    log = runlog.RunLog(tmp_path / "x.h5", 1)
    log.end(runlog.Work(2, 0, 0.5), 0)
    _, summary = runs(tmp_path / "x.runs.jsonl")
    assert summary["steps"] is None
    assert summary["steps_per_second_and_core"] is None


def test_a_log_that_cannot_be_written_stops_nothing(tmp_path, capfd):
    (tmp_path / "x.runs.jsonl").mkdir()
    log = runlog.RunLog(tmp_path / "x.h5", 1)
    log.end(runlog.Work(), 0)
    assert "no run log" in capfd.readouterr().err
