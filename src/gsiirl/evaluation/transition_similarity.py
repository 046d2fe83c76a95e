"""How alike two rewards of a continuous game are, over sampled transitions.

| measure | compares | invariant under |
|---|---|---|
| Pearson ρ | r(s, a, s') | scale, a constant |
| Spearman | ranks of r(s, a, s') | every increasing function |
| EPIC (Gleave et al. 2021) | as Pearson, √((1 − ρ)/2), for rewards of (a, s') alone | scale, a constant |
| STARC (Skalse et al. 2024) | c(r) = r(s, a, s') + γ V(s') − V(s), V of random play | scale, potential shaping |
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.evaluation.rank_correlation import spearman as of_ranks
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides, Transition

PLAYS = 8
"""Random plays that a value is the mean over."""


def pearson(first: TransitionReward, second: TransitionReward, sample: Transition) -> Float[Array, ""]:
    """Pearson correlation of two rewards over a sample of transitions (axis n); 0 where one of them is constant."""
    values = jnp.stack([jax.vmap(first)(sample), jax.vmap(second)(sample)])
    centred = values - jnp.mean(values, axis=1, keepdims=True)
    return _cosine(centred[0], centred[1])


def spearman(first: TransitionReward, second: TransitionReward, sample: Transition) -> Float[Array, ""]:
    """Correlation of the ranks of two rewards over a sample of transitions (axis n); 0 where one is constant."""
    return of_ranks(jax.vmap(first)(sample), jax.vmap(second)(sample))


def epic(correlation: Float[Array, ""]) -> Float[Array, ""]:
    """EPIC distance √((1 − ρ)/2) of two rewards that depend on (a, s') alone (Gleave et al. 2021).

    With S, A and S' independent, canonicalisation then only subtracts a constant, so that ρ is the correlation over
    independent a and s'.
    """
    return jnp.sqrt(jnp.maximum(1.0 - correlation, 0.0) / 2.0)


def starc(
    first: TransitionReward,
    second: TransitionReward,
    game: AbstractContinuousGame,
    states: PyTree,
    key: PRNGKeyArray,
    discount: float,
) -> Float[Array, ""]:
    """STARC distance ½‖c/‖c‖ − c'/‖c'‖‖ ∈ [0, 1] of two rewards, from `states` (axis n) and one random action in each.

        c(r)(s, a, s') = r(s, a, s') + γ V_{T−1}(s') − V_T(s),     V_k(s) = E[Σ_{j<k} γ^j r_j] of random play from s

    V is estimated over `PLAYS` plays, with the same actions for every state and for both rewards; T is the game's
    horizon. Scale, a constant and shaping by a potential that vanishes after T steps change nothing. Actions are
    uniform in [−1, 1]^A.
    """
    leaves, sizes, horizon = jax.tree.leaves(states), game.action_size, game.horizon
    number = leaves[0].shape[0]
    dtype = next(leaf.dtype for leaf in leaves if jnp.issubdtype(leaf.dtype, jnp.floating))
    now_key, later_key = jax.random.split(key)

    def drawn(key: PRNGKeyArray, *shape: int) -> Sides[Array]:
        both = jax.random.uniform(key, (*shape, sizes.learner + sizes.expert), dtype, -1.0, 1.0)
        return Sides(*jnp.split(both, [sizes.learner], axis=-1))

    def values(seen: Transition) -> Float[Array, "2"]:
        return jnp.stack([first(seen), second(seen)])

    def one_step(state: PyTree, actions: Sides[Array]) -> tuple[PyTree, Array]:
        following = game.step(state, actions)
        return following, values(Transition(state, actions, following))

    plays = drawn(later_key, PLAYS, horizon)

    def worth(state: PyTree, steps: int) -> Float[Array, "2"]:
        weights = discount ** jnp.arange(steps, dtype=dtype)
        played = jax.vmap(lambda actions: weights @ jax.lax.scan(one_step, state, actions)[1])
        return jnp.mean(played(jax.tree.map(lambda leaf: leaf[:, :steps], plays)), axis=0)

    def canonical(state: PyTree, actions: Sides[Array]) -> Float[Array, "2"]:
        following, value = one_step(state, actions)
        return value + discount * worth(following, horizon - 1) - worth(state, horizon)

    compared = jax.vmap(canonical)(states, drawn(now_key, number))
    norms = jnp.linalg.norm(compared, axis=0)
    directions = compared / jnp.where(norms > 0, norms, 1.0)[None, :]
    # As far as from an unrelated reward, where one of them is like nothing.
    return jnp.where(jnp.min(norms) > 0, 0.5 * jnp.linalg.norm(directions[:, 0] - directions[:, 1]), 0.5**0.5)


def _cosine(first: Float[Array, " n"], second: Float[Array, " n"]) -> Float[Array, ""]:
    scale = jnp.linalg.norm(first) * jnp.linalg.norm(second)
    return jnp.where(scale > 0, jnp.vdot(first, second) / jnp.where(scale > 0, scale, 1.0), 0.0)
