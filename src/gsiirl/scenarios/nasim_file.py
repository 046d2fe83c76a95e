"""Attack networks from scenarios in the YAML format of NASim, the Network Attack Simulator (docs/scenarios.md)."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from gsiirl.errors import InputError, NetworkWarning, printable, warn
from gsiirl.scenarios.network import MAXIMUM_NODES, OUTSIDE, AttackNetwork, Variant

INTERNET = (0, 0)
LARGEST_FILE = 1_000_000
"""Bytes; a scenario of as many hosts as a network may have is smaller."""


def _address(key: object) -> object:
    found = re.fullmatch(r"\(\s*(\d{1,9})\s*,\s*(\d{1,9})\s*\)", key) if isinstance(key, str) else None
    if found is None:
        raise ValueError("should be a pair such as (1, 0)")
    return int(found[1]), int(found[2])


Address = Annotated[tuple[int, int], BeforeValidator(_address)]
"""Subnet and number of a host, or two subnets; subnet 0 is the internet."""


class _Section(BaseModel):
    model_config = ConfigDict(strict=True, allow_inf_nan=False, extra="allow", frozen=True)


class Exploit(_Section):
    """An attack on a service under an operating system; `None`, the word or nothing, is any system."""

    service: str
    os: str | None
    prob: float = Field(ge=0, le=1)
    cost: float = Field(ge=0)
    access: Any = None

    def works_on(self, host: "Host") -> bool:
        """Whether the host runs the service under the system that the exploit needs."""
        return self.prob > 0 and self.service in host.services and (self.any_system or self.os == host.os)

    @property
    def any_system(self) -> bool:
        """Whether it works under every operating system."""
        return str(self.os).lower() == "none"


class Host(_Section):
    """What runs on a host; `firewall` are the services that it denies to other hosts."""

    os: str
    services: list[str]
    processes: Any = None
    value: float = 0.0
    firewall: dict[Address, list[str]] = Field(default_factory=dict)


class Scenario(_Section):
    """A scenario; `firewall` are the services that pass from one subnet to another. What is `Any` is not looked at."""

    subnets: list[Annotated[int, Field(ge=1)]]
    topology: list[list[Literal[0, 1]]]
    os: list[str]
    services: list[str]
    exploits: dict[str, Exploit] = Field(min_length=1)
    sensitive_hosts: dict[Address, float]
    host_configurations: dict[Address, Host]
    firewall: dict[Address, list[str]]
    processes: Any = None
    privilege_escalation: Any = None
    service_scan_cost: Any = None
    os_scan_cost: Any = None
    subnet_scan_cost: Any = None
    process_scan_cost: Any = None
    step_limit: Any = None


def read_nasim(path: Path, variant: Variant = "general_sum") -> AttackNetwork:
    """Turn a NASim scenario into an attack network: one node a host, one edge where some exploit passes.

    An exploit passes from i to j when j runs its service under its operating system, i and j share a subnet or the
    firewall between their connected subnets lets the service through, and j's own firewall does not deny it to i. Entry
    edges come from the internet by the same rule. Of several exploits, the edge has the likeliest, then the cheapest.

    With v the hosts' values over the largest absolute value (costs are scaled alike), what NASim does not have is

        block_cost = the scenario's cheapest exploit,
        criticality_j = (max(v_j, 0) + out-degree of j / largest out-degree) / 2        (general_sum):

    the defender fears a host that opens the way further as much as one that holds the data.

    Raises:
        InputError: when the file cannot be read or holds no such scenario; it names the file and the field.
    """
    try:
        scenario = _scenario(_parsed(path))
        _check_names(scenario)
        _check_hosts(scenario)
        network = _network(path.stem, scenario).with_variant(variant)
    except InputError as error:
        raise InputError(f"{path}: {error.field}", error.problem, error.mend) from None
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "give a readable file") from None
    parts = [scenario, *scenario.exploits.values(), *scenario.host_configurations.values()]
    if others := sorted({str(name) for part in parts for name in part.model_extra or ()}):
        listed = ", ".join(_shown(name) for name in others[:5]) + (", ..." if len(others) > 5 else "")
        warn(f"{path}: NASim's format has no {listed}; what they say is not looked at", NetworkWarning)
    return network


class _Loader(yaml.SafeLoader):
    """YAML's plain types. A key that is there twice is refused, and merge keys are, which NASim's format has not."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        seen: set[str] = set()
        for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
            name = "".join(key.value.split())
            if name in seen:
                raise yaml.constructor.ConstructorError(
                    problem=f"{_shown(key.value)} is there twice", problem_mark=key.start_mark
                )
            seen.add(name)


