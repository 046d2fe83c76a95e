"""GSIIRL in continuous games: Algorithm 1 with policy networks, warm-started from one iteration to the next.

For k = 0, …, K − 1, with the forward model a pair of networks π(k) that go on ascending:

    D_k        ← the expert's demonstrations while the learner plays π_l(k)       line 4, into the memory
    θ_e(k+1)   ← t_k projected steps along −((μ_e(π') − μ̂_e(D)) + λθ_e)           lines 5-9
    g          ← ∇f at (θ_l(k), θ_e(k+1))                                         lines 11-14
    θ_l(k+1)   ← Proj(θ_l(k) + step of g)                                         line 15
    π(k+1)     ← `solver_steps` steps of the forward model at (θ_l(k+1), θ_e(k+1)), from π(k)

Deterministic policies have no likelihood: Lemma 1's gradient is then that of feature matching, with
μ(π) = E[Σ_t γ^t ∇_θ r^θ] in units of `expert_reward.scale`. π' is by `lower_level`

* `played`: (π_l as it was played, the modelled expert's response to it), for every remembered interaction. In every
  iteration each response starts anew from the forward model's expert, gets used to π_l, and then takes one step of
  ascent for each step of θ_e. (Kept from one iteration to the next it would go on as an earlier θ_e had it, wherever
  the present one hardly cares.)
* `equilibrium` (the paper's line 6): the forward model, for the newest demonstrations.

A policy network needs many steps to settle, so that what a change of θ_l is worth shows late: at first it only costs,
since π_l leaves its best response before the expert has moved. `TwinBranches` therefore keeps two more forward models,
at θ_l ± pΔ, that go on beside π(k) for `period` iterations; then f at them gives a step along Δ, and they start anew
with another Δ. For the first `honest_iterations` θ_l is the r_ld fitted to the values read: while models still lose
their way at times, what the two earn says little of Δ.

An expert that is only ever met by the policy that the model holds for best need never show that it would answer another
one otherwise than the model says. With `exploring` the learner plays, in every third interaction, the policy of a third
forward model beside the branches, at θ_l = 0. It acts for r_li alone, neither spares the expert nor hides from it, and
sees what the expert makes of that.

μ_e(π') is taken from the same initial states as D: dynamics and policies are deterministic, so what is left of the
difference is how the modelled expert differs from the real one, and not which episodes were drawn.
"""

from dataclasses import replace
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, PyTree

from gsiirl.bilevel import LowerLevel
from gsiirl.equilibria.pathwise import (
    Ascent,
    Pathwise,
    TransitionReward,
    episodes_from,
    mean_return,
    policies_of,
)
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.games.rollout import initial_states
from gsiirl.hypergradients import AbstractEstimator, BilevelProblem
from gsiirl.irl.dependent_reward import LeastSquares
from gsiirl.irl.maximum_likelihood import MaximumLikelihood
from gsiirl.irl.memory import Memory
from gsiirl.rewards.continuous import AbstractTransitionReward, LinearTransitionReward
from gsiirl.types import Sides, Transition

EXPLORING_EVERY = 3
"""One of as many interactions is played for r_li alone, where the learner explores."""

Remembering = Literal["latest", "uniform"]
"""Which interactions the lower level averages over: the latest, or a uniform sample of all with the newest in it."""


class Lived(eqx.Module):
    """One interaction: the policy played, and what was seen (axes d, T)."""

    learner_policy: PolicyNetwork
    demonstrations: Transition


class TwinBranches(eqx.Module):
    """∇f by simultaneous perturbation (Spall 1992), from forward models that stay perturbed for `period` iterations.

    In the first `honest_iterations` it is not followed.
    """

    perturbation: float
    period: int = eqx.field(static=True)
    honest_iterations: int = eqx.field(static=True)


class Branches(eqx.Module):
    """The forward models at θ_l + pΔ, at θ_l − pΔ and, to explore by, at 0, along a leading axis; and Δ ∈ {−1, 1}^n."""

    direction: Float[Array, " n"]
    solutions: Sides[Ascent]


class ContinuousState(eqx.Module):
    """What the learner carries from one iteration to the next.

    `commitment` θ_l is the reward to act on; `solution` the forward model at (θ_l, θ_e).
    """

    commitment: Float[Array, " n"]
    expert_parameters: Float[Array, " m"]
    solution: Sides[Ascent]
    memory: Memory[Lived]
    accessed: LeastSquares
    upper_optimiser: optax.OptState
    lower_optimiser: optax.OptState
    hypergradient: Any


