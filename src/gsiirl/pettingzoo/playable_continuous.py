"""The crossing and physical deception, one step at a time."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.games.base import AbstractContinuousGame
from gsiirl.pettingzoo.playable import AbstractPlayable, Bounds
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides, Transition


class PlayableContinuous(AbstractPlayable):
    """A continuous game with both true rewards r(s, a, s')."""

    game: AbstractContinuousGame
    rewards: Sides[TransitionReward] = eqx.field(static=True)
    farthest: float = eqx.field(static=True)
    """What no entry of an observation of the game exceeds."""

    @property
    def horizon(self) -> int:
        return self.game.horizon

    @property
    def action_number(self) -> None:
        return None

    @property
    def action_size(self) -> Sides[int]:
        return self.game.action_size

    @property
    def bounds(self) -> Sides[Bounds]:
        def of(seen: jax.ShapeDtypeStruct) -> Bounds:
            [size] = seen.shape
            return [-self.farthest] * size + [0.0], [self.farthest] * size + [1.0]

        seen = jax.eval_shape(lambda: self.game.observe(self.game.reset(jax.random.key(0))))
        return Sides(of(seen.learner), of(seen.expert))

    def reset(self, key: PRNGKeyArray) -> PyTree:
        return self.game.reset(key)

    def step(self, key: PRNGKeyArray, state: PyTree, actions: Sides[Array]) -> tuple[PyTree, Sides[Float[Array, ""]]]:
        following = self.game.step(state, actions)
        seen = Transition(state, actions, following)
        return following, Sides(self.rewards.learner(seen), self.rewards.expert(seen))

    def observe(self, state: PyTree, time: Float[Array, ""]) -> Sides[Float[Array, " o"]]:
        seen = self.game.observe(state)
        return Sides(jnp.append(seen.learner, time), jnp.append(seen.expert, time))
