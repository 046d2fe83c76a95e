"""What is said of a network's file."""

import json
from pathlib import Path
from typing import Any

import pytest

from gsiirl.errors import InputError
from gsiirl.experiments.security import cost, network_check
from gsiirl.experiments.security.network_check import check_network

ROOT = Path(__file__).parents[3]
GIGABYTE = 10**9


@pytest.fixture(autouse=True)
def free(monkeypatch: pytest.MonkeyPatch) -> None:
    """20 GB are free."""
    for module in (cost, network_check):
        monkeypatch.setattr(module, "available_memory", lambda: 20 * GIGABYTE)


def written(folder: Path, document: dict[str, Any]) -> str:
    path = folder / "network.json"
    path.write_text(json.dumps(document))
    return str(path)


def star(hosts: int) -> dict[str, Any]:
    return {
        "nodes": [{"name": f"h{host}", "value": 1.0} for host in range(hosts)],
        "edges": [{"source": None, "target": f"h{host}", "success_probability": 0.5} for host in range(hosts)],
    }


def test_of_a_game_its_parts_and_what_a_run_takes_are_said():
    found = check_network(str(ROOT / "examples" / "office.json"))
    assert found.can_run
    assert (found.hosts, found.edges, found.states) == (4, 6, 12)
    assert found.entries == ["outside -> workstation", "outside -> mail server"]
    assert (found.unreachable, found.unusable_edges, found.missing, found.notes) == ([], [], [], [])
    assert found.memory_bytes is not None
    assert found.allowed_bytes == 10 * GIGABYTE
    assert "12 can be reached" in found.as_text()


def test_of_a_plain_topology_everything_missing_is_named_at_once():
    found = check_network(str(ROOT / "examples" / "clinic.graphml"))
    assert not found.is_game
    assert [(each.attribute, len(each.without), each.total) for each in found.missing] == [
        ("value", 11, 11),
        ("success_probability", 14, 14),
        ("foothold", 0, 1),
    ]
    assert found.ignored == {"nodes": ["Building"], "edges": ["LinkType"]}
    assert "14, of which 14 undirected" in found.as_text()
    assert "gsiirl network build" in found.as_text()


def test_what_only_some_lack_is_named(tmp_path: Path):
    document = star(3)
    del document["nodes"][1]["value"]
    document["nodes"][1]["Value"] = 2
    found = check_network(written(tmp_path, document))
    assert "missing      value of 1 of 3 nodes (node 'h1')" in found.as_text()
    assert found.notes == ["not read: 'Value' (did you mean value?)"]


def test_hosts_too_far_for_an_episode_are_named(tmp_path: Path):
    chain = {
        "nodes": [{"name": f"h{host}", "value": 1.0} for host in range(12)],
        "edges": [
            {"source": f"h{host - 1}" if host else None, "target": f"h{host}", "success_probability": 0.5}
            for host in range(12)
        ],
    }
    found = check_network(written(tmp_path, chain))
    assert (found.unreachable, found.too_far) == ([], ["h10", "h11"])
    assert "too far      h10, h11: an episode has 10 steps (--horizon)" in found.as_text()
    assert "too far" not in check_network(written(tmp_path, star(3))).as_text()


def test_hosts_and_edges_that_no_attack_gets_to_are_named(tmp_path: Path):
    document = star(2)
    document["nodes"] += [{"name": "a", "value": 1}, {"name": "b", "value": 1}]
    document["edges"] += [
        {"source": "a", "target": "b", "success_probability": 1},
        {"source": "h0", "target": "h1", "success_probability": 1, "directed": False},
    ]
    found = check_network(written(tmp_path, document))
    assert found.unreachable == ["a", "b"]
    assert found.unusable_edges == ["a -> b"]
    assert found.notes == ["undirected edges (1 of 4) are read as attacks in both directions"]


@pytest.mark.parametrize(("hosts", "counted"), [(14, True), (20, False)])
def test_a_game_that_takes_too_much_memory_is_said_to_be_refused(tmp_path: Path, hosts: int, counted: bool):
    found = check_network(written(tmp_path, star(hosts)))
    assert found.is_game
    assert not found.can_run
    assert found.refused is not None
    assert "half of what is free is 10.0 GB" in found.refused
    # Where fewer seeds would do, the states are known.
    assert found.states == (2**hosts if counted else None)


def test_the_time_expected_grows_with_states_and_edges(tmp_path: Path):
    small, large = (check_network(written(tmp_path, star(hosts))).seconds for hosts in (4, 10))
    assert small is not None
    assert large is not None
    assert small < large


def test_lines_are_of_80_columns(tmp_path: Path):
    document = star(12)
    for node in document["nodes"]:
        node |= {f"an attribute of a name that is long {k}": 1 for k in range(3)}
    document["nodes"][0]["criticalty"] = 1
    text = check_network(written(tmp_path, document)).as_text()
    assert max(len(line) for line in text.splitlines()[1:]) <= 80


def test_a_scenario_of_nasim_is_checked_too():
    assert check_network("small-linear").states == 30


@pytest.mark.parametrize("content", ["no JSON", '{"nodes": [], "edges": []}'])
def test_what_is_no_network_is_refused(tmp_path: Path, content: str):
    (tmp_path / "network.json").write_text(content)
    with pytest.raises(InputError):
        check_network(str(tmp_path / "network.json"))
    with pytest.raises(InputError):
        check_network(str(tmp_path / "none.json"))
