"""How many trajectories of the expert a learner needs on a network.

Every learner lives on the same network with `--trajectories` trajectories an interaction. Printed are the trajectories
after which the correlation of the learned reward with the true one stays at 0.99 or above, and after which the regret
of what would be deployed stays at 2 % or below (medians over seeds; a dash where most seeds never get there), and what
is there at the end: both measures, and the mean width of the 90 % intervals of the weights.

    python benchmarks/sample_efficiency.py --out runs/efficiency --graph small-linear --trajectories 1 10 100

Run folders are kept, and a run that is there already is read.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import polars

from gsiirl.experiments.runner import run
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.runs import RunFolder

LEARNERS: dict[str, dict[str, Any]] = {
    "default (informative, then draws)": {},
    "draws only (Thompson)": {"explore": "thompson"},
    "neither: best under the estimate": {"explore": "estimate"},
    "paper": {"algorithm": "paper"},
    "MA-IRL": {"algorithm": "ma-irl"},
}
ALIKE, MISSED = 0.99, 0.02


def needed(metrics: polars.DataFrame, name: str, holds: Any) -> list[float]:
    """Per seed the trajectories from which on the metric holds to the end; infinite where it does not."""
    found = []
    for _, rows in metrics.sort("iteration").group_by("seed", maintain_order=True):
        good = holds(rows[name].to_numpy())
        begin = len(good) - int(np.argmin(good[::-1])) if not good.all() else 0
        found.append(float(rows["expert_trajectories"][begin]) if begin < len(good) else np.inf)
    return found


def shown(values: list[float]) -> str:
    middle = float(np.median(values))
    return "\N{EN DASH}" if np.isinf(middle) else f"{middle:,.0f}"


def main() -> None:
    """Print a table of Markdown."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--graph", default=None)
    parser.add_argument("--graph-seed", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--iterations", type=int, default=50)
    parser.add_argument("--trajectories", type=int, nargs="+", default=[1, 10, 100])
    asked = parser.parse_args()
    game = {"graph": asked.graph} if asked.graph else {"graph_seed": asked.graph_seed}
    place = Path(asked.graph).stem if asked.graph else f"graph-{asked.graph_seed}"
    print("| a time | learner | to 0.99 | to 2 % | correlation | regret | width |")
    print("|---|---|---|---|---|---|---|")
    for number in asked.trajectories:
        for name, settings in LEARNERS.items():
            folder = asked.out / place / f"{number}-{name.split()[0].strip(':')}-{name.split()[-1].strip(')')}"
            fields: dict[str, Any] = {**game, **settings}
            config = SecurityConfig(
                seeds=asked.seeds, iterations=asked.iterations, trajectories=number, **fields
            ).resolved()
            if not (folder / "summary.json").exists():
                run(config, folder)
            kept = RunFolder.open(folder)
            metrics, learned = kept.metrics(), kept.load_learned()
            last = metrics.filter(polars.col("iteration") == metrics["iteration"].max())
            known = [
                each for each in (learned.intervals.get("expert_reward", []) if learned else []) if each is not None
            ]
            width = np.mean([np.subtract(each.high, each.low).mean() for each in known]) if known else np.nan
            print(
                f"| {number} | {name} | {shown(needed(metrics, 'expert_reward_pearson', lambda v: v >= ALIKE))} "
                f"| {shown(needed(metrics, 'regret', lambda v: v <= MISSED))} "
                f"| {last['expert_reward_pearson'].mean():.4f} | {100 * float(last['regret'].to_numpy().mean()):.2f} % "
                f"| {width:.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
