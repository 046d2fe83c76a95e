"""The other side: somebody with aims of its own, who answers the policy that the learner plays."""

import abc

import jax
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.arguments import discount_of, positive
from gsiirl.equilibria.base import AbstractForwardModel
from gsiirl.equilibria.response import respond
from gsiirl.errors import InputError
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.games.rollout import rollout
from gsiirl.interaction import AbstractExpert, Proposal
from gsiirl.irl.estimated_policy import estimated_policy
from gsiirl.problems.problem import joint_payoff
from gsiirl.types import Interaction, Sides, Trajectories


class AbstractTabularExpert(AbstractExpert[None]):
    """An expert of a finite game that JAX can trace, and that remembers nothing from one interaction to the next.

    Anybody else (a person, a simulator) needs only a `demonstrate` of the same form.
    """

    @abc.abstractmethod
    def demonstrate(self, learner_policy: Float[Array, "T S A_l"], number: int, key: PRNGKeyArray) -> Trajectories:
        """`number` episodes of the expert against `learner_policy`."""

    def init(self, key: PRNGKeyArray, learner_policy: PyTree) -> None:
        return None

    def meet(self, habits: None, proposal: Proposal, number: int, key: PRNGKeyArray) -> tuple[None, Interaction]:
        return None, Interaction(proposal.policy, self.demonstrate(proposal.policy, number, key))


class RespondingExpert(AbstractTabularExpert):
    """An expert that plays its soft best response, at temperature τ, to the policy that the learner plays.

    It alone holds the true expert reward; a learner meets that reward only through the actions it sees.
    """

    game: AbstractTabularGame
    reward: AbstractPayoff
    temperature: float
    discount: float

    def __init__(self, game: AbstractTabularGame, reward: object, temperature: float, discount: float) -> None:
        """The expert of `reward` r_e: an array (S, A_l, A_e), or a payoff that the library made; τ in its units.

        Raises:
            InputError: an argument cannot be.
        """
        if not isinstance(game, AbstractTabularGame):
            raise InputError("game", f"is {type(game).__name__}", "make one with gsiirl.games.TabularGame.from_arrays")
        if reward is None:
            raise InputError("reward", "is None", "give the expert's reward, an array (S, A_l, A_e)")
        self.game = game
        self.reward = joint_payoff("reward", reward, game)
        self.temperature = positive("temperature", temperature)
        self.discount = discount_of(discount)

    def __repr__(self) -> str:
        return f"RespondingExpert({self.game!r}, temperature {self.temperature}, discount {self.discount})"

    def policy(self, learner_policy: Float[Array, "T S A_l"]) -> Float[Array, "T S A_e"]:
        """π_e = respond(π_l, r_e)."""
        return respond(self.game, learner_policy, self.reward, self.temperature, self.discount).policy

    def demonstrate(self, learner_policy: Float[Array, "T S A_l"], number: int, key: PRNGKeyArray) -> Trajectories:
        policies = Sides(learner_policy, self.policy(learner_policy))
        return jax.vmap(lambda one: rollout(one, self.game, policies))(jax.random.split(key, number))


class SimulatedExpert(AbstractExpert[None]):
    """The paper's expert: it is told what the learner acts on, and plays the equilibrium of that with its own reward.

    Both sides' trajectories come from the forward model at (r^θ_l + r_li, true r_e). The learner's half of that was
    made with the true r_e, so that the learner does not know it, and must estimate what it played from what it saw.
    `reward` is the true r_e, over (S, A_l, A_e). Only a learner that commits to a reward can meet this expert.
    """

    game: AbstractTabularGame
    reward: AbstractPayoff
    forward_model: AbstractForwardModel
    discount: float

    def __repr__(self) -> str:
        return f"SimulatedExpert({self.game!r}, {self.forward_model}, discount {self.discount})"

    def init(self, key: PRNGKeyArray, learner_policy: PyTree) -> None:
        return None

    def meet(self, habits: None, proposal: Proposal, number: int, key: PRNGKeyArray) -> tuple[None, Interaction]:
        assert proposal.reward is not None, "a SimulatedExpert is told the reward that the learner acts on"
        seen = self.demonstrate_told(proposal.reward, number, key)
        return None, Interaction(estimated_policy(seen.states, seen.actions.learner, proposal.policy), seen)

    def demonstrate_told(self, learner_reward: AbstractPayoff, number: int, key: PRNGKeyArray) -> Trajectories:
        """`number` episodes of the equilibrium of (`learner_reward`, r_e)."""
        policies = self.forward_model.solve(self.game, Sides(learner_reward, self.reward), self.discount).policies
        return jax.vmap(lambda one: rollout(one, self.game, policies))(jax.random.split(key, number))
