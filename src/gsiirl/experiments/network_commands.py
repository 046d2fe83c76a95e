"""The commands `gsiirl network check` and `build`. `gsiirl.cli` imports this module only when one is asked for."""

import json
import os
import shlex
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically


def check(
    file: Annotated[str, Parameter(name="FILE", metavar="FILE", help="GraphML, JSON, or NASim's YAML.")],
    /,
    *,
    as_json: Annotated[bool, Parameter(name="--json", negative="", help="Print JSON.")] = False,
) -> int:
    """What a network file holds, and what a run on it with the default settings takes.

    The exit status is 0 when `gsiirl run security --graph FILE` can begin, 1 when something is missing or the run would
    take too much memory, and 2 when the file cannot be read or is refused.
    """
    from gsiirl.experiments.security.network_check import check_network

    found = check_network(file)
    print(json.dumps(found.to_json_dict(), indent=2) if as_json else found.as_text())
    return 0 if found.can_run else 1


def build(
    topology: Annotated[Path, Parameter(name="TOPOLOGY", metavar="TOPOLOGY", help="GraphML or JSON: hosts and edges.")],
    /,
    *,
    vulnerabilities: Annotated[
        Path,
        Parameter(
            metavar="FILE.csv",
            help="Columns host, name, and probability or cvss; optional source, attack_cost and value.",
        ),
    ],
    foothold: Annotated[
        tuple[str, ...],
        Parameter(
            metavar="NAME",
            negative="",
            show_default=False,
            help="Host that is compromised at the start; may be given more than once.",
        ),
    ] = (),
    out: Annotated[Path, Parameter(metavar="FILE.json", help="File to make; an existing one is never overwritten.")],
    probability_of_cvss: Annotated[
        str,
        Parameter(
            metavar="RULE",
            help="Probability that a try succeeds, where only its CVSS base score is given: score (a tenth of it, from "
            "0.05 to 0.95), or four numbers for low, medium, high and critical, such as 0.2,0.4,0.6,0.8.",
        ),
    ] = "score",
) -> None:
    """A game from a plain topology and a table of vulnerabilities, for `gsiirl run security --graph`."""
    from gsiirl.scenarios.build import build_network
    from gsiirl.scenarios.vulnerabilities import CvssRule

    if out.suffix.lower() != ".json":
        raise InputError("out", f"'{out}' does not end in .json", "give a name that does")
    if os.path.lexists(out):
        raise InputError("out", f"'{out}' is there already", "give another name, or remove it")
    built = build_network(topology, vulnerabilities, foothold, CvssRule.of(probability_of_cvss))
    try:
        write_atomically(out, (json.dumps(built.to_json_dict(), indent=1, ensure_ascii=False) + "\n").encode())
    except OSError as error:
        raise InputError("out", f"'{out}' cannot be written ({error.strerror})", "give another name") from None
    network = built.network
    hosts, edges = len(network.node_names), len(network.edge_names)
    counts = f"{hosts} host{'s' * (hosts != 1)}, {edges} edge{'s' * (edges != 1)}"
    print(f"{out}: {counts}; `gsiirl network check {shlex.quote(str(out))}` says more")
