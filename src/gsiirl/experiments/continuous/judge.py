"""What the truth says of policies and of learned rewards in a continuous experiment.

Everything reported is measured on the same `evaluation_episodes` initial states, whatever the algorithm, seed and
iteration; what is chosen by its return, as a best response is, is chosen on as many others. Returns are undiscounted
sums under the true rewards.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray

from gsiirl.equilibria.pathwise import Ascent, Side, joint, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.evaluation.transition_similarity import epic, pearson
from gsiirl.evaluation.truth import named
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.problem import ContinuousProblem
from gsiirl.experiments.continuous.solvers import TRAINED_RATE, responder_of, solver_of
from gsiirl.experiments.prepared_run import Record
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.irl.feature_gap import gaps_of_episodes
from gsiirl.rewards.continuous import TransitionReward, mean_return
from gsiirl.types import Sides, Transition

EVALUATION_KEY = 20261125
"""Of the initial states that all figures are measured on, and of the transitions that rewards are compared over."""
COMPARED = 4000
SAMPLE_PATHS = 12
STARTS = 3
"""Policies that every search for a best response starts from: known ones, and random ones for the rest."""
TRIED = 0.5
"""Share of a best response's steps that every start takes, before the search goes on with the most promising one."""


class Judge:
    """What the truth says of policies and of learned rewards."""

    def __init__(self, config: ContinuousConfig, problem: ContinuousProblem) -> None:
        self.config, self.problem = config, problem
        self.trainer = solver_of(config, problem, config.training_steps, TRAINED_RATE)
        self._tester = responder_of(config, problem, config.training_steps, TRAINED_RATE)
        start_key, sample_key, self._key = jax.random.split(jax.random.key(EVALUATION_KEY), 3)
        self.starts = initial_states(problem.game, start_key, config.evaluation_episodes)
        self._others = initial_states(problem.game, jax.random.fold_in(start_key, 1), config.evaluation_episodes)
        self._sample = jax.vmap(problem.anywhere)(jax.random.split(sample_key, COMPARED))

    def episodes(self, policies: Sides[PolicyNetwork]) -> Transition:
        """Episodes of a pair from the evaluation's initial states."""
        return episodes_from(self.problem.game, policies, self.starts)

    def returns(self, episodes: Transition) -> Sides[Array]:
        """Undiscounted returns of both sides under the true rewards."""
        return jax.tree.map(lambda reward: mean_return(reward, episodes, 1.0), self.problem.true_rewards)

    def play(
        self, model: Sides[PolicyNetwork], deployed: Sides[PolicyNetwork]
    ) -> tuple[Record, Transition, Transition]:
        """Returns of the pair as modelled, and of the pair as deployed with the experiment's own metrics of it."""
        modelled, real = self.episodes(model), self.episodes(deployed)
        record = {
            **named("model", self.returns(modelled)),
            **named("deployed", self.returns(real)),
            **self.problem.judge_episodes(real),
        }
        return record, modelled, real

    def expert_reward(self, parameters: Array, modelled: Transition, real: Transition) -> Record:
        """How right θ_e is, and how the modelled expert's features differ from the real one's."""
        reward, discount = self.problem.expert_reward, self.config.discount
        steps = jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), real)

        def alike(sample: Transition) -> Array:
            return pearson(lambda seen: reward(parameters, seen), self.problem.true_expert_reward, sample)

        correlation = alike(self._sample)

        gaps = gaps_of_episodes(reward, parameters, modelled, real, discount)
        spread = jnp.sqrt(jnp.sum(jnp.var(gaps, axis=0)) / self.config.trajectories)
        return {
            "expert_reward_pearson": correlation,
            "expert_reward_epic": epic(correlation),
            "expert_reward_pearson_played": alike(steps),
            "feature_gap": jnp.linalg.norm(jnp.mean(gaps, axis=0)),
            "feature_gap_noise": spread,
            **self.problem.judge_reward(parameters),
        }

    def dependent_reward_pearson(self, fitted: Array) -> Array:
        """Correlation of the fitted r_ld with the true one."""
        reward = self.problem.dependent_reward
        return pearson(lambda seen: reward(fitted, seen), self.problem.dependent_value, self._sample)

    def best_response(
        self, learner_policy: PolicyNetwork, known: Sequence[PolicyNetwork], key: PRNGKeyArray
    ) -> PolicyNetwork:
        """The true expert's best response to a learner's policy, searched for from `known` and from random ones."""
        return self._best("expert", learner_policy, known, key)

    def best_answer(self, policies: Sides[PolicyNetwork], key: PRNGKeyArray) -> PolicyNetwork:
        """Likewise the learner's, under the true rewards, to the expert's policy."""
        return self._best("learner", policies.expert, (policies.learner,), key)

    def _best(
        self,
        side: Side,
        other: PolicyNetwork,
        known: Sequence[PolicyNetwork],
        key: PRNGKeyArray,
    ) -> PolicyNetwork:
        """What `training_steps` lead to from whichever start is worth most after the first `TRIED` of them."""
        reward: TransitionReward = getattr(self.problem.true_rewards, side)

        def climb(start: Ascent, key: PRNGKeyArray, steps: int) -> Ascent:
            return self._tester.climb(side, other, reward, start, key, steps)

        def worth(policy: PolicyNetwork) -> Array:
            episodes = episodes_from(self.problem.game, joint(side, policy, other), self._others)
            return getattr(self.returns(episodes), side)

        trial_key, rest_key = jax.random.split(key)
        fresh = [self._tester.init(jax.random.fold_in(key, number)) for number in range(STARTS - len(known))]
        begun: list[Ascent] = [getattr(each, side) for each in fresh]
        begun += [Ascent(one, begun[0].optimiser) for one in known]
        starts = jax.tree.map(lambda *each: jnp.stack(each), *begun)
        trial = int(TRIED * self.config.training_steps)
        tried = jax.vmap(lambda start: climb(start, trial_key, trial))(starts)
        best = jnp.argmax(jax.vmap(worth)(tried.policy))
        promising = jax.tree.map(lambda each: each[best], tried)
        return climb(promising, rest_key, self.config.training_steps - trial).policy

    def true_play(self, key: PRNGKeyArray) -> Sides[Ascent]:
        """What MARL comes to after `training_steps` with both true rewards."""
        start_key, ascent_key = jax.random.split(key)
        start = self.trainer.init(start_key)
        return self.trainer.ascend(start, self.problem.true_rewards, ascent_key, self.config.training_steps)[0]

    def exploitability(self, policies: Sides[PolicyNetwork], response: PolicyNetwork, key: PRNGKeyArray) -> Record:
        """What a best response gains over either side's policy, as a share of |return|; `response` is the expert's."""
        now = self.returns(self.episodes(policies))
        best = Sides(
            self.returns(self.episodes(Sides(self.best_answer(policies, key), policies.expert))).learner,
            self.returns(self.episodes(Sides(policies.learner, response))).expert,
        )
        gains = jax.tree.map(lambda after, before: (after - before) / jnp.abs(before), best, now)
        return {"exploitability_learner": gains.learner, "exploitability_expert": gains.expert}

    def truth(self, policies: Sides[PolicyNetwork]) -> Record:
        """What a MARL pair earns, under the names of a reference."""
        episodes = self.episodes(policies)
        rates = {f"truth_{name}": value for name, value in self.problem.judge_episodes(episodes).items()}
        return {**named("truth", self.returns(episodes)), **rates}

    def references(self) -> Record:
        """One MARL pair (`truth_`), and an untrained learner met by the true expert (`random_`)."""
        marl_key, random_key = jax.random.split(self._key)
        return {**self.truth(policies_of(self.true_play(marl_key))), **self.random(random_key)}

    def random_alone(self) -> Record:
        """The references of `marl`, which is its own truth."""
        return self.random(jax.random.split(self._key)[1])

    def random(self, key: PRNGKeyArray) -> Record:
        """What an untrained learner earns when the true expert has trained against it."""
        untrained = self._tester.init(key)
        learner_policy = untrained.learner.policy
        met = Sides(learner_policy, self.best_response(learner_policy, (), key))
        return named("random", self.returns(self.episodes(met)))

    def paths(self, policies: Sides[PolicyNetwork]) -> dict[str, Array]:
        """Columns of a few sample episodes."""
        starts = jax.tree.map(lambda leaf: leaf[:SAMPLE_PATHS], self.starts)
        return self.problem.paths(episodes_from(self.problem.game, policies, starts))
