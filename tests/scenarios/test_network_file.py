"""Attack networks from GraphML and JSON files."""

import gzip
import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import networkx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsiirl.errors import InputError, NetworkWarning
from gsiirl.scenarios.nasim import nasim_network
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.scenarios.network_file import read_network
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


def write(graph: networkx.Graph, path: Path) -> Path:
    if path.suffix == ".json":
        write_node_link(graph, path, "edges")
    else:
        networkx.write_graphml(graph, path)
    return path


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
    network = read_network(write(graph, tmp_path / f"office{suffix}"))
    assert network.footholds == (0,)
    assert network.edge_names == ("desk -> safe",)


def change_graph(change: Callable[[networkx.DiGraph], Any]) -> networkx.Graph:
    graph = office_graph()
    changed = change(graph)
    return changed if isinstance(changed, networkx.Graph) else graph


def two_exploits(graph: networkx.DiGraph, **second: float) -> networkx.MultiDiGraph:
    """The office with another edge from desk to safe."""
    double = networkx.MultiDiGraph(graph)
    double.add_edge("desk", "safe", **second)
    return double


BAD_GRAPHS: dict[str, tuple[Callable[[networkx.DiGraph], Any], list[str]]] = {
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
        ["success_probability", "'outside -> desk' has none"],
    ),
    "text for a number": (lambda graph: graph.nodes["desk"].update(value="much"), ["value: node 'desk' has", "much"]),
    "truth for a number": (lambda graph: graph.nodes["desk"].update(value=True), ["value: node 'desk' has", "rue"]),
    "text for a truth": (
        lambda graph: graph.nodes["desk"].update(foothold="perhaps"),
        ["foothold: node 'desk' has", "perhaps"],
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
    "a bad edge beside a good one": (
        lambda graph: two_exploits(graph, success_probability=-0.5),
        ["success_probability", "'desk -> safe'", "-0.5"],
    ),
    "NaN on an edge beside a good one": (
        lambda graph: two_exploits(graph, success_probability=0.1, attack_cost=float("nan")),
        ["attack_cost", "'desk -> safe'", "NaN"],
    ),
}


@pytest.mark.parametrize("suffix", [".json", ".graphml"])
@pytest.mark.parametrize("case", BAD_GRAPHS)
def test_a_bad_graph_is_refused_naming_file_and_element(tmp_path: Path, suffix: str, case: str):
    change, parts = BAD_GRAPHS[case]
    message = str(refusal(write(change_graph(change), tmp_path / f"bad{suffix}")))
    assert all(part in message for part in parts), message


