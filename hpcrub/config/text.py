"""Texts about keys for error lines and the table of keys; flat paths of keys, overrides.

The error lines replace those of pydantic, which tell users neither the correct spelling of a key
nor its unit.
"""

import difflib
import re
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError

from hpcrub.config import yaml_text
from hpcrub.errors import InputError

TAGS = "<list>", "<file>"  # of the two kinds that some values can have
DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+")
OUT_OF_RANGE = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
LIMITS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
LIMIT_WORDS = dict(zip(LIMITS.values(), ("above", "from", "below", "up to"), strict=True))


class Key(NamedTuple):
    """Texts about one key of the input."""

    path: str
    default: str
    allowed: str
    description: str


def show(value: Any) -> str:
    """Text of a value as in an input file, on one line of at most 80 characters."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, (list, tuple)):
        text = "[" + ", ".join(map(show, value)) + "]"
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{key}: {show(v)}" for key, v in value.items()) + "}"
    else:
        text = repr(value)
    return text if len(text) <= 80 else text[:77] + "..."


def is_table(value: Any) -> bool:
    """Whether a value is a list of sections, such as waves or modes, too long for a short text."""
    return isinstance(value, (list, tuple)) and any(isinstance(row, dict) for row in value)


def counted(n: int, what: str) -> str:
    """Text of a number of things, such as "1 sample" or "1,200 samples"."""
    return f"{n:,} {what}{'' if n == 1 else 's'}"


def lines_of(*rules: tuple[Any, str]) -> Iterator[str]:
    """Lines whose condition holds; rules: pairs of a condition and a line."""
    return (line for holds, line in rules if holds)


def one_line(text: str) -> str:
    """Make line breaks and other control characters of a text visible."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def flatten(data: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Flatten nested dicts to {"casing.n_bumps": 4, ...}, in their order."""
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            flat |= flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def steps(path: str) -> list[str | int]:
    """Names of sections and numbers of elements in a path such as "casing.harmonics[0].order"."""
    parts = re.findall(r"\[([0-9]+)\]|([^.\[\]]+)", path)
    return [int(number) if number else name for number, name in parts]


def value_at(data: Any, path: str) -> Any:
    """Value of a key, or of an element of a list, in the data of an input; None: there is none."""
    for step in steps(path):
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def set_key(data: dict[str, Any], path: str, value: Any) -> None:
    """Set a key, or an element of a list, such as "casing.harmonics[0].order".

    Raises InputError if a part of the path is no section, or a list has no such element.
    """
    *before, last = steps(path) or [path]
    place: Any = data
    try:
        for step in before:
            is_section = isinstance(place, dict) and isinstance(step, str)
            place = place.setdefault(step, {}) if is_section else place[step]
        if isinstance(last, int) or not isinstance(place, dict):
            place[last]  # there must be such an element
        place[last] = value
    except (KeyError, IndexError, TypeError):
        raise InputError(
            f"{path}: the input has no such section, or no such element of a list, counted from 0 "
            "as in [0]"
        ) from None


def apply_override(data: dict[str, Any], override: str) -> str:
    """Apply "key.path=value" to the data of an input, and return the path of the key.

    Raises InputError for other forms.
    """
    path, equals, text = override.partition("=")
    if not equals or not all(path.strip().split(".")):
        raise InputError(f"override {show(override)} is not of the form key.path=value")
    try:
        value = yaml_text.parse(text)
        if isinstance(value, dict):
            raise InputError("give one key at a time, as key.path=value")
        set_key(data, path.strip(), value)
    except InputError as error:
        raise InputError(f"override {show(override)}: {error}") from None
    return path.strip()


def key_table(model: type[BaseModel]) -> list[Key]:
    """Table of all keys of a pydantic model and its sections."""
    return [
        Key(path, show(node.get("default")).strip("'"), _allowed(node), node["description"])
        for path, node in _leaves(model).items()
    ]


def name_and_unit(model: type[BaseModel], path: str) -> tuple[str, str]:
    """What a key is, in a few words, and its unit such as " mm"; the path and "" if not known.

    path: also of an element of a list, such as casing.harmonics[0].amplitude_mm.
    """
    node = _leaves(model).get(re.sub(r"\[[0-9]+\]", "", path), {"description": path})
    words, _, unit = node["description"].partition(" [")
    name = re.split("[,;:(]", words)[0].strip()
    unit = unit.rstrip("]").replace("-", "")
    return name, f" {unit}" if unit else ""


def first_error(model: type[BaseModel], error: ValidationError) -> str:
    """Text of the first of pydantic's errors on one line, with the number of further errors."""
    lines = []
    for detail in error.errors(include_url=False):
        if detail["loc"] == ():
            lines += str(detail["ctx"]["error"]).split("\n") if "ctx" in detail else ["not keys"]
        elif detail["type"] == "extra_forbidden":
            lines.append(_unknown_key(model, [*_names(detail["loc"][:-1]), detail["loc"][-1]]))
        elif detail["type"] == "missing":
            lines.append(f"{_path(detail['loc'])}: not given; no usual value is known")
        else:
            lines.append(_wrong_value(model, detail))
    more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
    return one_line(lines[0] + more)


