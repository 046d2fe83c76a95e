"""What a learner is told: the game, its own reward, and where it may read the rest."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self, overload

import jax
import numpy as np

from gsiirl.arguments import discount_of, numbers, positive, signature_of
from gsiirl.errors import InputError
from gsiirl.games.base import AbstractContinuousGame, AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff, DensePayoff
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.rewards.continuous import AbstractTransitionFeatures, AbstractTransitionReward, TransitionReward
from gsiirl.rewards.linear import AbstractFeatures, IndicatorFeatures, TabularFeatures


@dataclass(frozen=True, init=False, repr=False)
class Problem:
    """A finite game as the learner sees it; of a continuous game it makes a `ContinuousProblem`.

    Args:
        game: the dynamics.
        own_reward: r_li, of shape (S, A_l) or (S, A_l, A_e); none is 0.
        dependent_value: r_ld (S, A_l, A_e), the part that depends on the expert; none is 0. The learner reads its
            values (with `feedback="visited"` only where it has been), and knows nothing else of it.
        discount: γ in (0, 1].
        temperature: τ > 0 of the expert's soft responses, in reward units; None where it is not known. Rewards are then
            learned in units of it.
        expert_features: features φ of r_e = Σ_i w_i φ_i: an array (S, A_l, A_e, m), or a mapping of names to arrays
            (S, A_l, A_e). Without it r_e has one weight for each state and joint action.
        dependent_features: the same for the fit of r_ld.
        expert_names, dependent_names: names of the features that are given as an array.
        reward_scale: standard deviation of the prior of each weight of r_e, in its units; None chooses it by the data.

    Raises:
        InputError: naming the argument that cannot be, and the mend.
    """

    game: AbstractTabularGame
    own_reward: AbstractPayoff
    dependent_value: AbstractPayoff
    discount: float
    temperature: float | None
    reward_scale: float | None
    expert_features: AbstractFeatures
    dependent_features: AbstractFeatures
    expert_names: Sequence[str]
    dependent_names: Sequence[str]

    @overload
    def __new__(
        cls,
        game: AbstractContinuousGame[Any],
        own_reward: TransitionReward | None = ...,
        dependent_value: TransitionReward | None = ...,
        *,
        discount: float = ...,
        expert_features: AbstractTransitionFeatures | AbstractTransitionReward,
        dependent_features: AbstractTransitionFeatures | None = ...,
        expert_scale: float | None = ...,
        dependent_scale: float | None = ...,
    ) -> ContinuousProblem: ...

    @overload
    def __new__(cls, game: object, *arguments: Any, **settings: Any) -> Self: ...

    def __new__(cls, *arguments: Any, **settings: Any) -> Any:
        """A problem of the kind that the game is of."""
        game = arguments[0] if arguments else settings.get("game")
        if isinstance(game, AbstractContinuousGame):
            return ContinuousProblem(*arguments, **settings)
        return super().__new__(cls)

    def __init__(
        self,
        game: AbstractTabularGame,
        own_reward: object = None,
        dependent_value: object = None,
        *,
        discount: float = 0.95,
        temperature: float | None,
        expert_features: object = None,
        dependent_features: object = None,
        expert_names: Sequence[str] | None = None,
        dependent_names: Sequence[str] | None = None,
        reward_scale: float | None = None,
    ) -> None:
        if not isinstance(game, AbstractTabularGame):
            raise InputError("game", f"is {type(game).__name__}", "make one with gsiirl.games.TabularGame.from_arrays")
        expert, names = features_of("expert_features", expert_features, "expert_names", expert_names, game)
        dependent, others = features_of(
            "dependent_features", dependent_features, "dependent_names", dependent_names, game
        )
        values = {
            "game": game,
            "own_reward": own_payoff(own_reward, game),
            "dependent_value": joint_payoff("dependent_value", dependent_value, game),
            "discount": discount_of(discount),
            "temperature": None if temperature is None else positive("temperature", temperature),
            "reward_scale": None if reward_scale is None else positive("reward_scale", reward_scale),
            "expert_features": expert,
            "dependent_features": dependent,
            "expert_names": names,
            "dependent_names": others,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def unit(self) -> float:
        """What a weight of 1 in units of the temperature is in reward units; 1 where the temperature is unknown."""
        return 1.0 if self.temperature is None else self.temperature

    def __repr__(self) -> str:
        actions = self.game.number_of_actions
        return (
            f"Problem({self.game.number_of_states} states, {actions.learner} x {actions.expert} actions, "
            f"{self.game.horizon} steps, {len(self.expert_names)} weights)"
        )


Problem.__signature__ = signature_of(Problem)  # pyright: ignore[reportAttributeAccessIssue] (what a notebook shows)


class StateActionNames(Sequence[str]):
    """Names of one weight for each state and joint action, made when they are asked for."""

    def __init__(self, shape: tuple[int, int, int]) -> None:
        self._shape = shape

    def __len__(self) -> int:
        return int(np.prod(self._shape))

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[each] for each in range(*index.indices(len(self)))]
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        state, learner, expert = np.unravel_index(index % len(self), self._shape)
        return f"state {state}, learner {learner}, expert {expert}"

    def __iter__(self) -> Iterator[str]:
        return (self[index] for index in range(len(self)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, StateActionNames) and other._shape == self._shape

    def __hash__(self) -> int:
        return hash(self._shape)


def joint_shape(game: AbstractTabularGame) -> tuple[int, int, int]:
    """(S, A_l, A_e)."""
    actions = game.number_of_actions
    return game.number_of_states, actions.learner, actions.expert


def joint_payoff(argument: str, reward: object, game: AbstractTabularGame) -> AbstractPayoff:
    """A reward of (s, a_l, a_e): an array of that shape, or a payoff that the library made.

    Raises:
        InputError: it has another shape, or is no array of finite numbers.
    """
    shape = joint_shape(game)
    if isinstance(reward, AbstractPayoff):
        given = jax.eval_shape(reward.dense).shape
        if given != shape:
            raise InputError(argument, f"is a payoff of shape {given}", f"give one of {shape}, that of the game")
        return reward
    table = np.zeros(shape) if reward is None else numbers(argument, reward)
    if table.shape != shape:
        raise InputError(
            argument, f"has shape {table.shape}", f"give {shape}: states, learner's actions, expert's actions"
        )
    return DensePayoff(table)


def own_payoff(reward: object, game: AbstractTabularGame) -> AbstractPayoff:
    """r_li of (s, a_l), or of (s, a_l, a_e).

    Raises:
        InputError: see `joint_payoff`.
    """
    shape = joint_shape(game)
    if reward is None or isinstance(reward, AbstractPayoff):
        return joint_payoff("own_reward", reward, game)
    table = numbers("own_reward", reward)
    if table.shape == shape[:2]:
        table = np.broadcast_to(table[:, :, None], shape).copy()
    if table.shape != shape:
        raise InputError(
            "own_reward",
            f"has shape {table.shape}",
            f"give {shape[:2]}: states, learner's actions; or {shape}, with the expert's",
        )
    return DensePayoff(table)


def features_of(
    argument: str, features: object, names_argument: str, names: Sequence[str] | None, game: AbstractTabularGame
) -> tuple[AbstractFeatures, Sequence[str]]:
    """The features of a reward and their names; without any, one for each state and joint action.

    Raises:
        InputError: a shape or a name cannot be.
    """
    shape = joint_shape(game)
    if isinstance(features, TabularFeatures):
        names = features.names or None if names is None else names
        features = features.table
    if isinstance(features, IndicatorFeatures) and features.shape == shape:
        features = None
    if isinstance(features, AbstractFeatures):
        given = jax.eval_shape(lambda weights: features.payoff(weights).dense(), np.zeros(features.number)).shape
        if given != shape:
            raise InputError(argument, f"are of a reward of shape {given}", f"give some of {shape}, that of the game")
        return features, features.names
    if features is None:
        if names is not None:
            raise InputError(names_argument, f"is given without {argument}", f"give {argument} too")
        return IndicatorFeatures(shape=shape, names=()), StateActionNames(shape)
    if isinstance(features, Mapping):
        if names is not None:
            raise InputError(names_argument, f"is given beside a mapping {argument}", "leave it out")
        if not features:
            raise InputError(argument, "is empty", "give at least one feature")
        names = list(features)
        tables = [numbers(f"{argument}[{name!r}]", each) for name, each in features.items()]
        for name, table in zip(names, tables, strict=True):
            if table.shape != shape:
                raise InputError(f"{argument}[{name!r}]", f"has shape {table.shape}", f"give {shape}")
        table = np.stack(tables, axis=-1)
    else:
        table = numbers(argument, features)
    if table.ndim != 4 or table.shape[:3] != shape or table.shape[3] == 0:
        raise InputError(
            argument, f"has shape {table.shape}", f"give ({', '.join(map(str, shape))}, number of features)"
        )
    if names is not None and (isinstance(names, str) or not isinstance(names, Iterable)):
        raise InputError(names_argument, f"is {names!r}", "give a list of texts, one a feature")
    given = [f"feature {index}" for index in range(table.shape[3])] if names is None else list(names)
    if len(given) != table.shape[3]:
        raise InputError(names_argument, f"has {len(given)} names", f"give {table.shape[3]}, one a feature")
    for name in given:
        if not isinstance(name, str) or not name:
            raise InputError(names_argument, f"holds {name!r}", "give texts that are not empty")
    if len(set(given)) != len(given):
        twice = next(name for name in given if given.count(name) > 1)
        raise InputError(names_argument, f"holds {twice!r} twice", "give every feature a name of its own")
    return TabularFeatures(table=table, names=()), given
