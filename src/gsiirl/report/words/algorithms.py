"""Name, colour and order of the algorithms."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AlgorithmStyle:
    """How one algorithm is shown."""

    name: str
    colour: str


ALGORITHMS = {
    "marl": AlgorithmStyle("MARL", "#111827"),
    "marl-maddpg": AlgorithmStyle("MARL (MADDPG)", "#15803d"),
    "ma-irl": AlgorithmStyle("MA-IRL", "#d97706"),
    "lin2019": AlgorithmStyle("LP after Lin et al. 2019", "#be185d"),
    "gsiirl": AlgorithmStyle("GSIIRL", "#2563eb"),
    "paper": AlgorithmStyle("GSIIRL, paper's preset", "#9333ea"),
}
"""In the order in which the report lists them."""

OTHER_COLOUR = "#0d9488"
"""Of an algorithm that is not listed above."""


def algorithm_style(algorithm: str) -> AlgorithmStyle:
    """The style of an algorithm; one that is not listed is shown under the name that its run gives it."""
    return ALGORITHMS.get(algorithm) or AlgorithmStyle(algorithm, OTHER_COLOUR)


def algorithm_rank(algorithm: str) -> tuple[int, str]:
    """Sort key for the report's order: listed algorithms as above, then the others by name."""
    known = list(ALGORITHMS)
    return (known.index(algorithm) if algorithm in known else len(known), algorithm)
