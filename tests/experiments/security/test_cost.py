"""What a run takes is known before anything is compiled."""

import json
import re
import tracemalloc
from pathlib import Path
from typing import Any

import pytest

from gsiirl.errors import InputError
from gsiirl.experiments.security import cost
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.cost import check_memory, memory_needed, warning_of

GIGABYTE = 10**9


def chain(hosts: int) -> list[int | None]:
    """The host before each one, None for outside."""
    return [None, *range(hosts - 1)]


def star(hosts: int) -> list[int | None]:
    return [None] * hosts


def tree(hosts: int) -> list[int | None]:
    """Two hosts behind each one."""
    return [None, *((host - 1) // 2 for host in range(1, hosts))]


def config_of(folder: Path, before: list[int | None], **settings: Any) -> SecurityConfig:
    nodes = [{"name": f"h{host}", "value": 1.0} for host in range(len(before))]
    edges = [
        {"source": None if source is None else f"h{source}", "target": f"h{host}", "success_probability": 0.5}
        for host, source in enumerate(before)
    ]
    path = folder / "network.json"
    path.write_text(json.dumps({"nodes": nodes, "edges": edges}))
    return SecurityConfig(graph=str(path), **settings).resolved()


@pytest.fixture
def free(monkeypatch: pytest.MonkeyPatch) -> None:
    """20 GB are free."""
    monkeypatch.setattr(cost, "available_memory", lambda: 20 * GIGABYTE)


@pytest.mark.usefixtures("free")
@pytest.mark.parametrize(
    ("before", "states"),
    [
        (chain(10), 11),
        (chain(21), 22),
        (chain(100), 101),
        (star(10), 1024),
        (star(12), 4096),
        (tree(7), 26),
    ],
)
def test_networks_of_few_states_run_whatever_the_number_of_their_hosts(
    tmp_path: Path, before: list[int | None], states: int
):
    config = config_of(tmp_path, before)
    assert check_memory(config, config.network()) == states


@pytest.mark.usefixtures("free")
def test_a_star_of_twenty_is_refused_with_the_numbers_and_without_being_counted(tmp_path: Path):
    config = config_of(tmp_path, star(20))
    tracemalloc.start()
    with pytest.raises(InputError) as caught:
        check_memory(config, config.network())
    assert tracemalloc.get_traced_memory()[1] < GIGABYTE / 10
    tracemalloc.stop()
    assert caught.value.field == "graph"
    assert "20 edges" in caught.value.problem
    assert "half of what is free is 10.0 GB" in caught.value.problem
    assert "or more states" in caught.value.problem


@pytest.mark.usefixtures("free")
def test_where_fewer_seeds_would_do_as_many_are_named(tmp_path: Path):
    config = config_of(tmp_path, star(14))
    with pytest.raises(InputError, match=r"a game of 16,384 states and 14 edges takes 21\.\d GB.*at most --seeds 1$"):
        check_memory(config, config.network())
    config = config_of(tmp_path, star(14), seeds=1)
    assert check_memory(config, config.network()) == 2**14


@pytest.mark.usefixtures("free")
def test_many_edges_are_refused_for_what_their_features_take(tmp_path: Path):
    config = config_of(tmp_path, chain(900), seeds=1, horizon=1, algorithm="marl")
    with pytest.raises(InputError, match="900 edges"):
        check_memory(config, config.network())


def test_memory_is_at_least_that_of_the_compiled_programs(tmp_path: Path):
    """Bytes by XLA's analysis: working memory, and states before and after."""
    seen: list[tuple[list[int | None], dict[str, Any], int, float]] = [
        (star(10), {"seeds": 2}, 2**10, 694.5e6 + 2 * 172.0e6),
        (star(12), {"seeds": 2}, 2**12, 2216.0e6 + 2 * 306.7e6),
        (star(12), {"seeds": 4}, 2**12, 2488.8e6 + 2 * 613.5e6),
        (star(12), {"seeds": 2, "iterations": 8}, 2**12, 1879.8e6 + 2 * 165.2e6),
        (star(12), {"seeds": 2, "horizon": 20}, 2**12, 3719.7e6 + 2 * 330.3e6),
        (star(12), {"seeds": 2, "lower_level": "matching"}, 2**12, 1907.2e6 + 2 * 165.2e6),
        (star(12), {"seeds": 2, "algorithm": "paper"}, 2**12, 336.6e6 + 2 * 7.9e6),
        (star(12), {"seeds": 2, "commitment": "reward"}, 2**12, 570.6e6 + 2 * 125.9e6),
        (star(12), {"seeds": 2, "algorithm": "ma-irl"}, 2**12, 668.8e6),
    ]
    for before, settings, states, measured in seen:
        config = config_of(tmp_path, before, **settings)
        estimate = memory_needed(config, config.network(), states, config.seeds)
        assert measured <= estimate <= 2.5 * measured


def test_the_program_of_lin2019_takes_the_rows_of_every_joint_action_besides(tmp_path: Path):
    """Of both rewards' weights, three times over, for each of two seeds."""
    watching, solving = (config_of(tmp_path, star(6), seeds=2, algorithm=each) for each in ("ma-irl", "lin2019"))
    network = solving.network()
    edges, nodes = len(network.edge_names), len(network.node_names)
    rows = solving.horizon * 2**6 * edges**2 * (2 * nodes + 3 * edges)
    more = memory_needed(solving, network, 2**6, 2) - memory_needed(watching, network, 2**6, 2)
    assert more == 8 * 3 * 2 * rows


def test_where_nothing_tells_what_is_free_only_the_states_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(cost, "available_memory", lambda: None)
    config = config_of(tmp_path, star(14))
    assert check_memory(config, config.network()) == 2**14


def test_nothing_runs_where_nothing_is_free(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(cost, "available_memory", lambda: 0)
    config = config_of(tmp_path, chain(3))
    with pytest.raises(InputError, match=r"half of what is free is 0\.0 GB"):
        check_memory(config, config.network())


@pytest.mark.usefixtures("free")
def test_a_long_run_is_warned_of_and_not_refused(tmp_path: Path):
    long = warning_of(config_of(tmp_path, star(12)))
    assert long is not None
    assert re.fullmatch(r"this run takes about \d+ hours of a processor", long)
    assert warning_of(config_of(tmp_path, star(12), iterations=1, seeds=1)) is None
    assert warning_of(SecurityConfig(graph="small").resolved()) is None
