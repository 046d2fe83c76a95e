"""Where attack networks come from: random graphs, NASim's published scenarios, a user's own file."""

import os
from pathlib import Path

from gsiirl.scenarios.nasim import nasim_names, nasim_network
from gsiirl.scenarios.network import AttackNetwork, Variant
from gsiirl.scenarios.network_file import READERS, read_network
from gsiirl.scenarios.random_graph import random_network

__all__ = [
    "AttackNetwork",
    "Variant",
    "known_scenarios",
    "load_network",
    "nasim_network",
    "random_network",
    "read_network",
]


def load_network(graph: str, variant: Variant = "general_sum") -> AttackNetwork:
    """Load a network from a file (.graphml, .xml, .json), or else the NASim scenario of that name.

    Raises:
        InputError: when there is neither, or the file does not hold a valid network.
    """
    if Path(graph).suffix.lower() in READERS or os.path.isfile(graph):
        return read_network(graph, variant)
    return nasim_network(graph, variant)


def known_scenarios() -> tuple[str, ...]:
    """Names that `load_network` knows; none when NASim is not installed. Nothing of NASim is imported."""
    return nasim_names()
