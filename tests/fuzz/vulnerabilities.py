"""Fuzzes the reader of tables of vulnerabilities."""

import tempfile
from pathlib import Path

from fuzz.driver import Target, main

from gsiirl.scenarios.vulnerabilities import COLUMNS, CvssRule, read_vulnerabilities

SAMPLES = (
    Path(__file__).parents[2].joinpath("examples", "clinic.csv").read_bytes(),
    b'\xef\xbb\xbfhost,name,probability\r\n"a, b","c\n""d""",0.5\r\n',
    b"host;name;cvss\na;b;5\n",
)


def read(content: bytes) -> None:
    """Read a table from a file, as users do."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        path.write_bytes(content)
        table = read_vulnerabilities(path, CvssRule())
    assert table.rows
    for row in table.rows:
        assert row.host
        assert row.probability is None or 0 < row.probability <= 1
        assert 0 <= row.attack_cost < float("inf")


TARGET = Target(
    read=read, samples=SAMPLES, words=[*COLUMNS, ",", ";", '"', "outside", "\r\n"], package="gsiirl.scenarios"
)

if __name__ == "__main__":
    main(TARGET)