OFFICE_EDITS: dict[str, tuple[str, str, list[str]]] = {
    "json: dangling target": ('"target": "workstation"', '"target": "workstaton"', ["edges", "'workstaton'"]),
    "json: dangling source": ('"source": "mail server"', '"source": "mail"', ["edges", "source 'mail'"]),
    "json: null target": ('"target": "mail server"', '"target": null', ["edges", "edge number 2 has the target null"]),
    "json: no source": ('{"source": null, "target": "mail', '{"target": "mail', ["edge number 2 has no source"]),
    "json: node twice": ('{"name": "database"', '{"name": "mail server"', ["node 'mail server' is there twice"]),
    "json: nameless node": ('{"name": "database", ', "{", ["node number 4 has no name"]),
    "json: no nodes": ('"nodes"', '"hosts"', ['"nodes"']),
    "json: nodes are no objects": ('{"name": "database", "value": 1.0, "criticality": 1.2}', '"database"', ["nodes"]),
    "json: directed by a word": ('"name": "office"', '"directed": "no"', ["directed", '"no"', "true or false"]),
    "json: an edge directed by a word": (
        '{"source": null, "target": "mail',
        '{"directed": 0, "source": null, "target": "mail',
        ["directed: edge 'outside -> mail server' has 0"],
    ),
    "json: a list for a source": ('{"source": null', '{"source": [[]]', ["source: edge number 1 has a list"]),
    "json: an object for a value": ('"value": 1.0', '"value": {}', ["value: node 'database' has an object"]),
    "json: a name that is not text": ('"name": "database"', '"id": 1, "name": false', ["name: node '1' has false"]),
    "json: half a character": (
        '"name": "database"',
        '"id": "database", "name": "data\\ud800base"',
        ["the name 'data base' holds half a character"],
    ),
    "json: value twice": ('"value": 1.0', '"value": 1.0, "value": 2.0', ["value: node 'database' has it twice"]),
    "json: source twice": ('"source": null', '"source": "database", "source": null', ["source", "twice"]),
    "json: edges twice": ('"name": "office",', '"name": "office", "edges": [],', ["edges: the file has it twice"]),
    "json: digits without end": ('"value": 1.0', '"value": 1' + 5000 * "0", ["thousands of digits"]),
    "json: huge number": ('"value": 1.0', '"value": 1' + 400 * "0", ["value", "'database'"]),
    "json: not JSON": ('"nodes": [', '"nodes": [,', ["not JSON", "line 3"]),
    "graphml: dangling target": ('target="workstation"', 'target="workstaton"', ["edges", "'workstaton'"]),
    "graphml: dangling source": ('source="mail server"', 'source="mail"', ["edges", "source 'mail'"]),
    "graphml: node twice": ('<node id="database"', '<node id="mail server"', ["node 'mail server' is there twice"]),
    "graphml: text for a number": ('<data key="v">1.0', '<data key="v">one', ["value", "node 'database' has 'one'"]),
    "graphml: empty number": ('<data key="p">0.7', '<data key="p">', ["success_probability", "'workstation -> file"]),
    "graphml: unknown key": ('<data key="v">1.0', '<data key="w">1.0', ["node 'database'", "key 'w'"]),
    "graphml: key twice": ('<key id="c"', '<key id="v"', ["key 'v' is there twice"]),
    "graphml: two defaults": ("<default>1.0", "<default>2.0</default><default>1.0", ["key 'b' has 2 defaults"]),
    "graphml: two keys with defaults": (
        '<key id="a"',
        '<key id="z" for="edge" attr.name="block_cost" attr.type="double"><default>2</default></key><key id="a"',
        ["block_cost: key 'b' has a second default"],
    ),
    "graphml: two keys of one attribute": ('attr.name="criticality"', 'attr.name="value"', ["'workstation'", "twice"]),
    "graphml: an element where a number belongs": (
        '<data key="v">1.0',
        '<data key="v">1<b/>0',
        ["'database'", "plain"],
    ),
    "graphml: digits as Python has them": (
        '<data key="v">1.0',
        '<data key="v">1_0',
        ["value: node 'database' has '1_0'"],
    ),
    "graphml: edgedefault": ('"directed"', '"both"', ["edgedefault: the graph has 'both'"]),
    "graphml: an edge's directed": ("<edge ", '<edge directed="no" ', ["directed: edge 'internet -> workstation'"]),
    "graphml: an element we do not know": ('<node id="database">', '<Node/><node id="database">', ["<Node>"]),
    "graphml: an element of the file": ("<graph ", "<node/><graph ", ["the file holds an element <node>"]),
    "graphml: a graph in an edge": (
        '"internet" target="workstation">',
        '"internet" target="workstation"><graph/>',
        ["<graph>"],
    ),
    "graphml: an entity of another file": (
        "<graphml ",
        '<!DOCTYPE graphml SYSTEM "x.dtd"><?x &mail;?><graphml ',
        ["entities of another file"],
    ),
    "graphml: an unknown entity": ('id="database"', 'id="&mail;"', ["not XML", "undefined entity"]),
    "graphml: not XML": ("</graphml>", "", ["not XML"]),
    "graphml: unknown encoding": ("UTF-8", "UTF-9", ["not XML", "UTF-9"]),
    "graphml: an encoding of several bytes": ("UTF-8", "GBK", ["not XML", "save it", "UTF-8"]),
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
        ("nothing.xml", b"<graphml/>"),
        ("deep.graphml", b"<graphml><graph>" + b"<node id='x' yfiles.foldertype='group'><graph>" * 50_000),
    ],
)
def test_other_content_is_refused(tmp_path: Path, name: str, content: bytes):
    path = tmp_path / name
    path.write_bytes(content)
    refusal(path)


@pytest.mark.parametrize("name", ["office.json", "office.graphml", "office.json.gz"])
def test_a_packed_file_is_to_be_unpacked_whatever_its_name(tmp_path: Path, name: str):
    path = tmp_path / name
    path.write_bytes(gzip.compress((EXAMPLES / "office.json").read_bytes()))
    assert "unpack it" in refusal(path).mend


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
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NetworkWarning)
            outcome = read_network(path)
    except InputError as error:
        outcome = error
    assert "\n" not in str(outcome)


def read_and_listen(path: Path) -> tuple[AttackNetwork, str]:
    """The network, and the one warning."""
    with pytest.warns(NetworkWarning) as said:
        network = read_network(path)
    (warning,) = said
    return network, str(warning.message).removeprefix(f"{path}: ")


