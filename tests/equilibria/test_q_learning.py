import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria import QLearning
from gsiirl.equilibria.q_learning import _pick, _two_best, exploit, explore
from gsiirl.games import DensePayoff
from gsiirl.types import Sides
from tests import helpers, oracles

DISCOUNT = 0.9

solve = eqx.filter_jit(lambda model, game, rewards: model.solve(game, rewards, DISCOUNT))


def small_problem(seed=0):
    dense = oracles.random_game(seed, 3, 3, 4)
    return helpers.tabular_game(dense, 3), helpers.rewards_of(dense), dense


def one_shot_game():
    """One state and step; the learner's actions are worth 0, 2, 1 and the expert's 1, 0, 3, 2, nearly whatever."""
    other = np.random.default_rng(0).uniform(-0.2, 0.2, (1, 3, 4))
    dense = oracles.Game(
        transition=np.ones((1, 3, 4, 1)),
        learner_reward=np.array([0.0, 2.0, 1.0])[None, :, None] + other,
        expert_reward=np.array([1.0, 0.0, 3.0, 2.0])[None, None, :] - other,
        initial=np.ones(1),
    )
    return helpers.tabular_game(dense, 1), helpers.rewards_of(dense)


def test_the_best_action_is_played_with_60_percent_and_the_second_best_with_40():
    game, rewards = one_shot_game()
    policies = solve(QLearning(episodes=2_000, batch=20), game, rewards).policies
    np.testing.assert_allclose(policies.learner, [[[0.0, 0.6, 0.4]]], rtol=1e-15)
    np.testing.assert_allclose(policies.expert, [[[0.0, 0.0, 0.6, 0.4]]], rtol=1e-15)


@pytest.mark.parametrize("seed", range(2))
def test_a_side_alone_learns_the_optimal_values(seed):
    dense = oracles.random_game(seed, 3, 4, 1)
    solution = solve(QLearning(episodes=60_000, batch=200), helpers.tabular_game(dense, 3), helpers.rewards_of(dense))
    optimal, value = np.zeros((3, 3, 4)), np.zeros(3)
    for time in reversed(range(3)):
        optimal[time] = (dense.learner_reward + DISCOUNT * dense.transition @ value)[:, :, 0]
        value = optimal[time].max(axis=-1)
    np.testing.assert_allclose(solution.tables.learner, optimal, atol=0.03)
    assert np.abs(optimal).max() > 0.9
    assert bool(solution.converged)


def test_training_mixes_the_two_best_actions_with_uniform_play():
    table = jnp.array([[0.0, 3.0, 1.0, 2.0, -1.0], [1.0, 0.0, 0.0, 1.0, 1.0], [5.0, 0.0, 0.0, 0.0, 0.0]])
    visited = jnp.array([True, True, False])
    expected = np.full((3, 5), 0.3 / 5)
    expected[0, 1] += 0.7 * 0.6
    expected[0, 3] += 0.7 * 0.4
    # Ties go to the lower index.
    expected[1, 0] += 0.7 * 0.6
    expected[1, 3] += 0.7 * 0.4
    expected[2] = 1 / 5
    np.testing.assert_allclose(explore(table, visited), expected, rtol=1e-14)
    np.testing.assert_array_equal(exploit(table, visited)[1], np.array([0.6, 0.0, 0.0, 0.4, 0.0]))


@pytest.mark.parametrize("actions", [1, 2, 5])
def test_actions_are_drawn_as_training_says(actions):
    table = jnp.asarray(np.random.default_rng(0).normal(size=(2, actions)))
    visited = jnp.array([True, False])
    expected = explore(table, visited)
    # Evenly spaced numbers stand in for random ones: frequencies are probabilities, up to one number per boundary.
    draws = jnp.asarray((np.arange(10_000) + 0.5) / 10_000)
    for state in range(2):
        states = jnp.full(draws.shape, state)
        drawn = np.asarray(_pick(draws, states, (*_two_best(table), visited), actions))
        frequencies = np.bincount(drawn, minlength=actions) / draws.size
        np.testing.assert_allclose(frequencies, expected[state], atol=3e-4)


