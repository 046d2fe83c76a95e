"""GSIIRL in games with finitely many states: Algorithm 1 with a policy for a commitment.

For k = 0, …, K − 1:

    D_k      ← the expert's demonstrations while the learner plays π_l(k)              line 4
    θ_e      ← the maximum of the conditional likelihood, with the posterior around it  lines 5-9
    π_l(k+1) ← in the first half of the iterations: what tells most about the expert;  lines 11-15
               then: the best commitment under one draw of the posterior (Thompson)

    at last:   the commitment that is best on average over the posterior

The paper ascends a reward θ_l that the learner acts on through a two-sided equilibrium; here the policy itself is what
is ascended (docs/commitment.md). `gsiirl.learners.reward_learner` is the paper's way.
"""

from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from gsiirl.commitment.objective import Commitment
from gsiirl.commitment.search import Objective, Search, Starts, committed, is_small, logits_of, ranked
from gsiirl.equilibria.base import AbstractSolution
from gsiirl.equilibria.response import respond
from gsiirl.games.base import AbstractTabularGame, uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.interaction import AbstractLearner, Proposal
from gsiirl.irl.dependent_reward import DependentFit, DependentValue
from gsiirl.irl.inference import AbstractLowerLevel, LikelihoodLevel
from gsiirl.irl.posterior import Draws
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.types import Interaction, Policies, Sides

Explore = Literal["informative", "thompson", "estimate"]
HandBack = Literal["average", "estimate"]
Feedback = Literal["model", "visited"]
LEAST_EFFECTIVE = 0.1
"""Below this share of effective draws, Hamiltonian Monte Carlo takes the weighted draws' place."""


class Incumbent(AbstractSolution):
    """What the learner plays next and expects of the expert; `residual` is the distance of the fit from its maximum."""

    policies: Policies
    residual: Float[Array, ""]
    converged: Bool[Array, ""]


class LearnerState(eqx.Module):
    """What the learner carries from one iteration to the next.

    `lower` is the lower level's; `pool` holds logits of good commitments under the estimate, the best first; `proposed`
    is the policy to play next. `effective_draws` and `played_loss` are those of the newest iteration.
    """

    lower: Any
    accessed: DependentFit
    pool: Float[Array, "P T S A_l"]
    proposed: Float[Array, "T S A_l"]
    effective_draws: Float[Array, ""]
    played_loss: Float[Array, ""]
    count: Float[Array, ""]


class HandedBack(eqx.Module):
    """What the learner ends with: the policy to deploy, and the response it expects.

    The policy is chosen by draws of the posterior. `effective_draws` is their effective sample size; `sampled` says
    whether they come from Hamiltonian Monte Carlo.
    """

    policies: Policies
    effective_draws: Float[Array, ""]
    sampled: Bool[Array, ""]


