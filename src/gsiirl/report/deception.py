"""Physical deception as a `game.json` and a recorded episode tell it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.errors import InputError
from gsiirl.report.plane_episode import PlaneEpisode, distances

AGENTS = ("agent_0", "agent_1")
LANDMARKS = ("landmark_0", "landmark_1")
BODIES = ("adversary", *AGENTS, *LANDMARKS)


def true_weights(game: dict[str, Any], run: Path) -> dict[str, float]:
    """The true weights of the adversary's reward by feature, as far as `game.json` tells them.

    Raises:
        InputError: they are no numbers by name; `run` names the folder.
    """
    truth = game.get("truth", {}).get("expert_reward", {})
    try:
        if not isinstance(truth, Mapping):
            raise TypeError("truth holds no weights by name")
        return {str(name): float(weight) for name, weight in truth.items()}
    except (TypeError, ValueError) as error:
        raise InputError(
            str(run / "game.json"), f"is damaged ({error!r})", "start the run again in another folder"
        ) from error


def targets(episode: PlaneEpisode) -> tuple[int, int]:
    """The landmark that the good agents are after, and the one that the adversary is after."""
    target = int(episode.start.get("target", 0))
    return target, int(episode.start.get("expert_target", target))


def adversary_distance(episode: PlaneEpisode) -> np.ndarray:
    """The adversary's distance to the good agents' target, [T + 1]."""
    return distances(episode.positions["adversary"], _target(episode))


def agents_distance(episode: PlaneEpisode) -> np.ndarray:
    """The distance of the nearer good agent to their target, [T + 1]."""
    return np.min([distances(episode.positions[agent], _target(episode)) for agent in AGENTS], axis=0)


def advantage(episode: PlaneEpisode) -> float:
    """By how much the nearer good agent is nearer to the target than the adversary, mean over the steps."""
    return float(np.mean(adversary_distance(episode) - agents_distance(episode)))


def _target(episode: PlaneEpisode) -> np.ndarray:
    return episode.positions[LANDMARKS[targets(episode)[0]]]
