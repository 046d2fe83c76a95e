"""The summary holds each seed's last iteration, over the seeds that did not fail."""

import numpy as np
import polars
import pytest

from gsiirl.runs import Statistics, Summary, summarise

CONFIG = {"experiment": "security", "algorithm": "gsiirl"}


def metrics(deployed: list[float], random: float = -9.0, **others: list[float]) -> polars.DataFrame:
    """Two iterations a seed; only the last has the given values."""
    seeds = len(deployed)
    columns = {"deployed_return_learner": deployed, "random_return_learner": [random] * seeds, **others}
    return polars.DataFrame(
        {
            "seed": np.repeat(np.arange(seeds), 2),
            "iteration": np.tile([0, 5], seeds),
            **{name: np.ravel([(-100.0, value) for value in values]) for name, values in columns.items()},
        }
    )


def test_final_is_the_last_iteration_of_each_seed() -> None:
    summary = summarise(CONFIG, metrics([-4.0, -5.0, -6.0]), completed=True)
    final = summary.final
    assert summary == Summary("security", "gsiirl", [0, 1, 2], [], 5, completed=True, final=final)
    assert final["deployed_return_learner"] == Statistics(-5.0, 1.0, [-4.0, -5.0, -6.0])
    assert summary.final.keys() == {"deployed_return_learner", "random_return_learner"}


def test_a_single_seed_has_standard_deviation_zero() -> None:
    summary = summarise(CONFIG, metrics([-4.0]), completed=False)
    assert summary.final["deployed_return_learner"].std == 0.0
    assert summary.completed is False


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e101])
def test_a_seed_with_a_value_that_is_not_finite_failed(value: float) -> None:
    summary = summarise(CONFIG, metrics([-4.0, -5.0, -6.0], nash_gap=[0.1, value, 0.3]), completed=True)
    assert summary.failed_seeds == [1]
    assert summary.final["deployed_return_learner"].per_seed == [-4.0, -6.0]
    assert summary.final["nash_gap"].per_seed == [0.1, 0.3]


def test_a_missing_value_is_not_finite() -> None:
    table = metrics([-4.0, -5.0]).with_columns(
        nash_gap=polars.Series([0.0, None, 0.0, 0.2], dtype=polars.Float64, strict=True)
    )
    assert summarise(CONFIG, table, completed=True).failed_seeds == [0]


def test_a_seed_below_random_play_failed_and_one_equal_to_it_did_not() -> None:
    summary = summarise(CONFIG, metrics([-4.0, -9.5, -9.0]), completed=True)
    assert summary.failed_seeds == [1]


def test_an_early_return_below_random_play_is_no_failure() -> None:
    table = metrics([-4.0])
    assert table["deployed_return_learner"][0] < -9.0
    assert summarise(CONFIG, table.with_columns(random_return_learner=-9.0), completed=True).failed_seeds == []


def test_random_play_is_not_asked_of_marl_or_without_the_columns() -> None:
    for algorithm in ("marl", "marl-maddpg"):
        assert summarise({**CONFIG, "algorithm": algorithm}, metrics([-9.5]), completed=True).failed_seeds == []
    without = metrics([-9.5]).drop("random_return_learner")
    assert summarise(CONFIG, without, completed=True).failed_seeds == []


def test_marl_too_fails_where_a_value_is_not_finite() -> None:
    assert summarise({**CONFIG, "algorithm": "marl"}, metrics([np.nan]), completed=True).failed_seeds == [0]


def test_final_is_empty_when_every_seed_failed_() -> None:
    summary = summarise(CONFIG, metrics([np.nan, -9.5]), completed=True)
    assert summary.failed_seeds == [0, 1]
    assert summary.final == {}


def test_seeds_interrupted_at_different_iterations_each_give_their_last() -> None:
    table = metrics([-4.0, -5.0]).filter((polars.col("seed") == 0) | (polars.col("iteration") == 0))
    summary = summarise(CONFIG, table.with_columns(random_return_learner=-200.0), completed=False)
    assert summary.final["deployed_return_learner"].per_seed == [-4.0, -100.0]


def test_no_metrics_give_an_empty_summary() -> None:
    empty = polars.DataFrame(schema={"seed": polars.Int64, "iteration": polars.Int64})
    summary = summarise(CONFIG, empty, completed=False)
    assert (summary.seeds, summary.iterations, summary.final) == ([], 0, {})
