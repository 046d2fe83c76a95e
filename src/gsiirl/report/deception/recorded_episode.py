"""Physical deception in the `game.json` and in the recorded episodes of a run."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.report.plane.episode import PlaneEpisode, distances
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.json_file import as_typed

AGENTS = ("agent_0", "agent_1")
LANDMARKS = ("landmark_0", "landmark_1")
BODIES = ("adversary", *AGENTS, *LANDMARKS)


def true_weights(game: dict[str, Any], run: Path) -> dict[str, float]:
    """The true weights of the adversary's reward by feature; {} where `game.json` holds none.

    Raises:
        InputError: they are no numbers by name; `run` names the folder.
    """
    described = as_typed(_Described, game, run / "game.json", START_AGAIN)
    return described.truth.expert_reward


@dataclass(frozen=True)
class _Truth:
    expert_reward: dict[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True)
class _Described:
    """The part of `game.json` that is drawn."""

    truth: _Truth = field(default_factory=_Truth)


def targets(episode: PlaneEpisode) -> tuple[int, int]:
    """Indices of two landmarks: the good agents' target, and the adversary's."""
    target = int(episode.start.get("target", 0) > 0)
    return target, int(episode.start.get("expert_target", target) > 0)


def adversary_distance(episode: PlaneEpisode) -> np.ndarray:
    """The adversary's distance to the good agents' target at every step, [T + 1]."""
    return distances(episode.positions["adversary"], _target(episode))


def agents_distance(episode: PlaneEpisode) -> np.ndarray:
    """The distance of the nearer good agent to their target at every step, [T + 1]."""
    return np.min([distances(episode.positions[agent], _target(episode)) for agent in AGENTS], axis=0)


def advantage(episode: PlaneEpisode) -> float:
    """How much nearer to the target the nearer good agent is than the adversary, mean over the steps."""
    return float(np.mean(adversary_distance(episode) - agents_distance(episode)))


def _target(episode: PlaneEpisode) -> np.ndarray:
    return episode.positions[LANDMARKS[targets(episode)[0]]]
