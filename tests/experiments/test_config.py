import dataclasses
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gsiirl.errors import InputError
from gsiirl.experiments.config import (
    EXPERIMENTS,
    ExperimentConfig,
    config_from_dict,
    config_to_dict,
    field_schemas,
    load_config,
    load_config_file,
)
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.runs.files.json_file import versioned
from gsiirl.scenarios import AttackNetwork
from tests import helpers


@pytest.mark.parametrize("kind", EXPERIMENTS.values())
def test_every_field_has_help_and_a_default(kind: type[ExperimentConfig]):
    schemas = field_schemas(kind)
    assert list(schemas) == [field.name for field in dataclasses.fields(kind)]
    assert all(schema["description"] and "default" in schema for schema in schemas.values())


def test_values_replace_defaults():
    config = load_config(SecurityConfig, {"graph_seed": 3, "discount": "0.9"})
    assert config == SecurityConfig(graph_seed=3, discount=0.9)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"seeds": 0}, "seeds: cannot be 0; give a whole number of at least 1 and at most 10000"),
        ({"seeds": 10_001}, "seeds: cannot be 10001; give a whole number of at least 1 and at most 10000"),
        (
            {"horizon": "9" * 5000},
            f"horizon: cannot be {'9' * 40}... (5000 characters); give a whole number of at least 1 and at most 10000",
        ),
        ({"nodes": 17}, "nodes: cannot be 17; give a whole number of at least 2 and at most 16"),
        ({"discount": 1.5}, "discount: cannot be 1.5; give a number above 0 and at most 1"),
        ({"temperature": float("nan")}, "temperature: cannot be nan; give a number above 0, or unknown"),
        ({"temperature": float("inf")}, "temperature: cannot be inf; give a number above 0, or unknown"),
        ({"temperature": ""}, "temperature: cannot be ''; give a number above 0, or unknown"),
        ({"temperature": [1, 2]}, "temperature: cannot be [1, 2]; give a number above 0, or unknown"),
        ({"variant": "foo"}, "variant: cannot be foo; choose general_sum or zero_sum"),
        ({"expert": "foo"}, "expert: cannot be foo; choose responding or simulated"),
        ({"learner_no_op": "maybe"}, "learner_no_op: cannot be maybe; give true or false"),
        ({"graph": 3}, "graph: cannot be 3; give a text"),
        ({"graf": "small"}, "graf: is no field of the security experiment; did you mean graph?"),
    ],
)
def test_a_bad_value_is_told_in_one_line(values: dict[str, Any], message: str):
    with pytest.raises(InputError) as raised:
        load_config(SecurityConfig, values)
    assert str(raised.value) == message


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        (CrossingConfig, {"hidden": 0}, "hidden: cannot be 0; give a whole number of at least 1 and at most 4096"),
        (CrossingConfig, {"solver": "logit"}, "solver: cannot be logit; choose pathwise or maddpg"),
        (CrossingConfig, {"variant": "mpe"}, "variant: is no field of the crossing experiment; the fields are "),
        (DeceptionConfig, {"discount": 0}, "discount: cannot be 0; give a number above 0 and at most 1"),
        (DeceptionConfig, {"variant": "x"}, "variant: cannot be x; choose mpe or separate_target"),
        (
            DeceptionConfig,
            {"iteration": 1},
            "iteration: is no field of the deception experiment; did you mean iteratio",
        ),
    ],
)
def test_every_experiment_checks_its_own_fields(kind: type[ExperimentConfig], values: dict[str, Any], message: str):
    with pytest.raises(InputError) as raised:
        load_config(kind, values)
    assert str(raised.value).startswith(message)


def test_maddpg_is_for_marl_only():
    assert CrossingConfig(solver="maddpg", algorithm="marl").resolved().solver == "maddpg"
    with pytest.raises(InputError, match="solver: maddpg does not go with algorithm gsiirl; use pathwise, or"):
        CrossingConfig(solver="maddpg").resolved()


