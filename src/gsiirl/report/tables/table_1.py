"""The paper's Table 1: its experiments side by side, our returns beside the paper's."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.read.group import GameGroup
from gsiirl.report.tables.comparison import ComparisonRow
from gsiirl.report.tables.paper_results import PAPER_RESULTS, paper_results
from gsiirl.report.tables.rivals import Rival, rivals_of
from gsiirl.report.words.algorithms import algorithm_rank, algorithm_style

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
    def marl(self) -> Rival | None:
        """MARL as a rival of GSIIRL; None where one of them is missing, or MARL was not deployed."""
        rivals = rivals_of(self.group)
        found = rivals.of("marl") if rivals is not None and rivals.subject.algorithm == "gsiirl" else None
        return None if found is None or found.verdict is None else found

    @property
    def sentence(self) -> str:
        """The verdict on GSIIRL beside MARL, and the paper's."""
        paper = f"the paper's GSIIRL ends {PAPER_RESULTS[self.group.experiment].gap} its MARL"
        if self.marl is None or self.marl.verdict is None:
            return f"{self.heading}: no GSIIRL and MARL to compare, both deployed, here; {paper}."
        words = self.marl.verdict.words()
        told = {"better": "better than MARL", "worse": "worse than MARL", "the same": "the same as MARL"}.get(
            words, words
        )
        return (
            f"{self.heading} ({self.game}): GSIIRL less MARL, both deployed: {self.marl.difference}: {told}; {paper}."
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
            games = [
                (group, rows) for group, rows in compared if group.experiment == experiment and paper_results(group)
            ]
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
                **({"gap_to_marl": column.marl.verdict.json()} if column.marl and column.marl.verdict else {}),
            }
            for column in self.columns
        ]
