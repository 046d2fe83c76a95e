"""What the truth says of policies and of learned rewards in a continuous experiment.

Everything is measured as `TrueReturns` does, whatever the algorithm, seed and iteration. Returns are undiscounted sums
under the true rewards.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray

from gsiirl.equilibria.pathwise import policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.evaluation.transition_similarity import epic, pearson, spearman, starc
from gsiirl.evaluation.true_returns import EVALUATION_KEY
from gsiirl.evaluation.truth import named
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.experiment import ContinuousExperiment, front_door_of
from gsiirl.experiments.prepared_run import Record
from gsiirl.games.rollout import episodes_from
from gsiirl.irl.feature_gap import gaps_of_episodes
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides, Transition

COMPARED, VISITED = 4000, 250
"""Transitions that rewards are correlated over, and states of deployed episodes that STARC compares them from."""
SAMPLE_PATHS = 12


class Judge:
    """What the truth says of policies and of learned rewards; `true` has the returns and the best responses."""

    def __init__(self, config: ContinuousConfig, experiment: ContinuousExperiment) -> None:
        self.config, self.experiment = config, experiment
        self.true = front_door_of(config, experiment.problem).true_returns(
            experiment.true_expert_reward,
            config.training_steps,
            config.judging_steps,
            config.evaluation_episodes,
        )
        _, sample_key, self._key = jax.random.split(jax.random.key(EVALUATION_KEY), 3)
        visited_key, self._starc_key = jax.random.split(jax.random.fold_in(sample_key, 1))
        steps = config.evaluation_episodes * config.horizon
        self._visited = jax.random.choice(visited_key, steps, (min(VISITED, steps),), replace=False)
        self._sample = jax.vmap(experiment.anywhere)(jax.random.split(sample_key, COMPARED))

    def play(
        self, model: Sides[PolicyNetwork], deployed: Sides[PolicyNetwork]
    ) -> tuple[Record, Transition, Transition]:
        """Returns of the pair as modelled, and of the pair as deployed with the experiment's own metrics of it."""
        modelled, real = self.true.episodes(model), self.true.episodes(deployed)
        record = {
            **named("model", self.true.returns(modelled)),
            **named("deployed", self.true.returns(real)),
            **self.experiment.judge_episodes(real),
        }
        return record, modelled, real

    def expert_reward(self, parameters: Array, modelled: Transition, real: Transition) -> Record:
        """How right θ_e is, and how the modelled expert's features differ from the real one's."""
        reward, discount = self.experiment.problem.expert_reward, self.config.discount
        steps = jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), real)
        visited = jax.tree.map(lambda leaf: leaf[self._visited], steps.state)
        both: tuple[TransitionReward, TransitionReward] = (
            lambda seen: reward(parameters, seen),
            self.experiment.true_expert_reward,
        )
        correlation, played = pearson(*both, self._sample), pearson(*both, steps)

        gaps = gaps_of_episodes(reward, parameters, modelled, real, discount)
        spread = jnp.sqrt(jnp.sum(jnp.var(gaps, axis=0)) / self.config.trajectories)
        return {
            "expert_reward_pearson": correlation,
            "expert_reward_spearman": spearman(*both, self._sample),
            "expert_reward_epic": epic(correlation),
            "expert_reward_starc": starc(*both, self.true.game, visited, self._starc_key, discount),
            "expert_reward_pearson_played": played,
            "expert_reward_epic_played": epic(played),
            "feature_gap": jnp.linalg.norm(jnp.mean(gaps, axis=0)),
            "feature_gap_noise": spread,
            **self.experiment.judge_reward(parameters),
        }

    def dependent_reward_pearson(self, fitted: Array) -> Array:
        """Correlation of the fitted r_ld with the true one."""
        problem = self.experiment.problem
        return pearson(lambda seen: problem.dependent_reward(fitted, seen), problem.dependent_value, self._sample)

    def exploitability(self, policies: Sides[PolicyNetwork], response: PolicyNetwork, key: PRNGKeyArray) -> Record:
        """What a best response gains over either side's policy, as a share of |return|; `response` is the expert's."""
        true = self.true
        now = true.returns(true.episodes(policies))
        best = Sides(
            true.returns(true.episodes(Sides(true.best_answer(policies, key), policies.expert))).learner,
            true.returns(true.episodes(Sides(policies.learner, response))).expert,
        )
        gains = jax.tree.map(lambda after, before: (after - before) / jnp.abs(before), best, now)
        return {"exploitability_learner": gains.learner, "exploitability_expert": gains.expert}

    def truth(self, policies: Sides[PolicyNetwork]) -> Record:
        """What a MARL pair earns, under the names of a reference."""
        episodes = self.true.episodes(policies)
        rates = {f"truth_{name}": value for name, value in self.experiment.judge_episodes(episodes).items()}
        return {**named("truth", self.true.returns(episodes)), **rates}

    def references(self) -> Record:
        """One MARL pair (`truth_`), and an untrained learner met by the true expert (`random_`)."""
        marl_key, random_key = jax.random.split(self._key)
        return {**self.truth(policies_of(self.true.marl(marl_key))), **self.random(random_key)}

    def random_alone(self) -> Record:
        """The references of `marl`, which is its own truth."""
        return self.random(jax.random.split(self._key)[1])

    def random(self, key: PRNGKeyArray) -> Record:
        """What an untrained learner earns when the true expert has trained against it."""
        return named("random", self.true.returns(self.true.episodes(self.true.untrained(key))))

    def paths(self, policies: Sides[PolicyNetwork]) -> dict[str, Array]:
        """Columns of a few sample episodes."""
        starts = jax.tree.map(lambda leaf: leaf[:SAMPLE_PATHS], self.true.starts)
        return self.experiment.paths(episodes_from(self.true.game, policies, starts))