@pytest.mark.parametrize(("batch", "rate_decay"), [(1, 0.7), (1, 1.0), (4, 0.7)])
def test_without_a_choice_the_update_is_the_rule_of_the_docstring(batch, rate_decay):
    # One action each and a chain 0 → 1 → 2: nothing is left to chance.
    transition = np.zeros((3, 1, 1, 3))
    transition[[0, 1, 2], 0, 0, [1, 2, 2]] = 1.0
    learner, expert = np.array([0.5, -1.0, 2.0]), np.array([1.0, 0.3, -0.4])
    dense = oracles.Game(transition, learner[:, None, None], expert[:, None, None], np.array([1.0, 0.0, 0.0]))
    model = QLearning(episodes=7 * batch, batch=batch, rate_decay=rate_decay)
    solution = solve(model, helpers.tabular_game(dense, 3), helpers.rewards_of(dense))
    for reward, found in ((learner, solution.tables.learner), (expert, solution.tables.expert)):
        table = np.zeros(4)
        for update in range(7):
            rate = min(1.0, batch * (batch * update + batch) ** -rate_decay)
            for time in range(3):
                table[time] += rate * (reward[time] + DISCOUNT * table[time + 1] - table[time])
        np.testing.assert_allclose(found[[0, 1, 2], [0, 1, 2], 0], table[:3], rtol=1e-12)
    np.testing.assert_array_equal(solution.policies.learner, np.ones((3, 3, 1)))
    np.testing.assert_array_equal(solution.policies.expert, np.ones((3, 3, 1)))
    assert float(solution.visits.learner.sum()) == 3 * 7 * batch


def test_where_training_never_came_play_is_uniform():
    dense = oracles.random_game(0, 3, 3, 4)
    start, transition = np.array([0.0, 1.0, 0.0]), dense.transition.copy()
    transition[..., 2] = 0.0
    dense = dense._replace(initial=start, transition=transition / transition.sum(-1, keepdims=True))
    solution = solve(QLearning(episodes=200, batch=10), helpers.tabular_game(dense, 3), helpers.rewards_of(dense))
    for table, visits, policy in (
        (solution.tables.learner, solution.visits.learner, solution.policies.learner),
        (solution.tables.expert, solution.visits.expert, solution.policies.expert),
    ):
        never = np.asarray(visits).sum(-1) == 0
        np.testing.assert_array_equal(never, [[True, False, True], [False, False, True], [False, False, True]])
        np.testing.assert_array_equal(np.asarray(table)[never], 0.0)
        np.testing.assert_array_equal(np.asarray(policy)[never], 1.0 / policy.shape[-1])
        np.testing.assert_allclose(np.sort(np.asarray(policy)[~never])[:, -2:], [[0.4, 0.6]] * (~never).sum())
        np.testing.assert_allclose(np.asarray(visits).sum((1, 2)), 200)


def test_episodes_start_as_the_game_says():
    dense = oracles.random_game(0, 4, 2, 2)._replace(initial=np.array([0.0, 0.7, 0.0, 0.3]))
    solution = solve(QLearning(episodes=10_000, batch=100), helpers.tabular_game(dense, 2), helpers.rewards_of(dense))
    started = np.asarray(solution.visits.expert[0].sum(-1)) / 10_000
    np.testing.assert_array_equal(started[[0, 2]], 0.0)
    # Four standard deviations.
    np.testing.assert_allclose(started[1], 0.7, atol=0.02)


def test_a_seed_fixes_everything():
    game, rewards, _ = small_problem()
    model = QLearning(episodes=500, batch=50, seed=3)
    first, again = solve(model, game, rewards), solve(model, game, rewards)
    jax.tree.map(np.testing.assert_array_equal, first, again)
    other = solve(eqx.tree_at(lambda one: one.seed, model, 4), game, rewards)
    assert float(jnp.max(jnp.abs(first.tables.learner - other.tables.learner))) > 1e-3
    assert bool(jnp.any(first.visits.expert != other.visits.expert))


def test_more_episodes_continue_the_same_run():
    game, rewards, _ = small_problem()
    short = solve(QLearning(episodes=45, batch=10), game, rewards)
    longer = solve(QLearning(episodes=51, batch=10), game, rewards)
    added = longer.visits.learner - short.visits.learner
    assert float(added.min()) >= 0.0
    np.testing.assert_array_equal(added.sum((1, 2)), 10.0)


@pytest.mark.slow
def test_a_batch_of_rewards_or_seeds_is_the_same_as_one_by_one():
    game, rewards, _ = small_problem()
    scaled = [jax.tree.map(lambda leaf, k=k: (1.0 + 0.3 * k) * leaf + 0.1 * k, rewards) for k in range(3)]

    def run(one, seed):
        return QLearning(episodes=500, batch=50, seed=seed).solve(game, one, DISCOUNT)

    seeds = jnp.arange(3)
    together = jax.jit(jax.vmap(run))(jax.tree.map(lambda *leaves: jnp.stack(leaves), *scaled), seeds)
    for k, one in enumerate(scaled):
        alone = run(one, k)
        jax.tree.map(lambda a, b, k=k: np.testing.assert_allclose(a[k], b, atol=1e-12), together, alone)
    assert float(jnp.max(jnp.abs(together.tables.learner[0] - together.tables.learner[1]))) > 1e-3


