"""The paper's Table 1: its experiments side by side, our returns beside the paper's."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.gap import VERDICTS, gap_to_marl
from gsiirl.report.read.group import GameGroup
from gsiirl.report.tables.comparison import ComparisonRow
from gsiirl.report.tables.paper_results import PAPER_RESULTS
from gsiirl.report.words.algorithms import algorithm_rank, algorithm_style
from gsiirl.report.words.numbers import format_number

PAPER_VARIANTS = ("mpe", "default", "zero_sum")


@dataclass(frozen=True)
class Table1Column:
    """One experiment."""

    group: GameGroup
    rows: dict[str, ComparisonRow]
    """By algorithm, the first run of each."""
    games: int
    """How many games of the experiment the report has."""

    @property
    def heading(self) -> str:
        """The heading in the paper."""
        return PAPER_RESULTS[self.group.experiment].column

    @property
    def game(self) -> str:
        """Name and variant of the game."""
        name, variant = self.group.game.get("name"), self.group.game.get("variant")
        return f"{name}, {str(variant).replace('_', ' ')}" if variant else str(name)

    @property
    def choice(self) -> str:
        """The reason for this game; empty where there is only one."""
        if self.games == 1:
            return ""
        return (
            f"{self.heading} shows {self.game}: of the {self.games} games below the one with the most algorithms, and "
            "of equals the paper's variant."
        )

    @property
    def gap(self) -> Estimate | None:
        """The deployed return of GSIIRL less MARL's; None where one of them is missing."""
        run = self.group.of("gsiirl")
        return None if run is None else gap_to_marl(self.group, run)

    @property
    def sentence(self) -> str:
        """The gap in words, beside the paper's."""
        paper = f"the paper's GSIIRL ends {PAPER_RESULTS[self.group.experiment].gap} its MARL"
        if self.gap is None:
            return f"{self.heading}: no GSIIRL to compare with MARL here; {paper}."
        found = self.gap
        spread = f"95 % interval {_signed(found.low)} to {_signed(found.high)}, {found.count} seeds"
        return (
            f"{self.heading} ({self.game}): GSIIRL, deployed, less MARL: {_signed(found.mean)} "
            f"({spread if found.count > 1 else 'one seed: no interval'}): {VERDICTS[found.sign]} than MARL; {paper}."
        )


@dataclass(frozen=True)
class Table1:
    """The experiments of a report that are also in the paper."""

    columns: list[Table1Column]

    @classmethod
    def of(cls, compared: list[tuple[GameGroup, list[ComparisonRow]]]) -> "Table1 | None":
        """The table of games and their comparisons; None where the paper has fewer than two of their experiments."""
        columns = []
        for experiment in PAPER_RESULTS:
            games = [(group, rows) for group, rows in compared if group.experiment == experiment]
            if games:
                # The game with the most algorithms, of equals the paper's variant, of equals the one given first.
                group, rows = max(games, key=lambda each: (len(each[1]), each[0].game.get("variant") in PAPER_VARIANTS))
                first = {row.algorithm: row for row in reversed(rows)}
                columns.append(Table1Column(group, first, len(games)))
        return cls(columns) if len(columns) > 1 else None

    @property
    def algorithms(self) -> dict[str, str]:
        """Names of all algorithms of the columns, in the report's order."""
        found = {algorithm for column in self.columns for algorithm in column.rows}
        return {algorithm: algorithm_style(algorithm).name for algorithm in sorted(found, key=algorithm_rank)}

    @property
    def choices(self) -> str:
        """The reasons for the games that are shown, where there was a choice."""
        return " ".join(column.choice for column in self.columns if column.choice)

    def json(self) -> list[dict[str, Any]]:
        """The entry in `table.json`."""
        return [
            {
                "column": column.heading,
                "experiment": column.group.experiment,
                "game": column.group.game.get("name"),
                "variant": column.group.game.get("variant"),
                "returns": [column.rows[name].json() for name in self.algorithms if name in column.rows],
                "sentence": column.sentence,
                **({"gap_to_marl": column.gap.json()} if column.gap else {}),
            }
            for column in self.columns
        ]


def _signed(value: float) -> str:
    return ("+" if value > 0 else "") + format_number(value)
