"""GSIIRL with a reward for a commitment: Algorithm 1 of the paper, mended where docs/deviations.md says.

For k = 0, …, K − 1:

    D_k        ← the expert's demonstrations while the learner plays π_l(k)       line 4, into the memory
    θ_e(k+1)   ← t_k projected gradient steps on L, warm-started at θ_e(k)        lines 5-9
    θ          ← θ_l(k); with `honest_start` the r_ld fitted to the values read,
                 where f(·, θ_e(k+1)) is greater there
    g          ← ∇f at (θ, θ_e(k+1)), by an estimator of `gsiirl.hypergradients`  lines 11-14
    θ_l(k+1)   ← Proj(θ + step of g)                                              line 15, ascent

with f(θ_l, θ_e) and L as `gsiirl.learners.bilevel` defines them. Two presets: `RewardGSIIRL.create` and
`RewardGSIIRL.paper`.
"""

from collections import deque
from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray

from gsiirl.equilibria.base import AbstractSolution
from gsiirl.experts.tabular_expert import SimulatedExpert
from gsiirl.hypergradients import SPSA, AbstractEstimator, Implicit, directional_jacobian
from gsiirl.interaction import AbstractLearner, Demonstrator, Proposal, live
from gsiirl.irl.dependent_reward import DependentValue, LeastSquares
from gsiirl.irl.expectations import sampled_reward_gradient
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps, growing_steps
from gsiirl.irl.memory import Memory, Played
from gsiirl.learners.bilevel import Bilevel
from gsiirl.rewards.linear import Linear
from gsiirl.types import Interaction, Number, Trajectories

PROBE = 0.1
"""How far from θ_l, in every coordinate, the learner asks to be met when it measures the expert's response."""


class RewardLearnerState(eqx.Module):
    """What GSIIRL carries from one iteration to the next.

    `commitment` θ_l is the reward to act on, what the policy is made of; it is no estimate of r_ld. That estimate comes
    from `accessed`, the values read along what was visited. `hypergradient` is what the estimator remembers; `solves`
    counts the two-sided games solved so far, passes of differentiation through one included.
    """

    commitment: Float[Array, " n"]
    expert_parameters: Float[Array, " m"]
    memory: Memory[Played]
    accessed: LeastSquares
    upper_optimiser: optax.OptState
    lower_optimiser: optax.OptState
    hypergradient: Any
    solves: Int[Array, ""]


class RewardResult(eqx.Module):
    """What a learner comes out with; the three rewards are weights of their features, in reward units.

    `expert_reward` estimates r_e and `dependent_reward` r_ld; `commitment` is the reward the policy is made of.
    `solution.policies.learner` is the policy to live by, `solution.policies.expert` what the learner expects of the
    expert.
    """

    state: RewardLearnerState
    expert_reward: Float[Array, " m"]
    dependent_reward: Float[Array, " n"]
    commitment: Float[Array, " n"]
    solution: AbstractSolution


