"""The program, as `python main.py`, `python -m hpcrub` or the command `hpcrub`."""

import signal


def main():
    """Run the program; returns the exit code."""
    # Until hpcrub listens to signals itself, Ctrl-C ends it at once: no half-done import to trace.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from hpcrub.cli import main

    return main()


if __name__ == "__main__":
    raise SystemExit(main())
