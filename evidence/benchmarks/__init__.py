"""Run time beside the machine and a plain C program: `make bench`."""
