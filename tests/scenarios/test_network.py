"""An attack network is checked when it is made."""

import dataclasses
import json
from typing import Any

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.scenarios.network import AttackNetwork


def chain(**changes: Any) -> AttackNetwork:
    """outside -> a -> b -> c."""
    fields: dict[str, Any] = {
        "name": "chain",
        "node_names": ("a", "b", "c"),
        "value": [0.0, 1.0, 2.0],
        "criticality": [0.5, 0.5, 3.0],
        "edge_source": [-1, 0, 1],
        "edge_target": [0, 1, 2],
        "success_probability": [0.5, 0.75, 1.0],
        "attack_cost": [0.0, 0.1, 0.2],
        "block_cost": [1.0, 1.0, 0.0],
    }
    made: dict[str, Any] = {
        field: np.array(content) if isinstance(content, list) else content
        for field, content in (fields | changes).items()
    }
    return AttackNetwork(**made)


def test_a_valid_network_keeps_its_numbers_as_read_only_arrays():
    value = np.array([0.0, 1.0, 2.0])
    network = chain(value=value)
    value[0] = 9.0
    assert network.value.tolist() == [0.0, 1.0, 2.0]
    assert network.value.dtype == np.float64
    assert network.edge_source.dtype == np.int64
    for field in dataclasses.fields(network):
        content = getattr(network, field.name)
        if isinstance(content, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                content[0] = 1


def test_edges_are_named_after_their_ends():
    assert chain().edge_names == ("outside -> a", "a -> b", "b -> c")


def test_footholds_are_sorted_and_each_kept_once():
    assert chain(footholds=(1, 0, 1)).footholds == (0, 1)


def test_zero_sum_sets_criticality_to_value_and_leaves_the_original():
    network = chain()
    paired = network.with_variant("zero_sum")
    assert paired.variant == "zero_sum"
    assert paired.criticality.tolist() == network.value.tolist()
    assert network.variant == "general_sum"
    assert network.criticality.tolist() == [0.5, 0.5, 3.0]


def test_json_content_has_null_for_outside_and_plain_numbers():
    content = json.loads(json.dumps(chain(footholds=(1,)).to_json_dict(), allow_nan=False))
    assert set(content) == {"kind", "name", "variant", "nodes", "edges"}
    assert content["kind"] == "attack_graph"
    assert content["nodes"][1] == {"name": "b", "value": 1.0, "criticality": 0.5, "foothold": True}
    assert content["edges"][0] == {
        "source": None,
        "target": "a",
        "success_probability": 0.5,
        "attack_cost": 0.0,
        "block_cost": 1.0,
    }
    assert content["edges"][2]["source"] == "b"


@pytest.mark.parametrize(
    ("changes", "field", "part"),
    [
        ({"node_names": ("a", "b", "a")}, "nodes", "node 'a' is there twice"),
        ({"node_names": ("a", "b", "outside")}, "nodes", "outside"),
        ({"node_names": ()}, "nodes", "0 nodes"),
        ({"node_names": tuple(map(str, range(1001)))}, "nodes", "there are 1001 nodes"),
        ({"value": [0.0, float("nan"), 2.0]}, "value", "node 'b' has NaN"),
        ({"criticality": [0.0, 1.0, float("inf")]}, "criticality", "node 'c' has an infinite number"),
        ({"value": [0.0, 1.0]}, "value", "shape (2,)"),
        ({"value": ["much", "more", "most"]}, "value", "something else than numbers"),
        ({"edge_source": [], "edge_target": []}, "edge_source", "at least one edge"),
        ({"edge_source": [-1.0, 0.5, 1.0]}, "edge_source", "node indices"),
        ({"edge_source": [-1, 0]}, "edge_target", "2 sources for 3 targets"),
        ({"edge_source": [-2, 0, 1]}, "edge_source", "edge 0 names node -2"),
        ({"edge_target": [0, 1, 3]}, "edge_target", "edge 2 names node 3"),
        ({"edge_target": [0, 1, -1]}, "edge_target", "edge 2 names node -1"),
        ({"edge_target": [0, 0, 2]}, "edges", "'a -> a' leads from a node to itself"),
        ({"edge_source": [-1, 0, 0], "edge_target": [0, 1, 1]}, "edges", "'a -> b' is there twice"),
        ({"success_probability": [0.5, 1.2, 1.0]}, "success_probability", "edge 'a -> b' has 1.2"),
        ({"success_probability": [0.5, 0.0, 1.0]}, "success_probability", "edge 'a -> b' has 0"),
        ({"success_probability": [float("nan"), 0.5, 1.0]}, "success_probability", "edge 'outside -> a' has NaN"),
        ({"attack_cost": [0.0, 0.0, -0.1]}, "attack_cost", "edge 'b -> c' has -0.1"),
        ({"block_cost": [-1, 0.0, 0.0]}, "block_cost", "edge 'outside -> a' has -1"),
        ({"block_cost": np.array(1.0)}, "block_cost", "shape ()"),
        ({"footholds": (3,)}, "foothold", "no node 3"),
        ({"footholds": (-1,)}, "foothold", "no node -1"),
        ({"variant": "zero_sum"}, "criticality", "differs from value"),
    ],
)
def test_a_bad_field_is_refused_in_one_line_naming_it(changes: dict[str, Any], field: str, part: str):
    with pytest.raises(InputError) as caught:
        chain(**changes)
    assert caught.value.field == field
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"edge_source": [1, 0, 1]},
        {"edge_source": [1, 0, 1], "footholds": (2,)},
        {"footholds": (0, 1, 2)},
    ],
    ids=["no way in", "foothold without outgoing edges", "everything compromised"],
)
def test_a_network_where_nothing_can_be_attacked_is_refused(changes: dict[str, Any]):
    with pytest.raises(InputError, match="nothing can ever be attacked") as caught:
        chain(**changes)
    assert caught.value.field == "foothold"
    assert "entry edge" in caught.value.mend
