"""Stress tests and measurements that are too long for ``make test``; not part of the package."""
