"""Attack networks from the benchmark scenarios that the package NASim publishes.

NASim's simulator is not imported: importing it needs Tk and sets Matplotlib's window backend for the whole process. Its
scenarios are YAML files inside the package, and they say everything that is needed here.
"""

import ast
import importlib.util
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.errors import InputError
from gsiirl.scenarios.network import OUTSIDE, AttackNetwork, Variant

Address = tuple[int, int]
"""Subnet and number of a host; subnet 0 is the internet."""

INTERNET: Address = (0, 0)


def nasim_names() -> tuple[str, ...]:
    """Names of the published scenarios; none when NASim is not installed."""
    return tuple(_scenario_files())


def nasim_network(name: str, variant: Variant = "general_sum") -> AttackNetwork:
    """Turn a published NASim scenario into an attack network: one node a host, one edge where some exploit passes.

    An exploit passes from i to j when j runs its service under its operating system, i and j share a subnet or the
    firewall between their connected subnets lets the service through, and j's own firewall does not deny it to i. Entry
    edges come from the internet by the same rule. Of several exploits, the edge has the likeliest, then the cheapest.

    With v the hosts' values over the largest absolute value (costs are scaled alike), what NASim does not have is

        block_cost = the scenario's cheapest exploit,
        criticality_j = (max(v_j, 0) + out-degree of j / largest out-degree) / 2        (general_sum):

    the defender fears a host that opens the way further as much as one that holds the data.

    Raises:
        InputError: when NASim is not installed or has no such scenario.
    """
    files = _scenario_files()
    if not files:
        raise InputError(
            "graph",
            f"'{name}' is no .graphml, .xml or .json file, and the NASim scenarios are not installed",
            "run pip install gsiirl[nasim], or give a file",
        )
    if name not in files:
        raise InputError(
            "graph", f"'{name}' is unknown", f"give one of {', '.join(files)}, or a .graphml, .xml or .json file"
        )
    import yaml

    scenario = yaml.safe_load(files[name].read_text(encoding="utf-8"))
    hosts: dict[Address, dict[str, Any]] = _by_address(scenario["host_configurations"])
    sensitive = _by_address(scenario["sensitive_hosts"])
    exploits = list(scenario["exploits"].values())
    values = np.array([sensitive.get(host, hosts[host].get("value", 0)) for host in hosts], dtype=np.float64)
    scale = np.max(np.abs(values))
    value = values / scale

    passing = _passing_exploits(scenario, hosts, exploits)
    index = {INTERNET: OUTSIDE} | {host: node for node, host in enumerate(hosts)}
    edge_source = np.array([index[source] for source, _ in passing])
    edge_target = np.array([index[target] for _, target in passing])
    out_degree = np.bincount(edge_source[edge_source != OUTSIDE], minlength=len(hosts))
    criticality = (np.maximum(value, 0.0) + out_degree / max(out_degree.max(), 1)) / 2
    cheapest = min(exploit["cost"] for exploit in exploits)
    return AttackNetwork(
        name=name,
        node_names=tuple(f"host {host}" for host in hosts),
        value=value,
        criticality=criticality,
        edge_source=edge_source,
        edge_target=edge_target,
        success_probability=np.array([exploit["prob"] for exploit in passing.values()], dtype=np.float64),
        attack_cost=np.array([exploit["cost"] for exploit in passing.values()]) / scale,
        block_cost=np.full(len(passing), cheapest / scale),
    ).with_variant(variant)


def _scenario_files() -> dict[str, Path]:
    package = importlib.util.find_spec("nasim")
    if package is None or not package.submodule_search_locations:
        return {}
    folder = Path(package.submodule_search_locations[0], "scenarios", "benchmark")
    return {file.stem: file for file in sorted(folder.glob("*.yaml"))}


def _by_address(section: dict[str, Any]) -> dict[Address, Any]:
    return {ast.literal_eval(address): content for address, content in section.items()}


def _passing_exploits(
    scenario: dict[str, Any], hosts: dict[Address, dict[str, Any]], exploits: list[dict[str, Any]]
) -> dict[tuple[Address, Address], dict[str, Any]]:
    """The exploit of every edge (source, target); edges from the internet come first."""
    firewall = _by_address(scenario["firewall"])

    def passes(exploit: dict[str, Any], source: Address, target: Address) -> bool:
        host = hosts[target]
        # An exploit without an operating system works under any.
        if exploit["service"] not in host["services"] or str(exploit["os"]) not in ("None", host["os"]):
            return False
        if source[0] != target[0]:
            connected = scenario["topology"][source[0]][target[0]] == 1
            if not connected or exploit["service"] not in firewall[source[0], target[0]]:
                return False
        return exploit["service"] not in _by_address(host.get("firewall", {})).get(source, [])

    edges: dict[tuple[Address, Address], dict[str, Any]] = {}
    for source in (INTERNET, *hosts):
        for target in hosts:
            possible = [exploit for exploit in exploits if source != target and passes(exploit, source, target)]
            if possible:
                edges[source, target] = min(possible, key=lambda exploit: (-exploit["prob"], exploit["cost"]))
    return edges
