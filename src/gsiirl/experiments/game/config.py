"""The configuration of a run on one's own finite game (docs/how-to/own-game.md)."""

from dataclasses import replace
from typing import ClassVar, Literal, Self

from pydantic import Field
from pydantic.dataclasses import dataclass

from gsiirl.errors import InputError
from gsiirl.experiments.run_config import CHECKED, MANY, RunConfig


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class GameConfig(RunConfig):
    """Everything that decides a run on one's own game: its fields are flags, TOML keys and `config.json`."""

    experiment: ClassVar[str] = "game"
    preparation: ClassVar[str] = "gsiirl.experiments.game.run:prepare"
    double_precision: ClassVar[bool] = True

    algorithm: Literal["gsiirl", "marl"] = "gsiirl"
    """Which algorithm learns: `gsiirl`; `marl` is given both true rewards."""
    file: str = ""
    """The game: FILE.npz with its arrays, or FILE.py:NAME, a function that returns (Problem, true reward or expert)."""
    preset: Literal["cooperative", "competitive", "classic"] | None = None
    """A special case, in place of the learner's rewards in the file: `cooperative` (it earns what the expert earns),
    `competitive` (what the expert loses), or `classic` (nothing; the expert is alone, and the file may be a Markov
    decision process). Without FILE the preset has a game of its own: a maze, soccer, or a walk."""
    temperature: Literal["known", "unknown"] = "known"
    """Whether the learner is told the temperature that the file gives the expert."""
    lower_level: Literal["likelihood", "matching"] = "likelihood"
    """How the expert's reward is fitted: by the conditional likelihood, to convergence, or by matching features."""
    explore: Literal["informative", "thompson", "estimate"] | None = None
    """What is played while learning: the best policy under a draw of the posterior (`thompson`), the same after a first
    half of the most `informative` policies (default with the likelihood), or the best under the `estimate`."""
    hand_back: Literal["average", "estimate"] | None = None
    """What is handed back: the best policy on `average` over the posterior (default with the likelihood), or under the
    `estimate`."""
    starts: Literal["many", "one"] = "many"
    """Ascents in each iteration: from many policies, or from the one before."""
    feedback: Literal["model", "visited"] = "model"
    """Where values of the dependent reward are read: everywhere by the model, or only along what was visited."""
    iterations: int = Field(default=50, ge=1, le=MANY)
    """Interactions with the expert."""

    def resolved(self) -> Self:
        """The configuration with the values that a run uses where none were given.

        Raises:
            InputError: fields do not go together, or no game is named.
        """
        if not self.file and self.preset is None:
            raise InputError("FILE", "is missing", "give FILE.npz, or FILE.py:NAME, or --preset")
        has_posterior = self.lower_level == "likelihood"
        full = replace(
            self,
            explore=self.explore or ("informative" if has_posterior else "estimate"),
            hand_back=self.hand_back or ("average" if has_posterior else "estimate"),
        )
        if not has_posterior and (full.explore, full.hand_back) != ("estimate", "estimate"):
            raise InputError("lower_level", "matching has no posterior", "use explore and hand_back estimate")
        return full
