"""The command `gsiirl transfer`. `gsiirl.cli` imports this module only when it is asked for."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from gsiirl.errors import printable

MOST_CHANGES = 1000
LARGEST_SEED = 2**31 - 1


def transfer(
    folder: Annotated[Path, Parameter(name="DIR", help="Folder of a finished run of security or crossing.")],
    /,
    *,
    change: Annotated[
        tuple[str, ...],
        Parameter(
            metavar="CHANGE",
            negative="",
            show_default=False,
            help="security: remove-edge=A:B, add-edge=A:B or redraw=SEED (new probabilities of success); crossing: "
            "robot-goal=X:Y, robot-start=X:Y, human-start=X:Y, robot-speed=V or human-speed=V. Each one makes another "
            "changed game.",
        ),
    ] = (),
    changes: Annotated[
        str | None,
        Parameter(metavar="INT", help="Changes drawn at random, besides those given; 10 where none is given."),
    ] = None,
    change_seed: Annotated[str, Parameter(metavar="INT", help="Seed of the changes that are drawn.")] = "0",
    beside: Annotated[
        Path | None,
        Parameter(metavar="DIR", help="Another finished run on the same game, such as MA-IRL's, to compare with."),
    ] = None,
    quiet: Annotated[bool, Parameter(negative="", help="Show no progress.")] = False,
) -> None:
    """Take learned rewards to changed games, commit anew there, and compare; writes transfer.json into DIR.

    No new demonstrations are seen. What is deployed meets the true expert of the changed game and is judged by the true
    rewards.
    """
    from gsiirl.experiments.config import at_least_one, whole

    number = None if changes is None else at_least_one("--changes", changes, MOST_CHANGES)
    number = number or (0 if change else 10)
    seed = whole("--change-seed", change_seed, 0, LARGEST_SEED)
    learned = _opened(folder, "DIR")
    other = None if beside is None else _opened(beside, "--beside")
    found = learned.transferred([*change, *learned.drawn(number, seed)], other, quiet)
    for each in found["changes"]:
        _print_change(each)
    if len(found["changes"]) > 1:
        _print_all(found["all_changes"], len(found["changes"]))
    print(folder / "transfer.json")
    for each in (learned, other):
        if each is not None and each.left_out:
            seeds = ", ".join(map(str, each.left_out))
            print(f"gsiirl: {each.folder.path}: left out seeds {seeds}, which learned no numbers", file=sys.stderr)


def _opened(folder: Path, field: str) -> Any:
    """What was learned in a run, as its experiment reads it."""
    from gsiirl.experiments.crossing.transfer import LearnedCrossing
    from gsiirl.experiments.security.transfer import Learned
    from gsiirl.runs import RunFolder

    kind = LearnedCrossing if RunFolder.open(folder).config.get("experiment") == "crossing" else Learned
    return kind.open(folder, field)


def _print_change(found: Mapping[str, Any]) -> None:
    """A row for each way to come to a policy: means over seeds, and the worst seed's regret."""
    import rich
    from rich.markup import escape
    from rich.table import Table

    table = Table(
        title=escape(printable(found["change"])) + (f", {found['states']} states" if "states" in found else ""),
        caption="discounted true returns; regret to the true rewards, in per cent of what is between them and random",
    )
    table.add_column("policy from")
    for heading in ("return", "regret", "regret, %", "worst seed, %"):
        table.add_column(heading, justify="right")
    for name, row in found["rows"].items():
        percent = row["regret_percent"]
        table.add_row(
            name,
            f"{row['discounted_return']['mean']:.4f}",
            f"{row['regret']['mean']:.4f}",
            f"{percent['mean']:.2f}",
            f"{max(percent['per_seed']):.2f}",
        )
    rich.print(table)


def _print_all(found: Mapping[str, Any], number: int) -> None:
    """Regret in per cent over all seeds and changes."""
    import rich
    from rich.table import Table

    table = Table(title=f"regret in per cent, all seeds and {number} changes")
    table.add_column("policy from")
    for heading in ("mean", "median", "90 %", "worst"):
        table.add_column(heading, justify="right")
    for name, row in found.items():
        table.add_row(name, *(f"{row[key]:.2f}" for key in ("mean", "median", "ninety_percent", "worst")))
    rich.print(table)
