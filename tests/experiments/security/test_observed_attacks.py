"""Attacks that interactions showed are counted."""

import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.experiments.security.observed_attacks import observed_attacks
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.rewards.attack_graph import commitment_features, dependent_features
from gsiirl.scenarios import AttackNetwork
from gsiirl.types import Sides

OUTSIDE_TO_A, A_TO_B, B_TO_A, C_TO_B = range(4)
CLEAN, A, A_AND_B = range(3)
VISITED = [
    # state, block, attack
    (CLEAN, A_TO_B, OUTSIDE_TO_A),
    (CLEAN, A_TO_B, OUTSIDE_TO_A),
    (CLEAN, OUTSIDE_TO_A, OUTSIDE_TO_A),
    (CLEAN, OUTSIDE_TO_A, A_TO_B),
    (A, OUTSIDE_TO_A, A_TO_B),
    (A_AND_B, OUTSIDE_TO_A, B_TO_A),
    (A, OUTSIDE_TO_A, C_TO_B),
]


@pytest.mark.parametrize("of", [dependent_features, commitment_features])
def test_attacks_and_those_with_a_chance_are_counted(of):
    network = AttackNetwork(
        name="g",
        node_names=("a", "b", "c"),
        value=np.ones(3),
        criticality=np.ones(3),
        edge_source=np.array([-1, 0, 1, 2]),
        edge_target=np.array([0, 1, 0, 1]),
        success_probability=np.array([0.5, 0.8, 0.3, 0.9]),
        attack_cost=np.zeros(4),
        block_cost=np.ones(4),
    )
    game = AttackGraph.create(network)
    features = of(game)
    visited = [[jnp.asarray(each) for each in step] for step in VISITED]
    seen = [features(state, Sides(block, attack)) for state, block, attack in visited]
    gram = np.stack(seen).T @ np.stack(seen)
    counts = observed_attacks(jnp.asarray(gram), game)
    np.testing.assert_allclose(counts["attacks"], [3, 2, 1, 1])
    # Not the blocked one, not a -> b while a is clean, not b -> a while a is held, never c -> b.
    np.testing.assert_allclose(counts["chances"], [2, 1, 0, 0], atol=1e-12)