class RewardGSIIRL(AbstractLearner[RewardLearnerState]):
    """General-sum interactive inverse reinforcement learning.

    `bilevel` holds the game and both levels; `inner_loop` steps on θ_e, `hypergradient` estimates ∇f and `optimiser`
    turns −∇f into a step on θ_l. `remembered` interactions are averaged over in the lower level; `ridge` regularises
    the fit of r_ld.
    """

    bilevel: Bilevel
    inner_loop: MaximumLikelihood
    hypergradient: AbstractEstimator
    ridge: Number
    optimiser: optax.GradientTransformation = eqx.field(static=True)
    remembered: int = eqx.field(static=True)
    honest_start: bool = eqx.field(static=True)

    @property
    def expert_reward(self) -> Linear:
        """The parametric r_e^θ_e."""
        return self.bilevel.expert_reward

    @property
    def dependent_reward(self) -> Linear:
        """The parametric r_ld^θ_l, of the commitment and of the fit alike."""
        return self.bilevel.dependent_reward

    @classmethod
    def create(
        cls,
        bilevel: Bilevel,
        *,
        inner_steps: int = 10,
        inner_step_size: float = 0.02,
        step_size: float = 1.0,
        step_decay: float = 20.0,
        remembered: int = 16,
    ) -> "RewardGSIIRL":
        """The default preset: the policy as played, a memory, the exact gradient, Adam in both levels.

        The upper level's first step changes rewards by about step_size · τ, and is halved after `step_decay`
        iterations; the lower level takes `inner_steps` steps of `inner_step_size` in the unit ball.
        """
        return cls(
            bilevel=replace(bilevel, lower_level="played"),
            inner_loop=MaximumLikelihood(bilevel.temperature, constant_steps(inner_steps), optax.adam(inner_step_size)),
            hypergradient=Implicit("well_specified"),
            ridge=bilevel.regularisation,
            optimiser=optax.adam(decaying_step(bilevel, step_size, step_decay)),
            remembered=remembered,
            honest_start=True,
        )

    @classmethod
    def paper(
        cls, bilevel: Bilevel, *, iterations: int, smoothness: float, inner_step_size: float = 0.02
    ) -> "RewardGSIIRL":
        """The paper's preset: Algorithm 1 with the paper's schedules, mended only where it cannot run.

        Line 6's lower level (the forward model at both estimates), the newest demonstrations only, the response
        `frozen`, SPSA with p_k = 1/(k + 1); t_k = ⌈(k+1)^(1/4)/2⌉ plain steps of `inner_step_size` on τ∇L, and plain
        ascent with α = 1/(L_f √K) for K = `iterations` and L_f = `smoothness`, which the paper does not give.
        """
        return cls(
            bilevel=replace(bilevel, lower_level="equilibrium"),
            inner_loop=MaximumLikelihood(bilevel.temperature, growing_steps, optax.sgd(inner_step_size)),
            hypergradient=SPSA("frozen", perturbation=1.0, decay=1.0),
            ridge=bilevel.regularisation,
            optimiser=optax.sgd(1.0 / (smoothness * max(iterations, 1) ** 0.5)),
            remembered=1,
            honest_start=False,
        )

    def fit(
        self,
        expert: Demonstrator | SimulatedExpert,
        iterations: int = 50,
        trajectories: int = 100,
        seed: int = 0,
        progress: bool = True,
    ) -> "RewardResult":
        """Live with `expert` for `iterations` rounds of `trajectories` episodes, with one seed; nothing is checked.

        The result holds the weights of r_e (m,), of r_ld (n,) and of the commitment (n,), in reward units.
        """
        keys = jax.random.split(jax.random.key(seed))[None]
        last = deque(live(self, expert, keys, iterations, trajectories, progress), maxlen=1)
        # Of one seed.
        state = jax.tree.map(lambda leaf: leaf[0], last[0].states) if last else eqx.filter_jit(self.init)(keys[0, 0])
        scale = self.dependent_reward.scale
        return RewardResult(
            state=state,
            expert_reward=self.expert_reward.scale * state.expert_parameters,
            dependent_reward=scale * self.fitted_dependent_reward(state),
            commitment=scale * state.commitment,
            solution=eqx.filter_jit(self.forward)(state),
        )

    def init(self, key: PRNGKeyArray) -> RewardLearnerState:
        game, dependent_reward, expert_reward = self.bilevel.game, self.dependent_reward, self.expert_reward
        dtype = game.initial.dtype
        commitment_key, expert_key = jax.random.split(key)
        actions = game.number_of_actions.learner
        uniform = jnp.full((game.horizon, game.number_of_states, actions), 1.0 / actions, dtype)
        nothing = Played(uniform, jnp.zeros(expert_reward.number_of_parameters, dtype))
        commitment = dependent_reward.initial_parameters(commitment_key, dtype)
        expert_parameters = expert_reward.initial_parameters(expert_key, dtype)
        return RewardLearnerState(
            commitment=commitment,
            expert_parameters=expert_parameters,
            memory=Memory.empty(self.remembered, nothing),
            accessed=LeastSquares.empty(dependent_reward.number_of_parameters, dtype),
            upper_optimiser=self.optimiser.init(commitment),
            lower_optimiser=self.inner_loop.optimiser.init(expert_parameters),
            hypergradient=self.hypergradient.init(expert_parameters),
            solves=jnp.zeros((), jnp.int32),
        )

    def forward(self, state: RewardLearnerState) -> AbstractSolution:
        """The forward model at (θ_l, θ_e)."""
        return self.bilevel.solve(state.commitment, state.expert_parameters)

    def propose(self, state: RewardLearnerState) -> Proposal:
        solution = self.forward(state)
        return Proposal(solution.policies.learner, solution, self.bilevel.committed_reward(state.commitment))

    def probes(self, state: RewardLearnerState, key: PRNGKeyArray) -> RewardLearnerState | None:
        if self.hypergradient.response != "measured":
            return None
        move = PROBE * self._direction(state, key)
        asked = state.commitment[None, :] + jnp.stack([move, -move])
        return jax.vmap(lambda commitment: eqx.tree_at(lambda at: at.commitment, state, commitment))(asked)

    def update(self, state: RewardLearnerState, interaction: Interaction, key: PRNGKeyArray) -> RewardLearnerState:
        accessed = state.accessed.read(
            self.dependent_reward, DependentValue(self.bilevel.accessed), interaction.demonstrations
        )
        played = Played(interaction.learner_policy, self._demonstrated(interaction.demonstrations))
        return self.learn(state, played, accessed, key, self._measured(state, interaction, key))

    def learn(
        self,
        state: RewardLearnerState,
        played: Played,
        accessed: LeastSquares,
        key: PRNGKeyArray,
        demonstration_jacobian: Float[Array, "m n"] | None = None,
    ) -> RewardLearnerState:
        """The state after an interaction of which these are known: what was `played`, r_ld as far as it was read.

        `demonstration_jacobian` is dμ̂_e(D(θ_l))/dθ_l, where it was measured.
        """
        bilevel, iteration = self.bilevel, state.memory.count
        memory = state.memory.remember(key, played)
        expert_parameters, lower_optimiser = self.inner_loop.fit(
            lambda theta: bilevel.lower_gradient(state.commitment, theta, memory),
            state.expert_parameters,
            state.lower_optimiser,
            iteration,
        )
        start = state.commitment
        if self.honest_start:
            start = self._better(start, accessed.solve(self.ridge), expert_parameters)
        # What was demonstrated was played while the old θ_e was believed.
        problem = bilevel.problem(state.expert_parameters, played.demonstrated, demonstration_jacobian)
        estimate, hypergradient = self.hypergradient.estimate(
            problem, start, expert_parameters, state.hypergradient, jax.random.fold_in(key, 1), iteration
        )
        step, upper_optimiser = self.optimiser.update(-estimate.value, state.upper_optimiser, start)
        return RewardLearnerState(
            commitment=optax.projections.projection_l2_ball(optax.apply_updates(start, step), 1.0),
            expert_parameters=expert_parameters,
            memory=memory,
            accessed=accessed,
            upper_optimiser=upper_optimiser,
            lower_optimiser=lower_optimiser,
            hypergradient=hypergradient,
            solves=state.solves + self._solves(iteration, estimate.calls),
        )

    def fitted_dependent_reward(self, state: RewardLearnerState) -> Float[Array, " n_d"]:
        """Parameters of r_ld, by regularised least squares over the values read so far."""
        return state.accessed.solve(self.ridge)

    def _better(
        self, commitment: Float[Array, " n"], fitted: Float[Array, " n"], expert_parameters: Float[Array, " m"]
    ) -> Float[Array, " n"]:
        """θ_l itself, or the fitted r_ld where committing to that honestly would bring more.

        The ascent is local; from a random start it can end below what the learner would get by acting on its own
        reward.
        """
        candidates = jnp.stack([commitment, fitted])
        return candidates[jnp.argmax(jax.vmap(self.bilevel.objective, (0, None))(candidates, expert_parameters))]

    def _measured(self, state: RewardLearnerState, interaction: Interaction, key: PRNGKeyArray) -> Array | None:
        """dμ̂_e(D(θ_l))/dθ_l (m, n) from the demonstrations at the probes."""
        if interaction.probes is None:
            return None
        forth, back = jax.vmap(self._demonstrated)(interaction.probes)
        slope = (forth - back) / (2.0 * PROBE)
        return directional_jacobian(self._direction(state, key)[None, :], slope[None, :])

    def _direction(self, state: RewardLearnerState, key: PRNGKeyArray) -> Float[Array, " n"]:
        return jax.random.rademacher(jax.random.fold_in(key, 2), state.commitment.shape, state.commitment.dtype)

    def _demonstrated(self, demonstrations: Trajectories) -> Float[Array, " m"]:
        """μ̂_e(D)."""
        return sampled_reward_gradient(
            self.bilevel.expert_reward, demonstrations, self.bilevel.discount, self.bilevel.game.initial.dtype
        )

    def _solves(self, iteration: Int[Array, ""], evaluations: Int[Array, ""]) -> Int[Array, ""]:
        """Two-sided games solved in iteration k: proposals, inner steps, honest start and hypergradient."""
        response, equilibrium = self.hypergradient.response, self.bilevel.lower_level == "equilibrium"
        solves = jnp.asarray(3 if response == "measured" else 1) + (2 if self.honest_start else 0)
        # With the policy as played, both f and the policy need a solve of their own.
        each = 1 if equilibrium or response == "well_specified" else 2
        inner = self.inner_loop.steps(iteration) if equilibrium else 0
        return (solves + inner + each * evaluations).astype(jnp.int32)


def decaying_step(bilevel: Bilevel, step_size: float, step_decay: float) -> optax.Schedule:
    """Steps on θ_l in units of temperature: step_size · τ / scale / (1 + k / step_decay).

    A step on θ_l changes rewards by scale times as much; what matters to a policy is that change over τ.
    """
    first = step_size * bilevel.temperature / bilevel.dependent_reward.scale
    return lambda k: first / (1.0 + k / step_decay)
