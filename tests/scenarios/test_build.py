"""A game from a plain topology and a table of vulnerabilities."""

import json
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from gsiirl.errors import InputError, NetworkWarning
from gsiirl.scenarios.build import BuiltNetwork, build_network
from gsiirl.scenarios.network_file import read_network
from gsiirl.scenarios.vulnerabilities import CvssRule

EXAMPLES = Path(__file__).parents[2] / "examples"
LINE = {"directed": False, "nodes": ["a", "b", "c"], "edges": ["ab", "bc"]}
"""a - b - c, undirected."""


def topology(folder: Path, directed: bool, nodes: Sequence[Any], edges: Sequence[Any]) -> Path:
    path = folder / "plain.json"
    document = {
        "directed": directed,
        "nodes": [{"name": node} if isinstance(node, str) else node for node in nodes],
        "edges": [{"source": edge[0], "target": edge[1]} if isinstance(edge, str) else edge for edge in edges],
    }
    path.write_text(json.dumps(document))
    return path


def built(folder: Path, table: str, footholds: Sequence[str] = ("a",), **plain: Any) -> tuple[BuiltNetwork, list[str]]:
    """The network, and what was said of it."""
    path = folder / "table.csv"
    path.write_text(table)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", NetworkWarning)
        network = build_network(topology(folder, **(LINE | plain)), path, footholds, CvssRule())
    return network, [str(warning.message) for warning in said]


def attacks(network: BuiltNetwork) -> dict[str, tuple[float, float, str]]:
    arrays = network.network
    numbers = zip(arrays.success_probability.tolist(), arrays.attack_cost.tolist(), strict=True)
    return {
        edge: (probability, cost, name)
        for edge, (probability, cost), name in zip(arrays.edge_names, numbers, network.vulnerabilities, strict=True)
    }


def refusal(folder: Path, table: str, footholds: Sequence[str] = ("a",), **plain: Any) -> str:
    with pytest.raises(InputError) as caught:
        built(folder, table, footholds, **plain)
    return str(caught.value)


def test_an_exploit_works_from_every_neighbour(tmp_path: Path):
    table = "host,name,probability,value\nb,hole,0.5,1\nc,hole,0.25,2\na,hole,0.9,3\n"
    network, _ = built(tmp_path, table, footholds=["c"])
    assert attacks(network) == {"c -> b": (0.5, 0, "hole"), "b -> a": (0.9, 0, "hole")}
    assert network.network.value.tolist() == [3, 1, 2]
    assert network.network.footholds == (2,)


def test_of_a_pair_the_likeliest_exploit_is_taken_then_the_cheapest_then_the_first(tmp_path: Path):
    table = "host,name,probability,attack_cost,value\nb,w,0.4,0,1\nb,x,0.5,2,\nb,y,0.5,1,\nb,z,0.5,1,\n"
    assert attacks(built(tmp_path, table)[0]) == {"a -> b": (0.5, 1, "y")}


def test_an_exploit_with_a_source_works_from_there_alone(tmp_path: Path):
    table = "host,name,probability,source,value\nb,any,0.2,,1\nb,near,0.9,c,\nc,only,0.7,b,1\n"
    star = {"nodes": ["a", "b", "c", "d"], "edges": ["ab", "bc", "ac", "cd", "bd"]}
    network, _ = built(tmp_path, table + "c,other,0.1,a,\n", ["a", "d"], **star)
    # d is next to c too, but has no exploit for it.
    assert attacks(network) == {
        "a -> b": (0.2, 0, "any"),
        "c -> b": (0.9, 0, "near"),
        "d -> b": (0.2, 0, "any"),
        "a -> c": (0.1, 0, "other"),
        "b -> c": (0.7, 0, "only"),
    }


def test_the_source_outside_makes_an_entry_edge_and_then_no_foothold_is_needed(tmp_path: Path):
    network, _ = built(tmp_path, "host,name,probability,source,value\nb,hole,0.5,outside,1\n", footholds=[])
    assert attacks(network) == {"outside -> b": (0.5, 0, "hole")}


def test_a_directed_edge_is_attacked_one_way_and_a_place_outside_of_the_topology_is_an_entry(tmp_path: Path):
    nodes = [{"name": "internet", "outside": True}, "a", "b"]
    edges = [{"source": "internet", "target": "a"}, "ab"]
    table = "host,name,probability,value\na,hole,0.5,1\nb,hole,0.5,1\n"
    network, _ = built(tmp_path, table, [], directed=True, nodes=nodes, edges=edges)
    assert set(attacks(network)) == {"outside -> a", "a -> b"}


def test_a_directed_edge_is_no_way_back_and_an_edge_to_itself_is_none(tmp_path: Path):
    table = "host,name,probability,value\nb,hole,0.5,1\nc,hole,0.5,1\n"
    network, said = built(tmp_path, table, directed=True, edges=["ab", "ac", "bc", "bb"])
    assert set(attacks(network)) == {"a -> b", "a -> c", "b -> c"}
    assert said == [f"{tmp_path / 'plain.json'}: edges from a host to itself (1) are left out"]


