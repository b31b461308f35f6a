"""mpirun -n 2 python main.py inputs/quickstart.yaml"""

from hpcrub.__main__ import main

if __name__ == "__main__":
    raise SystemExit(main())
