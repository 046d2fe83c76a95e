"""Where attack networks come from: random graphs, NASim's published scenarios, a user's own file."""

import os
from pathlib import Path

from gsiirl.scenarios.files import READERS, read_network
from gsiirl.scenarios.nasim import nasim_names, nasim_network
from gsiirl.scenarios.network import AttackNetwork, Variant
from gsiirl.scenarios.random_graph import random_network

__all__ = [
    "AttackNetwork",
    "Variant",
    "is_nasim_file",
    "known_scenarios",
    "load_network",
    "nasim_network",
    "random_network",
    "read_network",
]


def load_network(graph: str, variant: Variant = "general_sum") -> AttackNetwork:
    """Load a network from a file (.graphml, .xml, .json, NASim's .yaml), or else the NASim scenario of that name.

    Raises:
        InputError: when there is neither, or the file does not hold a valid network.
    """
    if is_nasim_file(graph):
        from gsiirl.scenarios.nasim_file import read_nasim

        return read_nasim(Path(graph), variant)
    if Path(graph).suffix.lower() in READERS or os.path.isfile(graph):
        return read_network(graph, variant)
    return nasim_network(graph, variant)


def is_nasim_file(graph: str) -> bool:
    """Whether `graph` names a file in NASim's format."""
    return Path(graph).suffix.lower() in (".yaml", ".yml")


def known_scenarios() -> tuple[str, ...]:
    """Names that `load_network` knows."""
    return nasim_names()
