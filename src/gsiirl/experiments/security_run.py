"""The security experiment as the runner sees it: its four algorithms, and what is recorded of each."""

from pathlib import Path

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.baselines.marl import marl
from gsiirl.equilibria import AbstractSolution, LogitSolution
from gsiirl.evaluation.reward_similarity import RewardSimilarity
from gsiirl.experiments.prepared_run import Algorithm, Ending, Parameters, PreparedRun, Record
from gsiirl.experiments.security import SecurityConfig
from gsiirl.experiments.security_problem import SecurityProblem, build, network_of
from gsiirl.games.rollout import rollout
from gsiirl.interaction import CHUNK, interact
from gsiirl.scenarios import read_network
from gsiirl.types import Sides

SAMPLE_PATHS = 3


def prepare(config: SecurityConfig, saved_game: Path | None = None) -> PreparedRun:
    """The run of a resolved configuration; `saved_game` is the `game.json` of a run to go on with.

    Raises:
        InputError: when there is no such network.
    """
    # A run goes on with the network as it was, wherever the file it came from may be now.
    network = network_of(config) if saved_game is None else read_network(saved_game, config.variant)
    problem = build(config, network)
    bilevel = problem.learner.bilevel
    rewards = {"expert_reward": bilevel.expert_reward}
    rewards |= dict.fromkeys(("dependent_reward", "commitment"), bilevel.dependent_reward)
    return PreparedRun(
        game={
            **network.to_json_dict(),
            "horizon": config.horizon,
            "no_op": {"learner": config.learner_no_op, "expert": config.expert_no_op},
            "truth": problem.true_weights,
        },
        algorithm=_ALGORITHMS[config.algorithm](config, problem),
        iterations=0 if config.algorithm == "marl" else config.iterations,
        chunk=CHUNK,
        references=problem.truth.references,
        parameters={name: Parameters(float(each.scale), each.features.names) for name, each in rewards.items()},
    )


def _gsiirl(config: SecurityConfig, problem: SecurityProblem) -> Algorithm:
    learner, judged = problem.learner, _Judge(config, problem)
    asked = config.trajectories * (3 if config.response == "measured" else 1)

    def observe(state: PyTree, proposal: AbstractSolution) -> Record:
        fitted = learner.fitted_dependent_reward(state)
        return {
            **judged(proposal, state.expert_parameters),
            "dependent_reward_pearson": judged.dependent_reward_pearson(fitted),
            "expert_trajectories": (state.memory.count * asked).astype(fitted.dtype),
            "game_solves": state.solves.astype(fitted.dtype),
        }

    def learned(state: PyTree) -> Record:
        return {
            "expert_reward": state.expert_parameters,
            "dependent_reward": learner.fitted_dependent_reward(state),
            "commitment": state.commitment,
        }

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        proposal = learner.propose(state)
        return Ending(observe(state, proposal), _sample_paths(problem, proposal, key), learned(state), {}, {})

    return Algorithm(
        init=learner.init,
        advance=lambda state, key, first, number: interact(
            learner, problem.expert, state, key, first, number, config.trajectories, observe
        ),
        finish=finish,
    )


def _ma_irl(config: SecurityConfig, problem: SecurityProblem) -> Algorithm:
    ma_irl, judged, true_play = problem.ma_irl, _Judge(config, problem), _true_play(config, problem)
    # As many demonstrations as GSIIRL asks for in all its interactions.
    number_of_demonstrations = config.trajectories * max(config.iterations, 1)

    def init(key: PRNGKeyArray) -> PyTree:
        parameter_key, demonstration_key = jax.random.split(key)
        keys = jax.random.split(demonstration_key, number_of_demonstrations)
        demonstrations = jax.vmap(lambda one: rollout(one, problem.game, true_play.policies))(keys)
        return ma_irl.init(parameter_key, demonstrations)

    def observe(state: PyTree, proposal: AbstractSolution) -> Record:
        asked = jnp.asarray(float(number_of_demonstrations))
        return {**judged(proposal, state.parameters.expert), "expert_trajectories": asked}

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(state: PyTree, _: None) -> tuple[PyTree, Record]:
            return ma_irl.update(state), observe(state, ma_irl.propose(state))

        return jax.lax.scan(one_iteration, state, None, length=number)

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        proposal = ma_irl.propose(state)
        learned = {"expert_reward": state.parameters.expert, "commitment": state.parameters.learner}
        return Ending(observe(state, proposal), _sample_paths(problem, proposal, key), learned, {}, {})

    return Algorithm(init, advance, finish)


