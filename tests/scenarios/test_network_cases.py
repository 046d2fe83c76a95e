"""Files as programs and people write them (tests/data/networks): what is read of each, or the line that refuses it."""

import warnings
from pathlib import Path

import pytest

from gsiirl.errors import InputError, NetworkWarning
from gsiirl.scenarios import read_network
from gsiirl.scenarios.network import AttackNetwork

CASES = Path(__file__).parents[1] / "data" / "networks"

Expected = tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float, float]], list[str]]
"""Hosts with value and criticality; edges with probability, attack cost and block cost; footholds."""


def hosts(**value: float) -> dict[str, tuple[float, float]]:
    """Hosts whose criticality is their value."""
    return {name: (number, number) for name, number in value.items()}


HALF = (0.5, 0.0, 1.0)
PAIR: Expected = (hosts(a=0.3, b=1.0), {"a -> b": HALF}, ["a"])
BOTH_WAYS: Expected = (hosts(a=0.3, b=1.0), {"a -> b": HALF, "b -> a": HALF}, ["a"])
ENTERED: Expected = (hosts(a=0.3, b=1.0), {"outside -> a": HALF, "a -> b": HALF}, [])
BY_DEFAULT: Expected = (hosts(a=0.7, b=0.7), {"a -> b": (0.4, 0.0, 1.0)}, ["a"])
LIKELIEST: Expected = (hosts(a=0.3, b=1.0), {"a -> b": (0.9, 0.0, 1.0)}, ["a"])
NUMBERED: Expected = ({"1": (0.3, 0.3), "2": (1.0, 1.0)}, {"1 -> 2": HALF}, ["1"])
LONG_NAME = "fileserver-very-long-name-01.branch.office.example.internal"

