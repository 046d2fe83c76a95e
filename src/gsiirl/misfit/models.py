"""Other models of an expert than the soft best response: what it may do instead.

Each gives ln π_e(a_e|s, t) for weights θ in units of the temperature, with q = Q_e/τ the action values of the soft best
response (`gsiirl.equilibria.response`):

* `lapses`: with chance ε it picks any allowed action, π = (1 − ε) softmax(q) + ε/|A(s)|;
* `ranks`: it picks the best action with one chance and the second best with another, whatever they are worth;
* `short_sighted`: it looks h steps ahead only, q_t = r + γ E[V_t+1] with V of the h − 1 steps that follow;
* `boltzmann`: π = softmax(Q*), with Q*_t = E[r/τ + γ max Q*_t+1] the values of choosing best from the next step on;
* `late`: it answers the policy of the interaction before.
"""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.equilibria.response import Response, respond_now
from gsiirl.games.base import FORBIDDEN
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood

SHARPER = (10.0, 30.0, 100.0, 300.0)
"""Sizes of the weights of `ranks`, in units of the soft best response's; each fit begins where the one before ended.

At the first size which action is best is blurred, and a search finds its way; at the last one hardly anything is.
"""


class Observed(eqx.Module):
    """What is known of interactions: the learner's policy, the one before it, and how often the expert did what."""

    learner_policy: Float[Array, "*N T S A_l"]
    policy_before: Float[Array, "*N T S A_l"]
    counts: Float[Array, "*N T S A_e"]


class Model(NamedTuple):
    """A model of the expert: its name, ln π_e from (θ, further parameters, one interaction), and where these begin."""

    name: str
    words: str
    """What such an expert does, with places for its `chances`."""
    log_policy: Callable[[ConditionalLikelihood, Array, Array, Observed], Array]
    further: tuple[float, ...] = ()
    chances: Callable[[np.ndarray], tuple[float, ...]] = lambda further: ()
    """What the further parameters say."""
    sharper: tuple[float, ...] = ()
    """Sizes of θ, in units of the soft best response's, where only the order of action values matters: the size is not
    fitted then, and there is a fit at each of these."""


def soft(expert: ConditionalLikelihood, weights: Array, further: Array, seen: Observed) -> Array:
    """The soft best response to the policy that was played."""
    return jax.nn.log_softmax(expert.action_values(weights, seen.learner_policy))


def late(expert: ConditionalLikelihood, weights: Array, further: Array, seen: Observed) -> Array:
    """The soft best response to the policy of the interaction before."""
    return jax.nn.log_softmax(expert.action_values(weights, seen.policy_before))


def lapses(expert: ConditionalLikelihood, weights: Array, further: Array, seen: Observed) -> Array:
    """As `soft`, with any action at chance ε = sigmoid(`further`)."""
    values = expert.action_values(weights, seen.learner_policy)
    allowed = values > 0.1 * FORBIDDEN
    anything = jnp.where(allowed, 1.0 / jnp.sum(allowed, axis=-1, keepdims=True), 0.0)
    chance = jax.nn.sigmoid(further[0])
    mixed = (1.0 - chance) * jax.nn.softmax(values) + chance * anything
    return jnp.where(allowed, jnp.log(jnp.where(allowed, mixed, 1.0)), FORBIDDEN)


def ranks(expert: ConditionalLikelihood, weights: Array, further: Array, seen: Observed) -> Array:
    """Chances of the best, the second best and any other action: softmax of (0, `further`).

    Which action is best is blurred a little, so that weights can be fitted by their slope: it is drawn from softmax(q),
    and the second best from what is left. The larger the weights, the less it is.
    """
    values = expert.action_values(weights, seen.learner_policy)
    allowed = values > 0.1 * FORBIDDEN
    number = jnp.sum(allowed, axis=-1, keepdims=True)
    first = jax.nn.softmax(values)
    others = jnp.where(jnp.eye(values.shape[-1], dtype=bool), FORBIDDEN, values[..., None, :])
    second = jnp.sum(first[..., :, None] * jax.nn.softmax(others), axis=-2)
    rest = jnp.where(allowed, jnp.maximum(1.0 - first - second, 0.0) / jnp.maximum(number - 2, 1), 0.0)
    chances = jax.nn.softmax(jnp.concatenate([jnp.zeros(1, weights.dtype), further]))
    mixed = chances[0] * first
    mixed += jnp.where(number > 1, chances[1] * second, 0.0) + jnp.where(number > 2, chances[2] * rest, 0.0)
    mixed = mixed / jnp.sum(mixed, axis=-1, keepdims=True)
    return jnp.where(allowed, jnp.log(jnp.where(allowed, jnp.maximum(mixed, 1e-30), 1.0)), FORBIDDEN)


def short_sighted(steps: int) -> Callable[[ConditionalLikelihood, Array, Array, Observed], Array]:
    """The model of an expert that looks `steps` steps ahead."""

    def log_policy(expert: ConditionalLikelihood, weights: Array, further: Array, seen: Observed) -> Array:
        payoff = expert.features.payoff(weights)

        def at(policy_now: Array, values: Array) -> Response:
            return respond_now(expert.game, policy_now, payoff, 1.0, expert.discount, values)

        nothing = jnp.zeros(seen.learner_policy.shape[:2], weights.dtype)
        response = jax.vmap(at)(seen.learner_policy, nothing)
        for _ in range(steps - 1):
            after = jnp.concatenate([response.values[1:], nothing[:1]])
            response = jax.vmap(at)(seen.learner_policy, after)
        return jax.nn.log_softmax(response.action_values)

    return log_policy


def boltzmann(expert: ConditionalLikelihood, weights: Array, further: Array, seen: Observed) -> Array:
    """softmax of the values of acting best from the next step on."""
    game, payoff = expert.game, expert.features.payoff(weights)

    def backward(values: Array, policy_now: Array) -> tuple[Array, Array]:
        action_values = respond_now(game, policy_now, payoff, 1.0, expert.discount, values).action_values
        return game.alive(jnp.max(action_values, axis=-1)), jax.nn.log_softmax(action_values)

    nothing = jnp.zeros(seen.learner_policy.shape[1], weights.dtype)
    return jax.lax.scan(backward, nothing, seen.learner_policy, reverse=True)[1]


def _lapse(further: np.ndarray) -> tuple[float, ...]:
    """ε."""
    return (float(1.0 / (1.0 + np.exp(-further[0]))),)


def _first_and_second(further: np.ndarray) -> tuple[float, ...]:
    """The chances of the best and of the second best action."""
    scores = np.exp(np.concatenate([[0.0], further]))
    return tuple(float(each) for each in (scores / scores.sum())[:2])


STANDARD = Model("soft best response", "it responds softly", soft)
OTHERS = (
    Model("lapses", "it picks any action with chance {:.2g}", lapses, (-2.0,), _lapse),
    Model(
        "ranks",
        "it picks the best action with chance {:.2g}, the second with {:.2g}, whatever they are worth",
        ranks,
        (-1.0, -2.0),
        _first_and_second,
        sharper=SHARPER,
    ),
    Model("short-sighted, 1 step", "it is short-sighted, 1 step", short_sighted(1)),
    Model("short-sighted, 2 steps", "it is short-sighted, 2 steps", short_sighted(2)),
    Model("Boltzmann in Q*", "its chances are exp(Q*/τ), with Q* the values of choosing best later on", boltzmann),
    Model("late", "it answers the policy of the interaction before", late),
)
