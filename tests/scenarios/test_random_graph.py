"""Random attack networks."""

import networkx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsiirl.errors import InputError
from gsiirl.scenarios import random_graph
from gsiirl.scenarios.random_graph import random_network

Size = tuple[int, int]


@st.composite
def sizes(draw: st.DrawFn) -> Size:
    """Numbers of nodes and edges that a random graph can have."""
    nodes = draw(st.integers(2, 20))
    return nodes, draw(st.integers(nodes - 1, (nodes - 1) ** 2))


@given(st.integers(0, 2**32), sizes())
def test_every_node_can_be_reached_from_the_foothold_and_nothing_leads_back_to_it(seed: int, size: Size):
    network = random_network(seed, *size)
    graph = networkx.DiGraph(zip(network.edge_source.tolist(), network.edge_target.tolist(), strict=True))
    assert network.footholds == (0,)
    assert networkx.descendants(graph, 0) == set(range(1, len(network.node_names)))
    assert 0 not in network.edge_target


@given(st.integers(0, 2**32), sizes())
def test_numbers_lie_in_the_documented_ranges(seed: int, size: Size):
    network = random_network(seed, *size)
    assert network.value[0] == network.criticality[0] == 0
    for numbers, (low, high) in (
        (network.success_probability, random_graph.SUCCESS_PROBABILITY),
        (network.value[1:], random_graph.VALUE),
        (network.criticality[1:], random_graph.CRITICALITY),
        (network.attack_cost, random_graph.ATTACK_COST),
        (network.block_cost, random_graph.BLOCK_COST),
    ):
        assert np.all((low <= numbers) & (numbers <= high))


def test_the_paper_sized_graph_has_8_nodes_and_10_edges():
    network = random_network(0)
    assert len(network.node_names) == 8
    assert network.edge_source.size == 10


def test_the_same_seed_gives_the_same_network_and_another_seed_another():
    assert random_network(3).to_json_dict() == random_network(3).to_json_dict()
    assert random_network(3).value.tolist() != random_network(4).value.tolist()


@pytest.mark.parametrize("seed", range(3))
def test_the_variants_of_a_seed_differ_in_criticality_alone(seed: int):
    general, paired = random_network(seed), random_network(seed, variant="zero_sum")
    assert paired.to_json_dict() == general.with_variant("zero_sum").to_json_dict()
    assert not np.array_equal(general.criticality, general.value)


def test_all_pairs_can_be_asked_for():
    assert random_network(0, nodes=4, edges=9).edge_source.size == 9


@pytest.mark.parametrize(
    ("arguments", "field"),
    [((-1, 8, 10), "seed"), ((0, 1, 1), "nodes"), ((0, 21, 30), "nodes"), ((0, 8, 6), "edges"), ((0, 4, 10), "edges")],
)
def test_impossible_sizes_are_refused(arguments: tuple[int, int, int], field: str):
    with pytest.raises(InputError) as caught:
        random_network(*arguments)
    assert caught.value.field == field
