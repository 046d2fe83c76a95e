"""The linear programs of Lin et al. 2019 (uNE) and 2018 (advE): rewards under which what was shown is an equilibrium.

Watching alone, once: the joint policy π is estimated from demonstrations, and every condition on a reward is linear,
because π is data. Here in finite horizon. With r_i = θ_i·φ_i + k_i (k_i known), and backward from V_i,T = 0,

    Q_i,t(s, a) = r_i(s, a) + γ E[V_i,t+1(s')|s, a]                          D_π r_i, one entry for each (t, s, a)
    V_i,t(s)    = Σ_a π_l,t(a_l|s) π_e,t(a_e|s) Q_i,t(s, a)                   B_π D_π r_i

both are linear in θ_i. B_{π|a_i} averages as B_π does, but with a_i in place of side i's own choice, and π is a Nash
equilibrium where

    ((B_{π|a_i} − B_π) D_π r_i)_t(s) = E_{a_−i ~ π_−i,t}[Q_i,t(s, a_i, a_−i)] − V_i,t(s) ≤ 0    for all i, t, s, a_i

One row each; call it A_i,t(s, a_i)·θ_i + (that of k_i). Rewards of 0 satisfy all, and soft or sampled play satisfies
them for no other, so there is something to be made large and something to be paid. With w_t(s) the discounted share of
episodes that are in s at t, m_i = −A_i·θ_i − … the margin of a row, and the mean over the actions of a side,

    max_θ  Σ_i Σ_t,s w_t(s) mean_{a_i} (m_i − C max(0, −m_i))  −  Σ_t,s w_t(s) max_a (Σ_i Q_i,t(s, a) − V_i,t(s))
    over  |θ_ij| ≤ bound

The first sum is the scale of the solution and the price of its violations, the second the gap to what both together
could have by another joint action (the `utilitarian` in uNE). In `zero_sum` (advE) r_l = −θ·φ_e + k_l with the expert's
own θ, and the gap is no matter of θ.

Lin, Adams and Beling, "Multi-agent inverse reinforcement learning for certain general-sum stochastic games", JAIR 66,
2019; Lin, Beling and Cogill, "Multi-agent inverse reinforcement learning for two-person zero-sum games", IEEE
Transactions on Games, 2018. Linear features, the horizon, C and the equal weights of scale and gap are ours: this is no
reproduction. A soft expert violates these rows by its nature, and is read poorly.
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy import sparse
from scipy.linalg import block_diag
from scipy.optimize import linprog

from gsiirl.games.base import AbstractTabularGame, only_allowed, uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.irl.estimated_policy import estimated_policy
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.types import Policies, Sides, Trajectories

TINY = 1e-7
"""What a weight costs, in units of the objective: one that no row tells is 0."""
ROUNDS = 100
"""Times that joint actions are added to the program."""


class Rows(eqx.Module):
    """What each deviation brings under one reward: `learner` and `expert` alone, and both together (`joint`)."""

    learner: Float[Array, "*mT S A_l"]
    expert: Float[Array, "*mT S A_e"]
    joint: Float[Array, "*mT S A_l A_e"]


class Lin2019(eqx.Module):
    """The program for one game; `features` are φ_l and φ_e, `own_reward` is k_l = r_li, and k_e = 0.

    `bound` is on every weight, in reward units. `violation_weight` is C. With `zero_sum` the learner's features are not
    read. In double precision.
    """

    game: AbstractTabularGame
    own_reward: AbstractPayoff
    features: Sides[AbstractFeatures]
    discount: float
    bound: float
    violation_weight: float
    zero_sum: bool = eqx.field(static=True, default=False)

    def estimate(self, demonstrations: Trajectories) -> tuple[Policies, Float[Array, "T S"]]:
        """Both sides' policies, uniform where nothing was seen, and w: the discounted share of episodes in s at t."""
        states, actions = demonstrations.states, demonstrations.actions
        game, dtype = self.game, self.game.initial.dtype
        steps = jnp.broadcast_to(jnp.arange(game.horizon, dtype=states.dtype), states.shape)
        counted = demonstrations.mask.astype(dtype)
        visits = jnp.zeros((game.horizon, game.number_of_states), dtype).at[steps, states].add(counted)
        learner = estimated_policy(states, actions.learner, uniform_policy(game))
        expert = estimated_policy(states, actions.expert, _uniform_expert(game))
        discounts = self.discount ** jnp.arange(game.horizon, dtype=dtype)
        return Sides(learner, expert), discounts[:, None] * visits / states.shape[0]

    def rows(self, policies: Policies, reward: AbstractPayoff) -> Rows:
        """(B_{π|a_i} − B_π) D_π r for either side's a_i, and (I − B_π) D_π r."""

        def backward(values: Array, now: Policies) -> tuple[Array, Rows]:
            action_values = reward + self.game.continuation(values) * self.discount
            value = action_values.expected(now.learner, now.expert)
            learner = action_values.learner_values(now.expert) - value[:, None]
            expert = action_values.expert_values(now.learner) - value[:, None]
            return self.game.alive(value), Rows(learner, expert, action_values.dense() - value[:, None, None])

        return jax.lax.scan(backward, jnp.zeros_like(self.game.initial), policies, reverse=True)[1]

    def learn(self, policies: Policies, visits: Float[Array, "T S"]) -> Sides[Float[Array, "..."]]:
        """θ_l and θ_e, in reward units; NaN where the program finds none. With `zero_sum` θ_l is θ_e."""

        def of_features(features: AbstractFeatures) -> Rows:
            each = jnp.eye(features.number, dtype=visits.dtype)
            return jax.vmap(lambda weights: self.rows(policies, features.payoff(weights)))(each)

        known = self.rows(policies, self.own_reward)
        expert = of_features(self.features.expert)
        number = expert.expert.shape[0]
        if self.zero_sum:
            # One θ for both: the learner's rows are minus those of the expert's reward for the learner's actions.
            learner, joint = -expert.learner, known.joint[None][:0]
            sizes = (0, number)
        else:
            other = of_features(self.features.learner)
            learner, joint = other.learner, jnp.concatenate([other.joint, expert.joint])
            sizes = (other.learner.shape[0], number)
        given = (
            learner,
            known.learner,
            expert.expert,
            joint,
            known.joint,
            visits[:, :, None] * uniform_policy(self.game),
            visits[:, :, None] * _uniform_expert(self.game),
            visits,
            jnp.asarray(self.bound, visits.dtype),
            jnp.asarray(self.violation_weight, visits.dtype),
        )
        bits = jax.pure_callback(
            _solve_in_bits,
            jax.ShapeDtypeStruct((sum(sizes), 2), jnp.uint32),
            *(jax.lax.bitcast_convert_type(each, jnp.uint32) for each in given),
            vmap_method="sequential",
        )
        found = jax.lax.bitcast_convert_type(bits, visits.dtype)
        return Sides(found if self.zero_sum else found[: sizes[0]], found[sizes[0] :])


