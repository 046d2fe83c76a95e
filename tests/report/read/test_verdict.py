"""Better, worse, the same or cannot tell: the rule on made-up results."""

import numpy as np
import pytest
from scipy import stats

from gsiirl.report.read.verdict import SeedValues, judge_difference

EXACT = None


def side(values: list[float] | np.ndarray, first_seed: int | None = 0) -> SeedValues:
    seeds = None if first_seed is None else list(range(first_seed, first_seed + len(values)))
    return SeedValues(np.array(values, dtype=float), seeds)


NOISE = [0.1, -0.2, 0.15, -0.05, 0.0, 0.12, -0.14, 0.02, 0.06, -0.06]
SWAPPED = NOISE[::-1]


def around(mean: float, seeds: int, noise: list[float] = NOISE) -> list[float]:
    return [mean + each for each in noise[:seeds]]


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        # One seed never decides, but a tie is a tie.
        (side([-4.6]), side([-6.3], EXACT), "cannot tell with 1 seed"),
        (side([-4.6]), side([-6.3]), "cannot tell with 1 seed"),
        (side(around(-4.6, 10)), side([-6.3]), "cannot tell with 1 seed"),
        (side([-10.0]), side([-10.0 + 2e-15], EXACT), "the same"),
        # Two seeds: what does not vary is certain, what varies rarely.
        (side([1.0, 1.0]), side([0.0, 0.0]), "better"),
        (side([0.0, 0.0]), side([1.0, 1.0], first_seed=7), "worse"),
        (side([4e-15, -4e-15]), side([0.0, 0.0]), "the same"),
        (side([-4.6, -4.7]), side([-6.3], EXACT), "better"),
        (side([-4.0, -6.0]), side([-6.3], EXACT), "cannot tell with 2 seeds"),
        # Three and ten seeds, against an exact number.
        (side(around(-4.6, 3)), side([-6.3], EXACT), "better"),
        (side(around(-6.4, 3)), side([-6.3], EXACT), "cannot tell with 3 seeds"),
        (side(around(-7.9, 3)), side([-6.3], EXACT), "worse"),
        (side(around(-6.3, 10)), side([-6.3], EXACT), "cannot tell with 10 seeds"),
        (side(around(-6.1, 10)), side([-6.3], EXACT), "better"),
        # The same noise on both sides goes away seed by seed, and not where the seeds are others.
        (side(around(-6.2, 3)), side(around(-6.3, 3, [each * 1.1 for each in NOISE])), "better"),
        (side(around(-6.2, 3)), side(around(-6.3, 3, [each * 1.1 for each in NOISE]), 3), "cannot tell with 3 seeds"),
        (side(around(-6.3, 10)), side(around(-6.3, 10, SWAPPED)), "cannot tell with 10 seeds"),
        (side(around(-6.3, 10)), side(around(-6.3, 10)), "the same"),
        (side(around(-5.3, 10)), side(around(-6.3, 4), 20), "better"),
        (side(around(-5.3, 10)), side(around(-6.3, 3)), "better"),
        # One seed in common is none: Welch.
        (side(around(-4.6, 3)), side(around(-6.3, 3), 2), "better"),
        # A failed seed counts, and one without a number lets nothing be said.
        (side([-4.6, -4.7, -99.0]), side([-6.3], EXACT), "cannot tell with 3 seeds"),
        (side([-4.6, np.nan, -4.5]), side([-6.3], EXACT), "cannot tell: 1 seed without a number"),
        (side([-4.6, np.nan, np.inf]), side([-6.3], EXACT), "cannot tell: 2 seeds without a number"),
    ],
)
def test_the_rule_on_made_up_results(first: SeedValues, second: SeedValues, words: str) -> None:
    assert judge_difference(first, second).words() == words
    turned = {"better": "worse", "worse": "better"}
    assert judge_difference(second, first).words() == turned.get(words, words)


def test_words_are_those_that_are_asked_for() -> None:
    verdict = judge_difference(side([1.0, 1.0]), side([0.0, 0.0]))
    assert verdict.words(higher="more often", lower="less often") == "more often"


def test_a_mean_that_ties_by_chance_is_no_tie() -> None:
    assert judge_difference(side([1.0, 2.0, 3.0]), side([3.0, 2.0, 1.0])).words() == "cannot tell with 3 seeds"


def test_rounding_is_in_units_of_the_numbers() -> None:
    assert judge_difference(side([1e6, 1e6]), side([1e6 + 0.5, 1e6 + 0.5])).words() == "the same"
    assert judge_difference(side([1e-4, 1e-4]), side([1.01e-4, 1.01e-4])).words() == "worse"


@pytest.mark.parametrize(("count", "others"), [(2, 2), (3, 3), (10, 3), (7, 12)])
def test_the_intervals_are_students_and_welchs(count: int, others: int) -> None:
    random = np.random.default_rng(count)
    ours, theirs = random.normal(1.0, 1.0, count), random.normal(0.0, 3.0, others)
    welch = stats.ttest_ind(ours, theirs, equal_var=False).confidence_interval(0.95)
    found = judge_difference(side(ours), side(theirs, first_seed=100))
    assert found.interval == pytest.approx((welch.low, welch.high))
    paired = stats.ttest_rel(ours[: min(count, others)], theirs[: min(count, others)]).confidence_interval(0.95)
    found = judge_difference(side(ours), side(theirs))
    assert (found.interval, found.count) == (pytest.approx((paired.low, paired.high)), min(count, others))


@pytest.mark.parametrize("seeds", [3, 10])
@pytest.mark.parametrize("others", ["the same seeds", "other seeds", "an exact number"])
def test_of_equal_learners_better_or_worse_is_said_in_5_per_cent(seeds: int, others: str) -> None:
    # Welch's test of 3 and 3 is a careful one: of very many pairs it says so in 3.5 %.
    pairs = 1000
    random = np.random.default_rng(1)
    ours, theirs = random.normal(-6.3, 0.4, (2, pairs, seeds))
    other = {
        "the same seeds": [side(each) for each in theirs],
        "other seeds": [side(each, first_seed=100) for each in theirs],
        "an exact number": [side([-6.3], EXACT)] * pairs,
    }[others]
    said = [judge_difference(side(each), rival).sign for each, rival in zip(ours, other, strict=True)]
    assert np.mean(np.abs(said)) == pytest.approx(0.05, abs=0.02)
