"""A learner that commits to a policy, as the runner sees it; shared by the finite experiments."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.evaluation.truth import Truth, named
from gsiirl.experiments.prepared_run import Algorithm, Ending, Record
from gsiirl.experts.tabular_expert import AbstractTabularExpert
from gsiirl.games.rollout import rollout
from gsiirl.interaction import Meeting, interact
from gsiirl.learners.commitment_learner import CommitmentLearner, LearnerState
from gsiirl.runs.policies import DRAWS
from gsiirl.types import Policies, Sides, Trajectories

SAMPLE_PATHS = 3


def policy_algorithm(
    learner: CommitmentLearner,
    expert: AbstractTabularExpert,
    truth: Truth,
    trajectories: int,
    judged: Callable[[Policies, Array, Array], Record],
    dependent: Callable[[LearnerState], Array],
    sample_paths: Callable[[Array, PRNGKeyArray], dict[str, Array]],
) -> Algorithm:
    """`judged` says what the truth says of (policies, weights of r_e in units of τ, weights of r_ld).

    Recorded as deployed is, along the iterations, the best policy under the estimate so far, and at the end the one
    that is handed back; what was played stands beside it.
    """

    def observe(state: LearnerState, policies: Policies) -> Record:
        played = truth.returns(Sides(state.proposed, truth.expert_response(state.proposed)))
        return {
            **judged(policies, learner.lower.estimate(state.lower), dependent(state)),
            **named("played", played),
            **learner.report(state),
            "expert_trajectories": state.count * trajectories,
            "game_solves": jnp.zeros_like(state.count),
        }

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def record(met: Meeting[LearnerState, None]) -> Record:
            return observe(met.state, learner.incumbent(met.state).policies)

        (state, _), records = interact(learner, expert, (state, None), key, first, number, trajectories, record)
        return state, records

    def finish(state: LearnerState, key: PRNGKeyArray) -> Ending:
        path_key, end_key = jax.random.split(key)
        policies = learner.end(state, end_key).policies
        draws = learner.posterior_draws(state, jax.random.fold_in(end_key, 1))
        learned = {"expert_reward": learner.lower.estimate(state.lower), "dependent_reward": dependent(state)}
        paths = sample_paths(policies.learner, path_key)
        kept = saved(policies) | ({DRAWS: draws} if draws.size else {})
        return Ending(observe(state, policies), paths, learned, {}, kept)

    return Algorithm(learner.init, advance, finish)


def deployed_episodes(truth: Truth, learner_policy: Array, key: PRNGKeyArray) -> Trajectories:
    """A few episodes of a learner's policy and the true expert's response to it."""
    deployed = Sides(learner_policy, truth.expert_response(learner_policy))
    keys = jax.random.split(key, SAMPLE_PATHS)
    return jax.vmap(lambda one: rollout(one, truth.game, deployed))(keys)


def saved(policies: Policies) -> dict[str, Array]:
    """A joint policy as a run folder keeps it: tables (T, S, A)."""
    return {"learner.table": policies.learner, "expert.table": policies.expert}
