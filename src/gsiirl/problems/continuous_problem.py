"""What a learner is told in a continuous game: the game, its own reward, and what it may find out of the rest."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key, PyTree

from gsiirl.arguments import discount_of, positive, whole_number
from gsiirl.errors import InputError
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.rewards.continuous import (
    AbstractTransitionFeatures,
    AbstractTransitionReward,
    LinearTransitionReward,
    TransitionReward,
)
from gsiirl.types import Sides, Transition

DEPENDENT_SCALE = 10.0
"""Bound on the norm of the weights of r_ld, where none is given."""
TRIED = 16
"""Random transitions on which rewards and features must be finite."""
A_STEP = "a function of one step, Transition(state, actions, following)"


class Nothing(AbstractTransitionFeatures):
    """The one feature, always 0, of a reward that is 0."""

    names: tuple[str, ...] = eqx.field(static=True, default=("nothing",))

    def __call__(self, transition: Transition) -> Float[Array, " 1"]:
        return jnp.zeros(1, jnp.float32)


@dataclass(frozen=True, init=False, repr=False, eq=False)
class ContinuousProblem:
    """A continuous game as the learner sees it; `gsiirl.Problem` makes one of a game of this kind.

    Args:
        game: the dynamics.
        own_reward: r_li(s, a, s'), a function of one step; none is 0.
        dependent_value: r_ld(s, a, s'), the part that depends on the expert; none is 0. The learner reads its values
            where it has been, and knows nothing else of it.
        discount: γ in (0, 1].
        expert_features: m features φ of r_e = Σ_i w_i φ_i; or a reward with parameters of its own, such as
            `rewards.continuous.NetworkReward`.
        dependent_features: n features for the fit of r_ld; not needed where that is 0.
        expert_scale: the norm of the weights w of r_e, in reward units; 1 unless given. What an expert does shows them
            up to a factor, so that the norm is chosen, and not learned.
        dependent_scale: bound on the norm of the weights of r_ld, in reward units; 10 unless given.

    Attributes:
        expert_reward: r_e^θ, which may be learned.
        dependent_reward: r_ld^θ, which may be fitted.

    Raises:
        InputError: naming the argument that cannot be, and the mend.
    """

    game: AbstractContinuousGame[Any]
    own_reward: TransitionReward
    dependent_value: TransitionReward
    discount: float
    expert_reward: AbstractTransitionReward
    dependent_reward: LinearTransitionReward

    def __init__(
        self,
        game: object,
        own_reward: object = None,
        dependent_value: object = None,
        *,
        discount: float = 0.95,
        expert_features: object,
        dependent_features: object = None,
        expert_scale: float | None = None,
        dependent_scale: float | None = None,
    ) -> None:
        known = continuous_game(game)
        if dependent_features is None and dependent_value is not None:
            raise InputError("dependent_features", "is None", "give the features that dependent_value is fitted with")
        tried = random_steps(known)
        own = reward_of("own_reward", own_reward, tried)
        value = reward_of("dependent_value", dependent_value, tried)
        fitted = Nothing() if dependent_features is None else dependent_features
        bound = DEPENDENT_SCALE if dependent_scale is None else positive("dependent_scale", dependent_scale)
        values = {
            "game": known,
            "own_reward": own,
            "dependent_value": value,
            "discount": discount_of(discount),
            "expert_reward": _expert_reward(expert_features, expert_scale, tried),
            "dependent_reward": LinearTransitionReward(
                features=features_of("dependent_features", fitted, tried), scale=bound
            ),
        }
        for name, each in values.items():
            object.__setattr__(self, name, each)

    def true_rewards(self, expert_reward: TransitionReward) -> Sides[TransitionReward]:
        """r_ld + r_li, and the true r_e, which the problem itself does not hold."""
        return Sides(lambda seen: self.dependent_value(seen) + self.own_reward(seen), expert_reward)

    def __repr__(self) -> str:
        sizes = self.game.action_size
        return (
            f"ContinuousProblem({type(self.game).__name__}, {sizes.learner} and {sizes.expert} actions, "
            f"{self.game.horizon} steps, {len(self.expert_reward.names)} weights)"
        )


@contextmanager
def single_precision() -> Iterator[None]:
    """Continuous games are computed in float32, whatever JAX is set to."""
    with jax.enable_x64(False), jax.numpy_dtype_promotion("standard"), warnings.catch_warnings():
        # A user's own constants may be in double precision.
        warnings.filterwarnings("ignore", message="Explicitly requested dtype")
        yield


def continuous_game(game: object) -> AbstractContinuousGame[Any]:
    """`game`, with a horizon, actions, states and observations that fit together.

    Raises:
        InputError: they do not, or it is no continuous game.
    """
    if not isinstance(game, AbstractContinuousGame):
        raise InputError(
            "game", f"is {type(game).__name__}", "give a game of arrays (gsiirl.games.TabularGame) or a continuous one"
        )
    whole_number("game.horizon", game.horizon, 1)
    sizes: Any = game.action_size
    if not isinstance(sizes, Sides):
        raise InputError("game.action_size", f"is {sizes!r}", "give Sides(learner=..., expert=...)")
    for side in ("learner", "expert"):
        whole_number(f"game.action_size.{side}", getattr(sizes, side), 1)
    with single_precision():
        state, following, seen = eqx.filter_eval_shape(_first_step, game)
        if _shapes(following) != _shapes(state):
            raise InputError(
                "game.step",
                f"makes {_shown(following)} of a state of {_shown(state)}",
                "give the state that follows the shapes and types that reset gives",
            )
    if not isinstance(seen, Sides):
        raise InputError("game.observe", f"gives {type(seen).__name__}", "give Sides(learner=..., expert=...)")
    for side in ("learner", "expert"):
        vector = getattr(seen, side)
        if getattr(vector, "ndim", None) != 1 or not jnp.issubdtype(vector.dtype, jnp.floating):
            raise InputError(f"game.observe, {side}", f"is {_shown(vector)}", "give a vector of real numbers")
    return game


def random_steps(game: AbstractContinuousGame[Any]) -> Transition:
    """`TRIED` first steps with random actions, along a leading axis."""
    with single_precision():
        return _transitions(game, jax.random.split(jax.random.key(0), TRIED))


def reward_of(argument: str, function: object, tried: Transition) -> TransitionReward:
    """A function of a step that gives a finite number wherever it is `tried`; None is 0.

    Raises:
        InputError: it is none.
    """
    if function is None:
        return nothing
    if not callable(function):
        raise InputError(argument, f"is {type(function).__name__}", f"give {A_STEP}")
    reward: TransitionReward = function  # pyright: ignore[reportAssignmentType] (what it gives is checked)
    _try(argument, reward, tried, (), "a number")
    return reward


def features_of(argument: str, function: object, tried: Transition) -> AbstractTransitionFeatures:
    """Features with names, each finite wherever it is `tried`.

    Raises:
        InputError: they are not.
    """
    if not isinstance(function, AbstractTransitionFeatures):
        mend = "give a gsiirl.rewards.continuous.AbstractTransitionFeatures"
        raise InputError(argument, f"is {type(function).__name__}", mend)
    names: Any = function.names
    texts = isinstance(names, tuple) and all(isinstance(each, str) and each for each in names)
    if not texts or not names or len(set(names)) != len(names):
        raise InputError(f"{argument}.names", f"is {names!r}", "give a tuple of texts, another one a feature")
    _try(argument, function, tried, (len(names),), f"a vector of {len(names)}, one a name")
    return function


def _try(
    argument: str, function: Callable[[Transition], Any], tried: Transition, shape: tuple[int, ...], wanted: str
) -> None:
    with single_precision():
        given = eqx.filter_eval_shape(function, jax.tree.map(lambda leaf: leaf[0], tried))
        real = hasattr(given, "dtype") and jnp.issubdtype(given.dtype, jnp.floating)
        if not real or given.shape != shape:
            raise InputError(argument, f"gives {_shown(given)}", f"give {wanted}, of real numbers")
        values = jax.jit(jax.vmap(function))(tried)
    if not np.isfinite(values).all():
        mend = "mend it, so that it is finite wherever the game may be"
        raise InputError(argument, "is not finite after a first step with random actions", mend)


def nothing(transition: Transition) -> Float[Array, ""]:
    """The reward 0."""
    return jnp.zeros((), jnp.float32)


def _expert_reward(features: object, scale: float | None, tried: Transition) -> AbstractTransitionReward:
    argument = "expert_features"
    if features is None:
        raise InputError(argument, "is None", "give features of the expert's reward")
    if not isinstance(features, AbstractTransitionReward):
        norm = 1.0 if scale is None else positive("expert_scale", scale)
        return LinearTransitionReward(features=features_of(argument, features, tried), scale=norm)
    if scale is not None:
        raise InputError("expert_scale", "is given beside a reward that has its own", "leave it out")
    start = jnp.zeros(features.number_of_parameters, jnp.float32)
    reward_of(argument, lambda seen: features(start, seen), tried)
    return features


def _first_step(game: AbstractContinuousGame[Any]) -> tuple[PyTree, PyTree, Any]:
    moved = _transition(game, jax.random.key(0))
    return moved.state, moved.following, game.observe(moved.state)


def _transition(game: AbstractContinuousGame[Any], key: Array) -> Transition:
    """A first step with random actions."""
    start_key, *keys = jax.random.split(key, 3)
    state = game.reset(start_key)
    draws = [
        jax.random.uniform(one, (size,), jnp.float32, -1.0, 1.0)
        for one, size in zip(keys, (game.action_size.learner, game.action_size.expert), strict=True)
    ]
    actions = Sides(*draws)
    return Transition(state, actions, game.step(state, actions))


@eqx.filter_jit
def _transitions(game: AbstractContinuousGame[Any], keys: Key[Array, " n"]) -> Transition:
    # One function of the module: the problem, the expert and the evaluation of a game compile it once.
    return jax.vmap(lambda key: _transition(game, key))(keys)


def _shapes(tree: PyTree) -> Any:
    return jax.tree.map(lambda leaf: (getattr(leaf, "shape", None), getattr(leaf, "dtype", None)), tree)


def _shown(tree: PyTree) -> str:
    """Shapes and types in one line: `float32[2], float32[3]`."""
    leaves = jax.tree.leaves(tree)
    return ", ".join(
        f"{leaf.dtype}{list(leaf.shape)}" if hasattr(leaf, "dtype") else type(leaf).__name__ for leaf in leaves
    )
