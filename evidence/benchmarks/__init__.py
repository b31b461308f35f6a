"""Run time against error, and against the machine: `make bench`."""
