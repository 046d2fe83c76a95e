"""Runs of a plan on a Ray cluster; their folders are on storage that all its machines share."""

import os
import tempfile
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from gsiirl.compilation import silence
from gsiirl.errors import InputError
from gsiirl.experiments.plans.planned_run import HERE, RETRIES, PlannedRun
from gsiirl.experiments.plans.side_by_side import ended
from gsiirl.experiments.plans.worker import keep_to, tried
from gsiirl.program.command import installing
from gsiirl.program.cores import cores
from gsiirl.program.progress import nobody, shown
from gsiirl.program_cache import keep_programs

GLANCE = 0.5
"""Seconds between two looks at what has ended."""
LOST = "Ray lost its worker"

_own: list[FileLock] = []
"""The lock of the core that this worker keeps to, held as long as its process lives."""


def do_on_ray(planned: Sequence[PlannedRun], address: str, jobs: int, quiet: bool) -> dict[Path, InputError]:
    """Do every run on the cluster at `address`; for those that could not be done the reason, by folder.

    A cluster `HERE` has `jobs` workers. Of another one every core that it offers is used. A worker keeps to a core of
    its own and does one run after another. A run whose worker is lost is gone on with by another, `RETRIES` times.

    Raises:
        InputError: Ray is not installed, or there is no cluster at the address.
    """
    ray = _ray()
    # Nothing of what is run here is told to others.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    known: dict[str, Any] = {"num_cpus": jobs, "include_dashboard": False} if address == HERE else {"address": address}
    keep_programs()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            ray.init(**known, log_to_driver=False, logging_level="CRITICAL", configure_logging=True)
        except (ConnectionError, ValueError, RuntimeError) as error:
            reason = str(error).splitlines()[0].rstrip(".")
            mend = "give the address of a cluster that was begun with `ray start --head`, or leave --address out"
            raise InputError("--address", f"no Ray cluster at {address} ({reason})", mend) from error
        try:
            return _carried_out(ray, planned, quiet)
        finally:
            ray.shutdown()


def _carried_out(ray: Any, planned: Sequence[PlannedRun], quiet: bool) -> dict[Path, InputError]:
    failures: dict[Path, InputError] = {}
    task = ray.remote(num_cpus=1, max_retries=RETRIES)(in_worker)
    here = os.getcwd()
    running = {task.remote(PlannedRun(each.folder.absolute(), each.config), here): each for each in planned}
    with shown(quiet) as progress:
        whole = progress.add_task(f"all {len(planned)} runs, on Ray", total=len(planned))
        while running:
            done, _ = ray.wait([*running], timeout=GLANCE)
            for each in done:
                run = running.pop(each)
                try:
                    error = ray.get(each)
                except ray.exceptions.RayError:
                    error = ended(run, RETRIES + 1, LOST)
                if error is not None:
                    failures[run.folder] = error
                progress.advance(whole)
    return failures


def in_worker(planned: PlannedRun, folder: str) -> InputError | None:
    """Do a run in a worker's process, from the folder in which the plan was made, which paths in it start from."""
    silence()
    keep_programs()
    if not _own:
        keep_to({_core_of_its_own()})
    with suppress(OSError):
        os.chdir(folder)
    return tried(planned, nobody)


def _core_of_its_own() -> int:
    """A core of this machine that no other worker keeps to, or its first one where all are taken.

    The lock is the kernel's, so that it ends with the process, however that ends.
    """
    place = Path(tempfile.gettempdir()) / f"gsiirl-cores-{os.getuid() if hasattr(os, 'getuid') else 'all'}"
    place.mkdir(exist_ok=True)
    for core in cores():
        lock = FileLock(place / f"{core}.lock")
        with suppress(Timeout):
            lock.acquire(timeout=0)
            _own.append(lock)
            return core
    return cores()[0]


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        mend = f"install it with `{installing('ray>=2.40')}`, or use --engine local"
        raise InputError("--engine", "ray is not installed", mend) from None
    return ray
