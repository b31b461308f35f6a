"""Faults of machines, disks and people, caused on purpose: ``make test-faults``."""
