"""The command `gsiirl evaluate`. `gsiirl.cli` imports this module only when it is asked for."""

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

COLUMNS = ("learner", "expert", "sum")


def evaluate(
    folder: Annotated[Path, Parameter(name="DIR", help="Folder of a finished run of deception, variant mpe.")],
    /,
    *,
    simulator: Annotated[
        Literal["mpe2"],
        Parameter(
            name="--in", metavar="mpe2", show_choices=False, help="Whose game: mpe2 is the package that publishes it."
        ),
    ],
    pair: Annotated[
        Literal["deployed", "model"],
        Parameter(
            metavar="deployed|model",
            show_choices=False,
            help="Whom the learner meets: the true expert's best response to it, or the expert of its model. "
            "Of marl too: the best response found, or its own expert.",
        ),
    ] = "deployed",
    episodes: Annotated[str, Parameter(metavar="INT", help="Episodes of each seed, the same for all.")] = "1000",
    quiet: Annotated[bool, Parameter(negative="", help="Show no progress.")] = False,
) -> None:
    """Play a run's policies in somebody else's implementation of the game; writes evaluation-mpe2.json into DIR."""
    from gsiirl.experiments.config import at_least_one
    from gsiirl.experiments.run_config import MANY

    number = at_least_one("--episodes", episodes, MANY)
    from gsiirl.experiments.deception.mpe2_evaluation import PlayedRun, evaluate_in_mpe2

    run = PlayedRun.open(folder)
    evaluation = evaluate_in_mpe2(run, pair, number, quiet)
    _print_table(evaluation)
    print(folder / f"evaluation-{simulator}.json")
    if run.failed_seeds:
        print(f"gsiirl: {folder}: left out failed seeds {', '.join(map(str, run.failed_seeds))}", file=sys.stderr)


def _print_table(evaluation: dict[str, Any]) -> None:
    """A row a seed, then mean and standard deviation over them: returns in mpe2 and in our port."""
    import rich
    from rich.table import Table

    error = evaluation["largest_standard_error"]
    table = Table(
        title=f"{evaluation['algorithm']}, {evaluation['pair']} pair, {evaluation['episodes']} episodes",
        caption=f"{evaluation['simulator']} and our port draw other initial states; one standard error in mpe2 "
        f"is up to {error['learner']:.2f} (learner) and {error['expert']:.2f} (expert)",
    )
    table.add_column("seed", justify="right")
    for side in COLUMNS:
        for place in ("mpe2", "port"):
            table.add_column(f"{side}\n{place}", justify="right")
    cells = [evaluation[place][side] for side in COLUMNS for place in ("in_mpe2", "in_port")]
    seeds = evaluation["seeds"]
    for row, seed in enumerate(seeds):
        table.add_row(str(seed), *(f"{cell['per_seed'][row]:.2f}" for cell in cells), end_section=row == len(seeds) - 1)
    table.add_row("mean", *(f"{cell['mean']:.2f}" for cell in cells))
    table.add_row("± std", *(f"{cell['std']:.2f}" for cell in cells))
    rich.print(table)
