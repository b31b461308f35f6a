"""The search for the paper's disk: its finite elements, its book, its order, its verdicts.

A rigid rotation by an angle strains nothing and has the kinetic energy of the polar moment of
inertia, which for straight beams of mass mu per length between r_1 and r_2 (vectors) is
mu L (r_1.r_1 + r_1.r_2 + r_2.r_2) / 3, and 2 pi R^3 mu for the ring.
"""

import json

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.identify import book as books
from evidence.identify import conclusions, disks, paper, predictions, report, search, shapes, stages
from hpcrub.config.schema import Config
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton

CONFIG = Config()
OLD = disks.EARLIER[0]
VARIED = disks.EARLIER[1]._replace(skew=0.5, ring_inset_mm=12.0, ring_width=0.7, spoke_width=1.3)


def test_without_variations_it_is_the_reference_model():
    names = disks.Dimensions._fields[2:5]
    blade = CONFIG.disk.blade
    own = disks.Dimensions(
        blade.lean_deg, blade.bow, *(getattr(CONFIG.disk, n) for n in names), blade.thickness_mm
    )
    mine, known = disks.build(own), build_disk(CONFIG.disk, CONFIG.material)
    for name in ("mass", "stiffness", "blade_stiffness"):
        known_values = getattr(known, name)
        scale = np.abs(known_values).max()
        np.testing.assert_allclose(getattr(mine, name), known_values, atol=1e-13 * scale)


def rotation(disk, dimensions):
    """Displacement of all dof when a disk without spokes turns by one radian."""
    x = np.zeros(len(disk.mass))
    ring_radius = CONFIG.disk.hub_radius - 1e-3 * dimensions.ring_inset_mm
    nodes = disk.points.blades[:, 1:]
    for blade, dof in enumerate(disk.blade_dof):
        x[dof[2]] = ring_radius  # v of the ring; u, u' and v' stay zero
        position, frame = disk.points.position[nodes[blade]], disk.points.frame[nodes[blade]]
        turned = np.column_stack([-position[:, 1], position[:, 0]])
        radial = np.column_stack([np.cos(frame), np.sin(frame)])
        tangential = np.column_stack([-np.sin(frame), np.cos(frame)])
        x[dof[3::3]] = np.sum(turned * radial, axis=1)
        x[dof[4::3]] = np.sum(turned * tangential, axis=1)
        x[dof[5::3]] = 1.0
    return x


def test_a_varied_disk_turns_rigidly_without_strain():
    free = VARIED._replace(spoke_thickness_mm=0.0)
    disk = disks.build(free)
    x = rotation(disk, free)
    strained = x @ np.diag(np.diag(disk.stiffness)) @ x
    assert abs(x @ disk.stiffness @ x) < 1e-12 * strained
    for dof, stiffness in zip(disk.blade_dof, disk.blade_stiffness, strict=True):
        assert abs(x[dof] @ stiffness @ x[dof]) < 1e-12 * strained


def test_inertia_of_a_varied_disk():
    free = VARIED._replace(spoke_thickness_mm=0.0)
    disk = disks.build(free)
    x = rotation(disk, free)
    section = CONFIG.material.density * CONFIG.disk.width
    ring_radius = CONFIG.disk.hub_radius - 1e-3 * free.ring_inset_mm
    ring = section * free.ring_width * 1e-3 * free.ring_thickness_mm * 2 * np.pi * ring_radius**3
    start, end = disk.points.position[disk.points.blades[0]][:-1], disk.points.position[1:6]
    length = np.linalg.norm(end - start, axis=1)
    squares = np.sum(start * start + start * end + end * end, axis=1) / 3
    blades = 12 * section * 1e-3 * free.blade_thickness_mm * np.sum(length * squares)
    # the ring's cubic elements hold a constant v exactly
    assert x @ disk.mass @ x == pytest.approx(ring + blades, rel=1e-12)


