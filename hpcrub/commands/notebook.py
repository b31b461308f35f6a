"""`hpcrub.run`: compute a study from Python, as the command line does."""

import html
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hpcrub.config.schema import Config, load_runs
from hpcrub.errors import HpcrubError, InputError, Interrupted

ERRORS = {InputError.exit_code: InputError, Interrupted.exit_code: Interrupted}
PROGRESS = re.compile(r"[a-z ]+: (\d+) of (?:at most |about )*(\d+)\b.*")
LAST = 20  # lines of output that an error quotes when the failure is not hpcrub's own


def run(
    config: Config | Mapping[str, Any] | str | os.PathLike[str],
    ranks: int = 1,
    *,
    output: str | os.PathLike[str] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    figures: bool = False,
    quiet: bool = False,
) -> Path:
    """Compute a study and return its result file, to be read with `hpcrub.open`.

    It runs in a process of its own, as from the command line: with one thread a rank, so that its
    results are the same bits, and with all that is needed to stop and resume it.

    Parameters
    ----------
    config
        What to compute: a `hpcrub.Config`, the keys of an input as nested dictionaries, or the path
        of an input file of a single run.
    ranks
        MPI ranks on this machine.
    output
        Result file; by default the configuration's own.
    resume, overwrite
        What to do with a result file that is there already; by default it is refused.
    figures
        Draw the figures of the study, too.
    quiet
        Print no progress, which in a notebook is a bar.

    Returns
    -------
    Path
        Result file.

    Raises
    ------
    InputError
        Something is wrong with the input; nothing has been computed.
    HpcrubError
        The study has failed.

    Examples
    --------
    >>> import hpcrub
    >>> config = hpcrub.Config(mistuning={"samples": 20}, output="few.h5")
    >>> with hpcrub.open(hpcrub.run(config, ranks=2)) as file:
    ...     table = file.to_dataframe("samples")
    """
    asked = _configuration(config)
    if not ranks >= 1:
        raise InputError(f"ranks: {ranks} is not a whole number from 1")
    if output is not None:
        asked = asked.replace({"output": os.fspath(output)})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "input.yaml")
        keys = asked.model_dump(mode="json", exclude_unset=True)
        path.write_text(json.dumps(keys, ensure_ascii=False), encoding="utf-8")
        options = [f"--output={asked.output}"] + ["--resume"] * resume + ["--overwrite"] * overwrite
        options += ["--no-figures"] * (not figures)
        launcher = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
        _call([*launcher, sys.executable, "-m", "hpcrub", "run", str(path), *options], quiet)
    return Path(asked.output).expanduser()


def _configuration(config: Any) -> Config:
    if isinstance(config, Config):
        return config
    if isinstance(config, Mapping):
        return Config(**config)
    if not isinstance(config, (str, os.PathLike)):
        raise InputError(f"{config!r} is no Config, no keys, and no path of an input file")
    runs = load_runs(Path(config))
    if len(runs) != 1:
        raise InputError(f"{config}: {len(runs)} runs; `hpcrub run` computes several")
    return runs[0]


class Bar:
    """Lines of output in a notebook: those of progress change one bar, all others are printed."""

    def __init__(self, display: Any) -> None:
        """Create it; display: `IPython.display`."""
        self.display, self.handle = display, None

    def __call__(self, line: str) -> None:
        """Show one line of output."""
        if not (found := PROGRESS.fullmatch(line.strip())):
            self.handle = None  # the next progress is of something else
            _print(line)
            return
        n_done, n_all = map(int, found.groups())
        bar = f'<progress value="{min(n_done, n_all)}" max="{n_all}"></progress>'
        page = self.display.HTML(f"{bar} {html.escape(line.strip())}")
        if self.handle is None:
            self.handle = self.display.display(page, display_id=True)
        else:
            self.handle.update(page)


def _shown() -> Any:
    """Function that shows a line of output, in a notebook or elsewhere."""
    ipython = sys.modules.get("IPython")
    if ipython and hasattr(ipython.get_ipython(), "kernel"):
        from IPython import display

        return Bar(display)
    return _print


def _print(line: str) -> None:
    print(line, end="", flush=True)


def _call(command: Any, quiet: Any) -> None:
    """Run a command and print its output line by line. Raises HpcrubError when it fails."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    said, show = [], _shown()
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        for line in process.stdout or ():
            said.append(line.strip())
            if not quiet:
                show(line)
    if process.returncode:
        ours = [line for line in said if line.startswith("hpcrub: ")]
        others = "\n".join(said[-LAST:])  # such as those of an mpirun that cannot start
        text = ours[-1] if ours else f"exit code {process.returncode}\n{others}"
        error = ERRORS.get(process.returncode, HpcrubError)
        raise error(text.removeprefix("hpcrub: ").removeprefix("error: "))
