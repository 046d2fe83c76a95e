"""How far a command is: bars on a terminal, lines in a log, nothing where it is to be quiet."""

import importlib.util
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import timedelta

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

EVERY = 30.0
"""Seconds after which a log gets a line, if nothing new has given it one."""
FIRST = 5.0
"""Seconds until the first line: what is refused by then gets no line but the error's."""
GLANCE = 0.5
"""Seconds between two looks for something new."""

Told = Callable[[int, int], None]
"""Who is told how many steps are done, and of how many: before a program is compiled, then whenever it returns."""


def nobody(done: int, of: int) -> None:
    """Told in quiet."""


def draws(console: Console) -> bool:
    """Whether bars can be drawn there: on a terminal, or in a notebook, for which rich needs ipywidgets."""
    if console.is_jupyter:
        return importlib.util.find_spec("ipywidgets") is not None
    return console.is_terminal and not console.is_dumb_terminal


@contextmanager
def shown(quiet: bool = False) -> Iterator[Progress]:
    """Tasks added to what this gives are shown: as bars, or off a terminal as lines."""
    progress = Progress(TextColumn("{task.description}"), BarColumn(), _Done(), TimeElapsedColumn())
    terminal = draws(progress.console)
    progress.disable = quiet or not terminal
    ended = threading.Event()
    writer = threading.Thread(target=_write_lines, args=(progress, ended), daemon=True)
    with progress:
        if not (quiet or terminal):
            writer.start()
        try:
            yield progress
        finally:
            ended.set()
            if writer.is_alive():
                writer.join()


class Begun:
    """A task that is under way, shown with what it does: it prepares, compiles, goes on, ends."""

    def __init__(self, progress: Progress, title: str) -> None:
        self._progress, self._title, self._compiled = progress, title, False
        self._task = progress.add_task(f"{title}: preparing", total=None)

    def tell(self, done: int, of: int) -> None:
        """How far it is; see `Told`."""
        doing = ": compiling" if not self._compiled else ": ending" if done == of else ""
        self._compiled = True
        self._progress.update(self._task, description=self._title + doing, completed=done, total=of or None)

    def end(self) -> None:
        """It is over, and shown no more."""
        self._progress.update(self._task, visible=False)


class _Done(MofNCompleteColumn):
    """How many of how many; empty where nothing is counted."""

    def render(self, task: Task) -> Text:
        return super().render(task) if task.total else Text()


def _write_lines(progress: Progress, ended: threading.Event) -> None:
    """A line whenever a task begins or does something else, and every `EVERY` seconds."""
    written, before = time.monotonic(), ""
    while not ended.wait(GLANCE if before else FIRST):
        tasks = [task for task in progress.tasks if task.visible]
        doing = "; ".join(task.description for task in tasks)
        if doing and (doing != before or time.monotonic() - written >= EVERY):
            # A log that cannot be written is no reason to stop what goes on.
            with suppress(OSError):
                progress.console.print("; ".join(map(_line, tasks)), markup=False, highlight=False, soft_wrap=True)
                progress.console.file.flush()
            written, before = time.monotonic(), doing


def _line(task: Task) -> str:
    counted = f" {task.completed:.0f} of {task.total:.0f}" if task.total else ""
    return f"{task.description}{counted} ({timedelta(seconds=int(task.elapsed or 0))})"