def test_skew_moves_the_bow_towards_the_tip():
    def bulge(skew):
        """Offsets of the second and fourth inner nodes from the chord."""
        disk = disks.build(OLD._replace(skew=skew))
        nodes = disk.points.position[disk.points.blades[0]]
        along = (nodes[-1] - nodes[0]) / np.linalg.norm(nodes[-1] - nodes[0])
        return (nodes - nodes[0])[[1, 4]] @ [-along[1], along[0]]

    root, tip = bulge(0.5)
    assert tip / root == pytest.approx(1.3 / 0.7)  # 1 + skew (2z - 1) at z = 0.8 and 0.2
    assert bulge(0.0) == pytest.approx(np.full(2, bulge(0.0)[0]))


def test_thicknesses_meet_the_band():
    varied = disks.in_band(VARIED)
    found = disks.family(disks.build(varied))
    np.testing.assert_allclose(found[[0, -1]], disks.BAND, rtol=1e-4)
    fixed = [name for name in varied._fields if name not in ("spoke_thickness_mm",
                                                             "blade_thickness_mm")]  # fmt: skip
    assert all(getattr(varied, name) == getattr(VARIED, name) for name in fixed)


def test_place_and_unit_of_are_inverse():
    bounds = disks.BOUNDS | disks.VARIATIONS
    unit = disks.unit_of(VARIED, bounds)
    placed = disks.place(unit, bounds, OLD)
    np.testing.assert_allclose(disks.unit_of(placed, bounds), unit, atol=1e-12)
    assert placed.blade_thickness_mm == OLD.blade_thickness_mm


@pytest.fixture
def few(monkeypatch):
    """Stages of few runs and samples."""
    for name in ("N_LINEAR", "N_TUNED", "N_PATTERN", "N_SAMPLES"):
        monkeypatch.setattr(stages, name, 1)
    monkeypatch.setattr(conclusions, "N_SAMPLES", 1)
    monkeypatch.setattr(predictions, "N_SAMPLES", {3: 1, 4: 1, 6: 1})
    monkeypatch.setattr(predictions, "N_TUNED", 1)
    monkeypatch.setattr(predictions, "LONGEST", 0.5)
    monkeypatch.setattr(stages, "FINE", 1e-5)


def test_every_stage_finds_the_numbers_of_its_statements(few):
    for stage, compute in books.COMPUTE.items():
        found = compute(disks.EARLIER[1], 0)
        numbers = {s.name for s in paper.STATEMENTS if s.stage == stage}
        assert numbers <= set(found), stage
        assert all(np.isfinite(found[name]) for name in numbers), stage


def test_without_mistuning_nothing_is_amplified(few, monkeypatch):
    monkeypatch.setattr(stages, "HALF_RANGES", (0.0, 0.0))
    for cloud in stages.amplifications(disks.reduced(disks.EARLIER[1]), 6, 0, 2):
        assert cloud.contact == pytest.approx([1, 1])
        assert cloud.linear == pytest.approx([1, 1])


def test_cost_and_verdict():
    peak = next(s for s in paper.STATEMENTS if s.name == "pattern_mm")
    assert peak.cost(58.1) == 0
    assert peak.cost(58.1 + 0.1 * peak.tolerance) == pytest.approx(0.01, rel=0.01)
    assert peak.cost(np.nan) > peak.cost(200.0) > peak.cost(80.0) > peak.cost(60.0)
    assert [peak.verdict(58.1 + z * peak.tolerance) for z in (-1, 1.9, 2.1)] == [
        "yes", "near", "no"]  # fmt: skip
    below = next(s for s in paper.STATEMENTS if s.name == "reduced_highest_hz")
    assert below.cost(5000.0) == 0 < below.cost(6400.0)


