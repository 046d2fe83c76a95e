"""The whole security comparison on one graph: gsiirl, ma-irl and marl, 10 seeds, 50 iterations, start to end."""

import json
import subprocess
import sys
import time


def test_ten_seeds_of_three_algorithms(tmp_path):
    total = 0.0
    for algorithm in ("gsiirl", "ma-irl", "marl"):
        out = tmp_path / algorithm
        command = [sys.executable, "-m", "gsiirl", "run", "security", "--graph-seed", "0", "--algorithm", algorithm]
        began = time.perf_counter()
        subprocess.run(
            [*command, "--seeds", "10", "--iterations", "50", "--out", str(out)], check=True, capture_output=True
        )
        seconds = time.perf_counter() - began
        total += seconds
        final = json.loads((out / "summary.json").read_text())["final"]
        print(
            f"\n{algorithm}: {seconds:.0f} s with start and compilation; deployed return of the learner "
            f"{final['deployed_return_learner']['mean']:.3f}",
            end="",
        )
    print(f"\nthe whole comparison: {total:.0f} s")
