"""GSIIRL in continuous games: Algorithm 1 with policy networks, warm-started from one iteration to the next.

For k = 0, …, K − 1, with the forward model a pair of networks π(k) that go on ascending:

    D_k        ← the expert's demonstrations while the learner plays π_l(k)       line 4, into the memory
    θ_e(k+1)   ← t_k projected steps along −((μ_e(π') − μ̂_e(D)) + λθ_e)           lines 5-9
    θ̄_e(k+1)   ← the mean of θ_e(1), …, θ_e(k+1), later ones weighing more (in `paper`: θ_e(k+1) itself)
    θ_l(k+1)   ← the r_ld fitted to the values read (in `paper`: a step along ∇f) lines 11-15
    π(k+1)     ← `solver_steps` steps of the forward model at (θ_l(k+1), θ̄_e(k+1)), from π(k)

Deterministic policies have no likelihood: Lemma 1's gradient is then that of feature matching, with
μ(π) = E[Σ_t γ^t ∇_θ r^θ] in units of `expert_reward.scale`. π' is by `lower_level`

* `played`: (π_l as it was played, the modelled expert's response to it), for every remembered interaction. A response
  starts anew in every iteration from a *clone*, a network that was trained to do what the expert was seen to do against
  π_l. It climbs for some steps under r^θ_e, and then by one more for each step of θ_e. At the true reward a clone has
  nothing to gain, so that the gap vanishes there, however little either expert has trained.
* `equilibrium` (the paper's line 6): the forward model, for the newest demonstrations.

With `played` the forward model's expert goes on from the newest clone when it was far off what was seen: a game may
have several equilibria (who lets whom pass), and the model must be at the one that is played.

With `played` the learner also explores: in every third interaction it plays the policy of a second forward model at
θ_l = 0, which acts for r_li alone. An expert that only meets the policy that the model holds for best need never show
that it would answer another one otherwise.

θ_e swings around what fits, from one set of remembered interactions to the next, and policies that followed it would
swing with it. The mean θ̄_e is the estimate of the expert's reward, and what the forward model follows.

μ_e(π') is taken from the same initial states as D: dynamics and policies are deterministic, so that what is left of the
difference is how the modelled expert differs from the real one, and not which episodes were drawn.
"""

import math
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, PyTree

from gsiirl.equilibria.pathwise import Ascent, Pathwise, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.hypergradients import AbstractEstimator, BilevelProblem
from gsiirl.interaction import AbstractLearner, Proposal
from gsiirl.irl.cloning import cloned
from gsiirl.irl.dependent_reward import LeastSquares
from gsiirl.irl.feature_gap import first_states, gaps_of_episodes, reward_gap
from gsiirl.irl.maximum_likelihood import MaximumLikelihood
from gsiirl.irl.memory import Memory
from gsiirl.learners.bilevel import LowerLevel
from gsiirl.rewards.continuous import AbstractTransitionReward, LinearTransitionReward, TransitionReward, mean_return
from gsiirl.types import Interaction, Sides, Transition

EXPLORING_EVERY = 3
"""One of as many interactions is played for r_li alone, where the learner explores."""

AVERAGING = 3.0
"""θ_e(k) weighs about k^`AVERAGING` in the mean over iterations (Shamir and Zhang 2013, polynomial-decay averaging)."""

FAR = 10.0
"""How many times the sampling noise the forward model's expert may be off before it is set to what was seen."""


class Lived(eqx.Module):
    """One interaction: the policy played, what was seen (axes d, T), and a network that does what the expert did."""

    learner_policy: PolicyNetwork
    demonstrations: Transition
    clone: PolicyNetwork


