"""A contact law of the user's own, from the Python file that an input names."""

import importlib.util
import sys
from types import ModuleType
from typing import Any

from hpcrub.config.schema import Config
from hpcrub.contact.protocols import Law
from hpcrub.errors import InputError
from hpcrub.results import model_file

MEMBERS = [name for name in vars(Law) if not name.startswith("_")]


def law_of(config: Config) -> Any:
    """Class of `contact.own_law`, which every rank loads for itself; None without that key.

    Raises InputError for a file that has changed or does not run, and for a class that is no law.
    """
    if config.contact.own_law is None:
        return None
    path, _, name = config.contact.own_law.rpartition(":")
    checksum = config.contact.own_law_sha256 or model_file.checksum(path)
    model_file.require("contact.own_law", path, checksum)
    law = getattr(_module(path, checksum), name, None)
    if law is None:
        raise InputError(f"contact.own_law: {path} has no class {name}")
    if lacking := [member for member in MEMBERS if not hasattr(law, member)]:
        raise InputError(
            f"contact.own_law: {name} of {path} lacks {', '.join(lacking)}; "
            "hpcrub.contact.protocols.Law lists the methods of a law"
        )
    return law


def _module(path: str, checksum: str) -> ModuleType:
    """Module of a file, by a name that pickle finds again on every rank."""
    name = f"own_law_{checksum[:16]}"
    if name in sys.modules:  # a copy of the file is the same law
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None  # the key asks for a file that ends with .py
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise InputError(f"contact.own_law: {path}: {type(error).__name__}: {error}") from None
    return module
