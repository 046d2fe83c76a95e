"""Made-up runs of the crossing and of physical deception, shaped like real ones, for the report's tests."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.runs import Environment, RunFolder, summarise

LITTLE = -1000.0
STEPS = 8
CROSSING: dict[str, Any] = {
    "kind": "crossing",
    "name": "crossing",
    "variant": "default",
    "horizon": STEPS,
    "robot_goal": [0, 0.5],
    "human_goal": [-0.5, 0],
    "goal_radius": 0.05,
    "collision_distance": 0.1,
    "safe_distance": 0.25,
    "robot_start": [[-0.25, 0.25], [-0.5, -0.4]],
    "human_start": [[0.4, 0.5], [-0.25, 0.25]],
    "arena": [[-0.8, 0.8], [-0.8, 0.8]],
}
FEATURES = ["distance to its target", "distance to the other landmark", "distance to the nearer good agent", "speed"]
TRUE_WEIGHTS = dict(zip(FEATURES, (-1.0, 0.0, 0.0, 0.0), strict=True))
DECEPTION: dict[str, Any] = {
    "kind": "deception",
    "name": "physical deception",
    "variant": "mpe",
    "horizon": STEPS,
    "truth": {"expert_reward": TRUE_WEIGHTS},
}


@dataclass(frozen=True)
class PlaneReturns:
    """Where the deployed returns (learner, expert) of each made-up algorithm end."""

    game: dict[str, Any]
    final: dict[str, tuple[float, float]]
    random: tuple[float, float]


RETURNS = {
    "crossing": PlaneReturns(
        CROSSING,
        {
            "marl": (-20.5, -12.9),
            "marl-maddpg": (-21.6, -13.6),
            "ma-irl": (-21.2, -13.4),
            "gsiirl": (-19.8, -12.7),
            "paper": (-22.4, -13.3),
        },
        (-34.0, -29.0),
    ),
    "deception": PlaneReturns(
        DECEPTION,
        {
            "marl": (8.9, -15.8),
            "marl-maddpg": (6.1, -16.9),
            "ma-irl": (8.1, -17.4),
            "gsiirl": (9.6, -16.1),
            "paper": (6.8, -18.2),
        },
        (-4.0, -24.0),
    ),
}
GIVEN_THE_REWARDS = ("marl", "marl-maddpg")


def write_plane_run(
    path: Path,
    experiment: str,
    algorithm: str,
    seeds: int = 3,
    iterations: int = 10,
    failed_seed: int | None = None,
    variant: str | None = None,
    exploring: bool = True,
) -> RunFolder:
    """Write a made-up run; the failed seed's deployed return ends below random play's."""
    made_up = RETURNS[experiment]
    game = {**made_up.game, "variant": variant or made_up.game["variant"]}
    config = {"experiment": experiment, "algorithm": algorithm, "seeds": seeds, "iterations": iterations}
    run = RunFolder.create(path, config, game)
    random = np.random.default_rng([seeds, *experiment.encode(), *algorithm.encode()])
    metrics = _metrics(experiment, algorithm, seeds, iterations, failed_seed, random)
    if algorithm == "gsiirl" and exploring:
        _explore(metrics)
    run.append_metrics(0, metrics)
    learns = algorithm not in GIVEN_THE_REWARDS
    if experiment == "crossing":
        run.save_paths(_crossing_paths(seeds, random))
        if learns:
            run.save_reward_map(_reward_map(seeds, failed_seed, random))
    else:
        run.save_paths(_deception_paths(seeds, random, game["variant"] == "separate_target"))
        if learns:
            _save_weights(run, algorithm, seeds, random)
    run.write_environment(Environment(gsiirl="0.1.0", wall_seconds=61.0, finished="2026-01-31T12:00:00+00:00"))
    run.write_summary(summarise(run.config, run.metrics(), completed=True))
    return run


def write_plane_comparison(folder: Path, experiment: str, **settings: Any) -> list[Path]:
    """A run of every algorithm; `settings` are those of the gsiirl run."""
    algorithms = RETURNS[experiment].final
    for algorithm in algorithms:
        write_plane_run(folder / algorithm, experiment, algorithm, **(settings if algorithm == "gsiirl" else {}))
    return [folder / algorithm for algorithm in algorithms]


def _explore(metrics: dict[str, np.ndarray]) -> None:
    """Every third interaction but the last is played to see more, and earns little."""
    exploring = (metrics["iteration"] % 3 == 2) & (metrics["iteration"] < metrics["iteration"].max())
    metrics["exploring"] = exploring.astype(float)
    metrics["deployed_return_learner"] = np.where(exploring, LITTLE, metrics["deployed_return_learner"].ravel())


def _metrics(
    experiment: str, algorithm: str, seeds: int, iterations: int, failed_seed: int | None, random: np.random.Generator
) -> dict[str, np.ndarray]:
    learns = algorithm not in GIVEN_THE_REWARDS
    iterations = iterations if learns else 0
    iteration = np.arange(iterations + 1)
    progress = 1 - np.exp(-4 * iteration / max(iterations, 1)) if learns else np.ones(1)
    shape = (seeds, iterations + 1)
    made_up = RETURNS[experiment]

    def curve(start: float, end: float, noise: float) -> np.ndarray:
        return start + (end - start) * progress + noise * random.normal(size=shape) * (0.4 + 0.6 * (1 - progress))

    rows: dict[str, np.ndarray] = {
        "seed": np.repeat(np.arange(seeds), iterations + 1),
        "iteration": np.tile(iteration, seeds),
    }
    sides = ("learner", "expert")
    truth = made_up.final["marl-maddpg" if algorithm == "marl-maddpg" else "marl"]
    for side, start, end, marl in zip(sides, made_up.random, made_up.final[algorithm], truth, strict=True):
        rows[f"deployed_return_{side}"] = curve(start, end, 0.5)
        rows[f"truth_return_{side}"] = np.full(shape, marl)
        rows[f"random_return_{side}"] = np.full(shape, start)
        if learns:
            rows[f"model_return_{side}"] = curve(start - 1, end - 0.3, 0.5)
    if learns:
        rows["expert_reward_pearson"] = np.minimum(1, curve(0.1, 0.98, 0.02))
        rows["feature_gap"] = np.abs(curve(2, 0.08, 0.02))
        rows["feature_gap_noise"] = np.full(shape, 0.05)
        rows["expert_trajectories"] = np.broadcast_to(100.0 * iteration, shape)
        # Measured at the end only.
        rows["exploitability_learner"] = np.full(shape, np.nan)
        rows["exploitability_learner"][:, -1] = 0.07
    if experiment == "crossing":
        rises = np.exp(-((iteration - 0.3 * iterations) ** 2) / max(0.03 * iterations**2, 1))
        rows["collision_rate"] = (
            np.clip(0.25 * rises + curve(0.05, 0.01, 0.01), 0, 1) if learns else np.full(shape, 0.01)
        )
        for whose, end in (("robot", 0.97), ("human", 0.99)):
            rows[f"goal_rate_{whose}"] = np.clip(curve(0.0, end, 0.03), 0, 1) if learns else np.full(shape, end)
            rows[f"truth_goal_rate_{whose}"] = np.full(shape, end)
        rows["truth_collision_rate"] = np.full(shape, 0.01)
        if learns:
            rows["human_goal_error"] = np.abs(curve(0.6, 0.03, 0.01))
    elif learns:
        rows["target_preference"] = curve(-0.2, 0.8, 0.1)
    if failed_seed is not None:
        rows["deployed_return_learner"][failed_seed, -1] = -99.0
    return {name: column.ravel() for name, column in rows.items()}


def _crossing_paths(seeds: int, random: np.random.Generator) -> dict[str, np.ndarray]:
    time = np.linspace(0, 1, STEPS + 1)[:, None]

    def encounter() -> np.ndarray:
        starts = random.uniform([-0.25, -0.5, 0.4, -0.25], [0.25, -0.4, 0.5, 0.25])
        ends = np.array([*CROSSING["robot_goal"], *CROSSING["human_goal"]])
        # The robot waits, the human swerves.
        hurry = np.concatenate([time**1.8, time**1.8, np.minimum(1, 1.3 * time), np.minimum(1, 1.3 * time)], axis=1)
        swerve = np.array([0, 0, 0, 0.2]) * np.sin(np.pi * np.minimum(1, 1.3 * time))
        return starts + (ends - starts) * hurry + swerve

    return _table(seeds, ("robot_x", "robot_y", "human_x", "human_y"), encounter)


def _deception_paths(seeds: int, random: np.random.Generator, separate: bool) -> dict[str, np.ndarray]:
    time = np.linspace(0, 1, STEPS + 1)[:, None]
    names = [
        f"{body}_{axis}" for body in ("adversary", "agent_0", "agent_1", "landmark_0", "landmark_1") for axis in "xy"
    ]

    def episode() -> np.ndarray:
        landmarks, starts = random.uniform(-1, 1, (2, 2)), random.uniform(-1, 1, (3, 2))
        target = int(random.integers(2))
        ends = np.stack([landmarks.mean(axis=0), landmarks[0], landmarks[1]])
        ways = [start + (end - start) * np.minimum(1, 1.6 * time) for start, end in zip(starts, ends, strict=True)]
        still = np.broadcast_to([*landmarks.ravel(), target, 1 - target if separate else target], (STEPS + 1, 6))
        return np.concatenate([*ways, still], axis=1)

    return _table(seeds, (*names, "target", "expert_target"), episode)


def _table(seeds: int, names: Any, episode: Any, trajectories: int = 3) -> dict[str, np.ndarray]:
    index = np.indices((seeds, trajectories, STEPS + 1)).reshape(3, -1)
    values = np.concatenate([episode() for _ in range(seeds * trajectories)])
    return dict(zip(("seed", "trajectory", "step"), index, strict=True)) | dict(zip(names, values.T, strict=True))


def _reward_map(seeds: int, failed_seed: int | None, random: np.random.Generator) -> dict[str, np.ndarray]:
    places = np.linspace(-0.8, 0.8, 33)
    seed, y, x = (each.ravel() for each in np.meshgrid(np.arange(seeds), places, places, indexing="ij"))
    true = -np.hypot(x + 0.5, y)
    goals = np.add([-0.5, 0.0], 0.05 * random.normal(size=(seeds, 2)))
    if failed_seed is not None:
        goals[failed_seed] = 0.7
    away = np.stack([x, y], axis=1) - np.repeat(goals, len(places) ** 2, axis=0)
    learned = 4 - 0.3 * np.linalg.norm(away, axis=1)
    return {"seed": seed, "x": x, "y": y, "learned": learned, "true": true}


def _save_weights(run: RunFolder, algorithm: str, seeds: int, random: np.random.Generator) -> None:
    error = 0.15 if algorithm == "ma-irl" else 0.05
    weights = np.array(list(TRUE_WEIGHTS.values())) + error * random.normal(size=(seeds, len(FEATURES)))
    run.save_learned(
        {"expert_reward": weights / 10}, {"expert_reward": 10.0}, {"expert_reward": FEATURES}, range(seeds)
    )