READ: dict[str, Expected] = {
    "OK.GRAPHML": BY_DEFAULT,
    "all_negative.json": (hosts(a=-1.0, b=-0.5), ENTERED[1], []),
    "all_zero.json": (hosts(a=0.0, b=0.0), ENTERED[1], []),
    "bom_crlf.graphml": BY_DEFAULT,
    "bom_crlf.json": ENTERED,
    "bool_1.graphml": PAIR,
    "bool_True.graphml": PAIR,
    "bool_default_empty.graphml": PAIR,
    "cvss_values.json": (hosts(a=7.5, b=9.8), ENTERED[1], []),
    "default_edge_ignored.graphml": ({"a": (0.3, 2.0), "b": (1.0, 2.0)}, {"a -> b": (0.5, 0.25, 3.0)}, ["a"]),
    "defaults_of_three_keys.graphml": (hosts(o=0.0, x=1.0), {"o -> x": (0.8, 0.25, 0.3)}, ["o"]),
    "dollar_names.json": (
        {"CORP\\WS01$": (0.3, 0.3), "CORP\\DC_01$": (1.0, 1.0)},
        {"outside -> CORP\\WS01$": HALF, "CORP\\WS01$ -> CORP\\DC_01$": HALF},
        [],
    ),
    "edge_directed_false.graphml": BOTH_WAYS,
    "edge_directed_true.graphml": PAIR,
    "epss.json": (ENTERED[0], {"outside -> a": (0.00043, 0.0, 1.0), "a -> b": (0.00091, 0.0, 1.0)}, []),
    "euros.json": (
        hosts(a=250_000.0, b=1_200_000.0),
        {"outside -> a": (0.5, 5_000.0, 20_000.0), "a -> b": (0.5, 9_000.0, 15_000.0)},
        [],
    ),
    "float_ids.json": NUMBERED,
    "graph_name_nl.json": ENTERED,
    "html_names.json": (
        {
            "<script>alert(1)</script>": (0.3, 0.3),
            "a | b & c": (1.0, 1.0),
            "核心数据库": (0.6, 0.6),
            LONG_NAME: (0.4, 0.4),
        },
        {
            "outside -> <script>alert(1)</script>": HALF,
            "<script>alert(1)</script> -> a | b & c": HALF,
            "a | b & c -> 核心数据库": HALF,
            f"核心数据库 -> {LONG_NAME}": HALF,
        },
        [],
    ),
    "int_ids.json": NUMBERED,
    "int_vs_str.json": NUMBERED,
    "isolated.json": (hosts(a=0.3, b=1.0, printer=0.1), ENTERED[1], []),
    "key_for_all.graphml": PAIR,
    "key_integer.graphml": (hosts(a=1.0, b=2.0), {"a -> b": (1.0, 0.0, 1.0)}, ["a"]),
    "key_no_for.graphml": PAIR,
    "key_no_id.graphml": PAIR,
    "key_wrong_for.graphml": PAIR,
    "label_names.graphml": (hosts(web=1.0, db=1.0), {"web -> db": HALF}, ["web"]),
    "label_only.json": (hosts(web=0.3, db=1.0), {"web -> db": HALF}, ["web"]),
    "latin1.graphml": (hosts(a=0.7, bü=0.7), {"a -> bü": (0.4, 0.0, 1.0)}, ["a"]),
    "no_edgedefault.graphml": BOTH_WAYS,
    "no_namespace.graphml": PAIR,
    "null_optional.json": (hosts(a=0.3, b=1.0), {"b -> a": HALF}, ["b"]),
    "num_default_empty.graphml": PAIR,
    "num_space.graphml": PAIR,
    "nx1_silent.json": (
        {"1": (0.1, 0.1), "0": (0.2, 0.2), "2": (1.0, 1.0)},
        {"0 -> 1": (0.9, 0.0, 1.0), "1 -> 2": (0.3, 0.0, 1.0), "0 -> 2": (0.1, 0.0, 1.0)},
        ["1"],
    ),
    "nx_mixed_types.graphml": (hosts(a=1.0, b=0.5), {"a -> b": HALF}, ["a"]),
    "office_default3.graphml": (
        {"workstation": (0.2, 0.4), "mail server": (0.5, 0.3), "file server": (0.6, 0.8), "database": (1.0, 1.2)},
        {
            "outside -> workstation": (0.8, 0.1, 3.0),
            "outside -> mail server": (0.5, 0.2, 0.8),
            "workstation -> file server": (0.7, 0.1, 3.0),
            "workstation -> database": (0.3, 0.3, 1.1),
            "mail server -> file server": (0.6, 0.1, 3.0),
            "file server -> database": (0.6, 0.2, 1.2),
        },
        [],
    ),
    "one_node.json": (hosts(a=1.0), {"outside -> a": HALF}, []),
    "other_bool_bad.graphml": PAIR,
    "other_double_bad.graphml": PAIR,
    "parallel.graphml": LIKELIEST,
    "parallel.json": (hosts(a=0.3), {"outside -> a": (0.9, 0.0, 1.0)}, []),
    "parallel_noid.graphml": LIKELIEST,
    "port.graphml": PAIR,
    "prefix_ns.graphml": PAIR,
    "typo_optional.json": ENTERED,
    "undirected.graphml": BOTH_WAYS,
    "undirected.json": (ENTERED[0], {**ENTERED[1], "b -> a": HALF}, []),
    "utf16.graphml": BY_DEFAULT,
    "yed.graphml": (hosts(web=0.3, db=1.0), {"web -> db": HALF}, ["web"]),
    "yed_group.graphml": (
        {"grp::x": (0.9, 0.9), "grp::y": (0.8, 0.8), "a": (0.3, 0.3)},
        {"grp::x -> grp::y": HALF, "a -> grp::x": HALF},
        ["a"],
    ),
}

