"""Algorithms have a name, a colour and a place in the report's order."""

from gsiirl.report.words.algorithms import ALGORITHMS, OTHER_COLOUR, algorithm_rank, algorithm_style


def test_listed_algorithms_have_a_colour_each() -> None:
    assert len({style.colour for style in ALGORITHMS.values()} | {OTHER_COLOUR}) == len(ALGORITHMS) + 1


def test_an_unlisted_algorithm_has_its_own_name_and_stands_last() -> None:
    assert (algorithm_style("lin2019").name, algorithm_style("lin2019").colour) == ("lin2019", OTHER_COLOUR)
    assert sorted(["lin2019", "a", "paper", "marl"], key=algorithm_rank) == ["marl", "paper", "a", "lin2019"]
