import numpy as np
import pytest

from gsiirl.experiments.transfer.regret import over_changes, rows


def test_regret_is_what_is_missed_of_what_lies_between_random_play_and_the_true_rewards():
    values = {
        "true rewards": np.array([[-2.0], [-5.0]]),
        "learned": np.array([[-2.5, -1.0], [-6.0, -3.0]]),
        "random": np.array([[-7.0], [-20.0]]),
    }
    found = rows(values)
    assert found["learned"]["discounted_return"]["per_seed"] == [-2.5, -1.0]
    assert found["learned"]["return"]["per_seed"] == [-6.0, -3.0]
    assert found["learned"]["regret"]["per_seed"] == [0.5, -1.0]
    assert found["learned"]["regret_percent"]["per_seed"] == pytest.approx([10.0, -20.0])
    assert found["random"]["regret_percent"]["mean"] == pytest.approx(100.0)


@pytest.mark.parametrize("random", [-2.0, -1.0])
def test_where_random_play_is_as_good_nothing_is_missed(random: float):
    values = {name: np.full((2, 1), value) for name, value in [("true rewards", -2.0), ("a", -3.0), ("random", random)]}
    assert rows(values)["a"]["regret"]["mean"] == 1.0
    assert rows(values)["a"]["regret_percent"]["mean"] == 0.0


def test_all_changes_count_alike_with_every_seed():
    def change(*percents: float) -> dict[str, object]:
        return {"rows": {"a": {"regret_percent": {"per_seed": list(percents)}}}}

    found = over_changes([change(0.0, 1.0, 2.0), change(3.0, 4.0)])["a"]
    assert found == pytest.approx({"mean": 2.0, "median": 2.0, "ninety_percent": 3.6, "worst": 4.0})