@pytest.mark.parametrize("suffix", [".json", ".graphml"])
def test_an_undirected_edge_from_outside_is_an_entry_edge_whichever_end_is_named_first(tmp_path: Path, suffix: str):
    graph = networkx.Graph()
    graph.add_edge("desk", "internet", success_probability=0.5)
    graph.add_edge("safe", "desk", success_probability=0.25)
    networkx.set_node_attributes(graph, {"desk": 1.0, "safe": 2.0}, "value")
    graph.nodes["internet"]["outside"] = True
    network, said = read_and_listen(write(graph, tmp_path / f"office{suffix}"))
    assert set(network.edge_names) == {"outside -> desk", "desk -> safe", "safe -> desk"}
    assert said == "undirected edges (1 of 2) are read as attacks in both directions"


def test_the_edges_of_an_undirected_json_file_may_be_directed_themselves(tmp_path: Path):
    path = tmp_path / "office.json"
    content = json.loads((EXAMPLES / "office.json").read_text()) | {"directed": False}
    for edge in content["edges"][:-1]:
        edge["directed"] = True
    path.write_text(json.dumps(content))
    network, _ = read_and_listen(path)
    assert network.edge_names[-2:] == ("file server -> database", "database -> file server")
    assert network.block_cost.tolist()[-2:] == [1.2, 1.2]
    assert len(network.edge_names) == 7


@pytest.mark.parametrize("suffix", [".json", ".graphml"])
@pytest.mark.parametrize(
    ("second", "taken"),
    [
        ({"success_probability": 0.7, "attack_cost": 9.0}, (0.7, 9.0, 1.0)),
        ({"success_probability": 0.1, "attack_cost": 0.0}, (0.25, 0.5, 2.0)),
        ({"success_probability": 0.25, "attack_cost": 0.1, "block_cost": 3.0}, (0.25, 0.1, 3.0)),
        ({"success_probability": 0.25, "attack_cost": 0.5, "block_cost": 3.0}, (0.25, 0.5, 2.0)),
    ],
    ids=["likelier", "less likely", "as likely, cheaper", "as good"],
)
def test_of_parallel_edges_the_likeliest_then_the_cheapest_is_taken(
    tmp_path: Path, suffix: str, second: dict[str, float], taken: tuple[float, float, float]
):
    graph = two_exploits(office_graph(), **second)
    network, said = read_and_listen(write(graph, tmp_path / f"office{suffix}"))
    assert network.edge_names == ("outside -> desk", "desk -> safe")
    numbers = (network.success_probability[1], network.attack_cost[1], network.block_cost[1])
    assert numbers == taken
    assert said.startswith("2 edges 'desk -> safe'")


def graphml(keys: str, elements: str, edgedefault: str = "directed") -> str:
    """A GraphML file that declares value (v), success_probability (p) and foothold (f), and `keys`."""
    ours = (
        '<key id="v" for="node" attr.name="value" attr.type="double"><default>1</default></key>'
        '<key id="p" for="edge" attr.name="success_probability" attr.type="double"><default>0.5</default></key>'
        '<key id="f" for="node" attr.name="foothold" attr.type="boolean"/>'
    )
    return f'<graphml>{ours}{keys}<graph edgedefault="{edgedefault}">{elements}</graph></graphml>'


FOOTHOLD = '<data key="f"> true\n</data>'
LABEL = '<key id="l" for="node" attr.name="Label" attr.type="string"/>'


def test_labels_of_several_nodes_leave_them_their_ids(tmp_path: Path):
    path = tmp_path / "office.graphml"
    labels = {"0": "web", "1": "web", "2": "two\n lines", "3": "4", "4": "mail", "5": " "}
    nodes = "".join(
        f'<node id="{node}">{FOOTHOLD}<data key="l">{label}</data></node>' for node, label in labels.items()
    )
    path.write_text(graphml(LABEL, f'{nodes}<node id="6"/><edge source="0" target="6"/>'))
    network, said = read_and_listen(path)
    assert network.node_names == ("0", "1", "two lines", "3", "mail", "5", "6")
    assert said == "labels that fit several nodes: 'web', '4'; these nodes are called by their ids"


