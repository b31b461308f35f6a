"""`hpcrub keys`: the keys of an input file, as a table or as a JSON schema for editors."""

import argparse
import json
from collections.abc import Sequence
from typing import Any

from hpcrub.config.schema import Config
from hpcrub.config.text import key_table, schema_of
from hpcrub.errors import InputError
from hpcrub.ranks.progress import say


def main(argv: Sequence[str] | None = None) -> int:
    """Print the keys; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub keys", description=__doc__)
    parser.add_argument("name", nargs="?", default="", help="only keys with this in their path")
    parser.add_argument(
        "--schema", action="store_true", help="print a JSON schema, for completion in editors"
    )
    options = parser.parse_args(argv)
    if options.schema:
        say(json.dumps(schema(), indent=1, ensure_ascii=False))
        return 0
    keys = [key for key in key_table(Config) if options.name in key.path]
    if not keys:
        raise InputError(f"no key has {options.name!r} in its path")
    for key in keys:
        say(f"{key.path}: {key.default}\n    {key.description} ({key.allowed})")
    return 0


def schema() -> dict[str, Any]:
    """Return the JSON schema of an input file: all keys with their ranges, names of the studies."""
    known = schema_of(Config)
    runs = {
        "type": "array",
        "items": {"type": "object"},
        "description": "several runs, each with the keys that it replaces, by their whole path",
    }
    with_runs = {"properties": known["properties"] | {"runs": runs}}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | known | with_runs