@pytest.fixture
def counted(monkeypatch):
    """Stages that only note what they were asked; the loss is the distance from 50 degrees."""
    asked = []

    def stage(name):
        def compute(disk, draw):
            asked.append((name, disk, draw))
            off = (disk.lean_deg - 50) / 10 + abs(disk.bow + 0.05) * 100
            return {s.name: (s.low if np.isfinite(s.low) else s.high) - 1e-3 + off * s.tolerance
                    for s in paper.STATEMENTS if s.stage == name}  # fmt: skip

        return compute

    compute = {name: stage(name) for name in paper.STAGES}
    compute["band"] = lambda disk, _draw: {"disk": disk}
    monkeypatch.setattr(books, "COMPUTE", compute)
    return asked


def test_an_interrupted_book_computes_only_what_is_missing(tmp_path, counted):
    path = tmp_path / "evaluations.jsonl"
    tasks = [("geometry", OLD._replace(lean_deg=x), 0) for x in (40.0, 41.0, 42.0)]
    whole = books.Book(path).measure(tasks)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:-1]) + lines[-1][:20])  # killed in its last line
    counted.clear()
    assert books.Book(path).measure(tasks) == whole
    assert counted == [tasks[2]]
    assert len(path.read_text().splitlines()) == 4
    assert books.Book(path).measure([*tasks, tasks[0]]) == [*whole, whole[0]]


def test_a_book_of_other_settings_is_refused(tmp_path):
    path = tmp_path / "evaluations.jsonl"
    path.write_text(json.dumps({"settings": {"seed": 1}}) + "\n")
    with pytest.raises(ValueError, match="other settings"):
        books.Book(path)


def test_no_evaluation_begins_after_the_time_given(tmp_path, counted):
    book = books.Book(tmp_path / "evaluations.jsonl", seconds=-1.0)
    with pytest.raises(books.BudgetSpentError):
        book.measure([("geometry", OLD, 0)])
    assert counted == []


def quiet(_line):
    pass


def test_the_search_finds_a_minimum_and_repeats_itself(tmp_path, counted):
    def run():
        book = books.Book(tmp_path / "evaluations.jsonl")
        first = search.whole_range(book, 32, quiet)
        return first, search.around(book, first[0].disk, disks.BOUNDS, 8, quiet)

    first, later = run()
    assert first[0].n_stages == later[0].n_stages == len(paper.STAGES)
    assert later[0].loss < 0.5 * first[0].loss
    n_asked = len(counted)
    again = run()
    assert len(counted) == n_asked  # all was in the book: the same disks in the same order
    assert again == (first, later)


def test_only_the_best_reach_the_dear_stages(tmp_path, counted):
    book = books.Book(tmp_path / "evaluations.jsonl")
    trials = search.whole_range(book, 64, quiet)
    samples = [disk for name, disk, _ in counted if name == "samples"]
    assert len(samples) == search.FIRST["samples"] + len(disks.EARLIER)
    cheap = paper.STAGES[:1]
    left_out = [t for t in trials if t.n_stages == 1 and t.disk not in disks.EARLIER]
    kept = [t for t in trials if t.n_stages > 1 and t.disk not in disks.EARLIER]
    if left_out:
        assert max(paper.loss(t.found, cheap) for t in kept) <= min(t.loss for t in left_out)


def test_set_of_disks_as_good():
    trials = [search.Trial(OLD._replace(lean_deg=30.0 + i), {}, 0) for i in range(10)]
    taken = search.apart(trials, 3)
    assert [t.disk.lean_deg for t in taken[:2]] == [30.0, 39.0]
    assert taken[2].disk.lean_deg in (34.0, 35.0)
    assert len(search.apart(trials, 20)) == 10


