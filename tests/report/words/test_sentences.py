"""Parts of sentences."""

from gsiirl.report.words.sentences import counted, enumeration


def test_one_is_singular() -> None:
    assert [counted(count, "seed") for count in (0, 1, 3)] == ["0 seeds", "1 seed", "3 seeds"]


def test_the_last_part_follows_an_and() -> None:
    assert [enumeration(list("abc"[:count])) for count in (1, 2, 3)] == ["a", "a and b", "a, b and c"]
