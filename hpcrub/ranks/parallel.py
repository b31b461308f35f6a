"""Tasks on MPI ranks. Only this module imports mpi4py, and only when the program runs under MPI.

Rank 0 hands out the tasks (`schedule` decides which) and computes some itself; it answers the other
ranks from a `poll()` that the computation calls every few hundredths of a second. No threads and no
one-sided messages are needed.

Stopping: a signal only sets a flag. The next poll tells rank 0, rank 0 tells everybody, and the
polls of all ranks raise `Interrupted`, so that every rank leaves `run_tasks` in the same way.

An error that all ranks share (`on_root`, `together`) carries `shared = True` and ends all ranks in
good order. Any other exception belongs to one rank only, and aborts the job.
"""

import os
import signal
import time
import traceback
from collections.abc import Callable, Iterable
from typing import Any, NoReturn

from hpcrub.config.text import one_line
from hpcrub.errors import HpcrubError, InputError, Interrupted, WriteError, complain, flush
from hpcrub.ranks.dispatch import PAUSE, Dispatcher, Worker
from hpcrub.ranks.schedule import Assignments, Tasks

MOST_CHARACTERS = 400  # of either end of an error line
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)

# (number of ranks, this rank) as the launchers tell it: Open MPI, MPICH and Intel MPI, srun
LAUNCHERS = (
    ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    ("PMI_SIZE", "PMI_RANK"),
    ("SLURM_STEP_NUM_TASKS", "SLURM_PROCID"),
)


def listen() -> None:
    """Let stop signals end the program at once, with a line and exit code, until `run` begins."""
    for number in STOP_SIGNALS:
        signal.signal(number, _stop_at_once)


def _stop_at_once(number: int, frame: Any) -> None:
    _print_error(Interrupted(f"{_name(number)} came before anything was begun"), launched_rank())
    os._exit(Interrupted.exit_code)  # without a traceback from a half-done import


def _name(number: int) -> Any:
    return signal.Signals(number).name


def run(program: Callable[["Team"], int]) -> int:
    """Run program(team) on this rank and end all ranks in good order.

    program: function of a `Team` that returns an exit code.
    Returns the exit code. A failure is printed once; an exception of one rank aborts all ranks.
    """
    team, rank, handlers = Team(), launched_rank(), {}  # until the ranks know each other
    try:
        size = launched_size()
        team, rank = Team(_world(size) if size else None), 0
        handlers = {number: signal.signal(number, team.remember) for number in STOP_SIGNALS}
        code = program(team)
        team.barrier()
        return code
    except HpcrubError as error:
        shared = getattr(error, "shared", False)
        if not shared or team.rank == 0:
            _print_error(error, rank)
        broken = isinstance(error, WriteError)
        if broken and team.size == 1:
            leave(error.exit_code)
        if broken and shared and team.rank > 0:
            time.sleep(1.0)  # rank 0 has printed the error, and aborts all ranks
        if broken or not shared:
            team.abort(error.exit_code)
        return error.exit_code
    except BaseException as error:
        if isinstance(error, MemoryError):
            _print_error(f"not enough memory: {error}", 0)
        else:
            complain(traceback.format_exc())
        team.abort(1)
        return 1
    finally:  # the signal that rank 0 has passed on may still be on its way to this rank
        for number, handler in handlers.items():
            signal.signal(number, signal.SIG_IGN if handler is _stop_at_once else handler)


def leave(code: int) -> None:
    """End this process now, without the exit handlers of Python and of the libraries."""
    flush()
    os._exit(code)


def alone(program: Callable[[], int]) -> int:
    """Run a command of one process; returns its exit code.

    An error is printed as one line. So is a stop signal, which ends the command in good order.
    """

    def stop(number: int, frame: Any) -> NoReturn:
        raise KeyboardInterrupt(_name(number))  # code that handles Exception lets it pass

    handlers = {number: signal.signal(number, stop) for number in STOP_SIGNALS}
    try:
        return program()
    except KeyboardInterrupt as stopped:
        _print_error(Interrupted(f"{stopped} came"), 0)
        return Interrupted.exit_code
    except HpcrubError as error:
        _print_error(error, 0)
        if isinstance(error, WriteError):
            leave(error.exit_code)
        return error.exit_code
    finally:
        for number, handler in handlers.items():
            signal.signal(number, signal.SIG_DFL if handler is _stop_at_once else handler)


def launched_size() -> int:
    """Number of ranks that a launcher announces in the environment, 0 without one."""
    for size, _ in LAUNCHERS:
        if os.environ.get(size, "").isdigit():
            n_ranks = int(os.environ[size])
            if n_ranks > 1 or not size.startswith("SLURM"):  # batch scripts have 1 and no MPI
                return n_ranks
    return 1 if "PMIX_RANK" in os.environ else 0


