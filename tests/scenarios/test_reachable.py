"""The states that an attack network's game can reach."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsiirl.scenarios import random_network
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.scenarios.reachable import (
    WORD,
    TooManyStatesError,
    reachable_states,
    reached_nodes,
    reached_within,
    starting_state,
    usable_edges,
    words,
)


def network(sources: list[int], targets: list[int]) -> AttackNetwork:
    """Hosts that are all alike, with these attacks; -1 is outside."""
    hosts, edges = max(targets) + 1, len(targets)
    return AttackNetwork(
        name="of edges",
        node_names=tuple(f"h{host}" for host in range(hosts)),
        value=np.ones(hosts),
        criticality=np.ones(hosts),
        edge_source=np.array(sources),
        edge_target=np.array(targets),
        success_probability=np.full(edges, 0.5),
        attack_cost=np.zeros(edges),
        block_cost=np.ones(edges),
    )


def chain(hosts: int) -> AttackNetwork:
    return network(list(range(-1, hosts - 1)), list(range(hosts)))


def star(hosts: int) -> AttackNetwork:
    return network([-1] * hosts, list(range(hosts)))


@pytest.mark.parametrize("hosts", [1, 21, WORD, WORD + 1, 100])
def test_in_a_chain_hosts_fall_one_after_the_other(hosts: int):
    states = reachable_states(chain(hosts), [0])
    assert states.tolist() == [2**fallen - 1 for fallen in range(hosts + 1)]


@pytest.mark.parametrize("hosts", [1, 4, 10])
def test_in_a_star_any_hosts_fall(hosts: int):
    states = reachable_states(star(hosts), [0])
    assert states.tolist() == list(range(2**hosts))


def test_no_other_states_are_reached_than_by_trying_every_attack():
    drawn = random_network(3, nodes=9, edges=14)
    seen, waiting = set[int](), [starting_state(drawn)]
    while waiting:
        state = waiting.pop()
        seen.add(state)
        for source, target in zip(drawn.edge_source.tolist(), drawn.edge_target.tolist(), strict=True):
            if state >> source & 1 and not state >> target & 1 and state | 1 << target not in seen:
                waiting.append(state | 1 << target)
    states = reachable_states(drawn, [starting_state(drawn)])
    assert states.tolist() == sorted(seen)


@pytest.mark.parametrize("hosts", [40, 80])
def test_counting_ends_where_there_are_more_than_was_asked_for(hosts: int):
    # 2^40 and 2^80 states could not be counted.
    with pytest.raises(TooManyStatesError):
        reachable_states(star(hosts), [0], most=1000)


def test_exactly_as_many_as_was_asked_for_are_counted():
    with pytest.raises(TooManyStatesError):
        reachable_states(star(10), [0], most=1023)
    assert reachable_states(star(10), [0], most=1024).size == 1024


def test_bitmasks_of_more_hosts_than_a_word_holds_are_several_words():
    states = reachable_states(chain(100), [0])
    parts = words(states)
    assert parts.shape == (101, 2)
    assert parts.dtype == np.int64
    assert [low + (high << WORD) for low, high in parts.tolist()] == states.tolist()


@given(st.integers(0, 200))
def test_edges_are_usable_where_a_state_that_can_be_reached_lets_them_be_attacked(seed: int):
    draw = np.random.default_rng(seed)
    pairs = [(s, t) for s in range(-1, 6) for t in range(6) if s != t and draw.random() < 0.2]
    footholds = {int(draw.integers(6))}
    states = pending = {frozenset(footholds)}
    while pending:
        pending = {state | {t} for state in pending for s, t in pairs if s in state | {-1} and t not in state} - states
        states = states | pending
    assert usable_edges(pairs, footholds) == {
        (s, t) for s, t in pairs for state in states if s in state | {-1} and t not in state
    }
    assert reached_nodes(pairs, footholds) == {-1}.union(*states)


def test_every_success_gets_one_host_further():
    chain = [(-1, 0), (0, 1), (1, 2), (5, 6)]
    assert [reached_within(attacks, chain, [5]) for attacks in range(4)] == [
        {-1, 5},
        {-1, 5, 0, 6},
        {-1, 5, 0, 6, 1},
        {-1, 5, 0, 6, 1, 2},
    ]
