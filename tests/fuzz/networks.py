"""What the fuzzers of network files share."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from gsiirl.scenarios.file_content import EDGE, NODE, FileContent, network_of
from gsiirl.scenarios.network import AttackNetwork

TESTS = Path(__file__).parents[1]
FILES = [*sorted((TESTS / "data" / "networks").iterdir()), *sorted((TESTS.parent / "examples").iterdir())]
ATTRIBUTES = [*NODE.attributes, *EDGE.attributes, "id", "label", "source", "target", "directed"]


def samples(*suffixes: str) -> list[bytes]:
    """Contents of our example files and of the test cases."""
    return [path.read_bytes() for path in FILES if path.suffix.lower() in suffixes]


def checked(read: Callable[[bytes], FileContent]) -> Callable[[bytes], None]:
    """The reader, and the network of what it reads, which has to be sound."""

    def read_and_check(content: bytes) -> None:
        said: list[str] = []
        network = network_of(read(content), "fuzz", "general_sum", said.append)
        assert len(said) < 15
        assert all(len(line) < 600 and "\n" not in line for line in said), said
        check_network(network)

    return read_and_check


def check_network(network: AttackNetwork) -> None:
    """Names are distinct, numbers finite, probabilities in (0, 1]."""
    edges = len(network.edge_names)
    assert len(set(network.edge_names)) == edges > 0
    assert len(set(network.node_names)) == len(network.node_names) == network.value.size
    for numbers in (network.value, network.criticality, network.attack_cost, network.block_cost):
        assert np.all(np.isfinite(numbers))
    assert network.success_probability.shape == (edges,)
    assert np.all((network.success_probability > 0) & (network.success_probability <= 1))
    "".join(network.node_names).encode()
