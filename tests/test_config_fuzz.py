"""Whatever an input file holds, it is read or refused with one clear line, never a traceback."""

from hypothesis import example, given, settings
from hypothesis import strategies as st

from hpcrub import config
from hpcrub.errors import InputError

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda v: st.lists(v, max_size=4) | st.dictionaries(st.text(max_size=4), v, max_size=3),
    max_leaves=6,
)
PATHS = st.sampled_from([key.path for key in config.key_table()])


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


@settings(max_examples=300, deadline=None)
@given(text=st.text(max_size=60))
@example("? ")
@example("<<: {a: 1}")
@example("%YAML 9.9\n---\na: 1")
@example("a: !<x> 1")
def test_any_text(text):
    refused_in_one_line(config.Config.from_yaml, text)


@settings(max_examples=300, deadline=None)
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


@settings(max_examples=100, deadline=None)
@given(content=st.binary(max_size=80), overrides=st.lists(st.text(max_size=20), max_size=2))
def test_any_file(tmp_path_factory, content, overrides):
    path = tmp_path_factory.mktemp("fuzz", numbered=True) / "a.yaml"
    path.write_bytes(content)
    refused_in_one_line(config.load, path, overrides)
