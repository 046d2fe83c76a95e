"""Runs of a plan at the same time, each in a process of its own.

A run uses about one core, and much of a short one is compilation. A process takes one run, so that a run's memory goes
with it, and keeps to its share of the cores: runs that spread over all of them spend much of the time on waiting for
each other. The last run of all keeps to its share too.
"""

import os
import signal
import threading
import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from multiprocessing import connection, get_context, parent_process
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple

from rich.progress import Progress

from gsiirl.errors import InputError, InputWarning
from gsiirl.experiments import runner
from gsiirl.experiments.config import ExperimentConfig
from gsiirl.experiments.plans.planned_run import PlannedRun, cores, do, is_finished
from gsiirl.program.progress import Begun, shown
from gsiirl.program_cache import overlook_faults


class Started(NamedTuple):
    """A run in its process, which tells how far it is through `heard` and closes it at its end."""

    run: PlannedRun
    process: BaseProcess
    heard: Any
    shown: Begun
    share: set[int]


def do_side_by_side(planned: Sequence[PlannedRun], jobs: int, quiet: bool) -> None:
    """Do every run, `jobs` of them at a time; if one cannot be done, the others that have begun are stopped.

    Raises:
        InputError: as the run that cannot be done raised it; or the process of a run ended before the run did.
    """
    waiting, started, free = list(planned), dict[Any, Started](), shares(min(jobs, len(planned)))
    with ExitStack() as at_the_end:
        progress = at_the_end.enter_context(shown(quiet))
        at_the_end.callback(lambda: _stop(list(started.values())))
        whole = progress.add_task(f"all {len(planned)} runs", total=len(planned))
        while waiting or started:
            while waiting and len(started) < jobs:
                each = _start(waiting.pop(0), free.pop(), progress)
                started[each.heard] = each
            for heard in connection.wait(list(started)):
                each = started[heard]
                if not _listen(each):
                    _ended(started.pop(heard))
                    free.append(each.share)
                    progress.advance(whole)


def shares(jobs: int) -> list[set[int]]:
    """The cores that each of `jobs` runs keeps to: every one's own, or all where they are fewer than runs."""
    every = cores()
    return [set(every[job::jobs] if jobs <= len(every) else every) for job in range(jobs)]


def _start(run: PlannedRun, share: set[int], progress: Progress) -> Started:
    context = get_context("spawn")
    heard, telling = context.Pipe(duplex=False)
    process = context.Process(target=_in_own_process, args=(*run, share, telling), daemon=True)
    process.start()
    # Only the run's process holds this end now, so that its end shows.
    telling.close()
    return Started(run, process, heard, Begun(progress, runner.title(run.config)), share)


def _listen(each: Started) -> bool:
    """Take in one message; whether there may be more."""
    try:
        message = each.heard.recv()
    except EOFError:
        return False
    if isinstance(message, tuple):
        each.shown.tell(*message)
        return True
    raise message


def _ended(each: Started) -> None:
    each.process.join()
    each.heard.close()
    each.shown.end()
    if each.process.exitcode or not is_finished(each.run.folder):
        problem = f"the process of this run was ended (status {each.process.exitcode})"
        raise InputError(str(each.run.folder), problem, "the same command goes on with it")


def _stop(running: list[Started]) -> None:
    for each in running:
        each.process.kill()
    for each in running:
        each.process.join()


def _in_own_process(folder: Path, config: ExperimentConfig, share: set[int], telling: Any) -> None:
    if hasattr(os, "sched_setaffinity"):
        # Before the first array, which counts the cores.
        os.sched_setaffinity(0, share)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # Whoever started this run has looked at its folder before.
    warnings.simplefilter("ignore", InputWarning)
    overlook_faults()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with telling:
        try:
            do(PlannedRun(folder, config), lambda done, of: telling.send((done, of)))
        except InputError as error:
            telling.send(error)
        except KeyboardInterrupt:
            # Whoever started this run was interrupted as well, and says so.
            os._exit(130)


def _end_with_parent() -> None:
    """A run that nobody waits for would get in the way of the one that goes on with it."""
    parent = parent_process()
    assert parent is not None, "a run of its own process was started by none"
    parent.join()
    os._exit(1)
