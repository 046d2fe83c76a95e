"""Evaluation under the true rewards; no learner holds any of this."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.commitment import Commitment
from gsiirl.equilibria.base import AbstractForwardModel
from gsiirl.equilibria.gap import nash_gap
from gsiirl.equilibria.response import respond
from gsiirl.evaluation.commitment import SHARPER, equilibrium, extremes
from gsiirl.games.base import AbstractTabularGame, uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.irl.conditional_likelihood import expected_log_ratio
from gsiirl.irl.expectations import expected_return, reward_gradient_expectation
from gsiirl.rewards.linear import Linear
from gsiirl.types import Policies, Sides


class Yardsticks(eqx.Module):
    """`ceiling` and `floor` of discounted returns, and undiscounted `returns` under the names a run folder uses."""

    ceiling: Float[Array, ""]
    floor: Float[Array, ""]
    returns: dict[str, Float[Array, ""]]


class Truth(eqx.Module):
    """A game with both true rewards; returns are undiscounted.

    `rewards.learner` is r_ld + r_li, `rewards.expert` is r_e; `forward_model` says what MARL plays.
    """

    game: AbstractTabularGame
    rewards: Sides[AbstractPayoff]
    forward_model: AbstractForwardModel
    temperature: float
    discount: float

    def returns(self, policies: Policies) -> Sides[Float[Array, ""]]:
        """E^π[Σ_t r_i(s_t, a_t)] of both sides."""
        return Sides(
            expected_return(self.game, self.rewards.learner, policies, 1.0),
            expected_return(self.game, self.rewards.expert, policies, 1.0),
        )

    def expert_response(self, learner_policy: Float[Array, "T S A_l"]) -> Float[Array, "T S A_e"]:
        """What the true expert plays against `learner_policy`."""
        return respond(self.game, learner_policy, self.rewards.expert, self.temperature, self.discount).policy

    def references(self) -> dict[str, Float[Array, ""]]:
        """Returns of MARL with both true rewards (`truth_`), and of a learner that acts at random (`random_`).

        The random learner meets the true expert's response. Against an expert that acts at random too, a learner's
        return can be higher than at any equilibrium (an attacker that picks edges blindly does no harm), and says
        nothing.
        """
        solution = self.forward_model.solve(self.game, self.rewards, self.discount)
        uniform = uniform_policy(self.game)
        met = Sides(uniform, self.expert_response(uniform))
        return {**named("truth", self.returns(solution.policies)), **named("random", self.returns(met))}

    def yardsticks(self) -> "Yardsticks":
        """The best and the worst commitment with r_e known, and MARL with a sharp learner."""
        commitment = Commitment(self.game, self.rewards.learner, self.discount)
        nothing = jnp.zeros((0, *uniform_policy(self.game).shape), self.game.initial.dtype)
        found = extremes(commitment, self.rewards.expert, self.temperature, nothing, jax.random.key(0))
        sharp = equilibrium(commitment, self.rewards.expert, self.temperature, SHARPER)
        policies = {"ceiling": found.best, "sharp": sharp.policy}
        returns: dict[str, Array] = {}
        for name, policy in policies.items():
            returns |= named(name, self.returns(Sides(policy, self.expert_response(policy))))
        return Yardsticks(found.ceiling, found.floor, returns)

    def regret(self, learner_policy: Float[Array, "T S A_l"], yardsticks: "Yardsticks") -> Float[Array, ""]:
        """(ceiling − deployed) / (ceiling − floor), in discounted returns."""
        commitment = Commitment(self.game, self.rewards.learner, self.discount)
        earned = commitment.value(learner_policy, self.rewards.expert * (1.0 / self.temperature))
        span = yardsticks.ceiling - yardsticks.floor
        return jnp.where(span > 0, (yardsticks.ceiling - earned) / jnp.where(span > 0, span, 1.0), 0.0)

    def evaluate(self, policies: Policies) -> dict[str, Float[Array, ""]]:
        """NashConv, and returns of the pair (`model_`) and of its learner's half with the true expert (`deployed_`)."""
        deployed = Sides(policies.learner, self.expert_response(policies.learner))
        return {
            **named("model", self.returns(policies)),
            **named("deployed", self.returns(deployed)),
            "nash_gap": nash_gap(self.game, self.rewards, policies, self.discount),
        }

    def misfit(
        self, learner_policy: Float[Array, "T S A_l"], reward: Linear, parameters: Float[Array, " m"]
    ) -> dict[str, Float[Array, ""]]:
        """How far the answers predicted by an estimate are from the true expert's.

        `feature_gap`: ‖μ_e(π_l, π̂_e) − μ_e(π_l, π_e)‖ / scale, in features, where π̂_e = respond(π_l, r^θ_e) and π_e is
        the true expert. `log_likelihood_lost`: E^(π_l, π_e)[Σ_t ln π_e,t(a_e | s) − ln π̂_e,t(a_e | s)], in nats an
        episode: how much less likely a held-out episode of the expert is under θ_e than under the truth. Both are 0 at
        the truth, and neither is below.
        """
        modelled = respond(self.game, learner_policy, reward.payoff(parameters), self.temperature, self.discount)
        true = respond(self.game, learner_policy, self.rewards.expert, self.temperature, self.discount)
        met = Sides(learner_policy, true.policy)
        difference = reward_gradient_expectation(
            self.game, reward, Sides(learner_policy, modelled.policy), self.discount
        ) - reward_gradient_expectation(self.game, reward, met, self.discount)
        return {
            "feature_gap": jnp.linalg.norm(difference) / reward.scale,
            "log_likelihood_lost": expected_log_ratio(
                self.game, learner_policy, true.action_values, modelled.action_values
            ),
        }


def named(prefix: str, returns: Sides[Float[Array, ""]]) -> dict[str, Float[Array, ""]]:
    """Returns of both sides under the names a run folder uses."""
    return {f"{prefix}_return_learner": returns.learner, f"{prefix}_return_expert": returns.expert}