NOTES: dict[str, list[str]] = {
    "case_attr.graphml": ["'Value' (did you mean value?)"],
    "edge_directed_false.graphml": ["undirected edges (1 of 1)", "both directions"],
    "epss.json": ["hardly ever succeed", "0.00043"],
    "no_edgedefault.graphml": ["undirected edges (1 of 1)", "both directions"],
    "parallel.graphml": ["2 edges 'a -> b'", "likeliest"],
    "parallel.json": ["2 edges 'outside -> a'", "likeliest"],
    "parallel_noid.graphml": ["2 edges 'a -> b'", "likeliest"],
    "typo_optional.json": [
        "'Criticality' (did you mean criticality?)",
        "'footHold' (did you mean foothold?)",
        "'criticalty' (did you mean criticality?)",
        "'attackCost' (did you mean attack_cost?)",
        "'blockcost' (did you mean block_cost?)",
        "'attack_costs' (did you mean attack_cost?)",
    ],
    "undirected.graphml": ["undirected edges (1 of 1)", "both directions"],
    "undirected.json": ["undirected edges (1 of 2)", "both directions"],
}
"""Parts of the one warning; files not named here give none."""

REFUSED: dict[str, list[str]] = {
    "apoc.graphml": ["2 of 2 nodes have no value", "'WS01.CORP'", "1 of 1 edges have no success_probability"],
    "bloodhound_graph.json": ["1 of 1 nodes have no value", "WS01$", "1 of 1 edges have no success_probability"],
    "bloodhound_raw.json": ["nodes:", 'give "nodes": [{...}, ...]'],
    "bool_empty.graphml": ["foothold: node 'a' has an empty one", "give true or false"],
    "bool_yes.graphml": ["foothold: node 'a' has 'yes'", "give true or false"],
    "both_links_edges.json": ["both edges and links", "put all of them under edges"],
    "case_attr.graphml": ["value: 2 of 2 nodes have no value", "rename 'Value' to value"],
    "comment.json": ["not JSON", "line 1"],
    "cyto.json": ["nodes:", 'give "nodes": [{...}, ...]'],
    "cyto_key.graphml": ["node 'web' is there twice"],
    "data_no_key.graphml": ["node 'a' has data without a key", "name the <key>"],
    "default_bad.graphml": ["value: key 'v' in its default has 'high'", "give a number"],
    "dup_data.graphml": ["value: node 'a' has it twice", "keep one"],
    "edge_no_target.graphml": ["edge number 1, from 'a', has no target", "name a node"],
    "empty.json": ["not JSON"],
    "empty_boolean.graphml": ["foothold: node 'o' has an empty one", "give true or false"],
    "empty_default.graphml": ["edges: there are 0 edges"],
    "empty_lists.json": ["nodes: there are 0 nodes"],
    "flag_int.json": ["foothold: node 'a' has 1", "give true or false"],
    "flag_string.json": ["foothold: node 'a' has \"true\"", "give true or false"],
    "from_to.json": ["edge number 1 has no source"],
    "hyper.graphml": ["hyperedge: one joins 'a', 'b'", "write an edge for each pair"],
    "inf.graphml": ["value: node 'a' has an infinite number"],
    "jsonl.json": ["not JSON", "line 2"],
    "key_int_float.graphml": ["value: node 'a' has '0.3'", "whole number", 'attr.type="double"'],
    "key_no_name.graphml": ["key 'zz' has no attr.name", "remove it"],
    "key_not_declared.graphml": ["node 'a' has data of the key 'k5'", "add the <key>"],
    "key_notype.graphml": ["value: node 'a' has '0.3' of the type string", 'attr.type="double"'],
    "key_string.graphml": ["value: node 'a' has '0.3' of the type string", 'attr.type="double"'],
    "latin1.json": ["not UTF-8 text (line 1)", "save it as UTF-8"],
    "latin1_lie.graphml": ["not XML", "line 5", "UTF-8"],
    "laughs.graphml": ["entity 'a'", "write its text"],
    "list.json": ["no JSON object"],
    "n60_plain.json": ["60 of 60 nodes have no value", "59 of 59 edges have no success_probability"],
    "nan.graphml": ["value: node 'a' has NaN"],
    "nan.json": ["value: node 'a' has NaN"],
    "nested_silent.graphml": ["node 'grp' holds a graph", "move its nodes and edges"],
    "no_edges.json": ["edges: there are 0 edges"],
    "node_name_edges.json": ["edge 'web -> db' has a source 'web' that is no node"],
    "node_no_id.graphml": ["node number 1 has no id", "give it an id"],
    "null_value.json": ["value: node 'a' has none"],
    "num_comma.graphml": ["value: node 'a' has '0,3'", "give a number"],
    "num_empty.graphml": ["value: node 'a' has an empty one", "give a number"],
    "nx1_index_links.json": ["nothing can ever be attacked"],
    "ok.graphml.gz": ["is packed", "unpack it"],
    "old_ns.graphml": [
        "http://graphml.graphdrawing.org/xmlns/graphml",
        'xmlns="http://graphml.graphdrawing.org/xmlns"',
    ],
    "outside_target.json": ["edge 'a -> internet' leads outside"],
    "plain.graphml": ["2 of 2 nodes have no value", "1 of 1 edges have no success_probability"],
    "prob_bool.json": ["success_probability: edge 'b -> a' has true"],
    "prob_percent.json": ["success_probability: edge 'b -> a' has 80"],
    "prob_zero.json": ["success_probability: edge 'b -> a' has 0"],
    "self_loop.json": ["edge 'b -> b' leads from a node to itself"],
    "space_first.graphml": ["not XML", "line 2"],
    "string_number.json": ["value: node 'a' has \"0.3\"", "give a number"],
    "true_id.json": ["node number 1 has true", "give a text or a number"],
    "two_graphs.graphml": ["there are 2 graphs", "keep one graph a file"],
    "undirected_flipped.graphml": ["nothing can ever be attacked"],
    "unknown_key.graphml": ["node 'a' has data of the key 'zz'", "add the <key>"],
    "utf16.json": ["UTF-16", "save it as UTF-8"],
    "xxe.graphml": ["entity 'x'", "write its text"],
}


