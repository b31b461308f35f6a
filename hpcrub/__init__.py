"""hpcrub: blade-tip rubbing of mistuned bladed disks."""

__version__ = "0.1.0"


def __getattr__(name):
    """`hpcrub.plot`, imported when it is asked for: matplotlib takes a second."""
    if name == "plot":
        from importlib import import_module

        return import_module("hpcrub.plot")
    raise AttributeError(f"module 'hpcrub' has no attribute {name!r}")
