"""Attack networks from NASim's published scenarios, beside NASim's own files and its own reading of them."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.scenarios.nasim import FOLDER, nasim_names, nasim_network
from gsiirl.scenarios.nasim_file import read_nasim
from gsiirl.scenarios.network import AttackNetwork


def edge(network: AttackNetwork, name: str) -> tuple[float, float]:
    place = network.edge_names.index(name)
    return float(network.success_probability[place]), float(network.attack_cost[place])


@pytest.mark.parametrize(
    ("name", "hosts", "entries", "others"),
    [
        ("tiny", 3, 1, 4),
        ("tiny-small", 5, 1, 8),
        ("small-linear", 8, 2, 15),
        ("small", 8, 1, 32),
        ("small-honeypot", 8, 1, 33),
        ("medium", 16, 1, 149),
    ],
)
def test_hosts_and_edges_are_as_many_as_the_scenario_has(name: str, hosts: int, entries: int, others: int):
    network = nasim_network(name)
    assert len(network.node_names) == hosts
    assert np.sum(network.edge_source == -1) == entries
    assert np.sum(network.edge_source >= 0) == others


def test_small_linear_has_the_numbers_of_its_file():
    network = nasim_network("small-linear")
    assert network.node_names[2:5] == ("host (3, 0)", "host (3, 1)", "host (4, 0)")
    assert network.value.tolist() == [0, 0, 1, 0, 1, 0, 0, 0]
    assert network.footholds == ()
    assert network.edge_names[:2] == ("outside -> host (1, 0)", "outside -> host (6, 0)")
    # Exploits: http 0.9 for 2, ssh 0.9 for 3 (Linux), ftp 0.6 for 1 (Windows); sensitive hosts are worth 100.
    assert edge(network, "outside -> host (1, 0)") == (0.9, 0.02)
    assert edge(network, "host (1, 0) -> host (2, 0)") == (0.9, 0.03)
    assert edge(network, "host (3, 1) -> host (3, 0)") == (0.6, 0.01)
    assert np.all(network.block_cost == 0.01)


def test_hosts_of_one_subnet_attack_each_other_without_a_firewall():
    names = nasim_network("small-linear").edge_names
    assert "host (3, 0) -> host (3, 1)" in names
    assert "host (3, 1) -> host (3, 0)" in names


def test_the_likeliest_of_several_exploits_is_taken():
    # Host (3, 1) runs ftp (0.6 for 1) and http (0.9 for 2) under Windows, and within a subnet both pass.
    assert edge(nasim_network("small"), "host (3, 0) -> host (3, 1)") == (0.9, 0.02)


def test_a_host_firewall_denies_one_way_only():
    # In tiny, (1, 0) denies ssh to (3, 0), and ssh is all there is.
    names = nasim_network("tiny").edge_names
    assert "host (3, 0) -> host (1, 0)" not in names
    assert "host (1, 0) -> host (3, 0)" in names


def test_the_honeypot_keeps_its_negative_value_and_its_loss_counts_as_nothing():
    network = nasim_network("small-honeypot")
    honeypot = network.node_names.index("host (3, 2)")
    assert network.value[honeypot] == -1
    assert 0 <= network.criticality[honeypot] <= 0.5


def test_criticality_is_half_value_and_half_out_degree():
    network = nasim_network("tiny")
    # Edges between hosts: (1, 0) -> (3, 0), (2, 0) -> (3, 0), (2, 0) -> (1, 0) and (3, 0) -> (2, 0).
    assert network.value.tolist() == [0, 1, 1]
    assert network.criticality.tolist() == [0.25, 1.0, 0.75]
    assert nasim_network("tiny", "zero_sum").criticality.tolist() == [0, 1, 1]


@pytest.mark.parametrize("name", nasim_names())
def test_every_listed_scenario_loads(name: str):
    assert len(nasim_network(name).node_names) <= 16


def test_an_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"'smal' is unknown.*small-linear.*\.graphml") as caught:
        nasim_network("smal")
    assert caught.value.field == "graph"


def test_the_networks_that_come_with_the_package_are_those_of_nasims_files():
    package = importlib.util.find_spec("nasim")
    assert package is not None
    assert package.submodule_search_locations
    files = sorted(Path(package.submodule_search_locations[0], "scenarios", "benchmark").glob("*.yaml"))
    assert {file.stem for file in files} == set(nasim_names())
    for file in files:
        # To the last bit: run folders hold these numbers.
        assert nasim_network(file.stem).to_json_dict() == read_nasim(file).to_json_dict()


def test_nasims_licence_stands_beside_its_scenarios():
    notice = " ".join((FOLDER / "LICENSE-NASim.md").read_text().split())
    assert "Copyright (c) 2018" in notice
    assert "The above copyright notice and this permission notice shall be included in all copies" in notice


NASIM_PAIRS = """
import json
from nasim.envs.network import Network
from nasim.scenarios import make_benchmark_scenario
from nasim.scenarios.benchmark import AVAIL_STATIC_BENCHMARKS

pairs = {}
for name in AVAIL_STATIC_BENCHMARKS:
    scenario = make_benchmark_scenario(name)
    network = Network(scenario)
    pairs[name] = {}
    for source in [(0, 0), *scenario.hosts]:
        for target, host in scenario.hosts.items():
            passing = [
                (-exploit["prob"], exploit["cost"])
                for exploit in scenario.exploits.values()
                if source != target
                and host.services[exploit["service"]]
                and (exploit["os"] is None or host.os[exploit["os"]])
                and network.subnet_traffic_permitted(source[0], target[0], exploit["service"])
                and network.host_traffic_permitted(source, target, exploit["service"])
            ]
            if passing:
                start = "outside" if source == (0, 0) else f"host {source}"
                pairs[name][f"{start} -> host {target}"] = min(passing)
print(json.dumps(pairs))
"""


def test_nasim_itself_permits_the_same_edges():
    pytest.importorskip("tkinter", reason="importing NASim needs Tk")
    # In a process of its own: importing NASim sets Matplotlib's backend.
    answer = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", NASIM_PAIRS],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"MPLBACKEND": "Agg"},
    )
    permitted = json.loads(answer.stdout)
    # NASim 0.12 reads the addresses in host firewalls as text and so never finds them; only tiny has such firewalls.
    del permitted["tiny"]["host (3, 0) -> host (1, 0)"]
    assert set(permitted) == set(nasim_names())
    for name, pairs in permitted.items():
        network = nasim_network(name)
        scale = 100.0
        ours = {
            edge_name: (-float(probability), round(float(cost) * scale, 9))
            for edge_name, probability, cost in zip(
                network.edge_names, network.success_probability, network.attack_cost, strict=True
            )
        }
        assert ours == {edge_name: tuple(best) for edge_name, best in pairs.items()}