def residual_by_numpy(dense, tables, visits):
    """The residual from its definition, one entry at a time."""
    horizon, states = tables[0].shape[:2]

    def behaviour(side, time, state):
        actions = tables[side].shape[-1]
        if visits[side][time, state].sum() == 0 or actions == 1:
            return np.full(actions, 1 / actions)
        policy = np.full(actions, 0.3 / actions)
        best, second = np.argsort(-tables[side][time, state], kind="stable")[:2]
        policy[best] += 0.42
        policy[second] += 0.28
        return policy

    total = 0.0
    for side, reward in enumerate((dense.learner_reward, dense.expert_reward)):
        for time in range(horizon):
            following = tables[side][time + 1].max(-1) if time + 1 < horizon else np.zeros(states)
            backup = reward + DISCOUNT * dense.transition @ following
            for state in range(states):
                met = behaviour(1 - side, time, state)
                expected = backup[state] @ met if side == 0 else met @ backup[state]
                total += (visits[side][time, state] * np.abs(tables[side][time, state] - expected)).sum()
    return total / (visits[0].sum() + visits[1].sum())


@pytest.mark.parametrize("actions", [(3, 4), (1, 3)])
def test_the_residual_agrees_with_numpy(actions):
    dense = oracles.random_game(1, 3, *actions)._replace(initial=np.array([0.0, 0.4, 0.6]))
    solution = solve(QLearning(episodes=300, batch=10), helpers.tabular_game(dense, 3), helpers.rewards_of(dense))
    tables = [np.asarray(table) for table in (solution.tables.learner, solution.tables.expert)]
    visits = [np.asarray(count) for count in (solution.visits.learner, solution.visits.expert)]
    assert (visits[0][0, 0] == 0).all()
    assert float(solution.residual) == pytest.approx(residual_by_numpy(dense, tables, visits), rel=1e-12)


@pytest.mark.slow
def test_the_residual_falls_with_more_episodes_and_decides_convergence():
    network, game, _ = helpers.small_attack_graph()
    rewards = helpers.true_rewards(game, network)
    residuals = [
        float(solve(QLearning(episodes=episodes, batch=50), game, rewards).residual)
        for episodes in (500, 5_000, 50_000)
    ]
    assert residuals[1] < 0.7 * residuals[0]
    assert residuals[2] < 0.7 * residuals[1]
    dense = np.concatenate([rewards.learner.dense().ravel(), rewards.expert.dense().ravel(), [0.0]])
    relative = residuals[0] / (dense.max() - dense.min())
    for factor, expected in ((1.001, True), (0.999, False)):
        model = QLearning(episodes=500, batch=50, tolerance=factor * relative)
        assert bool(solve(model, game, rewards).converged) is expected


def test_learners_that_chase_each_other_are_not_called_converged():
    model = QLearning(episodes=40_000, batch=200)
    game, rewards, _ = small_problem(1)
    assert bool(solve(model, game, rewards).converged)
    # Here the two best actions of one side change with those of the other, round and round.
    game, rewards, _ = small_problem(0)
    assert not bool(solve(model, game, rewards).converged)


def test_the_form_of_a_payoff_does_not_matter():
    network, game, _ = helpers.small_attack_graph(no_op=True)
    rewards = helpers.true_rewards(game, network)
    dense = Sides(DensePayoff(rewards.learner.dense()), DensePayoff(rewards.expert.dense()))
    model = QLearning(episodes=500, batch=50)
    jax.tree.map(
        lambda a, b: np.testing.assert_allclose(a, b, atol=1e-12),
        solve(model, game, rewards),
        solve(model, game, dense),
    )


def test_rewards_of_zero_are_learnt_at_once():
    game, rewards, _ = small_problem()
    solution = solve(QLearning(episodes=10, batch=10), game, jax.tree.map(jnp.zeros_like, rewards))
    assert float(solution.residual) == 0.0
    assert bool(solution.converged)


def test_single_precision_stays_single():
    with jax.enable_x64(False):
        game, rewards, _ = small_problem(1)
        solution = solve(QLearning(episodes=5_000, batch=100), game, rewards)
        assert {leaf.dtype for leaf in jax.tree.leaves(solution)} == {jnp.dtype("float32"), jnp.dtype(bool)}
        assert bool(solution.converged)
