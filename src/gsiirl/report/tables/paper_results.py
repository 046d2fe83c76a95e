"""The results that the paper prints (its Table 1)."""

from dataclasses import dataclass

from gsiirl.report.read.group import GameGroup

Returns = dict[str, tuple[float, float]]
"""Mean and standard deviation, by side."""


@dataclass(frozen=True)
class PaperResults:
    """One column of the paper's Table 1."""

    column: str
    returns: dict[str, Returns]
    """By algorithm, as printed."""
    gap: str
    """How far the paper's GSIIRL ends from its MARL, in words."""
    note: str
    """How far its numbers can be compared with ours."""


def _results(column: str, marl: Returns, ma_irl: Returns, gsiirl: Returns, gap: str, note: str) -> PaperResults:
    # The paper's algorithm is what our preset `paper` rebuilds.
    returns = {"marl": marl, "ma-irl": ma_irl, "gsiirl": gsiirl, "paper": gsiirl}
    return PaperResults(column, returns, gap, note)


PAPER_RESULTS = {
    "deception": _results(
        "MPE",
        marl={"learner": (5.43, 1.66), "expert": (-16.91, 2.01)},
        ma_irl={"learner": (5.12, 4.08), "expert": (-20.37, 4.27)},
        gsiirl={"learner": (4.54, 1.81), "expert": (-19.53, 2.50)},
        gap="16 % below",
        note="The paper's figures (Table 1, MPE) are of the same environment, solved by MADDPG. What one side gains "
        "there the other loses, so how well either is trained moves both figures: they stand here for orientation.",
    ),
    "crossing": _results(
        "HRI",
        marl={"learner": (-20.22, 3.34), "expert": (-12.98, 4.78)},
        ma_irl={"learner": (-20.63, 1.07), "expert": (-13.52, 2.57)},
        gsiirl={"learner": (-21.69, 1.87), "expert": (-13.16, 1.03)},
        gap="7.3 % below",
        note="The paper prints neither the horizon nor the radii and penalties of its rewards, so its figures (Table "
        "1, HRI) stand here for orientation: they cannot be compared digit by digit.",
    ),
    "security": _results(
        "CS",
        marl={"learner": (-16.96, 1.45), "expert": (6.96, 1.45)},
        ma_irl={"learner": (-17.08, 3.21), "expert": (7.03, 3.21)},
        gsiirl={"learner": (-17.38, 3.59), "expert": (6.76, 3.59)},
        gap="2.5 % below",
        note="The paper's graph is not published, so its figures (Table 1, CS: cyber security) stand here for "
        "orientation: they cannot be compared digit by digit.",
    ),
}
"""By experiment, in the order of the paper's columns."""

PAPER_NODES, PAPER_EDGES = 8, 10
"""Of the paper's attack graph, which was drawn at random."""


def paper_results(group: GameGroup) -> PaperResults | None:
    """What the paper prints of such a game; None where it has none, and of other networks than one like its own."""
    if group.experiment == "security":
        parts = [group.game.get(name) for name in ("nodes", "edges")]
        sizes = [len(each) if isinstance(each, list) else 0 for each in parts]
        if group.first.made.settings.get("graph") or sizes != [PAPER_NODES, PAPER_EDGES]:
            return None
    return PAPER_RESULTS.get(group.experiment)