def _uniform_expert(game: AbstractTabularGame) -> Float[Array, "T S A_e"]:
    """The expert's policy that chooses every allowed action equally often."""
    shape = (game.horizon, game.number_of_states, game.number_of_actions.expert)
    return jax.nn.softmax(only_allowed(jnp.zeros(shape, game.initial.dtype), game.allowed.expert), axis=-1)


def _solve_in_bits(*bits: Any) -> np.ndarray:
    """`_solve` of numbers of double precision as pairs of whole ones: JAX calls back in a thread without the former."""
    found = _solve(*(np.ascontiguousarray(each).view(np.float64)[..., 0] for each in bits))
    return found.view(np.uint32).reshape(-1, 2)


def _solve(
    learner: np.ndarray,
    known: np.ndarray,
    expert: np.ndarray,
    joint: np.ndarray,
    joint_known: np.ndarray,
    learner_weights: np.ndarray,
    expert_weights: np.ndarray,
    visits: np.ndarray,
    bound: np.ndarray,
    violation_weight: np.ndarray,
) -> np.ndarray:
    """The program's weights (θ_l, θ_e), or θ where both are one; NaN where it has none.

    By its dual, which has a row for each weight and not for each deviation. With A θ + k the rows of side i's own
    deviations, w their weights, and G θ + c those of joint ones, it is

        max_{y, z} k·y + c·z − bound ‖A'y + G'z‖₁    over w ≤ y ≤ (1 + C) w,  z ≥ 0,  Σ_a z_t(s, a) ≤ w_t(s)

    and θ are the multipliers of A'y + G'z = p − q, p, q ≥ 0. Columns of G' come in where they are missed.
    """
    counted, here = (learner_weights > 0, expert_weights > 0), visits > 0
    blocks = learner[:, counted[0]], expert[:, counted[1]]
    own: Any = np.concatenate(blocks, axis=1) if len(joint) == 0 else block_diag(*blocks)
    paid = np.concatenate([learner_weights[counted[0]], expert_weights[counted[1]]])
    constant = np.concatenate([known[counted[0]], np.zeros(blocks[1].shape[1])])
    number, gaps = len(own), int(here.sum())
    others = joint[:, here].reshape(len(joint), gaps, known.shape[-1] * expert.shape[-1])
    others_known = joint_known[here].reshape(gaps, others.shape[2])
    # The unknowns are y, p, q, what is left of a sum that is nearly 0, and z.
    balance = np.concatenate([own, -np.eye(number), np.eye(number), np.eye(number)], axis=1)
    cost = np.concatenate([-constant, np.full(2 * number, float(bound)), np.zeros(number)])
    lower = np.concatenate([paid, np.zeros(2 * number), np.full(number, -TINY)])
    upper = np.concatenate([(1.0 + float(violation_weight)) * paid, np.full(2 * number, np.inf), np.full(number, TINY)])
    shares = sparse.csr_matrix((gaps, len(cost)))
    for _ in range(ROUNDS):
        solution: Any = linprog(
            cost,
            A_ub=shares,
            b_ub=visits[here],
            A_eq=sparse.csr_matrix(balance),
            b_eq=np.zeros(number),
            bounds=np.stack([lower, upper], axis=1),
        )
        if solution.status != 0:
            break
        weights = solution.eqlin.marginals
        if len(joint) == 0:
            return weights
        gained = np.einsum("m,mga->ga", weights, others) + others_known
        best = gained.argmax(1)
        missed = np.flatnonzero(gained.max(1) > -solution.ineqlin.marginals + 1e-9 * float(bound))
        if len(missed) == 0:
            return weights
        balance = np.concatenate([balance, others[:, missed, best[missed]]], axis=1)
        cost = np.concatenate([cost, -others_known[missed, best[missed]]])
        lower, upper = np.pad(lower, (0, len(missed))), np.pad(upper, (0, len(missed)), constant_values=np.inf)
        chosen = sparse.csr_matrix((np.ones(len(missed)), (missed, np.arange(len(missed)))), (gaps, len(missed)))
        shares = sparse.hstack([shares, chosen], "csr")
    return np.full(number, np.nan)
