"""One Markov logit solve: against the same stage games one by one in NumPy, and over the size of the network.

make bench
"""

import statistics
import subprocess
import sys
import time

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import stage_by_stage

from gsiirl.equilibria import Logit
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.rewards import attack_graph as rewards
from gsiirl.scenarios import random_network
from gsiirl.types import Sides

TEMPERATURE, DISCOUNT, HORIZON = 0.4, 0.95, 10


def problem(nodes: int, edges: int):
    """A random network over all 2^N states, T = 10, with its true rewards."""
    network = random_network(0, nodes, edges)
    game = AttackGraph.create(network, HORIZON, starts=range(2**nodes))
    learner = rewards.commitment_features(game).payoff(jnp.asarray(rewards.dependent_weights(network)))
    expert = rewards.attack_features(game).payoff(jnp.asarray(rewards.expert_weights(network)))
    return game, Sides(learner + rewards.own_reward(game, network), expert)


def compiled(game: AttackGraph, true: Sides, temperature: float = TEMPERATURE):
    solver = Logit(temperature)
    return jax.jit(lambda both: solver.solve(game, both, DISCOUNT)).lower(true).compile()


def test_one_solve_of_256_states(benchmark):
    with jax.enable_x64(True):
        game, true = problem(8, 10)
        solve = compiled(game, true)
        solution = benchmark(lambda: jax.block_until_ready(solve(true)))
        assert float(solution.residual) <= 1e-10
        learner, expert, residual = stage_by_stage.solve(game, true, DISCOUNT, TEMPERATURE, 1e-11)
        ours, theirs, ratios = [], [], []
        for _ in range(3):
            began = time.perf_counter()
            stage_by_stage.solve(game, true, DISCOUNT, TEMPERATURE, 1e-11)
            theirs.append(time.perf_counter() - began)
            began = time.perf_counter()
            for _ in range(20):
                jax.block_until_ready(solve(true))
            ours.append((time.perf_counter() - began) / 20)
            ratios.append(theirs[-1] / ours[-1])
        np.testing.assert_allclose(solution.policies.learner, learner, atol=1e-9)
        np.testing.assert_allclose(solution.policies.expert, expert, atol=1e-9)
        assert residual <= 1e-10
    benchmark.extra_info.update(residual=float(solution.residual), numpy_over_ours=statistics.median(ratios))
    print(
        f"\n256 states, 10x10 actions, T = 10, tau = 0.4: ours {statistics.median(ours) * 1e3:.2f} ms to residual "
        f"{float(solution.residual):.0e}; the same 2560 stage games one by one in NumPy "
        f"{statistics.median(theirs) * 1e3:.0f} ms; ratio {statistics.median(ratios):.0f}"
    )


@pytest.mark.parametrize("temperature", [1.0, 0.4, 0.3, 0.1, 0.05, 0.02])
def test_one_solve_over_temperatures(benchmark, temperature):
    with jax.enable_x64(True):
        game, true = problem(8, 10)
        solve = compiled(game, true, temperature)
        solution = benchmark(lambda: jax.block_until_ready(solve(true)))
        assert float(solution.residual) <= 1e-10
        followed = int(solution.followed.sum())
    benchmark.extra_info.update(followed=followed)
    print(f"\ntau = {temperature}: {followed} of 2560 stage games followed along their branch")


def test_growth_with_the_network():
    """Time and peak memory of one solve for 8 to 14 nodes and 1.25 edges a node, each in a process of its own."""
    rows = []
    for nodes in (8, 10, 12, 14):
        edges = nodes * 5 // 4
        command = [sys.executable, __file__, str(nodes), str(edges)]
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        rows.append((nodes, edges, *map(float, printed)))
    print("\nnodes edges   states x edges   time [ms]   ns per state-edge   peak memory [MiB]")
    for nodes, edges, seconds, memory, residual in rows:
        size = 2**nodes * edges
        print(
            f"{nodes:5d} {edges:5d} {size:16d} {seconds * 1e3:11.1f} {seconds / size * 1e9:19.1f} {memory:15.1f}"
            f"      residual {residual:.0e}"
        )
    sizes = np.log([2**nodes * edges for nodes, edges, *_ in rows])
    times, memories = np.log([row[2] for row in rows]), np.log([row[3] for row in rows])
    print(f"growth exponent in states x edges: time {np.polyfit(sizes, times, 1)[0]:.2f}, ", end="")
    print(f"memory {np.polyfit(sizes, memories, 1)[0]:.2f}")


def _measure(nodes: int, edges: int) -> None:
    """Print the seconds of a solve, the MiB it needs (arguments, results, temporaries, by XLA), and the residual."""
    with jax.enable_x64(True):
        game, true = problem(nodes, edges)
        solve = compiled(game, true)
        memory = solve.memory_analysis()
        assert memory is not None, "this backend counts no memory"
        needed = memory.temp_size_in_bytes + memory.argument_size_in_bytes + memory.output_size_in_bytes
        solution = jax.block_until_ready(solve(true))
        repeats = max(3, 200_000 // (2**nodes * edges))
        each = []
        for _ in range(5):
            began = time.perf_counter()
            for _ in range(repeats):
                jax.block_until_ready(solve(true))
            each.append((time.perf_counter() - began) / repeats)
        print(statistics.median(each), needed / 2**20, float(solution.residual))


if __name__ == "__main__":
    _measure(int(sys.argv[1]), int(sys.argv[2]))
