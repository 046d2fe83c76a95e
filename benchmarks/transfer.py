"""What learned rewards are worth on changed networks: runs of GSIIRL and MA-IRL, then `gsiirl transfer`.

    python benchmarks/transfer.py --out runs/transfer --seeds 10 --changes 10

Finished runs in the folder are kept, and so are transfers. At the end comes a table of the regret to the same procedure
with the true rewards, in per cent of what lies between that and random play, over all seeds and changes.
"""

import argparse
import json
from pathlib import Path

from gsiirl.cli import main
from gsiirl.runs import RunFolder

NETWORKS = {
    "small-linear": ("--graph", "small-linear"),
    "graph 0": ("--graph-seed", "0"),
    "graph 1": ("--graph-seed", "1"),
    "graph 2": ("--graph-seed", "2"),
}
ROWS = ("gsiirl", "ma-irl", "ma-irl, r_e alone", "clone", "policy unchanged")


def finished_run(folder: Path, network: str, algorithm: str, seeds: int) -> Path:
    """The folder of a run, made where it is not there."""
    if not (RunFolder.is_at(folder) and RunFolder.open(folder).is_finished()):
        flags = ("--algorithm", algorithm, "--seeds", str(seeds), "--out", str(folder), "--quiet")
        resumed = RunFolder.is_at(folder)
        status = main(
            ["resume", str(folder), "--quiet"] if resumed else ["run", "security", *NETWORKS[network], *flags]
        )
        assert status == 0, f"{folder} has status {status}"
    return folder


def measured(network: str, out: Path, seeds: int, changes: int, change_seed: int) -> dict[str, dict[str, float]]:
    """Regret in per cent of every row of one network: mean and worst over seeds and changes."""
    place = out / network.replace(" ", "-")
    own, other = (finished_run(place / name, network, name, seeds) for name in ("gsiirl", "ma-irl"))
    if not (own / "transfer.json").exists():
        flags = ["--changes", str(changes), "--change-seed", str(change_seed), "--beside", str(other), "--quiet"]
        status = main(["transfer", str(own), *flags])
        assert status == 0, f"{own} has status {status}"
    return json.loads((own / "transfer.json").read_text())["all_changes"]


def table(found: dict[str, dict[str, dict[str, float]]]) -> str:
    """A Markdown table: mean, then 90 % and the worst, of every row on every network."""
    lines = [f"| network | {' | '.join(ROWS)} |", f"|---{'|---' * len(ROWS)}|"]
    for network, rows in found.items():
        cells = (rows[row] for row in ROWS)
        shown = (f"{each['mean']:.2f} / {each['ninety_percent']:.2f} / {each['worst']:.2f}" for each in cells)
        lines.append(f"| {network} | {' | '.join(shown)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--networks", nargs="+", choices=NETWORKS, default=list(NETWORKS))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--changes", type=int, default=10)
    parser.add_argument("--change-seed", type=int, default=0)
    asked = parser.parse_args()
    print(
        table(
            {
                network: measured(network, asked.out, asked.seeds, asked.changes, asked.change_seed)
                for network in asked.networks
            }
        )
    )
