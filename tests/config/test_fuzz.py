"""Whatever an input file holds, it is read or refused with one clear line, never a traceback."""

import random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hpcrub import studies
from hpcrub.config import schema as config
from hpcrub.errors import InputError
from hpcrub.runs import memory

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda v: st.lists(v, max_size=4) | st.dictionaries(st.text(max_size=4), v, max_size=3),
    max_leaves=6,
)
KEYS = {key.path for key in config.key_table()}
PATHS = st.sampled_from(
    sorted(p for p in KEYS if p.rpartition(".")[0] not in KEYS)
)  # none of a list's


def refused_in_one_line(function, *args):
    """Call; whatever is refused must be an InputError of one line."""
    try:
        function(*args)
    except InputError as refusal:
        message = str(refusal)
    else:
        return
    assert message
    assert message.isprintable()


@settings(max_examples=100)
@given(text=st.text(max_size=60))
@example("? ")
@example("<<: {a: 1}")
@example("%YAML 9.9\n---\na: 1")
@example("a: !<x> 1")
def test_any_text(text):
    refused_in_one_line(config.Config.from_yaml, text)


@settings(max_examples=100)
@given(keys=st.dictionaries(PATHS, VALUES, max_size=4), unknown=st.text(max_size=5))
def test_any_values(keys, unknown):
    data = {unknown: 1} if unknown else {}
    for path, value in keys.items():
        section = data
        *sections, leaf = path.split(".")
        for name in sections:
            section = section.setdefault(name, {})
        section[leaf] = value
    refused_in_one_line(config._validated, data)


@settings(max_examples=30)
@given(content=st.binary(max_size=80), overrides=st.lists(st.text(max_size=20), max_size=2))
def test_any_file(tmp_path_factory, content, overrides):
    path = tmp_path_factory.mktemp("fuzz", numbered=True) / "a.yaml"
    path.write_bytes(content)
    refused_in_one_line(config.load_runs, path, overrides)


LAUGHS = "\n".join(
    f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 9 if n else ['ha'] * 9)}]" for n in range(10)
)
HOSTILE = {
    "a billion laughs": LAUGHS,
    "a tag that runs a program": "study: !!python/object/apply:os.system ['touch harmed']",
    "99,999 brackets": "[" * 99_999,
    "400 levels": "".join(" " * n + "a:\n" for n in range(400)),
    "a number of 90,000 digits": "casing: {n_bumps: " + "9" * 90_000 + "}",
    "15,000 keys": "\n".join(f"k{n}: 1" for n in range(15_000)),
    "a sweep of 1000 sweeps": "sweep: [" + ", ".join(["{casing.n_bumps: 3}"] * 1000) + "]",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_no_text_grows_or_runs(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.yaml").write_text(HOSTILE[name], encoding="utf-8")
    with pytest.raises(InputError) as caught:
        config.load_runs("study.yaml")
    assert len(str(caught.value)) < 500
    assert not (tmp_path / "harmed").exists()


def mutilated(seed):
    """The YAML text of all defaults, changed in a few places as people and editors do."""
    rng = random.Random(seed)
    lines = config.Config().to_yaml().splitlines()
    for _ in range(rng.randint(1, 4)):
        at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
        change = rng.randrange(7)
        if change == 0:
            lines.pop(at)
        elif change == 1:
            lines.insert(other, lines[at])
        elif change == 2:
            lines[at] = " " * rng.randint(0, 4) + lines[at].strip()
        elif change == 3:
            lines[at], lines[other] = lines[other], lines[at]
        elif change == 4:
            where = rng.randrange(len(lines[at]) + 1)
            lines[at] = (
                lines[at][:where] + rng.choice("{}[]:,#&*!|>'\"%@`-? \t") + lines[at][where:]
            )
        elif change == 5:
            lines[at] = (
                lines[at].partition(":")[0] + ": " + rng.choice(["", "{}", "[1e9]", "-1", "~"])
            )
        else:
            lines[at] += lines[other]
    return "\n".join(lines)


@settings(max_examples=50)
@given(seed=st.integers(0, 10**9))
def test_a_real_input_mutilated(seed):
    refused_in_one_line(config.Config.from_yaml, mutilated(seed))


NUMBERS = {
    "time.step_s": st.floats(1e-300, 1e-2),
    "speeds.from_hz": st.floats(1e-12, 1e5),
    "disk.n_blades": st.integers(2, 200),
    "disk.blade.n_elements": st.integers(1, 50),
    "casing.n_bumps": st.integers(1, 1000),
    "mistuning.samples": st.integers(1, 10**12),
    "history.duration_s": st.floats(1e-3, 1000),
    "spectrum.step_hz": st.floats(1e-3, 1e4),
    "steady_state.window_revolutions": st.integers(1, 1000),
}
KINDS = ["contact", "modal", "linear", "time_response", "interaction_map", "branches"]


@settings(max_examples=50)
@given(study=st.sampled_from(KINDS), keys=st.fixed_dictionaries({}, optional=NUMBERS))
def test_the_size_of_anything_allowed_is_known_without_work(study, keys):
    data = {"study": study, "speeds": {}, "reduction": {"n_modes": 4}}
    for path, value in keys.items():
        section = data
        *sections, leaf = path.split(".")
        for name in sections:
            section = section.setdefault(name, {})
        section[leaf] = value
    if "from_hz" in data["speeds"]:
        data["speeds"]["to_hz"] = data["speeds"]["from_hz"]
    try:
        cfg = config._validated(data)
    except InputError:
        return
    run = studies.run_of(cfg)
    refused_in_one_line(lambda: memory.estimate(run) >= 0 or 1 / 0)
    refused_in_one_line(memory.check, run)
