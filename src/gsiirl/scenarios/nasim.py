"""The benchmark scenarios that the package NASim publishes, as attack networks.

They come with this package, one JSON file each below `nasim_networks/`. `scripts/write_nasim_networks.py` writes these
from NASim's own files.
"""

from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.scenarios.network import AttackNetwork, Variant
from gsiirl.scenarios.network_file import read_network

FOLDER = Path(__file__).parent / "nasim_networks"


def nasim_names() -> tuple[str, ...]:
    """Names of the published scenarios."""
    return tuple(sorted(file.stem for file in FOLDER.glob("*.json")))


def nasim_network(name: str, variant: Variant = "general_sum") -> AttackNetwork:
    """The attack network of a published NASim scenario; `nasim_file` says what it is made of.

    Raises:
        InputError: when there is no such scenario.
    """
    names = nasim_names()
    if name not in names:
        problem = f"'{name}' is unknown"
        raise InputError("graph", problem, f"give one of {', '.join(names)}, or a .graphml, .xml, .json or .yaml file")
    return read_network(FOLDER / f"{name}.json", variant)