@cache
def schema_of(model: type[BaseModel]) -> Any:
    """JSON schema of a pydantic model, with one-line texts and the standard names of limits."""
    return _renamed(model.model_json_schema())


def _renamed(node: Any) -> Any:
    if isinstance(node, str):
        return " ".join(node.split())
    if isinstance(node, dict):
        return {LIMITS.get(key, key): _renamed(value) for key, value in node.items()}
    return [_renamed(value) for value in node] if isinstance(node, list) else node


def _unknown_key(model: Any, path: Any) -> str:
    section, wrong = ".".join(path[:-1]), path[-1]
    known = _children(model)[section]
    everywhere = {leaf.rsplit(".", 1)[-1]: leaf for leaf in _leaves(model)}
    prefix = section + "." if section else ""
    near, vague = (difflib.get_close_matches(wrong, known, 1, alike) for alike in (0.7, 0.5))
    far = [everywhere[key] for key in difflib.get_close_matches(wrong, everywhere, 1, 0.7)]
    meant = [prefix + key for key in near] or far or [prefix + key for key in vague]
    hint = f"did you mean {meant[0]}?" if meant else f"known here: {', '.join(known)}"
    return f"{prefix}{wrong}: unknown key; {hint}"


def _names(loc: Any) -> list[Any]:
    """Names of the keys in the location of a value, without list indices and tags of kinds."""
    return [part for part in loc if isinstance(part, str) and part not in TAGS]


def _path(loc: Any) -> str:
    """Location of a value as in an input, such as casing.modes[0].waves."""
    named = (part for part in loc if part not in TAGS)
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in named)[1:]


def _wrong_value(model: Any, detail: Any) -> str:
    loc, value = detail["loc"], detail["input"]
    names, path = _names(loc), _path(loc)
    node = _leaves(model).get(".".join(names))
    if node is None:
        known = ", ".join(_children(model).get(".".join(names), ()))
        return f"{path}: {show(value)} is not a section with keys such as {known}"
    about = node["description"]
    for place in reversed(loc):
        if not isinstance(place, int):
            break
        while "items" not in node:
            node = _variants(node)[0]
        node = node["items"]
    verb = "is out of range, allowed is" if detail["type"] in OUT_OF_RANGE else "is not"
    near = difflib.get_close_matches(str(value), node.get("enum", ()), n=1)
    if isinstance(value, str) and DECIMAL_COMMA.fullmatch(value):
        near = [value.replace(",", ".")]
    hint = f"; did you mean {near[0]}?" if near else ""
    return f"{path}: {show(value)} {verb} {_allowed(node)} ({about}){hint}"


def _allowed(node: Any) -> Any:
    """Text of the values that a node of the JSON schema allows, to follow "is not"."""
    if variants := _variants(node):
        words = [*map(_allowed, variants)]
        return (", or " if "each" in words[0] else " or ").join(words)
    if "enum" in node:
        return f"one of {', '.join(node['enum'])}"
    kind = node["type"]
    if kind == "object":
        return f"a section with keys such as {', '.join(node['properties'])}"
    if kind == "array":
        least, most = node.get("minItems", 0), node["maxItems"]
        length = most if least == most else f"{least} to {most}"
        order = f"{node['format']} " if "format" in node else ""
        return f"a list of {length} {order}values, each {_allowed(node['items'])}"
    names = {"integer": "a whole number", "number": "a number", "boolean": "true or false"}
    other = "null" if kind == "null" else node.get("format", "a text")
    limits = [f" {word} {_plain(node[key])}" for key, word in LIMIT_WORDS.items() if key in node]
    closed = "minimum" in node and "maximum" in node
    return names.get(kind, other) + ("" if closed else " and").join(limits)


def _plain(limit: Any) -> str:
    return f"{int(limit):,}" if limit == int(limit) else f"{limit:g}"


def _variants(node: Any) -> Any:
    return node.get("anyOf") or node.get("oneOf") or []


@cache
def _leaves(model: Any) -> dict[Any, Any]:
    """{path: JSON schema} of every key that holds a value."""
    return {path: node for path, node in _walk(schema_of(model)) if "properties" not in node}


@cache
def _children(model: Any) -> dict[Any, Any]:
    """{path of a section: names of its keys}; the path "" is the whole input."""
    sections = ((path, node.get("items", node)) for path, node in _walk(schema_of(model)))
    return {path: list(node["properties"]) for path, node in sections if "properties" in node}


def _walk(schema: Any) -> Any:
    """Yield (path, node) of a JSON schema; sections and their lists come before their keys."""

    def known(node: Any) -> Any:
        if "$ref" in node:
            return schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
        return node | {"items": known(node["items"])} if "items" in node else node

    def below(path: Any, node: Any) -> Iterator[Any]:
        yield path, node
        for name, child in node.get("items", node).get("properties", {}).items():
            yield from below(f"{path}.{name}".removeprefix("."), known(child))

    return below("", schema)


def percent(share: float) -> str:
    """A share in per cent with two digits, without an exponent."""
    return f"{100 * share:.0f}" if share >= 0.1 else f"{100 * share:.2g}"


def signed_percent(share: float) -> str:
    """A share in per cent, as `percent`, with its sign."""
    return f"{'-' if share < 0.0 else '+'}{percent(abs(share))}"
