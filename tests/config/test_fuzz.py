"""Whatever an input file holds, it is read or refused with one clear line, never a traceback."""

from hypothesis import example, given, settings
from hypothesis import strategies as st

from hpcrub import studies
from hpcrub.config import schema as config
from hpcrub.config.text import key_table, set_key
from hpcrub.errors import InputError
from hpcrub.runs import memory

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda v: st.lists(v, max_size=4) | st.dictionaries(st.text(max_size=4), v, max_size=3),
    max_leaves=6,
)
KEYS = {key.path for key in key_table(config.Config)}
PATHS = st.sampled_from(
    sorted(p for p in KEYS if p.rpartition(".")[0] not in KEYS)
)  # none of a list's


def nested(keys):
    """Values by their paths as the sections of an input."""
    data = {}
    for path, value in keys.items():
        set_key(data, path, value)
    return data


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
    refused_in_one_line(lambda: config.Config(**nested(({unknown: 1} if unknown else {}) | keys)))


@settings(max_examples=30)
@given(content=st.binary(max_size=80), overrides=st.lists(st.text(max_size=20), max_size=2))
def test_any_file(tmp_path_factory, content, overrides):
    path = tmp_path_factory.mktemp("fuzz", numbered=True) / "a.yaml"
    path.write_bytes(content)
    refused_in_one_line(config.load_runs, path, overrides)


NUMBERS = {
    "time.step_s": st.floats(1e-12, 1e-2), "speeds.from_hz": st.floats(1e-6, 1e5),
    "history.duration_s": st.floats(1e-3, 1000), "spectrum.step_hz": st.floats(1e-3, 1e4),
    "disk.n_blades": st.integers(2, 200), "disk.blade.n_elements": st.integers(1, 50),
    "casing.n_bumps": st.integers(1, 1000), "mistuning.samples": st.integers(1, 10**12),
    "steady_state.window_revolutions": st.integers(1, 1000),
}  # fmt: skip
KINDS = ["contact", "modal", "linear", "time_response", "interaction_map", "branches"]


@settings(max_examples=50)
@given(study=st.sampled_from(KINDS), keys=st.fixed_dictionaries({}, optional=NUMBERS))
def test_the_size_of_anything_allowed_is_known_without_work(study, keys):
    keys |= {"study": study, "reduction.n_modes": 4}
    if "speeds.from_hz" in keys:
        keys["speeds.to_hz"] = keys["speeds.from_hz"]
    try:
        cfg = config.Config(**nested(keys))
    except InputError:
        return
    run = studies.run_of(cfg)
    refused_in_one_line(lambda: memory.estimate(run) >= 0 or 1 / 0)
    refused_in_one_line(memory.check, run)
