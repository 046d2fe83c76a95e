"""The factors of the hypergradient at the cost that the paper's appendix A.9 counts, with the right numbers.

A.9 walks the state frequencies from s_t step by step up to each t' > t, and begins again at s_t for the next t':

    E[g_t' | s_t = s] = (P_t P_{t+1} ⋯ P_{t'−1} g_t')(s),     t' = t, …, T − 1

with P_t (S, S) and g_t (S, k) the dynamics and the k quantities summed, under the joint policy. That takes O(T²) steps
for μ_i(s_t), and O(T³) where μ_i(s_t) stands in a sum over t. Going backward in t once gives the same numbers in T
steps: that is `SoftJointModel`.

To the paper's advantage one walk serves μ_l, μ_e and J alike, walks begin at states and not at state-action pairs, the
joint policy comes from one backward pass, and all t walk side by side.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.theory.support.direct import LemmaThree, LemmaThreeProblem, Tables
from gsiirl.theory.support.soft_joint_model import SoftJointModel


def printed_problem(model: SoftJointModel, demonstrations: Float[Array, "T S A_l A_e"]) -> LemmaThreeProblem:
    """The bilevel problem of `model`; `Direct` and `SPSA` on it cost O(T³) and O(T²), as the paper says."""
    game = model.instance.game

    def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
        increments, joint = _increments(model, learner, expert), model.solve(learner, expert).joint
        transitions, expected = _under(model, joint, increments)
        ((totals,),) = recomputed(jnp.asarray(game.initial)[None, None, :], transitions, expected, model.discount)
        demonstrated = model.expert_expectation(demonstrations, expert)
        return totals[-1], (totals[learner.size : -1] - demonstrated) / model.temperature

    def lemma_three(learner: Array, expert: Array) -> LemmaThree:
        increments, joint = _increments(model, learner, expert), model.solve(learner, expert).joint
        transitions, expected = _under(model, joint, increments)
        everywhere = jnp.broadcast_to(jnp.eye(game.number_of_states, dtype=joint.dtype), transitions.shape)
        means = recomputed(everywhere, transitions, expected, model.discount)
        following = jnp.concatenate([means[1:], jnp.zeros_like(means[:1])])
        onwards = jnp.einsum("sabp,tpk->tsabk", _dynamics(model), following)
        values = increments[None] + model.discount * onwards
        n = learner.size
        return replace(
            model.lemma_three(learner, expert, demonstrations),
            learner=Tables(values[..., :n], means[..., :n]),
            expert=Tables(values[..., n:-1], means[..., n:-1]),
            returns=values[..., -1],
        )

    return LemmaThreeProblem(evaluate=evaluate, regularisation=model.regularisation, lemma_three=lemma_three)


def recomputed(
    starts: Float[Array, "L R S"],
    transitions: Float[Array, "T S S"],
    increments: Float[Array, "T S k"],
    discount: float,
) -> Float[Array, "L R k"]:
    """E[Σ_{t' ≥ t} γ^{t'−t} g_t'] for s_t ~ `starts[t, r]`, t = 0, …, L − 1: T(T − 1)/2 steps one after another.

    For each distance t' − t the frequencies are walked from the start again, for all L times at once. For L = T these
    are less than T³/2 steps, where A.9 counts T³. A walk that passes the horizon finds neither states nor increments.
    """
    number, horizon = starts.shape[0], transitions.shape[0]
    padded_transitions = jnp.concatenate([transitions, jnp.zeros_like(transitions)])
    padded_increments = jnp.concatenate([increments, jnp.zeros_like(increments)])
    # Distance by distance, the positions on the way in order.
    distances, positions = (jnp.asarray(each) for each in np.tril_indices(horizon, k=-1))

    def step(carry, now):
        frequencies, total = carry
        distance, position = now
        frequencies = jnp.where(position == 0, starts, frequencies)
        frequencies = frequencies @ jax.lax.dynamic_slice_in_dim(padded_transitions, position, number)

        def arrived():
            reached = jax.lax.dynamic_slice_in_dim(padded_increments, distance, number)
            return total + discount ** distance.astype(total.dtype) * (frequencies @ reached)

        return (frequencies, jax.lax.cond(position == distance - 1, arrived, lambda: total)), None

    (_, total), _ = jax.lax.scan(step, (starts, starts @ increments[:number]), (distances, positions))
    return total


def _increments(
    model: SoftJointModel, learner: Float[Array, " n"], expert: Float[Array, " m"]
) -> Float[Array, "S A_l A_e k"]:
    """Side by side: ∇r_ld (n), ∇r_e (m), and the learner's reward with the accessed values of r_ld."""
    reward = model.instance.accessed + model.instance.own_reward
    return jnp.concatenate(
        [jax.jacfwd(model.dependent_reward)(learner), jax.jacfwd(model.expert_reward)(expert), reward[..., None]],
        axis=-1,
    )


def _dynamics(model: SoftJointModel) -> Float[Array, "S A_l A_e S"]:
    """P(s'|s, a)."""
    game = model.instance.game
    each = jnp.eye(game.number_of_states, dtype=game.initial.dtype)
    return jnp.moveaxis(jax.vmap(lambda values: game.continuation(values).dense())(each), 0, -1)


def _under(
    model: SoftJointModel, joint: Float[Array, "T S A_l A_e"], increments: Float[Array, "S A_l A_e k"]
) -> tuple[Float[Array, "T S S"], Float[Array, "T S k"]]:
    """P_t and g_t."""
    return (
        jnp.einsum("tsab,sabp->tsp", joint, _dynamics(model)),
        jnp.einsum("tsab,sabk->tsk", joint, increments),
    )
