"""What policies of a continuous game earn under both true rewards, and what the true expert answers them."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray

from gsiirl.equilibria.pathwise import Ascent, Pathwise, Side, joint, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.several_starts import best_of_starts
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.rewards.continuous import TransitionReward, mean_return
from gsiirl.types import Sides, Transition

EVALUATION_KEY = 20261125
"""Of the initial states that all figures are measured on, and of the transitions that rewards are compared over."""
STARTS = 3
"""Policies that every search for a best response starts from: known ones, and random ones for the rest."""


class TrueReturns:
    """Returns under both true rewards, and best responses and equilibria that a search with them finds.

    Everything is measured on the same `episodes` initial states; what is chosen by its return, as a best response is,
    is chosen on as many others. `trainer` moves both sides for `training_steps`, `tester` one alone for
    `judging_steps`.
    """

    def __init__(
        self,
        rewards: Sides[TransitionReward],
        trainer: Pathwise,
        tester: Pathwise,
        training_steps: int,
        judging_steps: int,
        episodes: int,
    ) -> None:
        self.game, self.rewards, self.trainer, self.tester = trainer.game, rewards, trainer, tester
        self._training_steps, self._judging_steps = training_steps, judging_steps
        start_key = jax.random.split(jax.random.key(EVALUATION_KEY), 3)[0]
        self.starts = initial_states(self.game, start_key, episodes)
        self._others = initial_states(self.game, jax.random.fold_in(start_key, 1), episodes)

    def episodes(self, policies: Sides[PolicyNetwork]) -> Transition:
        """Episodes of a pair (axes d, T) from the initial states that are measured on."""
        return episodes_from(self.game, policies, self.starts)

    def returns(self, episodes: Transition, discount: float = 1.0) -> Sides[Array]:
        """Returns of both sides, means over the episodes."""
        return jax.tree.map(lambda reward: mean_return(reward, episodes, discount), self.rewards)

    def best_response(
        self, learner_policy: PolicyNetwork, known: Sequence[PolicyNetwork], key: PRNGKeyArray
    ) -> PolicyNetwork:
        """The true expert's best response to a learner's policy, searched for from `known` and from random ones."""
        return self._best("expert", learner_policy, known, key)

    def best_answer(self, policies: Sides[PolicyNetwork], key: PRNGKeyArray) -> PolicyNetwork:
        """The learner's best response to the expert's policy, searched for likewise from the learner's."""
        return self._best("learner", policies.expert, (policies.learner,), key)

    def marl(self, key: PRNGKeyArray) -> Sides[Ascent]:
        """What MARL comes to with both true rewards."""
        start_key, ascent_key = jax.random.split(key)
        return self.trainer.ascend(self.trainer.init(start_key), self.rewards, ascent_key, self._training_steps)[0]

    def untrained(self, key: PRNGKeyArray) -> Sides[PolicyNetwork]:
        """An untrained learner, and the true expert that has trained against it."""
        learner_policy = policies_of(self.tester.init(key)).learner
        return Sides(learner_policy, self.best_response(learner_policy, (), key))

    def _best(
        self, side: Side, other: PolicyNetwork, known: Sequence[PolicyNetwork], key: PRNGKeyArray
    ) -> PolicyNetwork:
        """What all steps lead to from the most promising of several starts."""
        reward: TransitionReward = getattr(self.rewards, side)

        def climb(start: Ascent, key: PRNGKeyArray, steps: int) -> Ascent:
            return self.tester.climb(side, other, reward, start, key, steps)

        def worth(ascent: Ascent) -> Array:
            episodes = episodes_from(self.game, joint(side, ascent.policy, other), self._others)
            return getattr(self.returns(episodes), side)

        fresh = [self.tester.init(jax.random.fold_in(key, number)) for number in range(STARTS - len(known))]
        begun: list[Ascent] = [getattr(each, side) for each in fresh]
        begun += [Ascent(one, begun[0].optimiser) for one in known]
        starts = jax.tree.map(lambda *each: jnp.stack(each), *begun)
        return best_of_starts(starts, climb, worth, key, self._judging_steps).policy