def outcome(path: Path) -> tuple[AttackNetwork | InputError, list[str]]:
    """What is read of a file, or why not; and the warnings."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            network = read_network(path)
        except InputError as error:
            network = error
    assert all(warning.category is NetworkWarning for warning in said)
    return network, [str(warning.message) for warning in said]


def test_every_file_has_its_outcome():
    assert sorted(path.name for path in CASES.iterdir()) == sorted({*READ, *REFUSED})


@pytest.mark.parametrize("file", READ)
def test_the_file_is_read_as_it_stands(file: str):
    network, _ = outcome(CASES / file)
    assert isinstance(network, AttackNetwork), network
    nodes = dict(zip(network.node_names, zip(network.value, network.criticality, strict=True), strict=True))
    numbers = zip(network.success_probability, network.attack_cost, network.block_cost, strict=True)
    footholds = [network.node_names[node] for node in network.footholds]
    expected_nodes, expected_edges, expected_footholds = READ[file]
    assert (nodes, footholds) == (expected_nodes, expected_footholds)
    assert list(nodes) == list(expected_nodes)
    assert dict(zip(network.edge_names, numbers, strict=True)) == expected_edges


@pytest.mark.parametrize("file", REFUSED)
def test_the_file_is_refused_in_a_short_line_that_helps(file: str):
    error, _ = outcome(CASES / file)
    assert isinstance(error, InputError), error
    line = str(error)
    assert line.startswith(str(CASES / file))
    assert "\n" not in line
    assert len(line) < len(str(CASES / file)) + 250
    assert [part for part in REFUSED[file] if part not in line] == [], line


@pytest.mark.parametrize("file", [*READ, *REFUSED])
def test_what_is_not_as_it_seems_is_said_in_one_line(file: str):
    _, said = outcome(CASES / file)
    assert len(said) == (file in NOTES), said
    for line in said:
        assert line.startswith(str(CASES / file))
        assert [part for part in NOTES[file] if part not in line] == [], line
