"""The upper level alone: the best policy for given rewards, where nothing is left to learn."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.commitment.objective import Commitment
from gsiirl.commitment.search import Search, committed, is_small
from gsiirl.games.base import only_allowed
from gsiirl.games.payoff import AbstractPayoff


def best_commitment(
    commitment: Commitment, expert_reward: AbstractPayoff, key: PRNGKeyArray
) -> Float[Array, "T S A_l"]:
    """The best π_l found to commit to, argmax f(π_l; r_e), against an expert that answers it.

    `expert_reward` is in units of the expert's temperature. The search begins anew, from random starts alone, which
    depend on the size of the rewards and on `key`.
    """
    game = commitment.game
    small = is_small(game)
    start_key, round_key = jax.random.split(key)
    search = Search(game, steps=100)
    starts = search.random(32 if small else 12, commitment.range_of_answers(expert_reward), start_key)
    nothing = jnp.zeros(0, game.initial.dtype)
    objective = committed(commitment, lambda _: expert_reward)
    logits, _ = search.best(objective, starts, nothing, 12 if small else 4, round_key)
    return commitment.policy(logits[0])


def best_answer(commitment: Commitment, expert_policy: Float[Array, "T S A_e"]) -> Float[Array, "T S A_l"]:
    """The π_l that earns most against an expert that plays π_e whatever the learner does.

    The game is then a Markov decision process of the learner alone. Backward in t, from V_T = 0,

        q_t(s, a_l) = E_{a_e ~ π_e,t}[r_ld + r_li + γ E V_t+1(s')],   π_l,t chooses a largest one,   V_t = max q_t.
    """
    game = commitment.game

    def backward(values: Array, expert_now: Array) -> tuple[Array, Array]:
        payoff = commitment.learner_reward + game.continuation(values) * commitment.discount
        action_values = only_allowed(payoff.learner_values(expert_now), game.allowed.learner)
        chosen = jax.nn.one_hot(jnp.argmax(action_values, axis=-1), action_values.shape[-1], dtype=values.dtype)
        return game.alive(jnp.max(action_values, axis=-1)), chosen

    return jax.lax.scan(backward, jnp.zeros_like(game.initial), expert_policy, reverse=True)[1]
