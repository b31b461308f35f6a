"""Programs that measure the product; `python -m evidence.NAME --help` tells what each of them does.

They compute on one thread, as every rank of a study does.
"""

import os

for _name in ("OMP", "OPENBLAS", "NUMBA"):
    os.environ.setdefault(f"{_name}_NUM_THREADS", "1")  # before NumPy and Numba are imported
