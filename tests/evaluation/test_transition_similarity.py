import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats

from gsiirl.evaluation.transition_similarity import PLAYS, epic, pearson, spearman, starc
from gsiirl.games import Crossing, CrossingState
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides, Transition


def sample(seed: int) -> Transition:
    values = np.random.default_rng(seed).normal(size=(4, 60)).astype(np.float32)
    return Transition(values[0], Sides(values[1], values[2]), values[3])


def first(seen: Transition) -> jax.Array:
    return seen.following + 0.5 * seen.actions.expert


def second(seen: Transition) -> jax.Array:
    return seen.following**2 - seen.actions.expert


@pytest.mark.parametrize("seed", range(3))
def test_pearson_is_that_of_numpy(seed: int) -> None:
    seen = sample(seed)
    expected = np.corrcoef(np.asarray(first(seen)), np.asarray(second(seen)))[0, 1]
    assert float(pearson(first, second, seen)) == pytest.approx(expected, abs=1e-5)


def test_scale_and_offset_change_nothing_a_sign_turns_it_and_a_constant_is_like_nothing() -> None:
    seen = sample(0)
    assert float(pearson(first, lambda one: 3.0 * first(one) - 7.0, seen)) == pytest.approx(1.0, abs=1e-5)
    assert float(pearson(first, lambda one: -first(one), seen)) == pytest.approx(-1.0, abs=1e-5)
    assert float(pearson(first, lambda one: 0.0 * first(one), seen)) == 0.0


def test_epic_is_0_for_the_same_1_for_the_opposite_and_between_as_the_distance_of_standard_scores() -> None:
    assert [float(epic(jnp.asarray(each))) for each in (1.0, -1.0)] == [0.0, 1.0]
    one, other = (np.asarray(each(sample(1)), float) for each in (first, second))
    one, other = ((each - each.mean()) / each.std() for each in (one, other))
    # Half the distance of the two rewards once both have mean 0 and variance 1.
    expected = 0.5 * np.sqrt(np.mean((one - other) ** 2))
    assert float(epic(pearson(first, second, sample(1)))) == pytest.approx(expected, abs=1e-5)


def test_spearman_is_that_of_scipy_and_asks_for_the_order_alone() -> None:
    seen = sample(2)
    expected = scipy.stats.spearmanr(np.asarray(first(seen)), np.asarray(second(seen)))[0]
    assert float(spearman(first, second, seen)) == pytest.approx(expected, abs=1e-5)
    assert float(spearman(first, lambda one: jnp.exp(first(one)), seen)) == pytest.approx(1.0, abs=1e-5)


CROSSING, DISCOUNT = Crossing(horizon=40), 0.5


def near_a_place(seen: Transition) -> jax.Array:
    human, robot = seen.following.positions.expert, seen.following.positions.learner
    return -jnp.sum((human - jnp.asarray([-0.5, 0.1])) ** 2) - 0.3 * jnp.tanh(jnp.vdot(human, robot))


def with_effort(seen: Transition) -> jax.Array:
    return seen.following.positions.expert[0] ** 3 + jnp.sum(seen.actions.expert**2)


def unrelated(seen: Transition) -> jax.Array:
    return jnp.sin(20.0 * seen.following.positions.learner[1]) + seen.actions.learner[0]


def shaped(reward: TransitionReward) -> TransitionReward:
    def potential(state: CrossingState) -> jax.Array:
        return jnp.cos(3.0 * state.positions.expert[0]) + state.positions.learner[1] ** 2

    return lambda seen: 2.0 * reward(seen) + DISCOUNT * potential(seen.following) - potential(seen.state) + 0.7


def states(number: int) -> CrossingState:
    places = jnp.asarray(np.random.default_rng(3).uniform(-0.8, 0.8, (2, number, 2)))
    return CrossingState(Sides(places[0], places[1]))


def distance(one: TransitionReward, other: TransitionReward, discount: float = DISCOUNT) -> float:
    return float(starc(one, other, CROSSING, states(40), jax.random.key(5), discount))


def test_starc_ignores_scale_constants_and_shaping_and_nothing_else() -> None:
    assert distance(near_a_place, shaped(near_a_place)) < 1e-8
    assert distance(near_a_place, lambda seen: 3.0 * near_a_place(seen) - 9.0, 0.95) < 1e-8
    assert distance(near_a_place, lambda seen: near_a_place(seen) + 0.2 * unrelated(seen)) > 0.05


def test_to_starc_the_opposite_is_farthest_and_an_unrelated_reward_between() -> None:
    assert distance(near_a_place, lambda seen: -near_a_place(seen)) == pytest.approx(1.0, abs=1e-8)
    assert 0.3 < distance(near_a_place, unrelated) < 0.9


def test_starc_is_what_plays_one_by_one_come_to() -> None:
    now, later = jax.random.split(jax.random.key(5))
    at_once = np.asarray(jax.random.uniform(now, (40, 4), float, -1.0, 1.0))
    plays = np.asarray(jax.random.uniform(later, (PLAYS, 40, 4), float, -1.0, 1.0))

    def pays(before: np.ndarray, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        (x, y, u, v), (_, _, right, up) = (after := before + 0.1 * actions), actions
        tables = -((u + 0.5) ** 2 + (v - 0.1) ** 2) - 0.3 * np.tanh(u * x + v * y), u**3 + right**2 + up**2
        return after, np.array(tables)

    def worth(state: np.ndarray, steps: int) -> np.ndarray:
        total = np.zeros(2)
        for play in plays:
            at = state
            for step in range(steps):
                at, paid = pays(at, play[step])
                total += DISCOUNT**step * paid
        return total / PLAYS

    rows = []
    for place, actions in zip(np.concatenate(jax.tree.leaves(states(40)), axis=1), at_once, strict=True):
        after, paid = pays(place, actions)
        rows.append(paid + DISCOUNT * worth(after, 39) - worth(place, 40))
    one, other = np.array(rows).T
    expected = 0.5 * np.linalg.norm(one / np.linalg.norm(one) - other / np.linalg.norm(other))
    assert distance(near_a_place, with_effort) == pytest.approx(expected, abs=1e-9)