class ContinuousGSIIRL(eqx.Module):
    """GSIIRL in a continuous game.

    `own_reward` is r_li; `accessed` reads values of r_ld. The lower level averages over `remembered` interactions, in
    every step over another `compared` of the episodes of each; `remembering` says which these are. The modelled expert
    gets used to what was played for `model_response_steps` steps, of as many new episodes, before it is compared.
    """

    solver: Pathwise
    own_reward: TransitionReward
    accessed: TransitionReward
    dependent_reward: LinearTransitionReward
    expert_reward: AbstractTransitionReward
    inner_loop: MaximumLikelihood
    hypergradient: AbstractEstimator | TwinBranches
    regularisation: float
    trajectories: int = eqx.field(static=True)
    optimiser: optax.GradientTransformation = eqx.field(static=True)
    solver_steps: int = eqx.field(static=True)
    model_response_steps: int = eqx.field(static=True)
    remembered: int = eqx.field(static=True)
    compared: int = eqx.field(static=True)
    lower_level: LowerLevel = eqx.field(static=True)
    remembering: Remembering = eqx.field(static=True)
    exploring: bool = eqx.field(static=True)

    def init(self, key: PRNGKeyArray) -> ContinuousState:
        """Random parameters in the unit ball, and random policies."""
        commitment_key, expert_key, policy_key = jax.random.split(key, 3)
        commitment = self.dependent_reward.initial_parameters(commitment_key)
        expert_parameters = self.expert_reward.initial_parameters(expert_key)
        solution = self.solver.init(policy_key)
        starts = initial_states(self.solver.game, policy_key, self.trajectories)
        episodes = episodes_from(self.solver.game, policies_of(solution), starts)
        return ContinuousState(
            commitment=commitment,
            expert_parameters=expert_parameters,
            solution=solution,
            memory=Memory.empty(self.remembered, Lived(solution.learner.policy, episodes)),
            accessed=LeastSquares.empty(commitment.shape[0], commitment.dtype),
            upper_optimiser=self.optimiser.init(commitment),
            lower_optimiser=self.inner_loop.optimiser.init(expert_parameters),
            hypergradient=Branches(jnp.ones_like(commitment), repeated(solution, 3 if self.exploring else 2))
            if isinstance(self.hypergradient, TwinBranches)
            else self.hypergradient.init(expert_parameters),
        )

    def policy(self, state: ContinuousState) -> PolicyNetwork:
        """The learner's half of the forward model."""
        return state.solution.learner.policy

    def propose(self, state: ContinuousState) -> PolicyNetwork:
        """The policy that the learner wants to play next: its own, or at times, if it explores, that for r_li alone."""
        if not self._may_explore:
            return self.policy(state)
        alone = jax.tree.map(lambda leaf: leaf[2], state.hypergradient.solutions.learner.policy)
        return chosen(self.explores(state), alone, self.policy(state))

    def explores(self, state: ContinuousState) -> Bool[Array, ""]:
        """Whether what it wants to play next is not its own policy."""
        return (state.memory.count % EXPLORING_EVERY == EXPLORING_EVERY - 1) & self._may_explore

    @property
    def _may_explore(self) -> bool:
        return self.exploring and isinstance(self.hypergradient, TwinBranches)

    def update(
        self, state: ContinuousState, learner_policy: PolicyNetwork, demonstrations: Transition, key: PRNGKeyArray
    ) -> ContinuousState:
        """One iteration of learning from one interaction; the expert's reward is not among what is passed."""
        memory_key, lower_key, upper_key, forward_key = jax.random.split(key, 4)
        iteration = state.memory.count
        newest = Lived(learner_policy, demonstrations)
        if self.remembering == "latest":
            memory = state.memory.remember_latest(newest)
        else:
            memory = state.memory.remember(memory_key, newest)
        expert_parameters, lower_optimiser = self._lower(state, memory, lower_key, iteration)
        accessed = self._read(state.accessed, demonstrations)
        fitted = accessed.solve(self.regularisation)
        if isinstance(self.hypergradient, TwinBranches):
            commitment, upper_optimiser, hypergradient = self._upper_by_branches(
                self.hypergradient, state, expert_parameters, fitted, demonstrations, upper_key, iteration
            )
        else:
            problem = self._problem(state.solution, fitted, demonstrations, upper_key)
            estimate, hypergradient = self.hypergradient.estimate(
                problem, state.commitment, expert_parameters, state.hypergradient, upper_key, iteration
            )
            commitment, upper_optimiser = self._stepped(state, estimate.value)
        solution, _ = self._ascend(state.solution, commitment, expert_parameters, forward_key)
        return ContinuousState(
            commitment=commitment,
            expert_parameters=expert_parameters,
            solution=solution,
            memory=memory,
            accessed=accessed,
            upper_optimiser=upper_optimiser,
            lower_optimiser=lower_optimiser,
            hypergradient=hypergradient,
        )

    def fitted_dependent_reward(self, state: ContinuousState) -> Float[Array, " n"]:
        """Parameters of r_ld, by regularised least squares over the values read so far."""
        return state.accessed.solve(self.regularisation)

    def rewards(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Sides[TransitionReward]:
        """r^θ_l + r_li and r^θ_e."""
        return Sides(
            lambda seen: self.dependent_reward(commitment, seen) + self.own_reward(seen),
            lambda seen: self.expert_reward(expert_parameters, seen),
        )

    def _ascend(
        self, solution: Sides[Ascent], commitment: Array, expert_parameters: Array, key: PRNGKeyArray
    ) -> tuple[Sides[Ascent], Any]:
        return self.solver.ascend(solution, self.rewards(commitment, expert_parameters), key, self.solver_steps)

    def _stepped(self, state: ContinuousState, gradient: Float[Array, " n"]) -> tuple[Array, optax.OptState]:
        """θ_l after a projected step of ascent along ∇f, and the optimiser's state."""
        step, optimiser = self.optimiser.update(-gradient, state.upper_optimiser, state.commitment)
        return optax.projections.projection_l2_ball(optax.apply_updates(state.commitment, step), 1.0), optimiser

    def _upper_by_branches(
        self,
        settings: TwinBranches,
        state: ContinuousState,
        expert_parameters: Array,
        fitted: Array,
        demonstrations: Transition,
        key: PRNGKeyArray,
        iteration: Int[Array, ""],
    ) -> tuple[Array, optax.OptState, Branches]:
        """θ_l, the optimiser's state and the branches after this iteration.

        θ_l is the fit in the honest iterations; then it moves where a period ends.
        """
        ascent_key, direction_key = jax.random.split(key)
        branches: Branches = state.hypergradient
        offset = settings.perturbation * branches.direction
        commitments = jnp.stack([state.commitment + offset, state.commitment - offset])
        if self.exploring:
            commitments = jnp.concatenate([commitments, jnp.zeros_like(offset)[None]])

        def on(solution: Sides[Ascent], commitment: Array) -> tuple[Sides[Ascent], Array]:
            # The same key for all: what differs between them is θ_l alone.
            after, _ = self._ascend(solution, commitment, expert_parameters, ascent_key)
            episodes = episodes_from(self.solver.game, policies_of(after), first_states(demonstrations))
            honest = self.rewards(fitted, expert_parameters).learner
            return after, mean_return(honest, episodes, self.solver.discount)

        solutions, values = jax.vmap(on)(branches.solutions, commitments)
        slope = (values[0] - values[1]) / (2.0 * settings.perturbation)
        stepped = self._stepped(state, slope * branches.direction)
        is_honest, ends = iteration < settings.honest_iterations, (iteration + 1) % settings.period == 0
        commitment, optimiser = chosen(ends & ~is_honest, stepped, (state.commitment, state.upper_optimiser))
        direction = jax.random.rademacher(direction_key, branches.direction.shape, branches.direction.dtype)
        begun = jax.tree.map(lambda old, new: old.at[:2].set(new), solutions, state.solution)
        renewed = Branches(direction, begun)
        kept = Branches(branches.direction, solutions)
        return jnp.where(is_honest, fitted, commitment), optimiser, chosen(ends, renewed, kept)

    def _lower(
        self, state: ContinuousState, memory: Memory[Lived], key: PRNGKeyArray, iteration: Int[Array, ""]
    ) -> tuple[Array, optax.OptState]:
        """θ_e and its optimiser's state after t_k steps, with what is compared going on beside it."""
        fitting = (state.expert_parameters, state.lower_optimiser)
        if self.lower_level == "equilibrium":
            newest = jax.tree.map(lambda leaf: leaf[0], memory.kept.demonstrations)

            def one_step(number: Array, carry: tuple[Any, Sides[Ascent]]) -> tuple[Any, Sides[Ascent]]:
                (theta, optimiser), solution = carry
                solution, _ = self._ascend(solution, state.commitment, theta, jax.random.fold_in(key, number))
                gap = self._gap(
                    theta, episodes_from(self.solver.game, policies_of(solution), first_states(newest)), newest
                )
                return self._fitted(gap, theta, optimiser), solution

            return jax.lax.fori_loop(0, self.inner_loop.steps(iteration), one_step, (fitting, state.solution))[0]

        used_key, fit_key = jax.random.split(key)
        modelled = self.rewards(state.commitment, state.expert_parameters).expert

        responder = replace(self.solver, batch=self.compared)

        def used_to(played: PolicyNetwork) -> Ascent:
            return responder.respond(played, modelled, state.solution.expert, used_key, self.model_response_steps)

        def one_played_step(number: Array, carry: tuple[Any, Ascent]) -> tuple[Any, Ascent]:
            (theta, optimiser), responses = carry
            draw = jax.random.fold_in(fit_key, number)
            looked_at = jax.random.choice(draw, self.trajectories, (self.compared,), replace=False)

            def one(lived: Lived, response: Ascent) -> tuple[Array, Ascent]:
                seen = jax.tree.map(lambda leaf: leaf[looked_at], lived.demonstrations)
                return self._respond(theta, lived.learner_policy, seen, response)

            gaps, responses = jax.vmap(one)(memory.kept, responses)
            gap = jnp.mean(gaps, axis=0, where=memory.filled[:, None])
            return self._fitted(gap, theta, optimiser), responses

        responses = jax.vmap(used_to)(memory.kept.learner_policy)
        return jax.lax.fori_loop(0, self.inner_loop.steps(iteration), one_played_step, (fitting, responses))[0]

    def _fitted(self, gap: Array, theta: Array, optimiser: optax.OptState) -> tuple[Array, optax.OptState]:
        """θ_e and its optimiser's state after one step along the gap and the regularisation."""
        return self.inner_loop.step(gap + self.regularisation * theta, theta, optimiser)

    def _respond(
        self, theta: Array, learner_policy: PolicyNetwork, demonstrations: Transition, response: Ascent
    ) -> tuple[Array, Ascent]:
        """The gap of a remembered interaction under θ_e, and the response one step on."""
        starts = first_states(demonstrations)

        def value(policy: PolicyNetwork) -> tuple[Array, Transition]:
            episodes = episodes_from(self.solver.game, Sides(learner_policy, policy), starts)
            return mean_return(lambda seen: self.expert_reward(theta, seen), episodes, self.solver.discount), episodes

        gradient, episodes = jax.grad(value, has_aux=True)(response.policy)
        return self._gap(theta, episodes, demonstrations), self.solver.responded(response, gradient)

    def _gap(self, theta: Array, modelled: Transition, demonstrated: Transition) -> Float[Array, " m"]:
        return reward_gap(self.expert_reward, theta, modelled, demonstrated, self.solver.discount)

    def _read(self, accessed: LeastSquares, demonstrations: Transition) -> LeastSquares:
        """The normal equations with the values of r_ld along `demonstrations`."""
        gradients = self.dependent_reward.scale * jax.vmap(jax.vmap(self.dependent_reward.features))(demonstrations)
        values = jax.vmap(jax.vmap(self.accessed))(demonstrations)
        return accessed.add(gradients, values, jnp.ones_like(values))

    def _problem(
        self, solution: Sides[Ascent], fitted: Array, demonstrations: Transition, key: PRNGKeyArray
    ) -> BilevelProblem:
        """Both levels around the forward model's present state, with common random numbers.

        f is taken with the fitted r_ld: values of r_ld can be read, but not differentiated.
        """

        def evaluate(commitment: Array, expert_parameters: Array) -> tuple[Array, Array]:
            moved, _ = self._ascend(solution, commitment, expert_parameters, key)
            episodes = episodes_from(self.solver.game, policies_of(moved), first_states(demonstrations))
            honest = self.rewards(fitted, expert_parameters).learner
            return mean_return(honest, episodes, self.solver.discount), self._gap(
                expert_parameters, episodes, demonstrations
            )

        return BilevelProblem(evaluate=evaluate, regularisation=self.regularisation)


def repeated(tree: PyTree, number: int) -> PyTree:
    """`number` copies, along a leading axis."""
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (number, *leaf.shape)), tree)


def chosen(condition: Bool[Array, ""], one: PyTree, other: PyTree) -> PyTree:
    """`one` where the condition holds, else `other`."""
    return jax.tree.map(lambda first, second: jnp.where(condition, first, second), one, other)


def first_states(episodes: Transition) -> PyTree:
    """The initial states of episodes (axes d, T)."""
    return jax.tree.map(lambda leaf: leaf[:, 0], episodes.state)


def reward_gap(
    reward: AbstractTransitionReward,
    parameters: Float[Array, " m"],
    modelled: Transition,
    demonstrated: Transition,
    discount: float,
) -> Float[Array, " m"]:
    """(μ(modelled) − μ(demonstrated)) / scale with μ = (1/d) Σ_i Σ_t γ^t ∇_θ r^θ, in features for a linear reward."""

    def difference(theta: Array) -> Array:
        modelled_return, demonstrated_return = (
            mean_return(lambda seen: reward(theta, seen), episodes, discount) for episodes in (modelled, demonstrated)
        )
        return modelled_return - demonstrated_return

    return jax.grad(difference)(parameters) / reward.scale
