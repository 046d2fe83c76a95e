"""What the policies of a finished deception run earn in mpe2 itself, beside what they earn in our port of it."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from gsiirl.adapters import mpe2
from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.errors import InputError
from gsiirl.experiments.config import config_from_dict
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.program.command import command
from gsiirl.program.progress import shown
from gsiirl.runs import RunFolder, Statistics
from gsiirl.runs.files.atomic import refuse_unwritable

Pair = Literal["deployed", "model"]
EXPERTS: Mapping[Pair, str] = {"deployed": "response", "model": "expert"}
"""The expert's network in each pair: the true expert's response is deployed."""

OTHER_RUN = "give the folder of a finished deception run"
ANEW = "start the run again in another folder"


@dataclass(frozen=True)
class PlayedRun:
    """A finished deception run that mpe2 can play: the seeds that did not fail, and their policies."""

    folder: RunFolder
    config: DeceptionConfig
    seeds: list[int]
    failed_seeds: list[int]
    final: dict[str, Statistics]
    """Of each metric, over `seeds`."""
    weights: dict[str, np.ndarray]
    """Of the policies of `seeds`, in their order."""

    @classmethod
    def open(cls, path: Path) -> "PlayedRun":
        """The run in a folder.

        Raises:
            InputError: it holds no run, or one that mpe2 cannot play.
        """
        folder = RunFolder.open(path)
        config = config_from_dict(folder.config, path / "config.json")
        if not isinstance(config, DeceptionConfig):
            raise InputError(str(path), f"is a run of {config.experiment}, which mpe2 does not have", OTHER_RUN)
        if config.variant != "mpe":
            raise InputError(
                str(path), f"is of variant {config.variant}, but in mpe2 both sides share a target", "give one of mpe"
            )
        summary = folder.summary()
        if summary is None or not summary.completed:
            raise InputError(str(path), "holds a run that is not finished", f"run {command('resume', path)}")
        if not summary.kept_seeds:
            raise InputError(str(path), "holds failed seeds only", OTHER_RUN)
        weights = folder.load_policies()
        if weights is None:
            raise InputError(str(path), "keeps no policies: an earlier version ran it", ANEW)
        kept = [place for place, seed in enumerate(summary.seeds) if seed in summary.kept_seeds]
        weights = {name: array[kept] for name, array in weights.items()}
        return cls(folder, config, summary.kept_seeds, summary.failed_seeds, summary.final, weights)

    def policy(self, name: str, place: int, observation_size: int, action_size: int) -> NumpyPolicy:
        """The network of that name of the seed at that place.

        Raises:
            InputError: there is none, or none of these sizes.
        """
        try:
            policy = NumpyPolicy.of(self.weights, name, place)
            shape = policy(np.zeros(observation_size, np.float32), 0.0).shape
            if shape != (action_size,):
                raise ValueError(f"actions of shape {shape}, not {action_size}")
        except (LookupError, TypeError, ValueError) as error:
            path = self.folder.path / "policies.safetensors"
            raise InputError(str(path), f"is damaged: it holds no {name} of physical deception", ANEW) from error
        return policy

    def in_port(self, pair: Pair) -> np.ndarray:
        """Returns [side, seed] of learner and expert as the run measured them.

        Raises:
            InputError: it did not.
        """
        names = [f"{pair}_return_{side}" for side in ("learner", "expert")]
        for name in names:
            if name not in self.final:
                raise InputError(str(self.folder.path / "summary.json"), f"is damaged: final holds no {name}", ANEW)
        return np.array([self.final[name].per_seed for name in names])


def evaluate_in_mpe2(run: PlayedRun, pair: Pair, episodes: int, quiet: bool = False) -> dict[str, Any]:
    """Play the pair of every seed in the episodes 0, 1, ... of mpe2, and write and return `evaluation-mpe2.json`.

    Raises:
        InputError: mpe2 is not installed, or the run's policies are damaged.
    """
    in_port = run.in_port(pair)
    horizon, names = run.config.horizon, ("learner", EXPERTS[pair])
    environment = mpe2.simple_adversary(horizon)
    pairs = [
        [
            run.policy(name, place, *sizes)
            for name, *sizes in zip(names, mpe2.OBSERVATION_SIZES, mpe2.ACTION_SIZES, strict=True)
        ]
        for place in range(len(run.seeds))
    ]
    returns = np.empty((len(pairs), episodes, 2))
    with shown(quiet) as progress:
        task = progress.add_task(f"{pair} pairs of {len(pairs)} seeds in mpe2", total=episodes)
        for episode in range(episodes):
            for place, (learner, expert) in enumerate(pairs):
                returns[place, episode] = mpe2.play(environment, horizon, learner, expert, seed=episode)
            progress.advance(task)
    error = np.std(returns, axis=1) / np.sqrt(episodes)
    evaluation = {
        "simulator": f"mpe2 {mpe2.version()}",
        "algorithm": run.config.algorithm,
        "pair": pair,
        "networks": dict(zip(("learner", "expert"), names, strict=True)),
        "episodes": episodes,
        "seeds": run.seeds,
        "failed_seeds": run.failed_seeds,
        "in_mpe2": _of_both(np.mean(returns, axis=1).T),
        "in_port": _of_both(in_port),
        "largest_standard_error": {"learner": float(error[:, 0].max()), "expert": float(error[:, 1].max())},
    }
    with refuse_unwritable(str(run.folder.path), run.folder.path, "make room or allow it, then try again"):
        run.folder.write_evaluation("mpe2", evaluation)
    return evaluation


def _of_both(returns: np.ndarray) -> dict[str, Any]:
    """Statistics over seeds of both sides' returns [side, seed], and of their sum."""
    learner, expert = returns
    return {
        name: asdict(Statistics.of(each))
        for name, each in (("learner", learner), ("expert", expert), ("sum", learner + expert))
    }
