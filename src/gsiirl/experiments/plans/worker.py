"""A process that does one run of a plan after another.

It keeps to its share of the cores: runs that spread over all of them spend much of the time on waiting for each other.
It takes run after run, because to start Python and JAX takes as long as a short run.
"""

import os
import signal
import threading
import warnings
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from gsiirl.errors import InputError, InputWarning
from gsiirl.experiments.plans.planned_run import PlannedRun, do
from gsiirl.program.progress import Told
from gsiirl.program_cache import overlook_faults

LARGEST = 3 * 1024**3
"""Bytes of memory from which on a process forgets its programs, which save most of the time of a run like the last."""

Message = tuple[int, int] | InputError | None
"""How far a run is; why it cannot be done; that it has ended."""


class Worker:
    """A process with its share of the cores; it tells how far its run is through `heard`, and closes it at its end."""

    def __init__(self, share: set[int]) -> None:
        context = get_context("spawn")
        self.heard, telling = context.Pipe()
        self.share = share
        self.process: BaseProcess = context.Process(target=_work, args=(share, telling), daemon=True)
        self.process.start()
        # Only the process holds this end now, so that its end shows.
        telling.close()

    def take(self, planned: PlannedRun) -> None:
        """Do this run next; a process that has just ended is found out by whoever listens."""
        try:
            self.heard.send(planned)
        except OSError:
            return

    def end(self) -> int | None:
        """Stop it at once; its exit status, if it had ended by itself."""
        self.process.join(timeout=0.1)
        status = self.process.exitcode
        self.process.kill()
        self.process.join()
        self.heard.close()
        return status


def keep_to(share: set[int]) -> None:
    """Let this process use these cores alone; to be called before the first array, which counts the cores."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, share)


def _is_large() -> bool:
    """Whether this process holds more memory than `LARGEST`, or nobody knows."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return True
    return pages * os.sysconf("SC_PAGE_SIZE") > LARGEST


def tried(planned: PlannedRun, told: Told | None = None) -> InputError | None:
    """Do a run; why it cannot be done, if it cannot. Its programs stay for the next one until they take much memory."""
    with warnings.catch_warnings():
        # Whoever planned this run has looked at its folder before.
        warnings.simplefilter("ignore", InputWarning)
        overlook_faults()
        try:
            do(planned, told)
        except InputError as error:
            return error
        finally:
            if _is_large():
                import jax

                jax.clear_caches()
    return None


def _work(share: set[int], telling: Connection) -> None:
    keep_to(share)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        while True:
            telling.send(tried(telling.recv(), lambda done, of: telling.send((done, of))))
    except EOFError:
        return
    except KeyboardInterrupt:
        # Whoever started this process was interrupted as well, and says so.
        os._exit(130)


def _end_with_parent() -> None:
    """A run that nobody waits for would get in the way of the one that goes on with it."""
    parent = parent_process()
    assert parent is not None, "a worker was started by no process"
    parent.join()
    os._exit(1)
