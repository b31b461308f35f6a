"""Strict and safe reading of YAML: plain numbers, texts, lists and mappings.

Scalars follow YAML 1.2, because YAML 1.1, which PyYAML implements, reads `1e-6` as a text, `010` as
eight, `12:30` as 750 and `no` as false. Aliases, tags and duplicate keys have no use in an input
file and are refused.
"""

import re
from typing import Any

import yaml

from hpcrub.errors import InputError

MAX_CHARACTERS = 500_000  # of the longest list of each key, written by `to_yaml`: 350,000

_TAG = "tag:yaml.org,2002:"
_PLAIN = {
    "null": (r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    "bool": (r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    "int": (r"[-+]?[0-9]+", list("-+0123456789")),
    "float": (r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?", list("-+.0123456789")),
}


class _Loader(yaml.SafeLoader):
    """SafeLoader with only the scalars above, and with unique text keys."""

    yaml_implicit_resolvers = {}

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            what = "aliases (*) are not supported; quote a text that needs one"
            raise yaml.composer.ComposerError(None, None, what, self.peek_event().start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                comma = "; a decimal comma? write 44.5" if isinstance(key, int | float) else ""
                what = f"a key must be a plain name{comma}"
            else:
                what = f"key {key!r} is given twice" if key in seen else ""
            if what:
                raise yaml.constructor.ConstructorError(None, None, what, key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep=deep)


class _Dumper(yaml.SafeDumper):
    """SafeDumper that quotes texts that `_Loader` would read back as something else."""

    yaml_implicit_resolvers = {}

    def ignore_aliases(self, data: Any) -> bool:
        return True


for _cls in (_Loader, _Dumper):
    for _name, (_pattern, _first) in _PLAIN.items():
        _cls.add_implicit_resolver(_TAG + _name, re.compile(rf"(?:{_pattern})\Z"), _first)
_Loader.add_constructor(_TAG + "int", lambda loader, node: int(node.value))
_Loader.add_constructor(_TAG + "float", lambda loader, node: float(node.value))
_Dumper.add_representer(
    list, lambda dumper, items: dumper.represent_sequence(_TAG + "seq", items, flow_style=True)
)


def parse(text: str) -> Any:
    """Read a YAML document into plain values. Raises InputError with the place of an error."""
    if len(text) > MAX_CHARACTERS:
        raise InputError(f"longer than the {MAX_CHARACTERS:,} characters allowed for an input")
    try:
        return yaml.load(text, _Loader)  # a SafeLoader
    except yaml.MarkedYAMLError as error:
        mark, what = error.problem_mark, error.problem or "not YAML"
        where = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        if what.startswith("but "):
            what = f"{error.context} {what}"
        raise InputError(where + what) from None
    except RecursionError:
        raise InputError("not YAML that an input needs: nested too deeply") from None
    except (yaml.YAMLError, ValueError) as error:
        raise InputError("not YAML: " + " ".join(str(error).split())) from None


def dump(data: Any) -> str:
    """Write dicts, lists and scalars as YAML that `parse` reads back to the same values."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)