def _marl(config: SecurityConfig, problem: SecurityProblem) -> Algorithm:
    true_play = _true_play(config, problem)

    def finish(_: PyTree, key: PRNGKeyArray) -> Ending:
        record = {**problem.truth.evaluate(true_play.policies), **_solved(true_play)}
        return Ending(record, _sample_paths(problem, true_play, key), {}, {}, {})

    return Algorithm(
        init=lambda key: jnp.zeros(()), advance=lambda state, key, first, number: (state, {}), finish=finish
    )


_ALGORITHMS = {"gsiirl": _gsiirl, "paper": _gsiirl, "ma-irl": _ma_irl, "marl": _marl}


def _true_play(config: SecurityConfig, problem: SecurityProblem) -> AbstractSolution:
    """Play of the true game, from which both baselines start."""
    truth = problem.truth
    return marl(problem.game, truth.rewards, truth.forward_model, config.discount)


class _Judge:
    """What the truth says of a proposal and of the expert's reward it was made with."""

    def __init__(self, config: SecurityConfig, problem: SecurityProblem) -> None:
        bilevel = problem.learner.bilevel
        self._truth, self._discount, self._expert_reward = problem.truth, config.discount, bilevel.expert_reward
        self._expert = RewardSimilarity.of(problem.game, bilevel.expert_reward.features)
        self._dependent = RewardSimilarity.of(problem.game, bilevel.dependent_reward.features)
        self._true_expert, self._true_dependent = (
            jnp.asarray(problem.true_weights[name]) for name in ("expert_reward", "dependent_reward")
        )

    def __call__(self, proposal: AbstractSolution, expert_parameters: Array) -> Record:
        return {
            **self._truth.evaluate(proposal.policies),
            "expert_reward_pearson": self._expert.pearson(expert_parameters, self._true_expert),
            "expert_reward_epic": self._expert.epic(expert_parameters, self._true_expert, self._discount),
            "feature_gap": self._truth.feature_gap(proposal.policies.learner, self._expert_reward, expert_parameters),
            **_solved(proposal),
        }

    def dependent_reward_pearson(self, fitted: Array) -> Array:
        return self._dependent.pearson(fitted, self._true_dependent)


def _solved(proposal: AbstractSolution) -> Record:
    if not isinstance(proposal, LogitSolution):
        # Only an equilibrium that should have been found, and was not, makes a seed fail.
        return {"forward_residual": proposal.residual}
    return {
        "forward_residual": jnp.where(proposal.converged, proposal.residual, jnp.inf),
        "branch_folds": jnp.sum(proposal.branch_folds).astype(proposal.residual.dtype),
    }


def _sample_paths(problem: SecurityProblem, proposal: AbstractSolution, key: PRNGKeyArray) -> dict[str, Array]:
    """Episodes of the proposed learner and the true expert's response to it."""
    played = proposal.policies.learner
    deployed = Sides(played, problem.truth.expert_response(played))
    keys = jax.random.split(key, SAMPLE_PATHS)
    paths = jax.vmap(lambda one: rollout(one, problem.game, deployed))(keys)
    return {
        "state": jnp.asarray(problem.game.masks)[paths.states],
        "learner_action": paths.actions.learner,
        "expert_action": paths.actions.expert,
    }