def test_the_first_label_that_yed_shows_is_the_name(tmp_path: Path):
    path = tmp_path / "office.graphml"
    drawn = (
        "<y:NodeLabel> </y:NodeLabel><y:NodeLabel>web<y:LabelModel/></y:NodeLabel><y:NodeLabel>10.0.0.1</y:NodeLabel>"
    )
    node = f'<node id="n0">{FOOTHOLD}<data key="g"><y:ShapeNode xmlns:y="yworks">{drawn}</y:ShapeNode></data></node>'
    keys = '<key id="g" for="node" yfiles.type="nodegraphics"/>'
    path.write_text(graphml(keys, node + '<node id="n1"/><edge source="n0" target="n1"/>'))
    assert read_network(path).node_names == ("web", "n1")


@pytest.mark.parametrize(
    ("edge", "arrows", "attacks"),
    [
        ("", 'source="none" target="standard"', ["a -> b"]),
        ("", 'source="none" target="none"', ["a -> b", "b -> a"]),
        ("", 'source="standard" target="delta"', ["a -> b", "b -> a"]),
        ('directed="true"', 'source="none" target="none"', ["a -> b"]),
    ],
)
def test_a_line_that_yed_draws_without_an_arrow_goes_both_ways(
    tmp_path: Path, edge: str, arrows: str, attacks: list[str]
):
    path = tmp_path / "office.graphml"
    drawn = f'<data key="g"><y:PolyLineEdge xmlns:y="yworks"><y:Arrows {arrows}/></y:PolyLineEdge></data>'
    keys = '<key id="g" for="edge" yfiles.type="edgegraphics"/>'
    nodes = f'<node id="a">{FOOTHOLD}</node><node id="b"/>'
    path.write_text(graphml(keys, f'{nodes}<edge source="a" target="b" {edge}>{drawn}</edge>'))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NetworkWarning)
        assert sorted(read_network(path).edge_names) == attacks


def test_a_name_goes_before_a_label(tmp_path: Path):
    path = tmp_path / "office.json"
    nodes = [
        {"id": 7, "name": "web", "label": "Web", "value": 1, "foothold": True},
        {"id": 8, "label": "DB", "value": 1},
    ]
    path.write_text(json.dumps({"nodes": nodes, "edges": [{"source": 7, "target": 8, "success_probability": 1}]}))
    assert read_network(path).edge_names == ("web -> DB",)


def group(identifier: str, elements: str, data: str = "", edgedefault: str = "") -> str:
    return f'<node id="{identifier}" yfiles.foldertype="group">{data}<graph {edgedefault}>{elements}</graph></node>'


def test_groups_in_groups_are_read_in_the_order_of_the_file(tmp_path: Path):
    path = tmp_path / "office.graphml"
    inner = group("inner", '<node id="c"/><edge source="b" target="c"/>', edgedefault='edgedefault="undirected"')
    outer = group("outer", f'<node id="b"/>{inner}<node id="d"/><edge source="b" target="d"/>')
    path.write_text(graphml("", f'<node id="a">{FOOTHOLD}</node>{outer}<edge source="a" target="b"/><node id="e"/>'))
    network, _ = read_and_listen(path)
    assert network.node_names == ("a", "b", "c", "d", "e")
    assert network.edge_names == ("b -> c", "c -> b", "b -> d", "a -> b")


def test_a_group_is_no_host(tmp_path: Path):
    path = tmp_path / "office.graphml"
    body = group("frame", f'<node id="a">{FOOTHOLD}</node><node id="b"/>', data='<data key="v">3</data>')
    path.write_text(graphml("", body + '<edge source="a" target="b"/>'))
    network, said = read_and_listen(path)
    assert network.node_names == ("a", "b")
    assert said == "groups are no hosts, so not read: value of 'frame'"
    path.write_text(graphml("", body + '<edge source="a" target="frame"/>'))
    with pytest.warns(NetworkWarning):
        assert "'frame' that is a group" in refusal(path).problem


def test_a_default_of_a_key_for_the_wrong_kind_is_read_and_said(tmp_path: Path):
    path = tmp_path / "office.graphml"
    key = '<key id="b" for="node" attr.name="block_cost" attr.type="double"><default>3</default></key>'
    path.write_text(graphml(key, f'<node id="a">{FOOTHOLD}</node><node id="b"/><edge source="a" target="b"/>'))
    network, said = read_and_listen(path)
    assert network.block_cost.tolist() == [3.0]
    assert said == "key 'b' is read as if it had for=\"edge\", as block_cost needs"