class CommitmentLearner(AbstractLearner[LearnerState]):
    """The learner of a finite game as pure functions of arrays; `gsiirl.GSIIRL` is its front door.

    `commitment` holds the game and the learner's reward with the accessed values of r_ld, `lower` the lower level.
    `explore` says what is played while learning: the best commitment under a draw of the posterior (`thompson`); the
    same, after `informative_rounds` of the policy that tells the draw from the estimate best (`informative`); or the
    best commitment under the estimate. `hand_back` says what is chosen at last: the best on average over the posterior,
    or under the estimate. `many_starts` False leaves the one ascent from the policy before. `feedback` says where r_ld
    is read: everywhere by the model, or only along what was visited, f then using the fit. `commitment` is in units of
    `unit`.
    """

    commitment: Commitment
    own_reward: AbstractPayoff
    accessed: AbstractPayoff
    dependent_features: AbstractFeatures
    lower: AbstractLowerLevel
    explore: Explore = eqx.field(static=True, default="informative")
    hand_back: HandBack = eqx.field(static=True, default="average")
    feedback: Feedback = eqx.field(static=True, default="model")
    many_starts: bool = eqx.field(static=True, default=True)
    informative_rounds: int | Float[Array, ""] = 0
    unit: float | Float[Array, ""] = 1.0
    remembered: int = eqx.field(static=True, default=50)

    @property
    def game(self) -> AbstractTabularGame:
        """The game."""
        return self.commitment.game

    @property
    def small(self) -> bool:
        """Whether the game is small enough for more starts, draws and rounds."""
        return is_small(self.game)

    @property
    def draws(self) -> int:
        """Draws of the posterior, K."""
        return 48 if self.game.policy_size < 2**10 else 24 if self.small else 12

    @property
    def lanes(self) -> int:
        """Ascents an iteration under the estimate; as many again, or half, under the draw."""
        if not self.many_starts:
            return 1
        return 10 if self.small else 4

    @property
    def search(self) -> Search:
        """The search of one iteration."""
        return Search(self.game, steps=60 if self.small else 20)

    def init(self, key: PRNGKeyArray) -> LearnerState:
        dtype = self.game.initial.dtype
        zero = jnp.zeros((), dtype)
        pool = self.search.random(4 if self.many_starts else 1, zero, key).logits
        return LearnerState(
            lower=self.lower.init(self.remembered),
            accessed=DependentFit.empty(self.dependent_features, dtype),
            pool=pool,
            # Nothing is known yet; every action is tried.
            proposed=uniform_policy(self.game),
            effective_draws=zero,
            played_loss=zero,
            count=zero,
        )

    def propose(self, state: LearnerState) -> Proposal:
        return Proposal(state.proposed)

    def incumbent(self, state: LearnerState) -> Incumbent:
        """The best commitment found so far under the estimate: what would be deployed if learning ended here."""
        return self._incumbent(state, self.commitment.policy(state.pool[0]))

    def update(self, state: LearnerState, interaction: Interaction, key: PRNGKeyArray) -> LearnerState:
        learn_key, draw_key, search_key = jax.random.split(key, 3)
        played = interaction.learner_policy
        lower = self.lower.learn(state.lower, played, interaction.demonstrations, learn_key)
        accessed = state.accessed.read(
            self.dependent_features, DependentValue(self.accessed), interaction.demonstrations
        )
        objective = self._objective(accessed)
        estimate = self.lower.estimate(lower)
        effective = one = jnp.ones((), played.dtype)
        believed = estimate[None]
        if self.explore != "estimate":
            assert isinstance(self.lower, LikelihoodLevel), "a lower level without a posterior has no draws"
            draws = self.lower.draws(lower, self.draws if self.small else self.draws // 2, draw_key)
            chosen = jax.random.categorical(jax.random.fold_in(draw_key, 1), jnp.log(draws.weights))
            draw = draws.values[chosen]
            inference = self.lower.inference
            if inference.dense and self.small:
                few = draws.effective < 0.3 * self.draws
                rounds = jnp.where(few, 30, 0)
                chain = inference.hamiltonian(lower.posterior, lower.memory, 1, rounds, jax.random.fold_in(draw_key, 2))
                draw = jnp.where(few, chain[0], draw)
            believed = jnp.stack([estimate, draw])
            effective = draws.effective
        pools = self._improved(objective, believed, state.pool, logits_of(played), search_key)
        pool, proposed = pools[0], pools[-1, 0]
        if self.explore == "informative":
            telling = self._telling(pools.reshape(-1, *pool.shape[1:]), believed, jax.random.fold_in(search_key, 1))
            proposed = jnp.where(state.count < self.informative_rounds, telling, proposed)
        values = jax.vmap(lambda logits: objective(self.commitment.policy(logits), estimate, one, one))(
            jnp.stack([pool[0], proposed])
        )
        return LearnerState(
            lower=lower,
            accessed=accessed,
            pool=pool,
            proposed=self.commitment.policy(proposed),
            effective_draws=effective,
            played_loss=self.unit * (values[0] - values[1]),
            count=state.count + 1.0,
        )

    def end(self, state: LearnerState, key: PRNGKeyArray) -> HandedBack:
        """The policy to deploy, by a search of its own from what was found, what was played, and new starts."""
        draw_key, chain_key, start_key, round_key = jax.random.split(key, 4)
        objective, estimate = self._objective(state.accessed), self.lower.estimate(state.lower)
        one = jnp.ones((), estimate.dtype)
        believed, sampled = self._believed(state, draw_key, chain_key)
        average = committed(self.commitment_of(state.accessed), self._reward, believed.weights)
        spread = self.commitment.range_of_answers(self._reward(estimate))
        starts, kept = Starts.plain(state.pool), state.pool[:0]
        if self.many_starts:
            remembered = logits_of(state.lower.memory.kept.learner_policy)
            values = jax.lax.map(
                lambda logits: average(self.commitment.policy(logits), believed.values, one, one), remembered
            )
            kept = ranked(remembered, values)[0][: 2 * self.lanes]
            starts = starts.and_also(Starts.plain(kept)).and_also(
                self.search.random(max(12, 2 * self.lanes), spread, start_key)
            )
        rounds = (6 if self.small else 4) if self.many_starts else 0
        logits, _ = Search(self.game, steps=100 if self.small else 40).best(
            objective, starts, estimate, rounds, round_key
        )
        # The last word has the average: the best few under it, some steps along it.
        few = min(8 if self.small else 4, logits.shape[0])
        if self.many_starts:
            logits = jnp.concatenate([logits[:few], kept[:few]])
        same = jnp.broadcast_to(believed.values[None], (logits.shape[0], *believed.values.shape))
        logits, _ = ranked(*self.search.ascend(average, Starts.plain(logits), same))
        policy = self.commitment.policy(logits[0])
        answer = respond(self.game, policy, self._reward(estimate), 1.0, self.commitment.discount).policy
        return HandedBack(Sides(policy, answer), believed.effective, sampled)

    def posterior_draws(self, state: LearnerState, key: PRNGKeyArray) -> Float[Array, "K m"]:
        """Draws of the expert's weights in units of the temperature, each counting alike; none without a posterior.

        They are drawn anew: those that choose the policy would make its return look larger than it is.
        """
        estimate = self.lower.estimate(state.lower)
        if not isinstance(self.lower, LikelihoodLevel):
            return jnp.zeros((0, *estimate.shape), estimate.dtype)
        return self.lower.equal_draws(state.lower, 8 * self.draws, key)

    def report(self, state: LearnerState) -> dict[str, Float[Array, ""]]:
        """How well the newest iteration went, by name."""
        return {
            **self.lower.report(state.lower),
            "effective_draws": state.effective_draws,
            "played_loss": state.played_loss,
        }

    def commitment_of(self, accessed: DependentFit) -> Commitment:
        """f with the learner's reward as `feedback` lets it be read."""
        if self.feedback == "model":
            return self.commitment
        fitted = self.dependent_features.payoff(accessed.solve())
        return Commitment(self.game, (fitted + self.own_reward) * (1.0 / self.unit), self.commitment.discount)

    def _believed(
        self, state: LearnerState, draw_key: PRNGKeyArray, chain_key: PRNGKeyArray
    ) -> tuple[Draws, Bool[Array, ""]]:
        """Draws of the expert's reward to choose by, and whether they come from Hamiltonian Monte Carlo."""
        estimate = self.lower.estimate(state.lower)
        if self.hand_back == "estimate":
            one = jnp.ones((), estimate.dtype)
            return Draws(estimate[None, :], one[None], one), jnp.asarray(False)
        assert isinstance(self.lower, LikelihoodLevel), "a lower level without a posterior has no average"
        inference, memory, posterior = self.lower.inference, state.lower.memory, state.lower.posterior
        drawn = inference.draws(posterior, memory, self.draws, draw_key)
        if not inference.dense:
            return drawn, jnp.asarray(False)
        sampled = drawn.effective < LEAST_EFFECTIVE * self.draws
        chains = inference.hamiltonian(posterior, memory, self.draws, jnp.where(sampled, 60, 0), chain_key)
        values = jnp.where(sampled, chains, drawn.values)
        return Draws(values, jnp.where(sampled, 1.0 / self.draws, drawn.weights), drawn.effective), sampled

    def _objective(self, accessed: DependentFit):
        return committed(self.commitment_of(accessed), self._reward)

    def _reward(self, weights: Float[Array, " m"]) -> AbstractPayoff:
        return self.lower.likelihood.features.payoff(weights)

    def _incumbent(self, state: LearnerState, policy: Array) -> Incumbent:
        reward = self._reward(self.lower.estimate(state.lower))
        answer = respond(self.game, policy, reward, 1.0, self.commitment.discount).policy
        report = self.lower.report(state.lower)
        decrement = report.get("fit_decrement", jnp.zeros((), policy.dtype))
        converged = report.get("fit_converged", jnp.ones((), policy.dtype)) > 0
        return Incumbent(Sides(policy, answer), decrement, converged)

    def _telling(
        self, logits: Float[Array, "N T S A_l"], believed: Float[Array, "2 m"], key: PRNGKeyArray
    ) -> Float[Array, "T S A_l"]:
        """The policy to which draw and estimate expect the most different answers.

        By an ascent from the two best of `logits`, pure policies and random ones.
        """
        estimate, draw = believed
        shape = logits.shape[1:]
        pure = logits_of(jnp.broadcast_to(jnp.eye(shape[-1], dtype=logits.dtype)[:, None, None], (shape[-1], *shape)))
        candidates = jnp.concatenate([logits, pure, self.search.random(8, jnp.ones((), logits.dtype), key).logits])
        told = jax.lax.map(
            lambda each: self.lower.likelihood.discrimination(self.commitment.policy(each), draw, estimate), candidates
        )
        starts = Starts.plain(candidates[jax.lax.top_k(told, 2)[1]])

        def objective(policy: Array, between: Array, temperature: Array, reaction: Array) -> Array:
            return self.lower.likelihood.discrimination(policy, between[1], between[0])

        return ranked(*self.search.ascend(objective, starts, jnp.stack([believed, believed])))[0][0]

    def _improved(
        self,
        objective: Objective,
        believed: Float[Array, "R m"],
        pool: Float[Array, "P T S A_l"],
        played: Float[Array, "T S A_l"],
        key: PRNGKeyArray,
    ) -> Float[Array, "R P T S A_l"]:
        """For each of the rewards `believed`, the best of the pool and of what ascents from it and elsewhere find."""
        number = believed.shape[0]
        if not self.many_starts:
            starts = Starts.plain(jnp.broadcast_to(pool[:1], (number, *pool.shape[1:])))
            return self.search.ascend(objective, starts, believed)[0][:, None]
        near_key, far_key, new_key = jax.random.split(key, 3)
        near = jax.vmap(lambda theta: self.search.neighbours(objective, pool[0], theta, self.lanes // 3, near_key))(
            believed
        )
        far = self.search.disturbed(pool[: max(1, self.lanes // 4)], far_key)
        spread = self.commitment.range_of_answers(self._reward(believed[0]))
        new = self.search.random(2, spread, new_key)
        # The new start is begun in another way every time.
        hot, held = jax.random.bernoulli(jax.random.fold_in(new_key, 1), 0.5, (2,))
        shared = Starts.plain(jnp.concatenate([pool[: 1 + self.lanes // 5], played[None], far])).and_also(
            Starts(
                new.logits[1:],
                jnp.where(hot, new.temperature[:1], 1.0),
                jnp.where(held, 0.5, jnp.zeros_like(spread))[None],
            )
        )
        starts = jax.vmap(lambda each: shared.and_also(Starts.plain(each)))(near)
        lanes = starts.temperature.shape[1]
        flat = jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), starts)
        logits, values = self.search.ascend(objective, flat, jnp.repeat(believed, lanes, axis=0))
        one = jnp.ones((), values.dtype)

        def best(theta: Array, logits: Array, values: Array) -> Array:
            before = jax.vmap(lambda each: objective(self.commitment.policy(each), theta, one, one))(pool)
            both = ranked(jnp.concatenate([logits, pool]), jnp.concatenate([values, before]))
            return both[0][: pool.shape[0]]

        return jax.vmap(best)(believed, logits.reshape(number, lanes, *logits.shape[1:]), values.reshape(number, lanes))
