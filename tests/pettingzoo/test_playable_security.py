"""Nodes are told apart in networks of any size."""

import jax
import numpy as np
import pytest

from gsiirl.games.attack_graph import AttackGraph
from gsiirl.pettingzoo.playable_security import compromised_nodes
from gsiirl.scenarios.network import AttackNetwork


@pytest.mark.parametrize("nodes", [3, 62, 63, 130])
def test_a_state_holds_the_nodes_that_are_compromised(nodes: int):
    edges = nodes - 1
    chain = AttackNetwork(
        name="chain",
        node_names=tuple(map(str, range(nodes))),
        value=np.ones(nodes),
        criticality=np.ones(nodes),
        edge_source=np.arange(edges),
        edge_target=np.arange(1, nodes),
        success_probability=np.full(edges, 0.5),
        attack_cost=np.full(edges, 0.1),
        block_cost=np.full(edges, 0.1),
        footholds=(0,),
    ).with_variant("general_sum")
    with jax.enable_x64(True):
        found = compromised_nodes(AttackGraph.create(chain, horizon=2))
    # Along a chain the first nodes fall first.
    np.testing.assert_array_equal(found, np.tril(np.ones((nodes, nodes))))