def test_an_attribute_of_the_same_name_of_the_other_kind_is_not_taken_for_it(tmp_path: Path):
    path = tmp_path / "office.graphml"
    key = '<key id="w" for="edge" attr.name="value" attr.type="double"><default>9</default></key>'
    key += '<key id="n" for="edge" attr.name="name" attr.type="string"><default>cable</default></key>'
    path.write_text(graphml(key, f'<node id="a">{FOOTHOLD}</node><node id="b"/><edge source="a" target="b"/>'))
    network = read_network(path)
    assert network.value.tolist() == [1.0, 1.0]
    assert network.node_names == ("a", "b")


def test_keys_may_stand_in_the_graph_and_share_an_id_between_nodes_and_edges(tmp_path: Path):
    path = tmp_path / "office.graphml"
    keys = (
        '<key id="x" for="node" attr.name="value" attr.type="double"/>'
        '<key id="x" for="edge" attr.name="success_probability" attr.type="double"/>'
    )
    edge = '<edge source="a" target="b"><data key="x">0.25</data></edge>'
    nodes = f'<node id="a">{FOOTHOLD}<data key="x">3</data></node><node id="b"><data key="x">4</data></node>'
    for text in (graphml(keys, nodes + edge), graphml("", keys + nodes + edge)):
        path.write_text(text)
        network = read_network(path)
        assert network.value.tolist() == [3.0, 4.0]
        assert network.success_probability.tolist() == [0.25]


def test_a_dtd_without_entities_is_no_hindrance(tmp_path: Path):
    path = tmp_path / "office.graphml"
    text = (EXAMPLES / "office.graphml").read_text()
    path.write_text(
        text.replace("<graphml ", '<!DOCTYPE graphml SYSTEM "graphml.dtd"><graphml ').replace("mail", "&lt;")
    )
    assert "< server" in read_network(path).node_names


@pytest.mark.parametrize(
    "name", ["value", "Value", "VALUE", "val-ue", "vlaue", "valu", "vale", "vallue", "values", "valve"]
)
def test_a_slip_in_a_name_is_seen(tmp_path: Path, name: str):
    path = tmp_path / "office.json"
    path.write_text(
        (EXAMPLES / "office.json").read_text().replace('"criticality"', f'"{name}"').replace('"value": 0.2,', "")
    )
    if name == "value":
        assert "twice" in refusal(path).problem
    else:
        with pytest.warns(NetworkWarning, match=f"'{name}' "):
            assert f"rename '{name}' to value" in refusal(path).mend


def test_only_attacks_that_can_come_first_say_whether_one_will_ever_succeed(tmp_path: Path):
    path = tmp_path / "office.graphml"
    edge = '<edge source="{}" target="{}"><data key="p">{}</data></edge>'.format
    nodes = f'<node id="a">{FOOTHOLD}</node><node id="b">{FOOTHOLD}</node><node id="c"/><node id="d"/>'
    path.write_text(graphml("", nodes + edge("a", "b", 0.9) + edge("b", "c", 0.001) + edge("c", "d", 0.9)))
    _, said = read_and_listen(path)
    assert said.endswith("at most 0.001 a try")


def test_a_slip_in_what_says_that_a_graph_is_undirected_is_seen(tmp_path: Path):
    path = tmp_path / "office.json"
    path.write_text((EXAMPLES / "office.json").read_text().replace('"name": "office"', '"Directed": false'))
    network, said = read_and_listen(path)
    assert len(network.edge_names) == 6
    assert said == "not read: 'Directed' (did you mean directed?)"


@pytest.mark.parametrize("name", ["volumes", "val", "weight", "cost", "label", "x" * 1000])
def test_other_attributes_are_no_slips(tmp_path: Path, name: str):
    path = tmp_path / "office.json"
    path.write_text((EXAMPLES / "office.json").read_text().replace('"criticality"', f'"{name}"'))
    assert read_network(path).criticality.tolist() == [0.2, 0.5, 0.6, 1.0]


@pytest.mark.parametrize("suffix", ["json", "graphml"])
@pytest.mark.parametrize("place", ["0.2", "database", "value", "success_probability"])
def test_a_message_stays_short_whatever_the_file_holds(tmp_path: Path, suffix: str, place: str):
    path = tmp_path / f"office.{suffix}"
    text = (EXAMPLES / f"office.{suffix}").read_text()
    long = json.dumps("x\x7fy" * 40_000)[1:-1] if suffix == "json" else "xy" * 40_000
    path.write_text(text.replace(place, f'"{long}"' if (suffix, place) == ("json", "0.2") else long, 1))
    error = refusal(path)
    assert len(str(error)) < len(str(path)) + 250
    assert error.problem.isprintable()
