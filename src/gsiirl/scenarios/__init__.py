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
    "is_file",
    "is_own_file",
    "known_scenarios",
    "load_network",
    "nasim_network",
    "random_network",
    "read_network",
]

NASIM_FILES = (".yaml", ".yml")
"""Files in NASim's format."""


def load_network(graph: str, variant: Variant = "general_sum") -> AttackNetwork:
    """Load a network from a file (.graphml, .xml, .json, NASim's .yaml), or else the NASim scenario of that name.

    Raises:
        InputError: when there is neither, or the file does not hold a valid network.
    """
    if Path(graph).suffix.lower() in NASIM_FILES:
        from gsiirl.scenarios.nasim_file import read_nasim

        return read_nasim(Path(graph), variant)
    if Path(graph).suffix.lower() in READERS or os.path.isfile(graph):
        return read_network(graph, variant)
    return nasim_network(graph, variant)


def is_own_file(graph: str) -> bool:
    """Whether `graph` names a network file of our own formats: neither NASim's format nor a scenario's name."""
    return Path(graph).suffix.lower() in READERS


def is_file(graph: str) -> bool:
    """Whether `graph` names a network file, of our own formats or of NASim's, and no scenario."""
    return is_own_file(graph) or Path(graph).suffix.lower() in NASIM_FILES


def known_scenarios() -> tuple[str, ...]:
    """Names that `load_network` knows."""
    return nasim_names()
