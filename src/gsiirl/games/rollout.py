"""Sampling an episode of a game."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.games.base import AbstractContinuousGame, AbstractTabularGame
from gsiirl.types import Policies, Sides, Trajectories, Transition

Policy = Callable[[Float[Array, " o"], Float[Array, ""]], Float[Array, " A"]]
"""A deterministic policy of a continuous game: what is observed, and t/T, to an action within ±1 along each axis."""


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
    over = jnp.zeros(game.horizon, bool) if game.terminal is None else game.terminal[states]
    return Trajectories(states=states, actions=actions, mask=~over)


def initial_states(game: AbstractContinuousGame, key: PRNGKeyArray, number: int) -> PyTree:
    """`number` initial states of a continuous game, along a leading axis."""
    return jax.vmap(game.reset)(jax.random.split(key, number))


def play(game: AbstractContinuousGame, policies: Sides[Policy], start: PyTree) -> Transition:
    """The episode of a continuous game from `start`: T steps; `vmap` over starts for more."""

    def one_step(state: PyTree, time: Array) -> tuple[PyTree, tuple[Sides[Array], PyTree]]:
        observations = game.observe(state)
        actions = Sides(
            policies.learner(observations.learner, time),
            policies.expert(observations.expert, time),
        )
        following = game.step(state, actions)
        return following, (actions, following)

    times = jnp.arange(game.horizon, dtype=jnp.float32) / game.horizon
    actions, following = jax.lax.scan(one_step, start, times)[1]
    states = jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest[:-1]]), start, following)
    return Transition(states, actions, following)


def episodes_from(game: AbstractContinuousGame, policies: Sides[Policy], starts: PyTree) -> Transition:
    """An episode (axes d, T) from each of d initial states."""
    return jax.vmap(lambda start: play(game, policies, start))(starts)
