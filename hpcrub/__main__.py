"""The program, as `python main.py`, `python -m hpcrub` or the command `hpcrub`."""

import sys
from importlib import import_module

from hpcrub.run import parallel

COMMANDS = {name: name for name in ("run", "merge", "inspect", "plot", "export")} | {
    "import": "import_model"
}


def main(argv=None):
    """Run a command, `run` when none is named; returns the exit code."""
    parallel.listen()  # the libraries that the next line loads take a second
    argv = sys.argv[1:] if argv is None else argv
    name, *rest = argv if argv and argv[0] in COMMANDS else ("run", *argv)
    if name == "run":  # on all ranks
        return import_module("hpcrub.commands.run").main(rest)
    return parallel.alone(lambda: import_module(f"hpcrub.commands.{COMMANDS[name]}").main(rest))


if __name__ == "__main__":
    raise SystemExit(main())
