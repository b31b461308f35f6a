"""The program, as the command `hpcrub`, `python -m hpcrub` or `python main.py`."""

import difflib
import gc
import os
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NoReturn

from hpcrub import __version__
from hpcrub.errors import InputError, flush
from hpcrub.ranks import parallel

COMMANDS = {
    "run": "compute the study of an input file, and draw its figures",
    "plot": "draw figures from result files",
    "report": "write one HTML file to read, print and sign",
    "merge": "put the files of parts of one study together",
    "inspect": "say what a result file holds, how far it is, and whether it is sound",
    "import": "read the matrices of a finite-element program into a model file",
    "keys": "list the keys of an input file",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command, `run` when none is named; returns the exit code."""
    try:
        return _command(argv)
    finally:
        flush()  # at Python's end nobody could handle a reader that has left, or a full disk


def _command(argv: Sequence[str] | None) -> Any:
    if argv is None:  # the process is the program's own, and so are all its signals
        parallel.listen()  # before the libraries of a command are loaded, which takes a second
        if not sys.warnoptions:  # `python -W default` shows the warnings of libraries
            warnings.simplefilter("ignore")  # hpcrub itself prints what a user must know
        argv = sys.argv[1:]
    argv = list(argv)
    if argv[:1] in (["-h"], ["--help"]):
        from hpcrub.ranks.progress import say

        say(usage())
        return 0
    if argv and argv[0].isalpha() and argv[0] not in COMMANDS and not os.path.exists(argv[0]):
        return parallel.alone(lambda: unknown(argv[0]))
    name, *rest = argv if argv and argv[0] in COMMANDS else ("run", *argv)
    module = f"hpcrub.commands.{'import_model' if name == 'import' else name}"
    if name == "run":  # on all ranks
        return _loaded(module).main(rest)
    return parallel.alone(lambda: _loaded(module).main(rest))


def _loaded(module: str) -> Any:
    """Import a command with its libraries, without looking for garbage among what stays."""
    gc.disable()
    try:
        return import_module(module)
    finally:
        gc.enable()
        gc.freeze()


def unknown(word: str) -> NoReturn:
    """Raise InputError for an unknown command; the message names the nearest known one."""
    near = difflib.get_close_matches(word, COMMANDS, 1)
    hint = f"; did you mean hpcrub {near[0]}?" if near else " (--help lists the commands)"
    raise InputError(f"{word} is no command and no file{hint}")


def usage() -> str:
    """Return the help of the program: commands, studies, one example."""
    from hpcrub.commands.run import STUDIES_AND_EXAMPLE

    commands = "\n".join(f"  hpcrub {name:8} {what}" for name, what in COMMANDS.items())
    return (
        f"hpcrub {__version__}: blade-tip rubbing of mistuned bladed disks\n\n"
        f"commands (each has --help):\n{commands}\n\n{STUDIES_AND_EXAMPLE}"
    )


if __name__ == "__main__":
    raise SystemExit(main())