def _parsed(path: Path) -> dict[Any, Any]:
    with path.open("rb") as file:
        content = file.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        raise InputError("file", f"is larger than {LARGEST_FILE:,} bytes", "give a NASim scenario")
    try:
        parsed = yaml.load(content, _Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = "" if mark is None else f" in line {mark.line + 1}"
        reason = getattr(error, "problem", None) or getattr(error, "reason", None) or "not text"
        raise InputError("file", f"is not YAML ({_shown(reason, 80)}{line})", "mend the file") from None
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        # What YAML's constructors raise for dates and numbers that are none, and for lists that are too deep.
        raise InputError("file", "is not YAML that can be read", "mend the file") from None
    if not isinstance(parsed, dict):
        raise InputError("file", "holds no NASim scenario", "give subnets, topology, host_configurations, ...")
    return parsed


def _scenario(parsed: dict[Any, Any]) -> Scenario:
    try:
        return Scenario.model_validate(parsed)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        field = _shown(".".join(_shown(part) for part in first["loc"] if part != "[key]"), 100)
        if first["type"] == "missing":
            raise InputError(field, "is missing", "add it") from None
        reason = first["msg"].removeprefix("Value error, ").removeprefix("Input ")
        raise InputError(field, f"cannot be {_shown(first['input'])}", f"it {reason}") from None


def _check_names(scenario: Scenario) -> None:
    """Whether every service and operating system that is named is also listed."""

    def check(field: str, names: Iterable[str], part: str, known: list[str]) -> None:
        for name in names:
            if name not in known:
                raise InputError(field, f"names {_shown(name)}, which {part} does not list", "correct one of the two")

    for name, exploit in scenario.exploits.items():
        check(f"exploits.{_shown(name)}.service", [exploit.service], "services", scenario.services)
        if not exploit.any_system:
            check(f"exploits.{_shown(name)}.os", [str(exploit.os)], "os", scenario.os)
    for address, host in scenario.host_configurations.items():
        check(f"host_configurations.{address}.os", [host.os], "os", scenario.os)
        check(f"host_configurations.{address}.services", host.services, "services", scenario.services)
        for source, denied in host.firewall.items():
            check(f"host_configurations.{address}.firewall.{source}", denied, "services", scenario.services)
    for pair, passing in scenario.firewall.items():
        check(f"firewall.{pair}", passing, "services", scenario.services)


def _check_hosts(scenario: Scenario) -> None:
    """Whether the sections speak of the same hosts and subnets."""
    size = len(scenario.subnets) + 1
    number = sum(scenario.subnets)
    if number > MAXIMUM_NODES:
        raise InputError("subnets", f"are of {_shown(number)} hosts", f"give at most {MAXIMUM_NODES}")
    if len(scenario.topology) != size or any(len(row) != size for row in scenario.topology):
        mend = f"give {size} rows of {size}: the internet and every subnet"
        raise InputError("topology", f"is not of {size - 1} subnets", mend)
    known = {(subnet, host) for subnet, hosts in enumerate(scenario.subnets, 1) for host in range(hosts)}
    for address in sorted(known - scenario.host_configurations.keys()):
        raise InputError("host_configurations", f"lacks the host {address} of subnets", "add it")
    named = {"host_configurations": scenario.host_configurations, "sensitive_hosts": scenario.sensitive_hosts} | {
        f"host_configurations.{address}.firewall": host.firewall
        for address, host in scenario.host_configurations.items()
    }
    for field, hosts in named.items():
        for address in hosts:
            if address not in known:
                raise InputError(field, f"names the host {address}, which subnets has not", "correct one of the two")
    for source, row in enumerate(scenario.topology):
        for target, connected in enumerate(row):
            if connected and 0 != target != source and (source, target) not in scenario.firewall:
                problem = f"lacks {(source, target)}, which topology connects"
                raise InputError("firewall", problem, "list the services that pass, or []")


def _network(name: str, scenario: Scenario) -> AttackNetwork:
    hosts = scenario.host_configurations
    worth = np.array([scenario.sensitive_hosts.get(address, host.value) for address, host in hosts.items()])
    scale = np.max(np.abs(worth))
    if scale == 0:
        raise InputError("sensitive_hosts", "no host is worth anything", "give the value of at least one")
    value = worth / scale

    passing = _passing_exploits(scenario)
    index = {INTERNET: OUTSIDE} | {address: node for node, address in enumerate(hosts)}
    edge_source = np.array([index[source] for source, _ in passing], dtype=np.int64)
    edge_target = np.array([index[target] for _, target in passing], dtype=np.int64)
    if not np.any(edge_source == OUTSIDE):
        problem = "no exploit passes from the internet to any host"
        raise InputError("firewall", problem, "let the service of an exploit through from subnet 0")
    out_degree = np.bincount(edge_source[edge_source != OUTSIDE], minlength=len(hosts))
    cheapest = min(exploit.cost for exploit in scenario.exploits.values())
    return AttackNetwork(
        name=name,
        node_names=tuple(f"host {address}" for address in hosts),
        value=value,
        criticality=(np.maximum(value, 0.0) + out_degree / max(out_degree.max(), 1)) / 2,
        edge_source=edge_source,
        edge_target=edge_target,
        success_probability=np.array([exploit.prob for exploit in passing.values()]),
        attack_cost=np.array([exploit.cost for exploit in passing.values()]) / scale,
        block_cost=np.full(len(passing), cheapest / scale),
    )


def _passing_exploits(scenario: Scenario) -> dict[tuple[Any, Any], Exploit]:
    """The exploit of every edge (source, target); edges from the internet come first."""
    best_first = sorted(scenario.exploits.values(), key=lambda exploit: (-exploit.prob, exploit.cost))
    hosts = scenario.host_configurations
    works = {target: [each for each in best_first if each.works_on(host)] for target, host in hosts.items()}

    def open_services(source: tuple[int, int], target: tuple[int, int]) -> list[str]:
        if source[0] == target[0]:
            return scenario.services
        return scenario.firewall[source[0], target[0]] if scenario.topology[source[0]][target[0]] else []

    edges: dict[tuple[Any, Any], Exploit] = {}
    for source in (INTERNET, *hosts):
        for target, host in hosts.items():
            passed, denied = open_services(source, target), host.firewall.get(source, [])
            possible = (each for each in works[target] if each.service in passed and each.service not in denied)
            best = next(possible, None)
            if source != target and best is not None:
                edges[source, target] = best
    return edges


def _shown(value: object, length: int = 40) -> str:
    """A value in a message, short whatever it is."""
    if isinstance(value, dict | list | set | tuple):
        return "a mapping" if isinstance(value, dict) else "a list"
    if isinstance(value, int) and abs(value) >= 10**length:
        return "a number beyond all bounds"
    text = "empty" if value is None else str(value)
    text = printable(text[: 2 * length])
    return text if len(text) <= length else f"{text[: length - 3]}..."
