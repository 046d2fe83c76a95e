import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.games import rollout
from gsiirl.irl import DependentValue, LeastSquares
from gsiirl.rewards import Linear, TabularFeatures
from gsiirl.rewards import attack_graph as rewards
from gsiirl.types import Sides, Trajectories
from tests import helpers, oracles


def episodes(game, number: int = 200) -> Trajectories:
    actions = game.number_of_actions
    shape = (game.horizon, game.number_of_states)
    policies = Sides(
        jnp.full((*shape, actions.learner), 1.0 / actions.learner),
        jnp.full((*shape, actions.expert), 1.0 / actions.expert),
    )
    return jax.jit(jax.vmap(lambda key: rollout(key, game, policies)))(jax.random.split(jax.random.key(0), number))


def test_values_read_are_the_entries_of_the_table():
    _, game, dense = helpers.small_attack_graph("zero_sum", no_op=True)
    network = helpers.small_network("zero_sum")
    table = rewards.commitment_features(game).payoff(jnp.asarray(rewards.dependent_weights(network)))
    value = DependentValue(table)
    states, learner, expert = (jnp.asarray(axis.ravel()) for axis in np.indices(dense.dependent_reward.shape))
    read = jax.vmap(value)(states, Sides(learner, expert))
    np.testing.assert_allclose(read, dense.dependent_reward.ravel(), atol=1e-15)


def test_exact_weights_are_recovered_from_the_values_along_trajectories():
    dense = oracles.random_game(0, 4, 3, 3)
    game = helpers.tabular_game(dense)
    random = np.random.default_rng(1)
    features = TabularFeatures(table=jnp.asarray(random.normal(size=(4, 3, 3, 6))), names=tuple("abcdef"))
    reward = Linear(features, 2.0)
    true = reward.initial_parameters(jax.random.key(3), jnp.dtype(float))
    seen = LeastSquares.empty(6, jnp.dtype(float)).read(reward, DependentValue(reward.payoff(true)), episodes(game))
    np.testing.assert_allclose(seen.solve(1e-10), true, atol=1e-9)


def test_the_weights_of_a_bounded_fit_stay_in_the_unit_ball():
    far, near = (
        LeastSquares(jnp.diag(jnp.array([2.0, 2.0])), jnp.array(moment)) for moment in ([6.0, 8.0], [0.6, 0.8])
    )
    np.testing.assert_allclose(far.solve(0.0), [0.6, 0.8], rtol=1e-12)
    np.testing.assert_allclose(near.solve(0.0), [0.3, 0.4], rtol=1e-12)


def test_what_was_never_seen_keeps_no_weight():
    network, game, _ = helpers.small_attack_graph()
    reward = Linear(rewards.commitment_features(game), 4.0)
    true = jnp.asarray(rewards.dependent_weights(network)) / 4.0
    value = DependentValue(reward.payoff(true))
    visited = episodes(game)
    seen = LeastSquares.empty(true.shape[0], jnp.dtype(float)).read(reward, value, visited)
    found = seen.solve(1e-8)
    # Node 0 is a foothold: it is never newly compromised.
    names = reward.features.names
    assert float(found[names.index("loss of a")]) == 0.0
    losses = [index for index, name in enumerate(names) if name.startswith("loss of") and name != "loss of a"]
    np.testing.assert_allclose(found[jnp.asarray(losses)], true[jnp.asarray(losses)], atol=1e-6)


def test_steps_after_the_end_of_an_episode_do_not_count():
    network, game, _ = helpers.small_attack_graph()
    reward = Linear(rewards.commitment_features(game), 4.0)
    value = DependentValue(reward.payoff(jnp.asarray(rewards.dependent_weights(network)) / 4.0))
    visited = episodes(game, 20)
    ended = Trajectories(visited.states, visited.actions, visited.mask.at[:, 2:].set(False))
    cut = Trajectories(visited.states[:, :2], jax.tree.map(lambda a: a[:, :2], visited.actions), visited.mask[:, :2])
    empty = LeastSquares.empty(reward.number_of_parameters, jnp.dtype(float))
    for one, other in zip(
        jax.tree.leaves(empty.read(reward, value, ended)),
        jax.tree.leaves(empty.read(reward, value, cut)),
        strict=True,
    ):
        np.testing.assert_allclose(one, other, atol=1e-12)
