"""The other side: somebody with aims of its own, who answers the policy that the learner plays."""

import abc

import equinox as eqx
import jax
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.equilibria.base import AbstractForwardModel
from gsiirl.equilibria.response import respond
from gsiirl.errors import InputError
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.games.rollout import rollout
from gsiirl.problem import discount_of, joint_payoff, positive
from gsiirl.types import Sides, Trajectories


class AbstractExpert(eqx.Module):
    """An expert that JAX can trace: its episodes can be drawn inside a compiled loop.

    Anybody else (a person, a simulator, logged data) needs only a `demonstrate` of the same form; see
    `interaction.live`.
    """

    @abc.abstractmethod
    def demonstrate(self, learner_policy: Float[Array, "T S A_l"], number: int, key: PRNGKeyArray) -> Trajectories:
        """`number` episodes of the expert against `learner_policy`."""


class RespondingExpert(AbstractExpert):
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

    def policy(self, learner_policy: Float[Array, "T S A_l"]) -> Float[Array, "T S A_e"]:
        """π_e = respond(π_l, r_e)."""
        return respond(self.game, learner_policy, self.reward, self.temperature, self.discount).policy

    def demonstrate(self, learner_policy: Float[Array, "T S A_l"], number: int, key: PRNGKeyArray) -> Trajectories:
        policies = Sides(learner_policy, self.policy(learner_policy))
        return jax.vmap(lambda one: rollout(one, self.game, policies))(jax.random.split(key, number))


class SimulatedExpert(eqx.Module):
    """The paper's expert: it is told what the learner acts on, and plays the equilibrium of that with its own reward.

    Both sides' trajectories come from the forward model at (r^θ_l + r_li, true r_e). The learner's half of that was
    made with the true r_e, so that the learner does not know it, and must estimate what it played from what it saw.
    """

    game: AbstractTabularGame
    reward: AbstractPayoff
    forward_model: AbstractForwardModel
    discount: float

    def demonstrate_told(self, learner_reward: AbstractPayoff, number: int, key: PRNGKeyArray) -> Trajectories:
        """`number` episodes of the equilibrium of (`learner_reward`, r_e)."""
        policies = self.forward_model.solve(self.game, Sides(learner_reward, self.reward), self.discount).policies
        return jax.vmap(lambda one: rollout(one, self.game, policies))(jax.random.split(key, number))
