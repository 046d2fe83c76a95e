"""`load_network` takes a file or a scenario's name."""

import subprocess
import sys
from pathlib import Path

import pytest

from gsiirl.errors import InputError
from gsiirl.scenarios import known_scenarios, load_network

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("example", ["office.json", "office.graphml"])
def test_a_file_is_read_in_the_variant_asked_for(example: str):
    network = load_network(str(EXAMPLES / example), "zero_sum")
    assert network.variant == "zero_sum"
    assert network.criticality.tolist() == network.value.tolist()


def test_a_name_is_a_nasim_scenario():
    assert load_network("small-linear").name == "small-linear"


def test_the_known_scenarios_include_those_of_eight_hosts():
    assert {"small", "small-linear", "small-honeypot"} <= set(known_scenarios())


def test_neither_file_nor_name_is_refused_naming_both_kinds():
    with pytest.raises(InputError, match=r"'no-such'.*tiny.*\.graphml, \.xml, \.json or \.yaml") as caught:
        load_network("no-such")
    assert caught.value.field == "graph"


def test_a_missing_file_is_not_taken_for_a_name():
    with pytest.raises(InputError, match=r"absent\.json: cannot be read"):
        load_network("absent.json")


def test_an_existing_file_of_another_kind_is_not_taken_for_a_name(tmp_path: Path):
    path = tmp_path / "office.txt"
    path.write_text("{}")
    with pytest.raises(InputError, match="unknown kind"):
        load_network(str(path))


def test_loading_a_scenario_imports_nothing_heavy():
    command = (
        "import sys; from gsiirl.scenarios import known_scenarios, load_network;"
        "known_scenarios(); load_network('tiny');"
        "print(sorted({'jax', 'matplotlib', 'nasim', 'networkx', 'tkinter'} & set(sys.modules)))"
    )
    answer = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_an_unknown_variant_is_refused_where_types_are_not_checked():
    command = (
        f"from gsiirl.scenarios import load_network; load_network({str(EXAMPLES / 'office.json')!r}, 'cooperative')"
    )
    answer = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=False)
    assert answer.returncode == 1
    assert "variant: 'cooperative' is unknown; give one of general_sum, zero_sum" in answer.stderr
