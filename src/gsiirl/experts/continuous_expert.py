"""The other side of a continuous game: it goes on improving its answer to whatever policy the learner plays."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Int, PRNGKeyArray

from gsiirl.arguments import discount_of, positive, whole_number
from gsiirl.equilibria.pathwise import Ascent, Pathwise
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.errors import InputError
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.interaction import AbstractExpert, Proposal
from gsiirl.problems.continuous_problem import continuous_game, random_steps, reward_of
from gsiirl.rewards.continuous import TransitionReward, mean_return
from gsiirl.types import Interaction, Sides

POLICIES = 2
"""That an expert practises: ascent from one start alone can get stuck."""


class Habits(eqx.Module):
    """The policies that an expert has practised, along a leading axis, and which of them is the best for it."""

    practised: Ascent
    best: Int[Array, ""]

    @property
    def policy(self) -> PolicyNetwork:
        """The policy that the expert plays."""
        return jax.tree.map(lambda leaf: leaf[self.best], self.practised.policy)


class ContinuousRespondingExpert(AbstractExpert[Habits]):
    """An expert that plays its best response to the policy that the learner plays, found by gradient ascent.

    It alone holds the true expert reward. It never forgets: it keeps `POLICIES` policies, its habits, improves each by
    `steps` steps in an interaction, and plays the one that earns it most. At the start it has answered the learner's
    first policy for `first_steps` steps: an untrained expert's actions carry no information about its reward.
    """

    solver: Pathwise
    reward: TransitionReward
    steps: int = eqx.field(static=True)
    first_steps: int = eqx.field(static=True)

    def __init__(
        self,
        game: object,
        reward: object,
        discount: float,
        *,
        iterations: int = 50,
        steps: int = 100,
        first_steps: int = 250,
        batch: int = 64,
        hidden: int = 64,
        learning_rate: float = 3e-3,
    ) -> None:
        """The expert of `reward` r_e(s, a, s'), a function of one step.

        Its networks have two hidden layers of width `hidden`; a step averages over `batch` episodes. The learning rate
        falls to a tenth over `iterations` interactions.

        Raises:
            InputError: an argument cannot be.
        """
        known = continuous_game(game)
        if reward is None:
            raise InputError("reward", "is None", "give the expert's reward, a function of one step")
        self.reward = reward_of("reward", reward, random_steps(known))
        self.steps, self.first_steps = whole_number("steps", steps, 0), whole_number("first_steps", first_steps, 0)
        self.solver = Pathwise.create(
            known,
            discount=discount_of(discount),
            batch=whole_number("batch", batch, 1),
            hidden=whole_number("hidden", hidden, 1),
            learning_rate=positive("learning_rate", learning_rate),
            decay_steps=max(self.first_steps + whole_number("iterations", iterations, 0) * self.steps, 1),
            expert_steps=1,
        )

    def __repr__(self) -> str:
        return f"ContinuousRespondingExpert({self.solver.game!r}, {self.steps} steps an interaction)"

    def init(self, key: PRNGKeyArray, learner_policy: PolicyNetwork) -> Habits:
        """An expert that has got used to `learner_policy` from nothing."""
        start_key, response_key = jax.random.split(key)
        fresh = jax.vmap(lambda one: self.solver.init(one).expert)(jax.random.split(start_key, POLICIES))
        return self._practised(fresh, learner_policy, response_key, self.first_steps)

    def adapt(self, habits: Habits, learner_policy: PolicyNetwork, key: PRNGKeyArray) -> Habits:
        """Its habits after it has got used to `learner_policy`."""
        return self._practised(habits.practised, learner_policy, key, self.steps)

    def meet(self, habits: Habits, proposal: Proposal, number: int, key: PRNGKeyArray) -> tuple[Habits, Interaction]:
        """Its habits once it is used to the policy proposed, and `number` episodes of both (axes d, T)."""
        adapt_key, start_key = jax.random.split(key)
        adapted = self.adapt(habits, proposal.policy, adapt_key)
        starts = initial_states(self.solver.game, start_key, number)
        seen = episodes_from(self.solver.game, Sides(proposal.policy, adapted.policy), starts)
        return adapted, Interaction(proposal.policy, seen)

    def _practised(self, before: Ascent, learner_policy: PolicyNetwork, key: PRNGKeyArray, steps: int) -> Habits:
        practice_key, trial_key = jax.random.split(key)
        starts = self.solver.starts(trial_key)

        def one(start: Ascent) -> tuple[Ascent, Array]:
            after = self.solver.respond(learner_policy, self.reward, start, practice_key, steps)
            episodes = episodes_from(self.solver.game, Sides(learner_policy, after.policy), starts)
            return after, mean_return(self.reward, episodes, self.solver.discount)

        practised, worth = jax.vmap(one)(before)
        return Habits(practised, jnp.argmax(worth))
