"""hpcrub: blade-tip rubbing of mistuned bladed disks."""

__version__ = "0.1.0"
