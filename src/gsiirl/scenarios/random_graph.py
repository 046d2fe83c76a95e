"""Random attack networks, as the paper's security experiment draws them (paper A.10.3)."""

import numpy as np

from gsiirl.errors import InputError
from gsiirl.scenarios.network import AttackNetwork, Variant

MOST_NODES = 20
"""A random graph of N nodes has up to 2^(N-1) states."""

# Ranges of the uniform draws; the paper gives none.
SUCCESS_PROBABILITY = (0.5, 0.9)
"""Attacks mostly work, and never surely: blocking decides more than luck."""
VALUE = (0.5, 1.5)
"""About 1 a node, and up to threefold apart: worth telling one node from another."""
CRITICALITY = (0.5, 1.5)
"""Of the values' size but drawn apart from them: the game is general-sum."""
ATTACK_COST = (0.05, 0.3)
"""Below the least expected gain of a success, 0.25, for most edges: an attack is worth a try."""
BLOCK_COST = (0.8, 1.2)
"""About 1 a step, which the paper's returns of about -10 over 10 steps imply."""


def random_network(seed: int, nodes: int = 8, edges: int = 10, variant: Variant = "general_sum") -> AttackNetwork:
    """Draw a network in which every node can be reached from node 0, the foothold.

    A random tree grows from node 0 over all nodes (each next node hangs on one drawn uniformly from those before it);
    the other edges are drawn uniformly from the remaining pairs i -> j with j != 0, since an edge into the foothold
    could never be used. The same seed gives the same network in both variants, up to the criticality.

    Raises:
        InputError: when there are too few or too many nodes or edges, or the seed is negative.
    """
    if seed < 0:
        raise InputError("seed", f"{seed} is negative", "give 0 or more")
    if not 2 <= nodes <= MOST_NODES:
        raise InputError("nodes", f"a random graph cannot have {nodes}", f"give 2 to {MOST_NODES}")
    fewest, most = nodes - 1, (nodes - 1) ** 2
    if not fewest <= edges <= most:
        raise InputError("edges", f"{nodes} nodes cannot have {edges} useful edges", f"give {fewest} to {most}")

    generator = np.random.default_rng(seed)
    order = [0, *(1 + generator.permutation(nodes - 1)).tolist()]
    tree = {(order[generator.integers(place)], order[place]) for place in range(1, nodes)}
    others = [
        (source, target)
        for source in range(nodes)
        for target in range(1, nodes)
        if source != target and (source, target) not in tree
    ]
    drawn = generator.choice(len(others), size=edges - len(tree), replace=False) if others else []
    pairs = sorted(tree | {others[place] for place in drawn})
    edge_source, edge_target = np.array(pairs, dtype=np.int64).T

    success_probability = generator.uniform(*SUCCESS_PROBABILITY, size=edges)
    value = generator.uniform(*VALUE, size=nodes)
    criticality = generator.uniform(*CRITICALITY, size=nodes)
    attack_cost = generator.uniform(*ATTACK_COST, size=edges)
    block_cost = generator.uniform(*BLOCK_COST, size=edges)
    # The foothold is never newly compromised.
    value[0] = criticality[0] = 0.0
    return AttackNetwork(
        name=f"random graph {seed}",
        node_names=tuple(f"node {node}" for node in range(nodes)),
        value=value,
        criticality=criticality,
        edge_source=edge_source,
        edge_target=edge_target,
        success_probability=success_probability,
        attack_cost=attack_cost,
        block_cost=block_cost,
        footholds=(0,),
    ).with_variant(variant)
