"""The command line. Nothing heavy is imported before a command needs it, so that `--help` answers at once."""

import errno
import logging
import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from typing import Any, TextIO, get_args, get_type_hints

from cyclopts import App, Argument, CycloptsError, Token
from cyclopts.exceptions import (
    CoercionError,
    MissingArgumentError,
    RepeatArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from gsiirl._version import __version__
from gsiirl.compilation import silence
from gsiirl.errors import InputError, InputWarning
from gsiirl.program_cache import keep_programs, overlook_faults

app = App(
    name="gsiirl",
    help="Learn an expert's reward by living with it: general-sum interactive inverse reinforcement learning.",
    version=__version__,
    help_format="plaintext",
    # `main` reports every error and interruption, in one line.
    print_error=False,
    exit_on_error=False,
    suppress_keyboard_interrupt=False,
    result_action="return_value",
)
_run = App(name="run", help="Run one experiment.")
_run.command(
    "gsiirl.experiments.commands:security",
    name="security",
    help="A defender lives with an attacker on an attack graph.",
)
_run.command("gsiirl.experiments.commands:crossing", name="crossing", help="A robot crosses the way of a human.")
_run.command(
    "gsiirl.experiments.commands:deception",
    name="deception",
    help="Two agents keep an adversary from their target.",
)
_run.command("gsiirl.experiments.commands:game", name="game", help="Your own finite game, from a file of arrays.")
app.command(_run)
app.command("gsiirl.experiments.commands:resume", name="resume", help="Go on with an interrupted run.")
_network = App(name="network", help="Look into a network's file, or make one from a plain topology.")
_network.command(
    "gsiirl.experiments.network_commands:check",
    name="check",
    help="What a network file holds and lacks, and what a run on it takes.\n\n"
    "The exit status is 0 when `gsiirl run security --graph FILE` can begin, 1 when something is missing or the run "
    "would take too much memory, and 2 when the file cannot be read or is refused.",
)
_network.command(
    "gsiirl.experiments.network_commands:build",
    name="build",
    help="A game from a plain topology and a table of vulnerabilities, for `gsiirl run security --graph`.",
)
app.command(_network)
app.command(
    "gsiirl.experiments.evaluate:evaluate",
    name="evaluate",
    help="Play a finished run's policies in somebody else's implementation of the game: mpe2's physical deception.",
)
app.command(
    "gsiirl.experiments.transfer.commands:transfer",
    name="transfer",
    help="What a finished run's learned rewards are worth where the game has changed.",
)
app.command(
    "gsiirl.experiments.plans.commands:sweep",
    name="sweep",
    help="Many runs: every combination of the values that a file gives, here or on a Ray cluster.",
)
app.command(
    "gsiirl.experiments.plans.commands:reproduce",
    name="reproduce",
    help="The paper's comparison: every algorithm on every game, then the report.",
)
app.command(
    "gsiirl.experiments.plans.commands:ablation",
    name="ablation",
    help="What each change of the default over the paper's preset is worth, on random attack graphs.",
)
app.command(
    "gsiirl.theory.commands:theory",
    name="theory",
    help="Measure each lemma and theorem of the paper on small random games.\n\n"
    "The exit status is 1 when a measurement misses a bound that the claim sets it.",
)

app.command(
    "gsiirl.finished.commands:report",
    name="report",
    help="Tables, figures and one HTML page from finished runs and from what `gsiirl theory` measured.",
)
app.command(
    "gsiirl.finished.commands:table",
    name="table",
    help="One metric of many runs: means by the settings that differ, and which of two is higher.",
)
app.command(
    "gsiirl.finished.commands:export",
    name="export",
    help="A run's metrics and what it learned, as CSV files or for TensorBoard.",
)

app.register_install_completion_command(
    help="Let your shell complete commands, flags and names: adds a file, and to your shell's start a line."
)

UNWRITABLE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EPIPE}
"""Errors of an output that can take no more: it goes to a file on a full disk, or to a program that has ended."""

SOON = 0.05
"""Seconds until an interruption that was lost is made again."""


