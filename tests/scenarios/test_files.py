"""Attack networks from GraphML and JSON files."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import networkx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsiirl.errors import InputError
from gsiirl.scenarios.files import read_network
from gsiirl.scenarios.nasim import nasim_network
from gsiirl.scenarios.random_graph import random_network

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


def refusal(path: Path) -> InputError:
    with pytest.raises(InputError) as caught:
        read_network(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    return caught.value


def test_both_examples_hold_the_same_network():
    from_json, from_graphml = read_network(EXAMPLES / "office.json"), read_network(EXAMPLES / "office.graphml")
    assert from_json.to_json_dict() == from_graphml.to_json_dict()
    assert from_json.name == "office"
    assert from_json.node_names == ("workstation", "mail server", "file server", "database")
    assert from_json.edge_names[0] == "outside -> workstation"
    assert from_json.criticality.tolist() == [0.4, 0.3, 0.8, 1.2]
    assert from_json.block_cost.tolist() == [1.0, 0.8, 1.0, 1.1, 1.0, 1.2]


@pytest.mark.parametrize("example", ["office.json", "office.graphml"])
def test_the_page_on_scenarios_shows_the_examples_as_they_are(example: str):
    assert (EXAMPLES / example).read_text().strip() in (ROOT / "docs" / "scenarios.md").read_text()


@given(st.integers(0, 1000), st.sampled_from(["general_sum", "zero_sum"]))
def test_the_game_of_a_run_reads_back_exactly(tmp_path_factory: Any, seed: int, variant: Any):
    path = tmp_path_factory.getbasetemp() / "game.json"
    network = random_network(seed, variant=variant)
    extra = {"format_version": 1, "horizon": 10, "truth": {"expert_reward": [[0.0], ["value of node 0"]]}}
    path.write_text(json.dumps(dict(network.to_json_dict()) | extra))
    assert read_network(path, variant).to_json_dict() == network.to_json_dict()


def test_entry_edges_read_back(tmp_path: Path):
    network = nasim_network("small-linear")
    path = tmp_path / "game.json"
    path.write_text(json.dumps(network.to_json_dict()))
    assert read_network(path).to_json_dict() == network.to_json_dict()


def office_graph() -> networkx.DiGraph:
    graph = networkx.DiGraph()
    graph.add_node("internet", outside=True)
    graph.add_node("desk", value=1)
    graph.add_node("safe", value=2.0, criticality=5.0)
    graph.add_edge("internet", "desk", success_probability=0.5)
    graph.add_edge("desk", "safe", success_probability=0.25, attack_cost=0.5, block_cost=2.0)
    return graph


def write_node_link(graph: networkx.Graph, path: Path, edges: str) -> None:
    path.write_text(json.dumps(networkx.node_link_data(graph, edges=edges)))


@pytest.mark.parametrize(
    ("suffix", "write"),
    [
        (".json", lambda graph, path: write_node_link(graph, path, "links")),
        (".json", lambda graph, path: write_node_link(graph, path, "edges")),
        (".graphml", networkx.write_graphml),
        (".xml", networkx.write_graphml),
    ],
    ids=["node-link links", "node-link edges", "graphml", "xml"],
)
def test_what_networkx_writes_is_read_with_defaults(
    tmp_path: Path, suffix: str, write: Callable[[networkx.Graph, Path], None]
):
    path = tmp_path / f"small office{suffix}"
    write(office_graph(), path)
    network = read_network(path)
    assert network.name == "small office"
    assert network.node_names == ("desk", "safe")
    assert network.edge_names == ("outside -> desk", "desk -> safe")
    assert network.value.tolist() == [1.0, 2.0]
    assert network.criticality.tolist() == [1.0, 5.0]
    assert network.success_probability.tolist() == [0.5, 0.25]
    assert network.attack_cost.tolist() == [0.0, 0.5]
    assert network.block_cost.tolist() == [1.0, 2.0]
    assert read_network(path, "zero_sum").criticality.tolist() == [1.0, 2.0]


@pytest.mark.parametrize("suffix", [".json", ".graphml"])
def test_a_foothold_replaces_the_way_in_and_names_replace_numbers(tmp_path: Path, suffix: str):
    graph = networkx.DiGraph()
    graph.add_node(0, name="desk", value=1.0, foothold=True)
    graph.add_node(1, name="safe", value=2.0, foothold=False)
    graph.add_edge(0, 1, success_probability=0.5)
    path = tmp_path / f"office{suffix}"
    if suffix == ".json":
        write_node_link(graph, path, "edges")
    else:
        networkx.write_graphml(graph, path)
    network = read_network(path)
    assert network.footholds == (0,)
    assert network.edge_names == ("desk -> safe",)


def change_graph(change: Callable[[networkx.DiGraph], Any]) -> networkx.Graph:
    graph = office_graph()
    changed = change(graph)
    return changed if isinstance(changed, networkx.Graph) else graph


BAD_GRAPHS: dict[str, tuple[Callable[[networkx.DiGraph], Any], list[str]]] = {
    "undirected": (lambda graph: graph.to_undirected(), ["undirected"]),
    "probability beyond 1": (
        lambda graph: graph["desk"]["safe"].update(success_probability=1.2),
        ["success_probability", "'desk -> safe'", "1.2"],
    ),
    "NaN": (lambda graph: graph.nodes["safe"].update(value=float("nan")), ["value", "'safe'", "NaN"]),
    "infinite": (lambda graph: graph["desk"]["safe"].update(attack_cost=float("inf")), ["attack_cost", "infinite"]),
    "no way in": (lambda graph: graph.remove_node("internet"), ["foothold", "nothing can ever be attacked"]),
    "missing value": (lambda graph: graph.nodes["desk"].pop("value"), ["value", "'desk' has none"]),
    "missing probability": (
        lambda graph: graph["internet"]["desk"].pop("success_probability"),
        ["success_probability", "'internet -> desk' has none"],
    ),
    "text for a number": (lambda graph: graph.nodes["desk"].update(value="much"), ["value", "'desk' has 'much'"]),
    "truth for a number": (lambda graph: graph.nodes["desk"].update(value=True), ["value", "'desk' has True"]),
    "text for a truth": (
        lambda graph: graph.nodes["desk"].update(foothold="perhaps"),
        ["foothold", "'desk' has 'perhaps'"],
    ),
    "edge to itself": (
        lambda graph: graph.add_edge("desk", "desk", success_probability=0.5),
        ["'desk -> desk'", "itself"],
    ),
    "edge leading outside": (
        lambda graph: graph.add_edge("desk", "internet", success_probability=0.5),
        ["'desk -> internet'", "outside"],
    ),
    "nothing": (lambda graph: networkx.DiGraph(), ["nodes", "0 nodes"]),
}


@pytest.mark.parametrize("suffix", [".json", ".graphml"])
@pytest.mark.parametrize("case", BAD_GRAPHS)
def test_a_bad_graph_is_refused_naming_file_and_element(tmp_path: Path, suffix: str, case: str):
    change, parts = BAD_GRAPHS[case]
    path = tmp_path / f"bad{suffix}"
    graph = change_graph(change)
    if suffix == ".json":
        write_node_link(graph, path, "edges")
    else:
        networkx.write_graphml(graph, path)
    message = str(refusal(path))
    assert all(part in message for part in parts), message


OFFICE_EDITS: dict[str, tuple[str, str, list[str]]] = {
    "json: dangling target": ('"target": "workstation"', '"target": "workstaton"', ["edges", "'workstaton'"]),
    "json: dangling source": ('"source": "mail server"', '"source": "mail"', ["edges", "source 'mail'"]),
    "json: null target": ('"target": "mail server"', '"target": null', ["edges", "outside -> "]),
    "json: no source": ('{"source": null, "target": "mail', '{"target": "mail', ["edge number 2 has no source"]),
    "json: node twice": ('{"name": "database"', '{"name": "mail server"', ["node 'mail server' is there twice"]),
    "json: edge twice": (
        '{"source": "workstation", "target": "database"',
        '{"source": "workstation", "target": "file server"',
        ["'workstation -> file server' is there twice"],
    ),
    "json: nameless node": ('{"name": "database", ', "{", ["node number 4 has no name"]),
    "json: no nodes": ('"nodes"', '"hosts"', ['"nodes"']),
    "json: nodes are no objects": ('{"name": "database", "value": 1.0, "criticality": 1.2}', '"database"', ["nodes"]),
    "json: undirected": ('"name": "office"', '"directed": false', ["undirected"]),
    "json: huge number": ('"value": 1.0', '"value": 1' + 400 * "0", ["value", "'database'"]),
    "json: not JSON": ('"nodes": [', '"nodes": [,', ["not JSON", "line 3"]),
    "graphml: dangling target": ('target="workstation"', 'target="workstaton"', ["edges", "'workstaton'"]),
    "graphml: dangling source": ('source="mail server"', 'source="mail"', ["edges", "source 'mail'"]),
    "graphml: node twice": ('<node id="database"', '<node id="mail server"', ["node 'mail server' is there twice"]),
    "graphml: edge twice": (
        'source="file server" target="database"',
        'source="workstation" target="database"',
        ["'workstation -> database' is there twice"],
    ),
    "graphml: text for a number": ('<data key="v">1.0', '<data key="v">one', ["value", "node 'database' has 'one'"]),
    "graphml: empty number": ('<data key="p">0.7', '<data key="p">', ["success_probability", "'workstation -> file"]),
    "graphml: unknown key": ('<data key="v">1.0', '<data key="w">1.0', ["not GraphML"]),
    "graphml: not XML": ("</graphml>", "", ["not XML"]),
    "graphml: unknown encoding": ("UTF-8", "UTF-9", ["not XML", "UTF-9"]),
    "graphml: no graph": ("graph edgedefault", "grid edgedefault", ["not XML"]),
}


@pytest.mark.parametrize("case", OFFICE_EDITS)
def test_a_damaged_example_is_refused_naming_file_and_element(tmp_path: Path, case: str):
    suffix = case.partition(":")[0]
    before, after, parts = OFFICE_EDITS[case]
    text = (EXAMPLES / f"office.{suffix}").read_text()
    assert before in text
    path = tmp_path / f"office.{suffix}"
    path.write_text(text.replace(before, after, 1))
    message = str(refusal(path))
    assert all(part in message for part in parts), message


@pytest.mark.parametrize("name", ["absent.json", "absent.graphml", "folder.json", "folder.xml"])
def test_what_is_no_readable_file_is_refused(tmp_path: Path, name: str):
    path = tmp_path / name
    if name.startswith("folder"):
        path.mkdir()
    assert "cannot be read" in refusal(path).problem


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("list.json", b"[1, 2]"),
        ("deep.json", b"[" * 100_000),
        ("bytes.json", b"\xff\xfe\x00"),
        ("empty.json", b""),
        ("empty.graphml", b""),
        ("page.xml", b"<html><body/></html>"),
    ],
)
def test_other_content_is_refused(tmp_path: Path, name: str, content: bytes):
    path = tmp_path / name
    path.write_bytes(content)
    refusal(path)


def test_an_unknown_kind_of_file_is_refused_with_the_known_kinds(tmp_path: Path):
    path = tmp_path / "office.yaml"
    path.write_text("nodes: []")
    assert ".graphml, .xml, .json" in refusal(path).mend


@given(st.integers(0, 2**32), st.binary(max_size=4), st.sampled_from(["json", "graphml"]))
def test_a_damaged_file_gives_a_network_or_an_input_error(tmp_path_factory: Any, place: int, patch: bytes, suffix: str):
    content = (EXAMPLES / f"office.{suffix}").read_bytes()
    place %= len(content)
    path = tmp_path_factory.getbasetemp() / f"damaged.{suffix}"
    path.write_bytes(content[:place] + patch + content[place + len(patch) + 1 :])
    try:
        outcome = read_network(path)
    except InputError as error:
        outcome = error
    assert "\n" not in str(outcome)
