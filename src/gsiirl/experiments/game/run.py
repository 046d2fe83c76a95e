"""A run on one's own finite game as the runner sees it."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, PRNGKeyArray

from gsiirl.baselines.marl import marl
from gsiirl.compilation import QUICKLY
from gsiirl.equilibria import Logit
from gsiirl.errors import InputError
from gsiirl.evaluation.truth import Truth, Yardsticks
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.game.file import OwnGame, read_game
from gsiirl.experiments.policy_run import deployed_episodes, policy_algorithm, saved
from gsiirl.experiments.prepared_run import Algorithm, Ending, Parameters, PreparedRun, Record
from gsiirl.experts.tabular_expert import RespondingExpert
from gsiirl.front_door.fit import GSIIRL
from gsiirl.games.payoff import DensePayoff
from gsiirl.interaction import CHUNK
from gsiirl.learners.commitment_learner import CommitmentLearner
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.json_file import read_versioned_json
from gsiirl.types import Policies, Sides


def prepare(config: GameConfig, saved_game: Path | None = None) -> PreparedRun:
    """The run of a resolved configuration; `saved_game` is the `game.json` of a run to go on with.

    Raises:
        InputError: there is no such game.
    """
    own = own_game(config, saved_game)
    # Through the saved form, so that a run that is gone on with has the same numbers.
    problem = own.problem
    game = jax.tree.map(jnp.asarray, problem.game)
    learner = jax.tree.map(jnp.asarray, settled(config, own).learner(config.iterations))
    reward = DensePayoff(jnp.asarray(own.expert_reward))
    expert = RespondingExpert(game, reward, own.temperature, problem.discount)
    rewards = Sides(jax.tree.map(jnp.asarray, problem.own_reward + problem.dependent_value), reward)
    truth = Truth(game, rewards, Logit(own.temperature), own.temperature, problem.discount)
    yardsticks: Yardsticks = jax.jit(lambda: truth.yardsticks(), compiler_options=QUICKLY)()
    algorithms = {"gsiirl": _gsiirl, "marl": _marl}
    return PreparedRun(
        game=own.to_json_dict(),
        algorithm=algorithms[config.algorithm](config, learner, expert, truth, yardsticks),
        iterations=0 if config.algorithm == "marl" else config.iterations,
        chunk=CHUNK,
        references=lambda: truth.references() | yardsticks.returns,
        parameters={
            "expert_reward": Parameters(problem.unit, tuple(problem.expert_names)),
            "dependent_reward": Parameters(1.0, tuple(problem.dependent_names)),
        },
    )


def own_game(config: GameConfig, saved_game: Path | None) -> OwnGame:
    """The game that the configuration names, or the one that a run folder holds."""
    if saved_game is None:
        return read_game(config.file, config.temperature == "known", config.preset)
    return OwnGame.from_json_dict(read_versioned_json(saved_game, START_AGAIN, False), saved_game)


def settled(config: GameConfig, own: OwnGame) -> GSIIRL:
    """The learner with the configuration's settings."""
    return GSIIRL(
        own.problem,
        lower_level=config.lower_level,
        explore=config.explore,
        hand_back=config.hand_back,
        feedback=config.feedback,
        many_starts=config.starts == "many",
    )


def _gsiirl(
    config: GameConfig, learner: CommitmentLearner, expert: RespondingExpert, truth: Truth, yardsticks: Yardsticks
) -> Algorithm:
    true = _centred(truth, truth.rewards.expert.dense())
    accessed = learner.accessed.dense()

    def judged(policies: Policies, expert_weights: Array, dependent_weights: Array) -> Record:
        estimate = learner.lower.likelihood.features.payoff(expert_weights).dense()
        fitted = learner.dependent_features.payoff(dependent_weights).dense()
        return {
            **truth.evaluate(policies),
            "regret": truth.regret(policies.learner, yardsticks),
            "expert_reward_pearson": _correlation(true, _centred(truth, estimate)),
            "dependent_reward_pearson": _correlation(accessed, fitted),
        }

    return policy_algorithm(
        learner,
        expert,
        truth,
        config.trajectories,
        judged,
        lambda state: state.accessed.solve(),
        lambda policy, key: _sample_paths(truth, policy, key),
    )


def _marl(
    config: GameConfig, learner: CommitmentLearner, expert: RespondingExpert, truth: Truth, yardsticks: Yardsticks
) -> Algorithm:
    play = marl(truth.game, truth.rewards, truth.forward_model, truth.discount)
    if not play.converged:
        problem = f"at the temperature {truth.temperature:g} its equilibrium is not found"
        raise InputError("FILE", problem, "give a temperature nearer to the size of the rewards")

    def finish(_: Array, key: PRNGKeyArray) -> Ending:
        learner_policy = play.policies.learner
        record = {
            **truth.evaluate(play.policies),
            "regret": truth.regret(learner_policy, yardsticks),
            "forward_residual": jnp.where(play.converged, play.residual, jnp.inf),
        }
        return Ending(record, _sample_paths(truth, learner_policy, key), {}, {}, saved(play.policies))

    return Algorithm(lambda key: jnp.zeros(()), lambda state, key, first, number: (state, {}), finish)


def _centred(truth: Truth, table: Array) -> Array:
    """r_e less its mean over the expert's actions: what is added to all of them in a state is never seen."""
    allowed = truth.game.allowed.expert
    weights = jnp.ones_like(table) if allowed is None else jnp.broadcast_to(allowed[:, None, :], table.shape) * 1.0
    mean = jnp.sum(weights * table, axis=-1, keepdims=True) / jnp.sum(weights, axis=-1, keepdims=True)
    return jnp.where(weights > 0, table - mean, 0.0)


def _correlation(first: Array, second: Array) -> Array:
    """Pearson's, over all state-actions; 0 where one of them is constant."""
    first, second = first - jnp.mean(first), second - jnp.mean(second)
    scale = jnp.linalg.norm(first) * jnp.linalg.norm(second)
    return jnp.where(scale > 0, jnp.sum(first * second) / jnp.where(scale > 0, scale, 1.0), 0.0)


def _sample_paths(truth: Truth, policy: Array, key: PRNGKeyArray) -> dict[str, Array]:
    """Episodes of a learner's policy and the true expert's response to it."""
    paths = deployed_episodes(truth, policy, key)
    return {
        "state": paths.states,
        "learner_action": paths.actions.learner,
        "expert_action": paths.actions.expert,
        "over": (~paths.mask).astype(np.int64),
    }