@pytest.mark.parametrize("algorithm", ["gsiirl", "ma-irl", "lin2019", "marl"])
def test_security_commits_to_a_policy_unless_it_is_told_otherwise(algorithm: str):
    full = SecurityConfig(algorithm=algorithm).resolved()  # pyright: ignore[reportArgumentType]
    assert (full.commitment, full.lower_level, full.explore) == ("policy", "likelihood", "informative")
    assert (full.response, full.hypergradient, full.remembered) == (None, None, None)
    assert full.resolved() == full
    assert SecurityConfig(explore="estimate").resolved().explore == "estimate"


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"response": "measured"},
            "response: measured does not go with a commitment to a policy; use --commitment rew",
        ),
        ({"lower_level": "equilibrium"}, "lower_level: equilibrium does not go with a commitment to a policy; use"),
        ({"algorithm": "paper", "explore": "thompson"}, "explore: thompson does not go with a commitment to a reward"),
        ({"commitment": "policy", "expert": "simulated"}, "expert: simulated is told the reward that the learner acts"),
        ({"lower_level": "matching", "explore": "thompson"}, "lower_level: matching has no posterior; use explore"),
        ({"algorithm": "paper", "temperature": "unknown"}, "temperature: cannot be unknown to the paper's algorithm"),
    ],
)
def test_settings_that_do_not_go_together_are_told(values: dict[str, Any], message: str):
    with pytest.raises(InputError) as raised:
        load_config(SecurityConfig, values).resolved()
    assert str(raised.value).startswith(message)


@pytest.mark.parametrize("algorithm", ["gsiirl", "paper", "ma-irl", "marl"])
def test_a_preset_fills_in_only_what_is_not_given(algorithm: str):
    fields = {"algorithm": algorithm, "commitment": "reward"}
    full: Any = load_config(SecurityConfig, fields).resolved()
    assert (full.response, full.remembered == 1) == (
        ("frozen", True) if algorithm == "paper" else ("well_specified", False)
    )
    assert full.resolved() == full
    more: Any = load_config(SecurityConfig, {"remembered": 7, **fields}).resolved()
    assert more.remembered == 7


def test_an_unlike_field_gets_the_list_of_fields():
    with pytest.raises(InputError, match="xyzzy: is no field of the security experiment; the fields are algorithm, "):
        load_config(SecurityConfig, {"xyzzy": 1})


def test_of_several_bad_values_the_first_is_told():
    with pytest.raises(InputError) as raised:
        load_config(SecurityConfig, {"discount": 2, "seeds": 0})
    assert raised.value.field == "seeds"  # the first in the order of the fields


def test_flags_override_the_file(tmp_path: Path):
    path = tmp_path / "run.toml"
    path.write_text('algorithm = "marl"\ngraph_seed = 3\nlearner_no_op = true\n')
    config = load_config_file(SecurityConfig, path, {"graph_seed": "4"})
    assert config == SecurityConfig(algorithm="marl", graph_seed=4, learner_no_op=True)


def test_an_error_names_the_flag_or_the_key_it_came_from(tmp_path: Path):
    path = tmp_path / "run.toml"
    path.write_text("graph_seed = -1\n")
    with pytest.raises(InputError) as raised:
        load_config_file(SecurityConfig, path, {})
    assert raised.value.field == f"graph_seed in {path}"
    with pytest.raises(InputError) as raised:
        load_config_file(SecurityConfig, path, {"graph_seed": "-2"})
    assert raised.value.field == "--graph-seed"


@pytest.mark.parametrize(
    ("content", "problem"),
    [(b"seeds = = 3", "is not TOML"), (b"\xff\xfe", "is not TOML"), (None, "cannot be read")],
)
def test_an_unreadable_file_is_told(tmp_path: Path, content: bytes | None, problem: str):
    path = tmp_path / "run.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=problem) as raised:
        load_config_file(SecurityConfig, path, {})
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("experiment", "config"),
    [
        ("security", SecurityConfig(algorithm="ma-irl", temperature=0.1, graph="small")),
        ("crossing", CrossingConfig(algorithm="paper", smoothness=5.0)),
        ("deception", DeceptionConfig(algorithm="marl", solver="maddpg", variant="separate_target")),
    ],
)
def test_a_configuration_survives_its_file(experiment: str, config: ExperimentConfig):
    content = config_to_dict(config)
    assert content["experiment"] == experiment
    assert config_from_dict(json.loads(json.dumps(versioned(content))), Path("config.json")) == config


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"experiment": "x"},
            "experiment in run/config.json: cannot be 'x'; "
            "this version of gsiirl knows security, crossing, deception, game",
        ),
        ({"seeds": 0}, "seeds in run/config.json: cannot be 0; give a whole number of at least 1 and at most 10000"),
    ],
)
def test_a_damaged_configuration_is_told(change: dict[str, Any], message: str):
    with pytest.raises(InputError) as raised:
        config_from_dict(config_to_dict(SecurityConfig()) | change, Path("run/config.json"))
    assert str(raised.value) == message