def test_hosts_without_a_vulnerability_and_what_lies_behind_them_are_named(tmp_path: Path):
    plain = {"nodes": ["a", "b", "c", "d"], "edges": ["ab", "ac", "cd"]}
    network, said = built(tmp_path, "host,name,probability,value\nb,hole,0.5,1\nd,hole,0.5,1\n", **plain)
    assert set(attacks(network)) == {"a -> b"}
    assert network.network.node_names == ("a", "b", "c", "d")
    path = tmp_path / "plain.json"
    assert f"{path}: no vulnerability, so no edge to them (2 left out): c" in said
    assert f"{path}: vulnerable, but no attacker gets next to them: d" in said
    assert f"{path}: 3 more edges left out: back to where" in "".join(said)


def test_a_cvss_score_becomes_a_probability_and_the_rule_is_said_unless_a_probability_is_given(tmp_path: Path):
    table = "host,name,cvss,probability,value\nb,hole,7.5,,1\nc,hole,9,0.2,1\n"
    network, said = built(tmp_path, table)
    assert [probability for probability, _, _ in attacks(network).values()] == [0.75, 0.2]
    assert "probability = cvss / 10" in "".join(said)
    assert "probability =" not in "".join(built(tmp_path, "host,name,cvss,probability,value\nb,hole,9,0.2,1\n")[1])


def test_a_cvss_of_0_is_no_vulnerability(tmp_path: Path):
    network, said = built(tmp_path, "host,name,cvss,value\nb,info,0.0,\nb,hole,5,1\nc,info,0,1\n")
    assert set(attacks(network)) == {"a -> b"}
    assert "left out line 2, 4" in "".join(said)


def test_values_come_from_the_table_then_from_the_topology_and_else_are_0(tmp_path: Path):
    nodes = ["a", {"name": "b", "value": 5, "criticality": 7}, {"name": "c", "value": 6}, "d"]
    table = "host,name,probability,value\nb,hole,0.5,\nc,hole,0.5,2\nc,other,0.1,2.0\nd,hole,0.5,\n"
    network, said = built(tmp_path, table, nodes=nodes, edges=["ab", "bc", "cd"])
    assert network.network.value.tolist() == [0, 5, 2, 0]
    assert f"{tmp_path / 'plain.json'}: no value, so 0 is taken: d" in said
    assert f"{tmp_path / 'plain.json'}: not read of the topology: criticality" in said


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("b,hole,0.5,,\n", ("value", "worth anything")),
        ("b,hole,0.5,,1\nc,hole,0.5,a,\n", ("line 3, source", "'a' has no edge to 'c'")),
        ("b,hole,0.5,,1\nb,other,0.5,,2\n", ("line 3, value", "'b' has 2, and 1 in line 2")),
        ("c,hole,0.5,,1\n", ("foothold", "no host can be attacked")),
        ("bb,hole,0.5,,1\nzz,hole,0.5,,\n", ("host", "'bb' (did you mean b?), 'zz'")),
        ("b,hole,0.5,cc,1\n", ("source", "'cc' (did you mean c?)")),
    ],
)
def test_tables_that_do_not_fit_the_topology_are_refused(tmp_path: Path, table: str, words: tuple[str, ...]):
    message = refusal(tmp_path, "host,name,probability,source,value\n" + table)
    assert all(word in message for word in words), message


def test_footholds_have_to_be_hosts_of_the_topology(tmp_path: Path):
    table = "host,name,probability,value\nb,hole,0.5,1\n"
    assert "foothold: not in the topology: 'A' (did you mean a?)" in refusal(tmp_path, table, ["A"])
    assert "add --foothold NAME" in refusal(tmp_path, table, [])
    nodes = [{"name": "internet", "outside": True}, "a", "b"]
    assert "a place outside" in refusal(tmp_path, table, ["internet"], nodes=nodes, edges=["ab"])


def test_a_label_of_several_hosts_asks_for_an_id(tmp_path: Path):
    nodes = [{"id": "1", "label": "pc"}, {"id": "2", "label": "pc"}]
    edges = [{"source": "1", "target": "2"}]
    table = "host,name,probability,value\npc,hole,0.5,1\n"
    assert "'pc' (a label of several: give an id, 1, 2)" in refusal(tmp_path, table, ["1"], nodes=nodes, edges=edges)
    table = "host,name,probability,value\n2,hole,0.5,1\n"
    assert set(attacks(built(tmp_path, table, ["1"], nodes=nodes, edges=edges)[0])) == {"1 -> 2"}


def test_what_is_built_reads_back(tmp_path: Path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NetworkWarning)
        network = build_network(EXAMPLES / "clinic.graphml", EXAMPLES / "clinic.csv", ["Reception PC"], CvssRule())
    path = tmp_path / "clinic.json"
    path.write_text(json.dumps(network.to_json_dict()))
    assert read_network(path).to_json_dict() == network.network.to_json_dict()
    assert json.loads(path.read_text())["edges"][0]["vulnerability"] == "outdated web mail"


def test_what_is_refused_is_told_in_one_line(tmp_path: Path):
    table, plain = tmp_path / "table.csv", topology(tmp_path, **LINE)
    table.write_text("host,name,cvss,value\nb,hole,9,1\nz,hole,5,1\n")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", NetworkWarning)
        with pytest.raises(InputError, match="not in the topology: 'z'"):
            build_network(plain, table, ["a"], CvssRule())
        assert not said


def test_hosts_without_a_vulnerability_that_no_edge_leads_to_have_none_left_out(tmp_path: Path):
    _, said = built(tmp_path, "host,name,probability,value\nb,hole,0.5,1\n", directed=True, edges=["ab", "cb"])
    assert f"{tmp_path / 'plain.json'}: no vulnerability, so not to be attacked: c" in said
