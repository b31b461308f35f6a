"""Whatever an input file holds, it is read or refused with one clear line, never a traceback.

What is read is the same once it has been written: as YAML, and into a result file.
"""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hpcrub import studies
from hpcrub.config import schema as config
from hpcrub.config.text import key_table, set_key
from hpcrub.errors import InputError
from hpcrub.runs import result_files
from tests.program import lay_out

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
    """What a function returns, None if it refuses; a refusal must be an InputError of one line."""
    try:
        return function(*args)
    except InputError as refusal:
        message = str(refusal)
    assert message
    assert message.isprintable()
    return None


def made_of(function, *args):
    """The Config that a function makes, which is the same from its text; None if it refuses."""
    made = refused_in_one_line(function, *args)
    assert made is None or config.Config.from_yaml(made.to_yaml()) == made
    return made


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Name of a result file."""
    return tmp_path_factory.mktemp("fuzz") / "a.h5"


@settings(max_examples=50)
@given(text=st.text(max_size=60))
@example("? ")
@example("<<: {a: 1}")
@example("%YAML 9.9\n---\na: 1")
@example("a: !<x> 1")
def test_any_text(text):
    made_of(config.Config.from_yaml, text)


@settings(max_examples=50)
@given(keys=st.dictionaries(PATHS, VALUES, max_size=4), unknown=st.text(max_size=5))
@example({"output": "1e-6"}, "")
@example({"output": "null"}, "")
@example({"output": "- a: [b] # &c"}, "")
def test_any_values(path, keys, unknown):
    keys = {"study": "modal"} | ({unknown: 1} if unknown else {}) | keys
    made = made_of(lambda: config.Config(**nested(keys)))
    run = made and refused_in_one_line(studies.run_of(made).checked)
    if run and result_files.file_size(run) < 1e6 and refused_in_one_line(lay_out, path, made):
        with studies.open_result(path) as file:
            assert file.config == made


@settings(max_examples=30)
@given(content=st.binary(max_size=80), overrides=st.lists(st.text(max_size=20), max_size=2))
def test_any_file(path, content, overrides):
    path.with_suffix(".yaml").write_bytes(content)
    refused_in_one_line(config.load_runs, path.with_suffix(".yaml"), overrides)