@pytest.mark.parametrize("name", ["n\x7fise", "clon\u07b7steps", "two\nlines", "\x1b[31mseeds"])
def test_an_unknown_field_of_strange_letters_is_told_in_one_printable_line(name: str):
    with pytest.raises(InputError, match="is no field of the security experiment") as raised:
        config_from_dict(config_to_dict(SecurityConfig()) | {name: 1}, Path("run/config.json"))
    assert str(raised.value).isprintable()


@pytest.mark.parametrize("kind", EXPERIMENTS.values())
def test_every_whole_number_has_an_upper_bound(kind: type[ExperimentConfig]):
    whole = {name: schema for name, schema in field_schemas(kind).items() if schema["type"] == "integer"}
    assert {"seeds", "first_seed", "iterations", "trajectories"} <= set(whole)
    assert [name for name, schema in whole.items() if "maximum" not in schema] == []
    # The last seed is a number of 32 bits.
    assert whole["first_seed"]["maximum"] + whole["seeds"]["maximum"] - 1 < 2**31


def test_temperature_follows_the_graph(tmp_path: Path):
    assert SecurityConfig().resolved().temperature == 0.4
    assert SecurityConfig(graph="small-linear").resolved().temperature == 0.05
    assert SecurityConfig(graph="small-linear", temperature=1.0).resolved().temperature == 1.0
    # Of a file it is 0.4 of the largest value, which is 1.2 here.
    graph = written(tmp_path, helpers.small_network())
    assert SecurityConfig(graph=graph).resolved().temperature == 0.4 * 1.2
    assert SecurityConfig(graph=graph, temperature=0.1).resolved().temperature == 0.1
    unknown = SecurityConfig(graph=graph, temperature="unknown").resolved()
    assert unknown.temperature == "unknown"
    assert unknown.expert_temperature(unknown.network()) == 0.4 * 1.2


def written(folder: Path, network: AttackNetwork) -> str:
    path = folder / f"{network.name}.json"
    path.write_text(json.dumps(network.to_json_dict()))
    return str(path)


@pytest.mark.parametrize("algorithm", ["gsiirl", "paper", "ma-irl", "marl"])
def test_a_file_whose_largest_value_is_1_is_run_as_ever(algorithm: str):
    office = str(Path(__file__).parents[2] / "examples" / "office.json")
    full: Any = load_config(SecurityConfig, {"graph": office, "algorithm": algorithm}).resolved()
    assert (full.temperature, full.reward_bound, full.smoothness) == (0.4, 1.2, 60.0)


def test_settings_in_reward_units_follow_a_network_s_scale_and_no_others_do(tmp_path: Path):
    network = helpers.small_network()
    euros = replace(
        network,
        name="euros",
        **{name: 1e5 * getattr(network, name) for name in ("value", "criticality", "attack_cost", "block_cost")},
    )
    one, other = (
        dataclasses.asdict(SecurityConfig(graph=written(tmp_path, each)).resolved()) for each in (network, euros)
    )
    assert {name for name in one if one[name] != other[name]} == {"graph", "temperature", "reward_bound"}
    for name in ("temperature", "reward_bound"):
        assert other[name] == pytest.approx(1e5 * one[name], rel=1e-15)


def test_the_bound_covers_values_losses_and_costs(tmp_path: Path):
    network = helpers.small_network()
    for name, largest in (("value", -7.0), ("criticality", 8.0), ("attack_cost", 9.0)):
        changed = getattr(network, name).copy()
        changed[1] = largest
        graph = written(tmp_path, replace(network, **{name: changed}))
        assert SecurityConfig(graph=graph).resolved().reward_bound == abs(largest)


def test_a_scenario_in_nasims_format_is_run_as_one_of_nasims_own():
    clinic = str(Path(__file__).parents[1] / "data" / "nasim" / "clinic.yaml")
    names = ("temperature", "reward_bound", "smoothness")
    full, own = (SecurityConfig(graph=graph).resolved() for graph in (clinic, "small"))
    assert [getattr(full, name) for name in names] == [getattr(own, name) for name in names] == [0.05, 1.0, 1.5]