@app.command(name="list")
def list_known() -> None:
    """Known experiments, scenarios, algorithms, solvers and experts."""
    from gsiirl.experiments.config import EXPERIMENTS
    from gsiirl.scenarios import known_scenarios

    def choices(field: str) -> list[str]:
        """What any of the experiments lets the field be, each once."""
        return list(
            dict.fromkeys(
                name for kind in EXPERIMENTS.values() for name in get_args(get_type_hints(kind).get(field, None))
            )
        )

    known = {
        "experiments": list(EXPERIMENTS),
        "scenarios": known_scenarios(),
        "algorithms": choices("algorithm"),
        "solvers": choices("solver"),
        "experts": choices("expert"),
    }
    for kind, names in known.items():
        print(f"{kind:<12} {', '.join(names) or 'none'}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line and return its exit status.

    0; 1 where every seed failed, a network cannot be run or a bound was missed; 2 for bad input; 130 when interrupted.
    """
    keep_programs()
    silence()
    # It takes a user without a home folder for a fault, in words of its own.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    status = 0
    try:
        status = _status_of(sys.argv[1:] if argv is None else list(argv))
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        # Without a file it is of the output, or a fault of the program's.
        if error.filename is not None or error.errno not in UNWRITABLE:
            raise
        _let_go(sys.stdout)
        _say(f"standard output: cannot be written ({error.strerror}); make room for it, or send it elsewhere")
        return status or 2
    return status


def _status_of(arguments: list[str]) -> int:
    try:
        with _told_in_lines(), _ended_like_interrupted():
            status = app(arguments)
    except (InputError, CycloptsError) as error:
        _say(str(error if isinstance(error, InputError) else _as_input_error(error)))
        return 2
    except OSError as error:
        # What nobody has put in better words.
        if error.filename is None:
            raise
        _say(f"{error.filename}: cannot be used ({error.strerror}); use another, or allow it")
        return 2
    except KeyboardInterrupt as interruption:
        _say(": ".join(["interrupted", *map(str, interruption.args)]))
        return 130
    return status if isinstance(status, int) else 0


def _say(line: str) -> None:
    """A line of the program's own, where it can be said at all."""
    try:
        print(f"gsiirl: {line}", file=sys.stderr)
    except OSError:
        _let_go(sys.stderr)


def _let_go(stream: TextIO | None) -> None:
    """What could not be written would be tried, and told of, once more at the end of the program."""
    if stream is not None:
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextmanager
def _told_in_lines() -> Iterator[None]:
    """A warning about what is read is one line, once, however often it is read."""
    with warnings.catch_warnings():
        show, said = warnings.showwarning, set[str]()

        def tell(message: Warning | str, category: type[Warning], *others: Any, **more: Any) -> None:
            if not issubclass(category, InputWarning):
                show(message, category, *others, **more)
            elif str(message) not in said:
                said.add(str(message))
                _say(str(message))

        warnings.simplefilter("always", InputWarning)
        overlook_faults()
        warnings.showwarning = tell
        yield


@contextmanager
def _ended_like_interrupted() -> Iterator[None]:
    """SIGTERM, with which a cluster ends a job, does what Ctrl-C does; and neither is lost.

    An interruption that comes while Python calls back, as JAX lets it at every collection of garbage, is printed and
    forgotten by Python. It is made once more then, a moment later.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before, tell = signal.signal(signal.SIGTERM, signal.default_int_handler), sys.unraisablehook
    again: list[threading.Timer] = []

    def interrupt_again(lost: Any) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            tell(lost)
            return
        again.append(threading.Timer(SOON, signal.pthread_kill, (threading.main_thread().ident, signal.SIGTERM)))
        again[-1].daemon = True
        again[-1].start()

    sys.unraisablehook = interrupt_again
    try:
        yield
    finally:
        for timer in again:
            timer.cancel()
        sys.unraisablehook = tell
        signal.signal(signal.SIGTERM, before)


def _as_input_error(error: CycloptsError) -> InputError:
    """What the parser has to say, in the words of every other error."""
    command = " ".join(["gsiirl", *(error.command_chain or ())])
    see_help = f"see `{command} --help`"
    match error:
        case UnknownCommandError(unused_tokens=[typed, *_], app=App() as parent):
            names = [name for name in parent if name.startswith("-") == typed.startswith("-")]
            mend = _nearest(typed, names) or f"choose from {', '.join(names)}"
            return InputError(typed, f"is no {'flag' if typed.startswith('-') else 'command'} of `{command}`", mend)
        case UnknownOptionError():
            typed = error.token.keyword or error.token.value
            names = [name for argument in error.argument_collection for name in argument.names]
            return InputError(typed, f"is no flag of `{command}`", _nearest(typed, names) or see_help)
        case MissingArgumentError(argument=Argument() as argument):
            usage = " ".join(filter(None, [argument.name, argument.parameter.metavar]))
            if error.keyword:
                return InputError(error.keyword, "has no value", f"give it as {usage}")
            for typed in error.unused_tokens or ():
                if mend := _nearest(typed, argument.names):
                    return InputError(typed, f"is no flag of `{command}`", mend)
            return InputError(argument.name, "is missing", f"add {usage}")
        case RepeatArgumentError():
            return InputError(error.token.keyword or error.token.value, "is given more than once", "give it once")
        case CoercionError(token=Token() as token):
            return InputError(token.keyword or token.value, f"cannot be {token.value}", see_help)
        case UnusedCliTokensError(unused_tokens=[typed, *_]):
            return InputError(typed, f"is one argument too many for `{command}`", see_help)
        case _:
            return InputError(command, str(error).rstrip("."), see_help)


def _nearest(typed: str, names: Iterable[str]) -> str | None:
    near = get_close_matches(typed.split("=")[0], list(names), n=1)
    return f"did you mean {near[0]}?" if near else None
