"""Changes of a network are what their texts say, and drawn ones can be given again."""

from dataclasses import replace

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.experiments.security.changes import ODDS, carried_over, changed, drawn
from gsiirl.scenarios import AttackNetwork, random_network
from tests.helpers import small_network

ARRAYS = ("edge_source", "edge_target", "success_probability", "attack_cost", "block_cost", "value", "criticality")


def assert_same(one: AttackNetwork, other: AttackNetwork) -> None:
    assert (one.node_names, one.footholds, one.variant) == (other.node_names, other.footholds, other.variant)
    for name in ARRAYS:
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, err_msg=name)


def test_an_edge_is_removed_with_all_that_belongs_to_it():
    network = small_network()
    by_hand = replace(
        network,
        edge_source=np.array([0, 1, 2, 2, -1]),
        edge_target=np.array([1, 3, 3, 1, 2]),
        success_probability=np.array([0.6, 0.9, 0.5, 0.7, 0.4]),
        attack_cost=np.array([0.1, 0.05, 0.15, 0.1, 0.3]),
        block_cost=np.array([1.0, 1.1, 0.8, 1.2, 1.0]),
    )
    assert_same(changed(network, "remove-edge=a:c"), by_hand)


def test_an_entry_edge_comes_from_outside():
    assert changed(small_network(), "remove-edge=outside:c").edge_names == small_network().edge_names[:-1]


@pytest.mark.parametrize(
    ("text", "numbers"),
    [("add-edge=a:d", (0.65, 0.15, 1.0)), ("add-edge=a:d:0.75:0.2:0.5", (0.75, 0.2, 0.5))],
)
def test_an_edge_is_added_with_its_own_numbers_or_the_means_of_the_others(text: str, numbers: tuple[float, ...]):
    network = small_network()
    by_hand = replace(
        network,
        edge_source=np.array([0, 0, 1, 2, 2, -1, 0]),
        edge_target=np.array([1, 2, 3, 3, 1, 2, 3]),
        success_probability=np.array([0.6, 0.8, 0.9, 0.5, 0.7, 0.4, numbers[0]]),
        attack_cost=np.array([0.1, 0.2, 0.05, 0.15, 0.1, 0.3, numbers[1]]),
        block_cost=np.array([1.0, 0.9, 1.1, 0.8, 1.2, 1.0, numbers[2]]),
    )
    assert_same(changed(network, text), by_hand)


def test_odds_are_redrawn_and_nothing_else():
    network = small_network()
    once, twice, other = (changed(network, f"redraw={seed}") for seed in (1, 1, 2))
    assert_same(once, twice)
    assert_same(replace(once, success_probability=network.success_probability), network)
    assert (once.success_probability != other.success_probability).all()
    assert (once.success_probability >= ODDS[0]).all()
    assert (once.success_probability <= ODDS[1]).all()


def test_names_may_hold_colons():
    network = replace(small_network(), node_names=("a", "b", "b:c", "d"))
    assert changed(network, "remove-edge=a:b:c").edge_names == tuple(
        name for name in network.edge_names if name != "a -> b:c"
    )
    # There is neither d -> b nor d -> b:c.
    assert changed(network, "add-edge=d:b:c:0.5:0.1:0.2").edge_names[-1] == "d -> b:c"
    assert changed(network, "add-edge=d:b:0.5:0.1:0.2").edge_names[-1] == "d -> b"


@pytest.mark.parametrize("seed", range(3))
def test_drawn_changes_come_in_turn_and_can_be_made(seed: int):
    network = random_network(seed)
    changes = drawn(network, 10, seed)
    assert changes == drawn(network, 10, seed) != drawn(network, 10, seed + 1)
    assert len(set(changes)) == 10
    assert [each.partition("=")[0] for each in changes[:3]] == ["remove-edge", "add-edge", "redraw"]
    edges = [len(changed(network, each).edge_names) for each in changes]
    assert edges == [9, 11, 10] * 3 + [9]


def test_where_no_edge_can_go_odds_are_drawn():
    one_edge = AttackNetwork(
        name="pair",
        node_names=("a", "b"),
        value=np.array([0.0, 1.0]),
        criticality=np.array([0.0, 1.0]),
        edge_source=np.array([0]),
        edge_target=np.array([1]),
        success_probability=np.array([0.5]),
        attack_cost=np.array([0.1]),
        block_cost=np.array([0.1]),
        footholds=(0,),
    )
    assert [each.partition("=")[0] for each in drawn(one_edge, 3, 0)] == ["redraw"] * 3


def test_weights_go_with_their_edges_and_a_new_edge_has_the_mean_of_its_kind():
    network = small_network()
    weights = np.arange(2 * 16, dtype=float).reshape(2, 16)
    without = carried_over(weights, network, changed(network, "remove-edge=a:c"))
    np.testing.assert_array_equal(without, np.delete(weights, [5, 11], axis=1))
    added = carried_over(weights, network, changed(network, "add-edge=a:d"))
    np.testing.assert_array_equal(added[:, :10], weights[:, :10])
    np.testing.assert_array_equal(added[:, 11:17], weights[:, 10:])
    np.testing.assert_array_equal(added[:, [10, 17]], [[6.5, 12.5], [22.5, 28.5]])


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("grow", "--change: 'grow' is no change of a network; give remove-edge=A:B, add-edge=A:B or redraw=SEED"),
        ("remove-edge=a:d", "--change: remove-edge: there is no edge 'a:d'; choose from a:b, a:c, "),
        ("add-edge=a:b", "--change: there is an edge 'a:b'; give A:B, names of nodes without an edge from A to B"),
        ("add-edge=a:x", "--change: add-edge: 'a:x' is no edge between two nodes; give A:B"),
        ("add-edge=a:d:0.5", "--change: add-edge: '0.5' is not three numbers; give probability of success"),
        ("add-edge=a:d:0.5:x:1", "--change: add-edge: '0.5:x:1' is not three numbers; give probability"),
        ("add-edge=a:d:2:0:0", "--change: add-edge: success_probability: edge 'a -> d' has 2; give a number above 0"),
        ("add-edge=a:d:nan:0:0", "--change: add-edge: success_probability: edge 'a -> d' has NaN; give a finite"),
        ("redraw=-1", "--change: redraw: '-1' is no seed; give a whole number below 1,000,000"),
        ("redraw=9999999999", "--change: redraw: '9999999999' is no seed; give a whole number below 1,000,000"),
    ],
)
def test_what_is_no_change_gets_one_line(text: str, line: str):
    with pytest.raises(InputError) as refused:
        changed(small_network(), text)
    assert str(refused.value).startswith(line)


def test_the_last_attack_that_can_be_made_stays():
    network = changed(changed(small_network(), "remove-edge=a:b"), "remove-edge=a:c")
    with pytest.raises(InputError, match="without 'outside:c' nothing can be attacked; remove another edge"):
        changed(network, "remove-edge=outside:c")
