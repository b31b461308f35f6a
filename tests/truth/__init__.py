"""References of the tests: the disk of the paper, plain-Python twins of compiled code."""
