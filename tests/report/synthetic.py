"""Made-up runs of one attack graph, shaped like real ones, for the report's tests, and how they are read."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.report.read.group import GameGroup, group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import Environment, RunFolder, summarise

Edge = tuple[str | None, str, float]

RING: dict[str, Any] = {
    "nodes": ["gateway", "web", "mail", "files", "staff", "build", "backup", "vault"],
    "footholds": ["gateway"],
    "edges": [
        ("gateway", "web", 0.8),
        ("gateway", "mail", 0.6),
        ("web", "files", 0.5),
        ("mail", "staff", 0.9),
        ("staff", "mail", 0.4),
        ("staff", "files", 0.7),
        ("files", "build", 0.6),
        ("build", "vault", 0.5),
        ("files", "backup", 0.3),
        ("backup", "vault", 0.9),
    ],
}


def dense_graph() -> dict[str, Any]:
    """Eight hosts and 33 edges, as NASim's `small`: a chain of two, then six hosts that all attack each other."""
    users = [f"(3, {index})" for index in range(5)]
    edges: list[Edge] = [(None, "(1, 0)", 0.9), ("(1, 0)", "(2, 0)", 0.9), ("(2, 0)", "(3, 1)", 0.9)]
    edges += [(source, target, 0.6) for source in users for target in users if source != target]
    edges += [(user, "(4, 0)", 0.9) for user in users] + [("(4, 0)", user, 0.6) for user in users]
    return {"nodes": ["(1, 0)", "(2, 0)", *users, "(4, 0)"], "footholds": [], "edges": edges}


@dataclass(frozen=True)
class SyntheticGame:
    """`game.json` of a made-up graph, with what is needed to make up runs on it."""

    graph: dict[str, Any]
    name: str = "synthetic"
    variant: str = "general_sum"
    seed: int = 0

    def content(self) -> dict[str, Any]:
        random = np.random.default_rng(self.seed)
        nodes, edges = self.graph["nodes"], self.graph["edges"]
        value, criticality = random.uniform(0.2, 2, len(nodes)).round(2), random.uniform(0.2, 2, len(nodes)).round(2)
        attack_cost = random.uniform(0.1, 0.5, len(edges)).round(2)
        zero_sum = self.variant == "zero_sum"
        criticality = value if zero_sum else criticality
        return {
            "format_version": 1,
            "kind": "attack_graph",
            "name": self.name,
            "variant": self.variant,
            "horizon": 10,
            "nodes": [
                {
                    "name": name,
                    "value": float(value[index]),
                    "criticality": float(criticality[index]),
                    "foothold": name in self.graph["footholds"],
                }
                for index, name in enumerate(nodes)
            ],
            "edges": [
                {
                    "source": source,
                    "target": target,
                    "success_probability": probability,
                    "attack_cost": float(attack_cost[index]),
                    "block_cost": 1.0,
                }
                for index, (source, target, probability) in enumerate(edges)
            ],
            "truth": {
                "expert_reward": [*value.tolist(), *attack_cost.tolist()],
                "dependent_reward": [*criticality.tolist(), *(attack_cost if zero_sum else 0 * attack_cost).tolist()],
            },
        }


FINISHED = "2026-01-31T12:00:00+00:00"
FINAL_RETURNS = {"gsiirl": (-4.6, 3.1), "ma-irl": (-6.9, 4.6), "marl": (-6.3, 4.2)}
"""Where the deployed returns (learner, expert) of each made-up algorithm end."""


def write_run(
    path: Path,
    algorithm: str,
    game: SyntheticGame | None = None,
    seeds: int = 3,
    iterations: int = 20,
    failed_seed: int | None = None,
    completed: bool = True,
) -> RunFolder:
    """Write a made-up run; the failed seed's deployed return ends below random play's."""
    game = game or SyntheticGame(RING)
    content = game.content()
    config = {"experiment": "security", "algorithm": algorithm, "seeds": seeds, "iterations": iterations}
    run = RunFolder.create(path, config, content)
    random = np.random.default_rng([seeds, *algorithm.encode(), game.seed])
    run.append_metrics(0, _metrics(algorithm, seeds, iterations, failed_seed, random))
    if algorithm != "marl":
        _save_learned(run, algorithm, seeds, failed_seed, random)
    run.save_paths(_paths(content, seeds, random))
    run.write_environment(Environment(gsiirl="0.1.0", device="cpu", wall_seconds=83.2, finished=FINISHED))
    if completed:
        run.write_summary(summarise(run.config, run.metrics(), completed=True))
    return run


def write_comparison(folder: Path, game: SyntheticGame | None = None, **settings: Any) -> list[Path]:
    """The three runs of one game; `settings` are those of the gsiirl run."""
    for algorithm in FINAL_RETURNS:
        write_run(folder / algorithm, algorithm, game, **(settings if algorithm == "gsiirl" else {}))
    return [folder / algorithm for algorithm in FINAL_RETURNS]


def group_of(paths: list[Path]) -> GameGroup:
    """The one group that runs of one game make."""
    (group,) = group_runs([ReportedRun.read(path) for path in paths])
    return group


