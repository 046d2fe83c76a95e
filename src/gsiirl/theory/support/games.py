"""Small random general-sum games, on which the theory is checked."""

from dataclasses import dataclass
from typing import Literal

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.equilibria.logit import Logit
from gsiirl.equilibria.response import respond
from gsiirl.equilibria.soft_joint import SoftJoint
from gsiirl.games.payoff import DensePayoff
from gsiirl.games.tabular import TabularGame
from gsiirl.irl.expectations import reward_gradient_expectation
from gsiirl.learners.bilevel import Bilevel, LowerLevel
from gsiirl.rewards.linear import Linear, TabularFeatures
from gsiirl.types import Number, Policies, Sides

TEMPERATURE, DISCOUNT = 0.5, 0.9
ForwardModel = Literal["logit", "soft_joint"]


@dataclass(frozen=True)
class Size:
    """Of a random game: states, actions of both sides, steps, and parameters n of r_ld and m of r_e."""

    states: int = 5
    learner_actions: int = 3
    expert_actions: int = 2
    horizon: int = 6
    learner_parameters: int = 4
    expert_parameters: int = 3


SIZES = (Size(), Size(states=4, learner_actions=2, expert_actions=3, horizon=4, learner_parameters=3), Size(states=8))


class RandomProblem(eqx.Module):
    """A random game with features of both parametric rewards and everything that is true.

    `own_reward` r_li and `accessed` r_ld (S, A_l, A_e); `learner_features` (S, A_l, A_e, n), `expert_features`
    (S, A_l, A_e, m); the true r_e is θ_true · expert_features + `unexpressed`, the part (S, A_l, A_e) that no θ_e
    expresses.
    """

    game: TabularGame
    own_reward: Float[Array, "S A_l A_e"]
    accessed: Float[Array, "S A_l A_e"]
    learner_features: Float[Array, "S A_l A_e n"]
    expert_features: Float[Array, "S A_l A_e m"]
    true_parameters: Float[Array, " m"]
    unexpressed: Float[Array, "S A_l A_e"]
    forward_model: ForwardModel = eqx.field(static=True, default="logit")

    @classmethod
    def draw(cls, seed: int, size: Size, true_norm: float = 0.5) -> "RandomProblem":
        """Three random successors of every (s, a), standard normal features and rewards, and ‖θ_true‖ = `true_norm`.

        With `true_norm` above 1 the true reward lies outside the unit ball, and the fit ends on its sphere. Nothing of
        r_e is outside its class, and the forward model is the logit equilibrium.
        """
        random = np.random.default_rng(seed)
        shape = (size.states, size.learner_actions, size.expert_actions)
        game = TabularGame.from_arrays(
            (random.integers(size.states, size=(*shape, 3)), random.dirichlet(np.ones(3), size=shape)),
            initial=random.dirichlet(np.ones(size.states)),
            horizon=size.horizon,
        )
        true_parameters = of_norm(random, true_norm, size.expert_parameters)
        return cls(
            game=game,
            own_reward=jnp.asarray(0.3 * random.normal(size=shape)),
            accessed=jnp.asarray(random.normal(size=shape)),
            learner_features=jnp.asarray(random.normal(size=(*shape, size.learner_parameters))),
            expert_features=jnp.asarray(random.normal(size=(*shape, size.expert_parameters))),
            true_parameters=true_parameters,
            unexpressed=jnp.zeros(shape),
        )

    def true_expert_reward(self) -> DensePayoff:
        """r_e."""
        return DensePayoff(self.expert_features @ self.true_parameters + self.unexpressed)

    def bilevel(self, regularisation: Number, lower_level: LowerLevel = "played") -> Bilevel:
        """Both levels under the forward model, with linear rewards."""
        return Bilevel(
            game=self.game,
            own_reward=DensePayoff(self.own_reward),
            accessed=DensePayoff(self.accessed),
            dependent_reward=Linear(_features(self.learner_features), 1.0),
            expert_reward=Linear(_features(self.expert_features), 1.0),
            forward_model=Logit(TEMPERATURE) if self.forward_model == "logit" else SoftJoint(TEMPERATURE),
            temperature=TEMPERATURE,
            discount=DISCOUNT,
            regularisation=regularisation,
            lower_level=lower_level,
        )

    def answered(self, learner_policy: Float[Array, "T S A_l"]) -> Policies:
        """π_l with the true expert's response to it."""
        answer = respond(self.game, learner_policy, self.true_expert_reward(), TEMPERATURE, DISCOUNT).policy
        return Sides(learner_policy, answer)

    def interaction(self, bilevel: Bilevel, commitment: Float[Array, " n"], believed: Float[Array, " m"]) -> Policies:
        """What both sides do while demonstrations are collected at (θ_l, θ̄_e).

        Under `equilibrium` (the paper) both follow the forward model at (θ_l, true r_e), and θ̄_e plays no part.
        """
        if bilevel.lower_level == "equilibrium":
            true = Sides(bilevel.committed_reward(commitment), self.true_expert_reward())
            return bilevel.forward_model.solve(self.game, true, DISCOUNT).policies
        return self.answered(bilevel.solve(commitment, believed).policies.learner)

    def features_met(self, policies: Policies) -> Float[Array, " m"]:
        """μ_e, the exact expectation over infinitely many episodes of both policies."""
        return reward_gradient_expectation(self.game, Linear(_features(self.expert_features), 1.0), policies, DISCOUNT)

    def demonstrated(
        self, bilevel: Bilevel, commitment: Float[Array, " n"], believed: Float[Array, " m"]
    ) -> Float[Array, " m"]:
        """μ̂_e of infinitely many demonstrations collected at (θ_l, θ̄_e)."""
        return self.features_met(self.interaction(bilevel, commitment, believed))


def of_norm(random: np.random.Generator, norm: float, length: int) -> Float[Array, " k"]:
    """A vector of that norm in a random direction."""
    direction = random.normal(size=length)
    return jnp.asarray(norm * direction / np.linalg.norm(direction))


def _features(table: Float[Array, "S A_l A_e k"]) -> TabularFeatures:
    return TabularFeatures(table=table, names=tuple(f"feature {number}" for number in range(table.shape[-1])))