def launched_rank() -> int:
    """Number of this rank as the launcher tells it, 0 without one."""
    names = [rank for _, rank in LAUNCHERS] + ["PMIX_RANK"]
    ranks = [os.environ[name] for name in names if os.environ.get(name, "").isdigit()]
    return int(ranks[0]) if ranks else 0


def _world(size: Any) -> Any:
    """MPI's world communicator, checked against the launcher's number of ranks.

    Raises InputError when a launcher started several ranks that cannot find each other.
    """
    try:
        import mpi4py

        mpi4py.rc.threads = False
        from mpi4py import MPI
    except (ImportError, RuntimeError, OSError) as error:
        if size == 1:
            return None
        raise InputError(
            f"started on {size} ranks, but mpi4py or its MPI library is missing "
            f"({str(error).splitlines()[0]}); run `make setup`, or `pip install mpi4py`"
        ) from None
    if MPI.COMM_WORLD.size < size:
        raise InputError(
            f"started on {size} ranks, but MPI sees {MPI.COMM_WORLD.size}: the launcher belongs to "
            "another MPI library than mpi4py (with Slurm, try `srun --mpi=pmix` or `mpirun`)"
        )
    return MPI.COMM_WORLD


def _print_error(error: Any, rank: Any) -> None:
    if rank == 0:
        kind = "stopped" if isinstance(error, Interrupted) else "error"
        text = one_line(str(error))  # may quote anything from a user's file
        if len(text) > 2 * MOST_CHARACTERS:
            text = f"{text[:MOST_CHARACTERS]} ... {text[-MOST_CHARACTERS:]}"
        complain(f"hpcrub: {kind}: {text}")


class Team:
    """The ranks that work on one study, or a single process when comm is None."""

    def __init__(self, comm: Any = None) -> None:
        self.comm = comm
        self.rank = comm.rank if comm else 0
        self.size = comm.size if comm else 1
        self.signal = None  # name of the signal that asked this rank to stop

    def remember(self, number: int, frame: object) -> None:
        """Handle a signal: note its name, and nothing else."""
        self.signal = _name(number)

    def barrier(self) -> None:
        """Wait for all ranks without taking a core."""
        if self.size > 1:
            request = self.comm.Ibarrier()
            while not request.Test():
                time.sleep(PAUSE)

    def bcast(self, value: Any) -> Any:
        """Rank 0's value on every rank."""
        self.barrier()
        return self.comm.bcast(value) if self.size > 1 else value

    def on_root(self, function: Callable[[], Any]) -> Any:
        """Call function() on rank 0 only, and return its result on every rank.

        Raises, on every rank, the HpcrubError that function() raised on rank 0.
        """
        return _result_or_raise(*self.bcast(_caught(function) if self.rank == 0 else None))

    def together(self, function: Callable[[], Any]) -> Any:
        """Call function() on every rank, and return the result of each on that rank.

        Raises, on every rank, the HpcrubError of the first rank whose call raised one.
        """
        result, error = _caught(function)
        self.barrier()
        errors = self.comm.gather(error) if self.size > 1 else [error]
        first = next((e for e in errors if e), None) if self.rank == 0 else None
        return _result_or_raise(result, self.bcast(first))

    def abort(self, code: int) -> None:
        """End all ranks now."""
        flush()
        if self.size > 1:
            self.comm.Abort(code)

    def run_tasks(
        self,
        tasks: Tasks | Iterable[Any],
        compute: Callable[[Any, Callable[[], None]], Any],
        on_result: Callable[[Any, Any], object] = lambda task, result: None,
    ) -> None:
        """Compute all tasks.

        tasks: `schedule.Tasks`, or an iterable of tasks (small and picklable); rank 0's are used.
        compute(task, poll): called on any rank; must call poll() many times a second and let
        Interrupted pass; returns a small picklable result. on_result(task, result): called on rank
        0 in order of completion; returns a true value when no further task is needed.
        Raises Interrupted on every rank after a stop signal on any; running tasks are dropped.
        """
        side: Any = Worker(self, compute)
        if self.rank == 0:
            side = Dispatcher(self, Assignments(tasks, self.size), compute, on_result)
        stopped_by = self.bcast(side.run())  # a signal may come after rank 0 has said the end
        if stopped_by:
            _result_or_raise(None, Interrupted(stopped_by))


def _caught(function: Any) -> tuple[Any, Any]:
    """Return (result, None), or (None, error) where function() raised an HpcrubError."""
    try:
        return function(), None
    except HpcrubError as error:
        return None, error


def _result_or_raise(result: Any, error: Any) -> Any:
    if error is not None:
        error.shared = True
        raise error
    return result
