"""A game of two sides as a PettingZoo environment."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.spaces import Box, Discrete, Space
from gymnasium.utils.seeding import np_random
from jaxtyping import Array, PyTree
from pettingzoo import ParallelEnv

from gsiirl.errors import InputError
from gsiirl.pettingzoo.playable import AbstractPlayable, Bounds
from gsiirl.types import Sides


class GameEnv(ParallelEnv[str, np.ndarray, Any]):
    """A game that two agents play, the learner's side first and the expert's second, for T steps.

    Rewards are the true ones. An episode is never terminated: after T steps it is truncated. `reset(seed)` decides the
    chance of this episode and of those after it. `game` holds dynamics and rewards, `current` is the game's state.
    """

    def __init__(self, experiment: str, agents: Sides[str], game: AbstractPlayable, double_precision: bool) -> None:
        """The game of an experiment, for the agents of the learner's side and the expert's."""
        self.metadata = {"name": f"gsiirl_{experiment}", "render_modes": [], "is_parallelizable": True}
        self.render_mode = None
        self.game, self._double_precision = game, double_precision
        self.current: Any = None
        self.possible_agents = list(_pair(agents))
        self.agents: list[str] = []
        self.observation_spaces = dict(zip(self.possible_agents, map(_box, _pair(game.bounds)), strict=True))
        self.action_spaces = dict(zip(self.possible_agents, _action_spaces(game), strict=True))
        self._random, _ = np_random()
        self._prepare()

    def _prepare(self) -> None:
        self._leaves, structure = jax.tree.flatten(self.game)
        self._begin, self._advance = _programs(structure)

    def __getstate__(self) -> dict[str, Any]:
        # Libraries copy environments; compiled programs cannot be copied, and JAX's own arrays would lose precision.
        made = ("_leaves", "_begin", "_advance")
        kept = {name: value for name, value in vars(self).items() if name not in made}
        return kept | {name: jax.tree.map(np.asarray, kept[name]) for name in ("game", "current")}

    def __setstate__(self, kept: dict[str, Any]) -> None:
        vars(self).update(kept)
        with jax.enable_x64(self._double_precision):
            self.game, self.current = jax.tree.map(jnp.asarray, (self.game, self.current))
        self._prepare()

    def observation_space(self, agent: str) -> Space:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space:
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Begin an episode; without a seed, the next one of those that the last seed decides. No options are known."""
        if seed is not None:
            self._random, _ = np_random(seed)
        self.agents, self._time = self.possible_agents[:], 0
        self._seed = self._random.integers(2**32, dtype=np.uint32)
        with jax.enable_x64(self._double_precision):
            self.current, seen = self._begin(self._leaves, self._seed)
        return self._by_agent(_pair(seen)), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, np.ndarray], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """One step of both; an entry of a vector beyond ±1 is taken for ±1.

        Raises:
            InputError: the episode is over, an action is missing, or is none of the agent's space.
        """
        if not self.agents:
            raise InputError("step", "no episode has begun, or the last one is over", "call reset first")
        chosen = [self._checked(agent, actions) for agent in self.agents]
        self._time += 1
        horizon = self.game.horizon
        share = np.float32(self._time) / np.float32(horizon)
        with jax.enable_x64(self._double_precision):
            self.current, paid, seen = self._advance(self._leaves, self._seed, self._time, share, self.current, *chosen)
        over = self._time == horizon
        steps = (
            self._by_agent(_pair(seen)),
            dict(zip(self.agents, np.asarray(paid).tolist(), strict=True)),
            dict.fromkeys(self.agents, False),
            dict.fromkeys(self.agents, over),
            {agent: {} for agent in self.agents},
        )
        if over:
            self.agents = []
        return steps

    def _checked(self, agent: str, actions: dict[str, Any]) -> np.ndarray:
        """The action of an agent as the game takes it."""
        space = self.action_spaces[agent]
        if agent not in actions:
            raise InputError("actions", f"holds none of {agent}", f"give one of {' and '.join(self.agents)}")
        action = np.asarray(actions[agent])
        if isinstance(space, Discrete):
            if action.shape == () and action.dtype.kind in "iu" and 0 <= action < space.n:
                return action.astype(np.int64)
            mend = f"give a whole number from 0 to {space.n - 1}"
        else:
            if action.shape == space.shape and action.dtype.kind in "iuf" and np.isfinite(action).all():
                return np.clip(action, -1.0, 1.0).astype(np.float32)
            mend = f"give {space.shape[0] if space.shape else 0} numbers from -1 to 1"
        raise InputError(f"actions[{agent!r}]", f"cannot be {actions[agent]!r}", mend)

    def _by_agent(self, seen: tuple[Any, Any]) -> dict[str, np.ndarray]:
        # Copies: JAX's arrays cannot be written to, and libraries may want to.
        return {agent: np.array(each) for agent, each in zip(self.agents, seen, strict=True)}


@lru_cache(maxsize=16)
def _programs(structure: Any) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """An episode's beginning, and its next step, of games of one tree structure; compiled once for all of them."""

    def first(leaves: list[Array], seed: Array) -> tuple[PyTree, Sides[Array]]:
        game: AbstractPlayable = jax.tree.unflatten(structure, leaves)
        state = game.reset(_key(seed, 0))
        return state, game.observe(state, jnp.zeros((), jnp.float32))

    def following(
        leaves: list[Array], seed: Array, event: Array, share: Array, state: PyTree, learner: Array, expert: Array
    ) -> tuple[PyTree, Array, Sides[Array]]:
        game: AbstractPlayable = jax.tree.unflatten(structure, leaves)
        after, paid = game.step(_key(seed, event), state, Sides(learner, expert))
        return after, jnp.stack([paid.learner, paid.expert]), game.observe(after, share)

    return jax.jit(first), jax.jit(following)


def _key(seed: Array, event: Array | int) -> Array:
    """The random key of an event of an episode: 0 is its beginning, t + 1 is the step from t."""
    return jax.random.fold_in(jax.random.key(seed), event)


def _pair(sides: Sides[Any]) -> tuple[Any, Any]:
    return sides.learner, sides.expert


def _box(bounds: Bounds) -> Box:
    low, high = (np.asarray(each, np.float32) for each in bounds)
    return Box(low, high, dtype=np.float32)


def _action_spaces(game: AbstractPlayable) -> list[Space]:
    if game.action_number is not None:
        return [Discrete(number) for number in _pair(game.action_number)]
    assert game.action_size is not None, "actions are numbers or vectors"
    return [Box(-1.0, 1.0, (size,), np.float32) for size in _pair(game.action_size)]
