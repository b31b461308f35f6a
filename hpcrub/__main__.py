"""The program, as `python main.py`, `python -m hpcrub` or the command `hpcrub`."""

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from hpcrub.run import parallel

COMMANDS = {name: name for name in ("run", "merge", "inspect", "plot", "export")} | {
    "import": "import_model"
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command, `run` when none is named; returns the exit code."""
    open_standard_streams()
    parallel.listen()  # the libraries that the next line loads take a second
    argv = sys.argv[1:] if argv is None else argv
    name, *rest = argv if argv and argv[0] in COMMANDS else ("run", *argv)
    if name == "run":  # on all ranks
        return import_module("hpcrub.commands.run").main(rest)
    return parallel.alone(lambda: import_module(f"hpcrub.commands.{COMMANDS[name]}").main(rest))


def open_standard_streams() -> None:
    """Lead standard streams that are closed into nothing.

    Otherwise the first files that are opened take their numbers, and what is printed goes there.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
            setattr(sys, name, open(number, "r" if number == 0 else "w"))  # noqa: SIM115


if __name__ == "__main__":
    raise SystemExit(main())
