"""The other side of a continuous game: it goes on improving its answer to whatever policy the learner plays."""

import equinox as eqx
import jax
from jaxtyping import PRNGKeyArray

from gsiirl.equilibria.pathwise import Ascent, Pathwise, TransitionReward, episodes_from
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.types import Sides, Transition


class ContinuousRespondingExpert(eqx.Module):
    """An expert that plays a best response to the policy that the learner plays, found by its own gradient ascent.

    It alone holds the true expert reward. Its policy is its own state, an `Ascent`, passed in and out: from one
    interaction to the next it starts from its habits and takes `steps` steps. Its first habits are its answer to the
    learner's first policy, after `first_steps` steps: who has not learned yet what is good for it shows nothing of what
    it wants.
    """

    solver: Pathwise
    reward: TransitionReward
    steps: int = eqx.field(static=True)
    first_steps: int = eqx.field(static=True)

    def init(self, key: PRNGKeyArray, learner_policy: PolicyNetwork) -> Ascent:
        """An expert that has got used to `learner_policy` from nothing."""
        start_key, response_key = jax.random.split(key)
        fresh = self.solver.init(start_key).expert
        return self.solver.respond(learner_policy, self.reward, fresh, response_key, self.first_steps)

    def adapt(self, habits: Ascent, learner_policy: PolicyNetwork, key: PRNGKeyArray) -> Ascent:
        """Its policy after it has got used to `learner_policy`."""
        return self.solver.respond(learner_policy, self.reward, habits, key, self.steps)

    def demonstrate(
        self, habits: Ascent, learner_policy: PolicyNetwork, number: int, key: PRNGKeyArray
    ) -> tuple[Ascent, Transition]:
        """Its policy once it is used to `learner_policy`, and `number` episodes of both (axes d, T)."""
        adapt_key, start_key = jax.random.split(key)
        adapted = self.adapt(habits, learner_policy, adapt_key)
        game = self.solver.game
        starts = jax.vmap(game.reset)(jax.random.split(start_key, number))
        policies = Sides(learner_policy, adapted.policy)
        return adapted, episodes_from(game, policies, starts)
