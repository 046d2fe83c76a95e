"""How the report names, colours and orders the algorithms."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AlgorithmStyle:
    """How one algorithm is shown."""

    name: str
    description: str
    colour: str


ALGORITHMS = {
    "marl": AlgorithmStyle("MARL", "given both true rewards: the yardstick", "#111827"),
    "marl-maddpg": AlgorithmStyle("MARL (MADDPG)", "the same, solved by MADDPG", "#15803d"),
    "ma-irl": AlgorithmStyle("MA-IRL", "learns from fixed demonstrations", "#d97706"),
    "gsiirl": AlgorithmStyle("GSIIRL", "learns by interacting", "#2563eb"),
    "paper": AlgorithmStyle("GSIIRL, paper's preset", "the algorithm as the paper prints it", "#9333ea"),
}
"""In the order in which the report lists them."""

OTHER_COLOURS = ("#0d9488", "#be185d", "#65a30d", "#7c2d12")


def algorithm_style(algorithm: str) -> AlgorithmStyle:
    """The style of any algorithm; one not known here is shown under its own name."""
    if algorithm in ALGORITHMS:
        return ALGORITHMS[algorithm]
    colour = OTHER_COLOURS[sum(algorithm.encode()) % len(OTHER_COLOURS)]
    return AlgorithmStyle(algorithm, "", colour)


def algorithm_rank(algorithm: str) -> tuple[int, str]:
    """Sort key of the report's order."""
    known = list(ALGORITHMS)
    return (known.index(algorithm) if algorithm in known else len(known), algorithm)
