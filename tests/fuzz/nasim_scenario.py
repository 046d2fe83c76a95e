"""Fuzzes the reader of NASim's scenarios."""

import tempfile
import warnings
from pathlib import Path

from fuzz.driver import Target, main
from fuzz.networks import check_network

from gsiirl.scenarios.nasim_file import Exploit, Host, Scenario, read_nasim

TESTS = Path(__file__).parents[1]
SMALLEST = b"""\
subnets: [1, 1]
topology: [[1, 1, 0], [1, 1, 1], [0, 1, 1]]
os: [linux]
services: [ssh, ftp]
sensitive_hosts: {"(2, 0)": 100}
exploits: {e: {service: ssh, os: none, prob: 0.5, cost: 2}}
host_configurations:
  (1, 0): {os: linux, services: [ssh]}
  (2, 0): {os: linux, services: [ssh, ftp], firewall: {(1, 0): [ftp]}}
firewall: {"(0, 1)": [ssh], "(1, 0)": [], "(1, 2)": [ssh], "(2, 1)": []}
"""


def read(content: bytes) -> None:
    """Read a scenario from a file, as users do."""
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        path = Path(folder) / "a.yaml"
        path.write_bytes(content)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            network = read_nasim(path)
    assert all(len(str(each.message)) < 600 and "\n" not in str(each.message) for each in said)
    check_network(network)


TARGET = Target(
    read=read,
    samples=(*(path.read_bytes() for path in sorted((TESTS / "data" / "nasim").iterdir())), SMALLEST),
    words=[f"{name}:" for part in (Scenario, Exploit, Host) for name in part.model_fields]
    + [
        "(0, 1)",
        "(1, 0)",
        "(3, 0)",
        "none",
        "null",
        "~",
        "&a",
        "*a",
        "<<:",
        "!!python/name:os",
        "2001-01-01",
        "- ",
        "[]",
    ],
    package="gsiirl.scenarios",
)

if __name__ == "__main__":
    main(TARGET)
