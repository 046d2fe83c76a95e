"""The paper's Table 1: all its experiments side by side, ours beside the paper's."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.algorithm import algorithm_rank, algorithm_style
from gsiirl.report.comparison_table import ComparisonRow
from gsiirl.report.estimate import format_number
from gsiirl.report.gap import Gap
from gsiirl.report.group import GameGroup
from gsiirl.report.paper_results import PAPER_RESULTS

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
        """As the paper heads it."""
        return PAPER_RESULTS[self.group.experiment].column

    @property
    def game(self) -> str:
        """Which game the column shows."""
        name, variant = self.group.game.get("name"), self.group.game.get("variant")
        return f"{name}, {str(variant).replace('_', ' ')}" if variant else str(name)

    @property
    def choice(self) -> str:
        """Why this game, or nothing where there is but one."""
        if self.games == 1:
            return ""
        return (
            f"{self.heading} shows {self.game}: of the {self.games} games below the one with the most algorithms, and "
            "of equals the paper's variant."
        )

    @property
    def gap(self) -> Gap | None:
        """How far GSIIRL ends from MARL."""
        run = self.group.of("gsiirl")
        return None if run is None else Gap.of(self.group, run)

    @property
    def sentence(self) -> str:
        """The gap in words, beside the paper's."""
        paper = f"the paper's GSIIRL ends {PAPER_RESULTS[self.group.experiment].gap} its MARL"
        if self.gap is None:
            return f"{self.heading}: no GSIIRL to compare with MARL here; {paper}."
        found = self.gap.difference
        text = f"{self.heading} ({self.game}): GSIIRL, deployed, less MARL: {_signed(found.mean)}"
        if found.count > 1:
            text += f" (95 % interval {_signed(found.low)} to {_signed(found.high)}, {found.count} seeds)"
        else:
            text += " (one seed: no interval)"
        return f"{text}: {self.gap.verdict} than MARL; {paper}."


@dataclass(frozen=True)
class Table1:
    """All experiments of a report that the paper has too."""

    columns: list[Table1Column]

    @classmethod
    def of(cls, compared: list[tuple[GameGroup, list[ComparisonRow]]]) -> "Table1 | None":
        """From every game with its comparison; None where they are of fewer than two of the paper's experiments."""
        columns = []
        for experiment in PAPER_RESULTS:
            games = [(group, rows) for group, rows in compared if group.experiment == experiment]
            if games:
                # Of equals the paper's own variant, then what was given first.
                group, rows = max(games, key=lambda each: (len(each[1]), each[0].game.get("variant") in PAPER_VARIANTS))
                first = {row.algorithm: row for row in reversed(rows)}
                columns.append(Table1Column(group, first, len(games)))
        return cls(columns) if len(columns) > 1 else None

    @property
    def algorithms(self) -> dict[str, str]:
        """Those of any column, with their names, in the report's order."""
        found = {algorithm for column in self.columns for algorithm in column.rows}
        return {algorithm: algorithm_style(algorithm).name for algorithm in sorted(found, key=algorithm_rank)}

    @property
    def sentences(self) -> list[str]:
        """One an experiment."""
        return [column.sentence for column in self.columns]

    @property
    def choices(self) -> str:
        """Which game a column shows, where there was a choice."""
        return " ".join(column.choice for column in self.columns if column.choice)

    def json(self) -> list[dict[str, Any]]:
        """As it stands in `table.json`."""
        return [
            {
                "column": column.heading,
                "experiment": column.group.experiment,
                "game": column.group.game.get("name"),
                "variant": column.group.game.get("variant"),
                "returns": [column.rows[name].json() for name in self.algorithms if name in column.rows],
                "sentence": column.sentence,
                **({"gap_to_marl": column.gap.difference.json()} if column.gap else {}),
            }
            for column in self.columns
        ]


def _signed(value: float) -> str:
    return ("+" if value > 0 else "") + format_number(value)
