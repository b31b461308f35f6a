"""hpcrub: blade-tip rubbing of mistuned bladed disks.

`hpcrub.run(CONFIG)` computes a study of a `hpcrub.Config`. `hpcrub.open(FILE)` reads its result
file, in a `with` statement. `hpcrub.plot.NAME(FILE)` draws a figure of it. A failure raises a
`hpcrub.HpcrubError` with a message of one line, bad input its subclass `hpcrub.InputError`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.2.0"

if TYPE_CHECKING:
    from hpcrub import plot
    from hpcrub.commands.notebook import run
    from hpcrub.config.schema import Config
    from hpcrub.errors import HpcrubError, InputError
    from hpcrub.results.reader import Results
    from hpcrub.results.reader import Results as open  # noqa: A004, as h5py.File or gzip.open

LAZY = {
    "open": ("hpcrub.results.reader", "Results"),
    "run": ("hpcrub.commands.notebook", "run"),
    "Config": ("hpcrub.config.schema", "Config"),
    "HpcrubError": ("hpcrub.errors", "HpcrubError"),
    "InputError": ("hpcrub.errors", "InputError"),
    "Results": ("hpcrub.results.reader", "Results"),
}
__all__ = ["Config", "HpcrubError", "InputError", "Results", "__version__", "open", "plot", "run"]


def __dir__() -> list[str]:
    """List the public names, so that a notebook completes them."""
    return __all__


def __getattr__(name: str) -> Any:
    """Import a public name when it is asked for, so that `import hpcrub` takes no time."""
    if name == "plot":
        return import_module("hpcrub.plot")
    if name not in LAZY:
        raise AttributeError(f"module 'hpcrub' has no attribute {name!r}")
    module, member = LAZY[name]
    return getattr(import_module(module), member)