def clouds(sign, n=40):
    """Numbers of a disk that agrees with the paper (sign 1), or contradicts it (-1)."""
    rng = np.random.default_rng(0)
    linear, other = 1.3 + 0.05 * rng.standard_normal((2, n))
    found = {}
    for bumps in conclusions.BUMPS:
        found[f"tuned {bumps}"] = 30.0
        gain = 0.2 * sign * {4: 2.0, 6: -1.0}.get(bumps, 1.0)
        own = (1 - sign) / 2 * linear + (1 + sign) / 2 * other  # the sample's A_lin again, or not
        for level in conclusions.LEVELS:
            speed = np.full(n, 30.3 if sign > 0 else 32.0)
            found[f"{bumps}, {level}"] = np.array([own * (1 + gain), linear, speed])
    more = found["4, 2.3"]
    found["less damping"] = more * np.array([1 + 0.05 * sign, 1.0, 1.0])[:, None]
    return {name: np.array(values).tolist() for name, values in found.items()}


def test_conclusions_hold_or_fail_on_made_up_samples():
    assert {a.verdict for a in conclusions.answers(clouds(1)).values()} == {"holds"}
    assert {a.verdict for a in conclusions.answers(clouds(-1)).values()} == {"fails"}


def test_a_conclusion_on_few_scattered_samples_stays_open():
    found = clouds(1)
    rng = np.random.default_rng(1)
    values = np.array(found["less damping"])
    values[0] *= 1 + 0.3 * rng.standard_normal(values.shape[1]) - 0.05
    answers = conclusions.answers(found | {"less damping": values})
    assert answers["damping"].verdict == "open"


def test_page_is_written_from_a_book(tmp_path, counted):
    book = books.Book(tmp_path / "evaluations.jsonl")
    search.whole_range(book, 16, quiet)
    search.repeat(book, search.contenders(search.finished(book)))
    (tmp_path / "figures").mkdir()
    page = tmp_path / "identification.md"
    page.write_text("before\n<!-- results -->\n<!-- end of results -->\nafter\n")
    report.write(book, tmp_path)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert text.count("| fitted |") == sum(s.fitted for s in paper.STATEMENTS)
    assert (tmp_path / "figures" / "identification_set.png").stat().st_size > 10_000


def test_the_coarsest_mesh_is_the_reference_model():
    disk = disks.EARLIER[1]
    mine, known = shapes.refined(disk, 1, 1), disks.build(disk)
    for name in ("mass", "stiffness"):
        known_values = getattr(known, name)
        scale = np.abs(known_values).max()
        np.testing.assert_allclose(getattr(mine, name), known_values, atol=1e-13 * scale)


def test_a_finer_mesh_lowers_frequencies_a_little():
    coarse, fine = (disks.family(shapes.refined(disks.EARLIER[1], n, n)) for n in (1, 3))
    assert (fine < coarse * (1 + 1e-9)).all()  # elements of a finer mesh hold those of a coarse one
    np.testing.assert_allclose(fine, coarse, rtol=2e-3)


def test_a_finer_mesh_is_reduced_alike():
    disk = disks.EARLIER[1]
    assert shapes.highest_hz(shapes.refined(disk, 1, 1)) == pytest.approx(
        shapes.highest_hz(disks.build(disk))
    )
    tips = [shapes.families(craig_bampton(shapes.refined(disk, n, n), 60)) for n in (1, 3)]
    np.testing.assert_allclose(tips[0]["touching"], tips[1]["touching"], rtol=1e-2)


def test_touching_without_friction_is_the_disk_with_its_tips_held():
    disk = disks.build(OLD)
    free = np.setdiff1d(np.arange(len(disk.mass)), disk.contact_dof[:, 0])
    held = [a[np.ix_(free, free)] for a in (disk.stiffness, disk.mass)]
    known = np.sqrt(eigh(*held, eigvals_only=True)[:12]) / (2 * np.pi)
    found = shapes.families(disks.reduced(OLD), friction=0.0)
    assert min(found["touching"]) == pytest.approx(known[0], rel=1e-4)
    assert max(found["touching"]) == pytest.approx(known[11], rel=1e-4)
    assert found["lost"] == pytest.approx(1.0)  # all that the normal velocity alone can lose
    assert found["growth"] == pytest.approx(0.0, abs=1e-3)
