"""A finished run whose learned rewards are taken to changed games; every experiment that can do so has its own kind."""

import abc
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from gsiirl.errors import InputError
from gsiirl.experiments.config import config_from_dict
from gsiirl.experiments.run_config import RunConfig
from gsiirl.experiments.transfer.regret import over_changes, rows
from gsiirl.program.command import command
from gsiirl.program.progress import Begun, Told, shown
from gsiirl.runs import RunFolder
from gsiirl.runs.files.atomic import refuse_unwritable
from gsiirl.runs.files.numbers import is_sound
from gsiirl.runs.learned import LearnedParameters
from gsiirl.types import Sides

OTHER_RUN = "give the folder of a finished run of `gsiirl run security` or `gsiirl run crossing`"


class Judged(NamedTuple):
    """One changed game: what there is to say of it, and of every row the returns (2, n), discounted and not."""

    about: dict[str, Any]
    returns: dict[str, np.ndarray]


class Model(NamedTuple):
    """What a learner takes to a changed game, of every seed: its weights, and the policies that it ended with."""

    weights: Sides[np.ndarray]
    policies: Any


class Kept(NamedTuple):
    """What a finished run has kept, of all its seeds."""

    folder: RunFolder
    config: RunConfig
    seeds: list[int]
    learned: LearnedParameters
    policies: dict[str, np.ndarray]

    @classmethod
    def open(cls, path: Path, field: str) -> Self:
        """The run in a folder.

        Raises:
            InputError: it has not ended, or has learned no reward.
        """
        folder = RunFolder.open(path)
        config = config_from_dict(folder.config, path / "config.json")
        summary = folder.summary()
        if summary is None or not summary.completed:
            raise InputError(field, f"{path} holds a run that is not finished", f"run {command('resume', path)}")
        learned, policies = folder.load_learned(), folder.load_policies()
        if learned is None or not policies:
            raise InputError(field, f"{path} is a run of {config.algorithm}, which keeps no learned reward", OTHER_RUN)
        return cls(folder, config, summary.seeds, learned, policies)

    @property
    def dependent(self) -> str:
        """Name of the learner's reward: MA-IRL fits one in place of reading r_ld."""
        return "dependent_reward" if "dependent_reward" in self.learned.arrays else "commitment"

    def sound(self, field: str, *arrays: np.ndarray) -> np.ndarray:
        """Which seeds have numbers in all `arrays` (n, ...).

        Raises:
            InputError: none has.
        """
        sound = np.array([all(np.all(is_sound(each)) for each in of_seed) for of_seed in zip(*arrays, strict=True)])
        if not sound.any():
            problem = f"{self.folder.path} holds no seed whose rewards and policy are numbers"
            raise InputError(field, problem, OTHER_RUN)
        return sound

    def parted(self, sound: np.ndarray) -> tuple[list[int], list[int]]:
        """The seeds that are sound, and those that are left out."""
        seeds = np.array(self.seeds)
        return seeds[sound].tolist(), seeds[~sound].tolist()


@dataclass(frozen=True)
class AbstractLearned(abc.ABC):
    """What every seed of a run has learned, and how that is judged in changed games."""

    folder: RunFolder
    seeds: list[int]
    left_out: list[int]
    """Seeds whose rewards or policy are no numbers."""
    weights: Sides[np.ndarray]
    """(n, ·) of the learner's reward and of r_e, in the units that the experiment computes with."""
    policies: Any
    """The final policies, along a leading axis n."""

    @property
    def algorithm(self) -> str:
        """Who learned."""
        return str(self.folder.config["algorithm"])

    @abc.abstractmethod
    def drawn(self, number: int, seed: int) -> list[str]:
        """`number` changes at random."""

    @abc.abstractmethod
    def is_of_the_same_game(self, other: "AbstractLearned") -> bool:
        """Whether another run was of the same game, and the same rewards were to be learned there."""

    @abc.abstractmethod
    def judge(self, changes: list[str], models: Mapping[str, Model]) -> Callable[[str, Told], Judged]:
        """What judges learned rewards in a game after one of these changes, a row for each name in `models`.

        It may tell how many of its searches are done.

        Raises:
            InputError: a change cannot be made.
        """

    def transferred(self, changes: list[str], beside: "AbstractLearned | None", quiet: bool = False) -> dict[str, Any]:
        """Take the run, and another one beside it, through every change; writes and returns `transfer.json`.

        Raises:
            InputError: a change cannot be made, or the other run is of another game.
        """
        if beside is not None and not self.is_of_the_same_game(beside):
            problem = f"{beside.folder.path} is a run of another game"
            raise InputError("--beside", problem, f"give one of the game of {self.folder.path}")
        judge = self.judge(changes, self.models(beside))
        found: list[dict[str, Any]] = []
        with shown(quiet) as progress:
            several = list(dict.fromkeys(changes))
            for number, change in enumerate(several, 1):
                task = Begun(progress, f"change {number} of {len(several)}, {change}")
                judged = judge(change, task.tell)
                task.end()
                found.append({"change": change, **judged.about, "rows": rows(judged.returns)})
        result = {
            "experiment": self.folder.config["experiment"],
            "algorithm": self.algorithm,
            "seeds": self.seeds,
            "beside": None if beside is None else {"algorithm": beside.algorithm, "seeds": beside.seeds},
            "changes": found,
            "all_changes": over_changes(found),
        }
        path = self.folder.path
        with refuse_unwritable(str(path), path, "make room or allow it, then try again"):
            self.folder.write_transfer(result)
        return result

    def models(self, beside: "AbstractLearned | None") -> dict[str, Model]:
        """What both runs have learned, by the name of a row.

        Of the run beside there are two: as it is, and its r_e with this run's fit of r_ld, mean over seeds. The
        learner's own reward can be read: whose expert is the better one is told by r_e alone.
        """
        found = {self.algorithm: Model(self.weights, self.policies)}
        if beside is not None:
            name = beside.algorithm if beside.algorithm != self.algorithm else f"{self.algorithm}, beside"
            fitted = np.repeat(self.weights.learner.mean(axis=0, keepdims=True), len(beside.seeds), axis=0)
            found[name] = Model(beside.weights, beside.policies)
            found[f"{name}, r_e alone"] = Model(Sides(fitted, beside.weights.expert), beside.policies)
        return found
