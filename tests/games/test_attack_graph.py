import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.games import attack_graph
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.rollout import rollout
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.types import Sides
from tests import helpers, oracles


@pytest.mark.parametrize("no_op", [False, True])
def test_continuation_is_the_expectation_under_the_dense_transition(no_op):
    _, game, dense = helpers.small_attack_graph(no_op=no_op)
    values = np.random.default_rng(0).normal(size=16)
    np.testing.assert_allclose(game.continuation(jnp.asarray(values)).dense(), dense.transition @ values, atol=1e-14)


@pytest.mark.parametrize("no_op", [False, True])
def test_advance_is_the_transpose_of_continuation(no_op):
    _, game, dense = helpers.small_attack_graph(no_op=no_op)
    actions = game.number_of_actions
    policies = Sides(
        jnp.asarray(oracles.random_policy(1, 1, 16, actions.learner)[0]),
        jnp.asarray(oracles.random_policy(2, 1, 16, actions.expert)[0]),
    )
    distribution = np.random.default_rng(3).dirichlet(np.ones(16))
    expected = np.einsum("s,sl,se,slen->n", distribution, policies.learner, policies.expert, dense.transition)
    np.testing.assert_allclose(game.advance(jnp.asarray(distribution), policies), expected, atol=1e-15)


def test_only_states_that_can_be_reached_are_kept():
    network = helpers.small_network()
    game = AttackGraph.create(network, 4)
    dense = oracles.attack_graph_dense(network)
    uniform = np.full((5, 16, 6), 1 / 6)
    reached = oracles.occupancy(dense.transition, dense.initial, uniform, uniform).sum(axis=(0, 2, 3)) > 0
    assert game.masks.tolist() == np.flatnonzero(reached).tolist()


def test_a_chain_of_a_hundred_hosts_is_a_game_of_as_many_states_and_one():
    hosts = 100
    network = AttackNetwork(
        name="chain",
        node_names=tuple(f"h{host}" for host in range(hosts)),
        value=np.ones(hosts),
        criticality=np.ones(hosts),
        edge_source=np.arange(-1, hosts - 1),
        edge_target=np.arange(hosts),
        success_probability=np.full(hosts, 0.5),
        attack_cost=np.zeros(hosts),
        block_cost=np.ones(hosts),
    )
    game = AttackGraph.create(network)
    states = np.arange(hosts)
    # With n hosts fallen only the next one can be attacked, and then n + 1 have fallen.
    np.testing.assert_array_equal(game.success, 0.5 * np.eye(hosts + 1, hosts))
    np.testing.assert_array_equal(np.asarray(game.successors)[states, states], states + 1)
    np.testing.assert_array_equal(np.asarray(game.predecessors)[states + 1, states], states)
    np.testing.assert_array_equal(game.initial, np.eye(hosts + 1)[0])


def test_a_game_that_no_memory_holds_is_refused_and_not_begun(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(attack_graph, "MOST_ATTACKS", 4000)
    hosts = 40
    star = AttackNetwork(
        name="star",
        node_names=tuple(f"h{host}" for host in range(hosts)),
        value=np.ones(hosts),
        criticality=np.ones(hosts),
        edge_source=np.full(hosts, -1),
        edge_target=np.arange(hosts),
        success_probability=np.full(hosts, 0.5),
        attack_cost=np.zeros(hosts),
        block_cost=np.ones(hosts),
    )
    with pytest.raises(InputError, match="network: its game has more than 100 states; use a smaller one"):
        AttackGraph.create(star)


def test_sampled_frequencies_are_the_occupancies():
    network = helpers.small_network()
    game = AttackGraph.create(network, 3)
    dense = oracles.attack_graph_dense(network)
    masks = np.asarray(game.masks)
    full = Sides(oracles.random_policy(0, 3, 16, 6), oracles.random_policy(1, 3, 16, 6))
    policies = jax.tree.map(lambda p: jnp.asarray(p[:, masks]), full)
    number = 20_000
    episodes = jax.vmap(lambda key: rollout(key, game, policies))(jax.random.split(jax.random.key(0), number))
    occupancy = oracles.occupancy(dense.transition, dense.initial, full.learner, full.expert)
    for time in range(3):
        counts = np.zeros((16, 6, 6))
        cells = masks[episodes.states[:, time]], episodes.actions.learner[:, time], episodes.actions.expert[:, time]
        np.add.at(counts, cells, 1 / number)
        standard_error = np.sqrt(occupancy[time] * (1 - occupancy[time]) / number)
        assert np.all(np.abs(counts - occupancy[time]) <= 5 * standard_error + 1e-12)


def test_a_no_op_of_the_attacker_changes_nothing():
    _, game, _ = helpers.small_attack_graph(no_op=True)
    actions = Sides(jnp.asarray(0), jnp.asarray(game.number_of_edges))
    states = jnp.arange(game.number_of_states)
    following = jax.vmap(lambda state: game.step(jax.random.key(0), state, actions))(states)
    assert following.tolist() == states.tolist()