def _metrics(
    algorithm: str, seeds: int, iterations: int, failed_seed: int | None, random: np.random.Generator
) -> dict[str, np.ndarray]:
    iteration = np.arange(iterations + 1)
    progress = 1 - np.exp(-iteration / 5)
    shape = (seeds, iterations + 1)
    learner, expert = FINAL_RETURNS[algorithm]
    rows: dict[str, np.ndarray] = {
        "seed": np.repeat(np.arange(seeds), iterations + 1),
        "iteration": np.tile(iteration, seeds),
    }

    def curve(start: float, end: float, noise: float = 0.25) -> np.ndarray:
        return start + (end - start) * progress + noise * random.normal(size=shape) * (0.4 + 0.6 * (1 - progress))

    if algorithm != "marl":
        rows["model_return_learner"] = curve(-9, learner - 0.4)
        rows["model_return_expert"] = curve(1, expert + 0.3)
        rows["expert_reward_pearson"] = np.minimum(1, curve(0.1, 0.99, 0.02))
        rows["expert_trajectories"] = np.broadcast_to(100.0 * iteration, shape)
        rows["feature_gap"] = np.abs(curve(2, 0.05, 0.02))
    if algorithm == "gsiirl":
        rows["dependent_reward_pearson"] = np.minimum(1, curve(0.3, 0.999, 0.01))
    noise = 0.0 if algorithm == "marl" else 0.25
    rows["deployed_return_learner"] = curve(learner if algorithm == "marl" else -8.8, learner, noise)
    rows["deployed_return_expert"] = curve(expert if algorithm == "marl" else 0.8, expert, noise)
    references = (("truth", (-6.3, 4.2)), ("random", (-9.6, 1.2)), ("ceiling", (-4.5, 3.0)), ("sharp", (-4.8, 3.2)))
    for name, value in references:
        rows[f"{name}_return_learner"], rows[f"{name}_return_expert"] = (np.full(shape, each) for each in value)
    rows["nash_gap"] = np.full(shape, 0.12)
    rows["regret"] = np.clip((-4.5 - rows["deployed_return_learner"]) / 5.5, 0, 1)
    if failed_seed is not None:
        rows["deployed_return_learner"][failed_seed, -1] = -99.0
    return {name: column.ravel() for name, column in rows.items()}


def _save_learned(
    run: RunFolder, algorithm: str, seeds: int, failed_seed: int | None, random: np.random.Generator
) -> None:
    nodes = [node["name"] for node in run.game["nodes"]]
    edges = [f"{edge['source'] or 'outside'} -> {edge['target']}" for edge in run.game["edges"]]
    names = {
        "expert_reward": [f"value of {node}" for node in nodes] + [f"cost of {edge}" for edge in edges],
        "dependent_reward": [f"loss of {node}" for node in nodes] + [f"attacker's cost of {edge}" for edge in edges],
        "commitment": [f"commitment {index}" for index in range(4)],
    }
    if algorithm != "gsiirl":
        del names["dependent_reward"]
    arrays, scales = {}, {}
    for name in names:
        truth = np.array(run.game["truth"].get(name, np.zeros(4)))
        error = 0.25 if algorithm == "ma-irl" else 0.06
        weights = truth + error * random.normal(size=(seeds, len(truth)))
        if failed_seed is not None:
            weights[failed_seed] = 50.0
        scales[name] = 200.0
        arrays[name] = weights / scales[name]
    if algorithm == "gsiirl":
        attacks = np.broadcast_to(np.arange(0.0, 10.0 * len(edges), 10.0), (seeds, len(edges)))
        for name, counts in (("attacks", attacks), ("chances", attacks / 2)):
            arrays[name], scales[name], names[name] = np.ascontiguousarray(counts), 1.0, edges
    run.save_learned(arrays, scales, names, seeds=range(seeds))


def _paths(game: dict[str, Any], seeds: int, random: np.random.Generator) -> dict[str, np.ndarray]:
    names = [node["name"] for node in game["nodes"]]
    edges = game["edges"]
    start = sum(1 << index for index, node in enumerate(game["nodes"]) if node["foothold"])
    rows: list[tuple[int, ...]] = []
    for seed in range(seeds):
        for trajectory in range(2):
            state = start
            for step in range(game["horizon"]):
                attack, block = _attack(edges, names, state, random), int(random.integers(len(edges)))
                rows.append((seed, trajectory, step, state, block, attack))
                hit = attack != block and random.random() < edges[attack]["success_probability"]
                if hit and _usable(edges[attack], names, state):
                    state |= 1 << names.index(edges[attack]["target"])
    columns = ("seed", "trajectory", "step", "state", "learner_action", "expert_action")
    return dict(zip(columns, np.array(rows).T, strict=True))


def _attack(edges: list[dict[str, Any]], names: list[str], state: int, random: np.random.Generator) -> int:
    usable = [index for index, edge in enumerate(edges) if _usable(edge, names, state)]
    return int(random.choice(usable)) if usable and random.random() < 0.9 else int(random.integers(len(edges)))


def _usable(edge: dict[str, Any], names: list[str], state: int) -> bool:
    source = edge["source"] is None or state >> names.index(edge["source"]) & 1
    return bool(source) and not state >> names.index(edge["target"]) & 1
