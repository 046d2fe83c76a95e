"""Sampling an episode of a tabular game."""

import jax
import jax.numpy as jnp
from jaxtyping import PRNGKeyArray

from gsiirl.games.base import AbstractTabularGame
from gsiirl.types import Policies, Sides, Trajectories


def rollout(key: PRNGKeyArray, game: AbstractTabularGame, policies: Policies) -> Trajectories:
    """One episode of T steps under time-indexed policies; `vmap` over keys for more."""
    reset_key, episode_key = jax.random.split(key)

    def one_step(state, inputs):
        step_key, policies_now = inputs
        learner_key, expert_key, transition_key = jax.random.split(step_key, 3)
        actions = Sides(
            jax.random.categorical(learner_key, jnp.log(policies_now.learner[state])),
            jax.random.categorical(expert_key, jnp.log(policies_now.expert[state])),
        )
        return game.step(transition_key, state, actions), (state, actions)

    keys = jax.random.split(episode_key, game.horizon)
    _, (states, actions) = jax.lax.scan(one_step, game.reset(reset_key), (keys, policies))
    return Trajectories(states=states, actions=actions, mask=jnp.ones(game.horizon, bool))