class GradientSteps(eqx.Module):
    """The paper's upper level: steps of ascent of θ_l along an estimate of ∇f, in the unit ball."""

    estimator: AbstractEstimator
    optimiser: optax.GradientTransformation = eqx.field(static=True)

    def init(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> tuple[Any, optax.OptState]:
        """What the estimator and the optimiser remember before the first step."""
        return self.estimator.init(expert_parameters), self.optimiser.init(commitment)

    def step(
        self,
        problem: BilevelProblem,
        commitment: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        remembered: tuple[Any, optax.OptState],
        key: PRNGKeyArray,
        iteration: Int[Array, ""],
    ) -> tuple[Float[Array, " n"], tuple[Any, optax.OptState]]:
        """θ_l after a step, and what is remembered then."""
        estimating, optimising = remembered
        estimate, estimating = self.estimator.estimate(
            problem, commitment, expert_parameters, estimating, key, iteration
        )
        step, optimising = self.optimiser.update(-estimate.value, optimising, commitment)
        stepped = optax.projections.projection_l2_ball(optax.apply_updates(commitment, step), 1.0)
        return stepped, (estimating, optimising)


class ContinuousState(eqx.Module):
    """What the learner carries from one iteration to the next.

    `commitment` θ_l is the reward to act on; `expert_parameters` θ̄_e the estimate of the expert's; `iterate` θ_e, from
    which the lower level goes on. `solution` is the forward model at (θ_l, θ̄_e); `explorer`, of a learner that
    explores, the one at (0, θ̄_e). `upper` is what `GradientSteps` remember.
    """

    commitment: Float[Array, " n"]
    expert_parameters: Float[Array, " m"]
    iterate: Float[Array, " m"]
    solution: Sides[Ascent]
    explorer: Sides[Ascent] | None
    memory: Memory[Lived]
    accessed: LeastSquares
    upper: tuple[Any, optax.OptState] | None
    lower_optimiser: optax.OptState


class ContinuousLearner(AbstractLearner[ContinuousState]):
    """GSIIRL in a continuous game.

    `own_reward` is r_li; `accessed` reads values of r_ld. The lower level averages over `remembered` interactions, a
    uniform sample of all with the newest in it, in every step over another `compared` of the episodes of each. The
    modelled expert responds to what was played for `model_response_steps` steps, of as many new episodes, before it is
    compared; its clone is trained for `cloning_steps`. Without `upper` θ_l is the fitted r_ld.
    """

    solver: Pathwise
    responder: Pathwise
    own_reward: TransitionReward
    accessed: TransitionReward
    dependent_reward: LinearTransitionReward
    expert_reward: AbstractTransitionReward
    inner_loop: MaximumLikelihood
    upper: GradientSteps | None
    regularisation: float
    trajectories: int = eqx.field(static=True)
    solver_steps: int = eqx.field(static=True)
    model_response_steps: int = eqx.field(static=True)
    cloning_steps: int = eqx.field(static=True)
    remembered: int = eqx.field(static=True)
    compared: int = eqx.field(static=True)
    lower_level: LowerLevel = eqx.field(static=True)

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
            iterate=expert_parameters,
            solution=solution,
            explorer=solution if self.lower_level == "played" else None,
            memory=Memory.empty(self.remembered, Lived(solution.learner.policy, episodes, solution.expert.policy)),
            accessed=LeastSquares.empty(commitment.shape[0], commitment.dtype),
            upper=None if self.upper is None else self.upper.init(commitment, expert_parameters),
            lower_optimiser=self.inner_loop.optimiser.init(expert_parameters),
        )

    def policy(self, state: ContinuousState) -> PolicyNetwork:
        """The learner's half of the forward model."""
        return state.solution.learner.policy

    def propose(self, state: ContinuousState) -> Proposal:
        """Its own policy, or at times, if it explores, that for r_li alone."""
        if state.explorer is None:
            return Proposal(self.policy(state))
        return Proposal(chosen(self.explores(state), state.explorer.learner.policy, self.policy(state)))

    def explores(self, state: ContinuousState) -> Bool[Array, ""]:
        """Whether what it proposes next is not its own policy."""
        if state.explorer is None:
            return jnp.asarray(False)
        return state.memory.count % EXPLORING_EVERY == EXPLORING_EVERY - 1

    def update(self, state: ContinuousState, interaction: Interaction, key: PRNGKeyArray) -> ContinuousState:
        learner_policy, demonstrations = interaction.learner_policy, interaction.demonstrations
        memory_key, lower_key, upper_key, forward_key = jax.random.split(key, 4)
        clone_key, explorer_key = jax.random.split(jax.random.fold_in(key, 4))
        iteration = state.memory.count
        newest = Lived(learner_policy, demonstrations, self._cloned(state, demonstrations, clone_key))
        memory = state.memory.remember(memory_key, newest)
        iterate, lower_optimiser = self._lower(state, memory, lower_key, iteration)
        expert_parameters = self._averaged(state, iterate, iteration)
        accessed = self._read(state.accessed, demonstrations)
        fitted = accessed.solve(self.regularisation)
        commitment, upper = fitted, None
        if self.upper is not None and state.upper is not None:
            problem = self._problem(state.solution, fitted, demonstrations, upper_key)
            commitment, upper = self.upper.step(
                problem, state.commitment, expert_parameters, state.upper, upper_key, iteration
            )
        solution, explorer = self._as_seen(state, newest)
        solution = self._ascend(solution, commitment, expert_parameters, forward_key, self.solver_steps)
        if explorer is not None:
            # It is played in one of as many interactions, and takes as many fewer steps.
            fewer = math.ceil(self.solver_steps / EXPLORING_EVERY)
            explorer = self._ascend(explorer, jnp.zeros_like(fitted), expert_parameters, explorer_key, fewer)
        return ContinuousState(
            commitment=commitment,
            expert_parameters=expert_parameters,
            iterate=iterate,
            solution=solution,
            explorer=explorer,
            memory=memory,
            accessed=accessed,
            upper=upper,
            lower_optimiser=lower_optimiser,
        )

    def fitted_dependent_reward(self, state: ContinuousState) -> Float[Array, " n"]:
        """Parameters of r_ld, by regularised least squares over the values read so far."""
        return state.accessed.solve(self.regularisation)

    def report(self, state: ContinuousState) -> dict[str, Array]:
        """What a history keeps of the last interaction: the estimate after it, and what the learner earned in it."""
        newest = jax.tree.map(lambda leaf: leaf[0], state.memory.kept)
        earned = mean_return(
            lambda seen: self.own_reward(seen) + self.accessed(seen), newest.demonstrations, self.solver.discount
        )
        last = state.memory.count - 1
        exploring = (last % EXPLORING_EVERY == EXPLORING_EVERY - 1) & (state.explorer is not None)
        return {"expert_parameters": state.expert_parameters, "earned": earned, "exploring": exploring}

    def rewards(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Sides[TransitionReward]:
        """r^θ_l + r_li and r^θ_e."""
        return Sides(
            lambda seen: self.dependent_reward(commitment, seen) + self.own_reward(seen),
            lambda seen: self.expert_reward(expert_parameters, seen),
        )

    def _as_seen(self, state: ContinuousState, newest: Lived) -> tuple[Sides[Ascent], Sides[Ascent] | None]:
        """The forward models; the expert of the one that was played does what the real one did, where it was far off.

        Far off: its features differ from those seen by more than `FAR` times what sampling explains,
        ‖mean_i g_i‖² > FAR² Σ_j Var(g_ij) / d, over the gaps g_i of d episodes.
        """
        if state.explorer is None:
            return state.solution, None
        explored, starts = self.explores(state), first_states(newest.demonstrations)
        modelled = chosen(explored, state.explorer.expert.policy, state.solution.expert.policy)
        episodes = episodes_from(self.solver.game, Sides(newest.learner_policy, modelled), starts)
        gaps = gaps_of_episodes(
            self.expert_reward, state.expert_parameters, episodes, newest.demonstrations, self.solver.discount
        )
        sampling = jnp.sum(jnp.var(gaps, axis=0)) / self.trajectories
        far_off = jnp.sum(jnp.mean(gaps, axis=0) ** 2) > FAR**2 * sampling

        def seen(model: Sides[Ascent], played: Bool[Array, ""]) -> Sides[Ascent]:
            policy = chosen(played & far_off, newest.clone, model.expert.policy)
            return Sides(model.learner, Ascent(policy, model.expert.optimiser))

        return seen(state.solution, ~explored), seen(state.explorer, explored)

    def _ascend(
        self, solution: Sides[Ascent], commitment: Array, expert_parameters: Array, key: PRNGKeyArray, steps: int
    ) -> Sides[Ascent]:
        return self.solver.ascend(solution, self.rewards(commitment, expert_parameters), key, steps)[0]

    def _lower(
        self, state: ContinuousState, memory: Memory[Lived], key: PRNGKeyArray, iteration: Int[Array, ""]
    ) -> tuple[Array, optax.OptState]:
        """θ_e and its optimiser's state after t_k steps, with what is compared going on beside it."""
        fitting = (state.iterate, state.lower_optimiser)
        if self.lower_level == "equilibrium":
            newest = jax.tree.map(lambda leaf: leaf[0], memory.kept.demonstrations)

            def one_step(number: Array, carry: tuple[Any, Sides[Ascent]]) -> tuple[Any, Sides[Ascent]]:
                (theta, optimiser), solution = carry
                draw = jax.random.fold_in(key, number)
                solution = self._ascend(solution, state.commitment, theta, draw, self.solver_steps)
                gap = self._gap(
                    theta, episodes_from(self.solver.game, policies_of(solution), first_states(newest)), newest
                )
                return self._fitted(gap, theta, optimiser), solution

            return jax.lax.fori_loop(0, self.inner_loop.steps(iteration), one_step, (fitting, state.solution))[0]

        used_key, fit_key = jax.random.split(key)
        modelled = self.rewards(state.commitment, state.iterate).expert

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

        responses = jax.vmap(lambda lived: self.response(lived, modelled, used_key))(memory.kept)
        return jax.lax.fori_loop(0, self.inner_loop.steps(iteration), one_played_step, (fitting, responses))[0]

    def _averaged(self, state: ContinuousState, iterate: Array, iteration: Int[Array, ""]) -> Array:
        """θ̄_e after iteration k: θ̄_e + (η + 1)/(k + η + 1) (θ_e − θ̄_e), on the sphere where θ_e is."""
        if self.lower_level == "equilibrium":
            return iterate
        share = (AVERAGING + 1.0) / (iteration.astype(iterate.dtype) + AVERAGING + 1.0)
        return self.inner_loop.projected(state.expert_parameters + share * (iterate - state.expert_parameters))

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
        return self._gap(theta, episodes, demonstrations), self.responder.responded(response, gradient)

    def response(self, lived: Lived, reward: TransitionReward, key: PRNGKeyArray) -> Ascent:
        """The modelled expert's response under `reward` to what was played, from what it was seen to do."""
        start = self.responder.init_at(Sides(lived.learner_policy, lived.clone)).expert
        return self.responder.respond(lived.learner_policy, reward, start, key, self.model_response_steps)

    def _cloned(self, state: ContinuousState, demonstrations: Transition, key: PRNGKeyArray) -> PolicyNetwork:
        """A network that does what the expert did, trained on from the one of the interaction before."""
        if self.lower_level == "equilibrium":
            return state.solution.expert.policy
        observations = jax.vmap(jax.vmap(self.solver.game.observe))(demonstrations.state).expert
        start = jax.tree.map(lambda leaf: leaf[0], state.memory.kept.clone)
        return cloned(
            start, observations, demonstrations.actions.expert, key, steps=self.cloning_steps, episodes=self.compared
        )

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
            moved = self._ascend(solution, commitment, expert_parameters, key, self.solver_steps)
            episodes = episodes_from(self.solver.game, policies_of(moved), first_states(demonstrations))
            honest = self.rewards(fitted, expert_parameters).learner
            return mean_return(honest, episodes, self.solver.discount), self._gap(
                expert_parameters, episodes, demonstrations
            )

        return BilevelProblem(evaluate=evaluate, regularisation=self.regularisation)


def chosen(condition: Bool[Array, ""], one: PyTree, other: PyTree) -> PyTree:
    """`one` where the condition holds, else `other`."""
    return jax.tree.map(lambda first, second: jnp.where(condition, first, second), one, other)
