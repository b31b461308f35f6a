"""The program, as `python main.py`, `python -m hpcrub` or the command `hpcrub`."""

from hpcrub import parallel


def main():
    """Run the program; returns the exit code."""
    parallel.listen()  # the libraries that the next line loads take a second
    from hpcrub.cli import main

    return main()


if __name__ == "__main__":
    raise SystemExit(main())
