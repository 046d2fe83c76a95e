"""Algorithms have a name, a colour and a place in the report's order."""

from gsiirl.report.words.algorithms import ALGORITHMS, OTHER_COLOUR, algorithm_rank, algorithm_style


def test_listed_algorithms_have_a_colour_each() -> None:
    assert len({style.colour for style in ALGORITHMS.values()} | {OTHER_COLOUR}) == len(ALGORITHMS) + 1


def test_an_unlisted_algorithm_has_its_own_name_and_stands_last() -> None:
    assert (algorithm_style("their-own").name, algorithm_style("their-own").colour) == ("their-own", OTHER_COLOUR)
    assert sorted(["their-own", "a", "paper", "marl"], key=algorithm_rank) == ["marl", "paper", "a", "their-own"]
