"""Runs of a plan at the same time, on this machine: a few processes, each with cores of its own."""

from collections import Counter, deque
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing import connection
from pathlib import Path
from typing import Any

from rich.progress import Progress

from gsiirl.errors import InputError
from gsiirl.experiments import runner
from gsiirl.experiments.plans.planned_run import RETRIES, PlannedRun
from gsiirl.experiments.plans.worker import Worker
from gsiirl.program.cores import cores
from gsiirl.program.progress import Begun, shown


@dataclass(frozen=True)
class Busy:
    """A worker, and the run that it does."""

    worker: Worker
    run: PlannedRun
    shown: Begun


def do_side_by_side(planned: Sequence[PlannedRun], jobs: int, quiet: bool) -> dict[Path, InputError]:
    """Do every run, `jobs` of them at a time; for those that could not be done the reason, by folder.

    A run whose process ends (killed, or out of memory) is gone on with in another one, `RETRIES` times.
    """
    waiting, busy, lost = deque(planned), dict[Any, Busy](), Counter[Path]()
    failures: dict[Path, InputError] = {}
    with ExitStack() as at_the_end:
        progress = at_the_end.enter_context(shown(quiet))
        free = [_started(share, at_the_end) for share in shares(min(jobs, len(planned)))]
        whole = progress.add_task(f"all {len(planned)} runs", total=len(planned))
        while waiting or busy:
            while waiting and free:
                each = _begun(free.pop(), waiting.popleft(), progress)
                busy[each.worker.heard] = each
            for heard in connection.wait(list(busy)):
                each = busy[heard]
                try:
                    message = each.worker.heard.recv()
                except (EOFError, OSError):
                    # The process is gone; its run is the next one that another process takes.
                    del busy[heard]
                    each.shown.end()
                    status = each.worker.end()
                    free.append(_started(each.worker.share, at_the_end))
                    lost[each.run.folder] += 1
                    if lost[each.run.folder] <= RETRIES:
                        waiting.appendleft(each.run)
                        continue
                    failures[each.run.folder] = ended(each.run, lost[each.run.folder], f"status {status}")
                else:
                    if isinstance(message, tuple):
                        each.shown.tell(*message)
                        continue
                    del busy[heard]
                    each.shown.end()
                    free.append(each.worker)
                    if message is not None:
                        failures[each.run.folder] = message
                progress.advance(whole)
    return failures


def ended(run: PlannedRun, times: int, how: str) -> InputError:
    """What is said of a run whose process ended before it did."""
    problem = f"the process of this run was ended {times} times ({how})"
    return InputError(str(run.folder), problem, "see that there is memory enough; the same command goes on with it")


def shares(jobs: int) -> list[set[int]]:
    """The cores that each of `jobs` runs keeps to: every one's own, or all where they are fewer than runs."""
    every = cores()
    return [set(every[job::jobs] if jobs <= len(every) else every) for job in range(jobs)]


def _started(share: set[int], at_the_end: ExitStack) -> Worker:
    worker = Worker(share)
    at_the_end.callback(worker.process.join)
    at_the_end.callback(worker.process.kill)
    return worker


def _begun(worker: Worker, run: PlannedRun, progress: Progress) -> Busy:
    begun = Busy(worker, run, Begun(progress, runner.title(run.config)))
    worker.take(run)
    return begun
