"""A result of a continuous game beside its yardsticks, with the true reward (`ContinuousResult.evaluate`)."""

from dataclasses import dataclass

import equinox as eqx
import jax
from jaxtyping import Array, PRNGKeyArray

from gsiirl.equilibria.pathwise import policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.evaluation.result import AbstractEvaluation
from gsiirl.evaluation.true_returns import TrueReturns
from gsiirl.types import Sides


@dataclass(frozen=True, repr=False)
class ContinuousEvaluation(AbstractEvaluation):
    """The learner's returns against the true expert; discounted, and under `undiscounted` without discount.

    `deployed` is what the result's policy earns against the best response that a search with the true reward finds, and
    `random` what an untrained policy earns so; `marl` what a pair earns that trained with both true rewards. What the
    expert earns in the same episodes is under `expert`, and without discount under `expert_undiscounted`.
    """

    deployed: float
    marl: float
    random: float
    undiscounted: dict[str, float]
    expert: dict[str, float]
    expert_undiscounted: dict[str, float]


def evaluate(
    true: TrueReturns, policies: Sides[PolicyNetwork], discount: float, key: PRNGKeyArray
) -> ContinuousEvaluation:
    """Every yardstick in one record; `policies` are those of the learner and of the expert as it is expected to be."""

    @eqx.filter_jit
    def measured() -> dict[str, tuple[Sides[Array], Sides[Array]]]:
        response_key, marl_key, random_key = jax.random.split(key, 3)
        response = true.best_response(policies.learner, (policies.expert,), response_key)
        pairs = {
            "deployed": Sides(policies.learner, response),
            "marl": policies_of(true.marl(marl_key)),
            "random": true.untrained(random_key),
        }
        episodes = {name: true.episodes(pair) for name, pair in pairs.items()}
        return {name: (true.returns(each, discount), true.returns(each)) for name, each in episodes.items()}

    found = measured()
    learner, expert = (
        [{name: float(getattr(each[plain], side)) for name, each in found.items()} for plain in (0, 1)]
        for side in ("learner", "expert")
    )
    return ContinuousEvaluation(**learner[0], undiscounted=learner[1], expert=expert[0], expert_undiscounted=expert[1])
