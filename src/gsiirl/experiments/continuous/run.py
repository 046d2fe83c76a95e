"""A continuous experiment as the runner sees it: its four algorithms, and what is recorded of each."""

import math
from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.baselines.continuous_ma_irl import ContinuousMAIRL, ContinuousMAIRLState
from gsiirl.baselines.maddpg import Maddpg, MaddpgState
from gsiirl.equilibria.pathwise import FOLLOWING_RATE, Ascent, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import weights_of
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.experiment import ContinuousExperiment, front_door_of
from gsiirl.experiments.continuous.judge import Judge
from gsiirl.experiments.prepared_run import Algorithm, Ending, Parameters, PreparedRun, Record
from gsiirl.experts.continuous_expert import ContinuousRespondingExpert, Habits
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.hypergradients import SPSA
from gsiirl.interaction import Meeting, interact
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, growing_steps
from gsiirl.learners.continuous_learner import ContinuousLearner, ContinuousState, GradientSteps
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.rewards.continuous import (
    AbstractTransitionFeatures,
    AbstractTransitionReward,
    LinearTransitionReward,
    NetworkReward,
)
from gsiirl.types import Sides

CHUNK = 2
TRAINING_CHUNK = 50
"""Solver steps in one iteration of `marl`."""
MADDPG_CHUNK = 20
"""Episodes of all environments in one iteration of `marl` by MADDPG."""


def learnable_reward(
    config: ContinuousConfig, features: AbstractTransitionFeatures, scale: float
) -> AbstractTransitionReward:
    """r_e^θ as the configuration asks for it."""
    if config.reward == "network":
        return NetworkReward(features=features, scale=scale / math.sqrt(len(features.names)))
    return LinearTransitionReward(features=features, scale=scale)


def prepare_continuous(config: ContinuousConfig, experiment: ContinuousExperiment) -> PreparedRun:
    """The run of a resolved configuration."""
    judge, problem = Judge(config, experiment), experiment.problem
    rewards: dict[str, AbstractTransitionReward] = {"expert_reward": problem.expert_reward}
    rewards |= dict.fromkeys(("dependent_reward", "commitment"), problem.dependent_reward)
    chunk = MADDPG_CHUNK if config.solver == "maddpg" else TRAINING_CHUNK
    training = math.ceil((config.maddpg_episodes if config.solver == "maddpg" else config.training_steps) / chunk)
    return PreparedRun(
        game=experiment.description,
        algorithm=_ALGORITHMS[config.algorithm](config, experiment, judge),
        iterations=training if config.algorithm == "marl" else config.iterations,
        chunk=CHUNK,
        references=judge.random_alone if config.algorithm == "marl" else judge.references,
        parameters={name: Parameters(each.scale, tuple(each.names)) for name, each in rewards.items()},
    )


def _gsiirl(config: ContinuousConfig, experiment: ContinuousExperiment, judge: Judge) -> Algorithm:
    problem = experiment.problem
    learner, front_door = learner_of(config, problem), front_door_of(config, problem)
    expert = expert_of(config, experiment)

    def observe(
        state: ContinuousState, model: Sides[PolicyNetwork], played: PolicyNetwork, answer: PolicyNetwork
    ) -> Record:
        record, modelled, real = judge.play(model, Sides(played, answer))
        return {
            **record,
            **judge.expert_reward(state.expert_parameters, modelled, real),
            "dependent_reward_pearson": judge.dependent_reward_pearson(learner.fitted_dependent_reward(state)),
            "expert_trajectories": (state.memory.count * config.trajectories).astype(jnp.float32),
        }

    def init(key: PRNGKeyArray) -> tuple[ContinuousState, Habits]:
        learner_key, expert_key = jax.random.split(key)
        state = learner.init(learner_key)
        return state, expert.init(expert_key, learner.propose(state).policy)

    def record(met: Meeting[ContinuousState, Habits]) -> Record:
        found = observe(met.state, policies_of(met.state.solution), met.proposal.policy, met.habits.policy)
        return found | {"exploring": learner.explores(met.state).astype(jnp.float32)}

    def advance(carry: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        return interact(learner, expert, carry, key, first, number, config.trajectories, record)

    def finish(carry: tuple[ContinuousState, Habits], key: PRNGKeyArray) -> Ending:
        state, habits = carry
        settle_key, response_key = jax.random.split(key)
        rewards = learner.rewards(state.commitment, state.expert_parameters)
        model = front_door.settled(state.solution, rewards, settle_key)
        answer = judge.true.best_response(model.learner, (habits.policy, model.expert), response_key)
        learned = {
            "expert_reward": state.expert_parameters,
            "dependent_reward": learner.fitted_dependent_reward(state),
            "commitment": state.commitment,
        }
        return Ending(
            observe(state, model, model.learner, answer) | {"exploring": jnp.zeros((), jnp.float32)},
            judge.paths(Sides(model.learner, answer)),
            learned,
            experiment.reward_map(state.expert_parameters),
            weights_of(learner=model.learner, expert=model.expert, response=answer),
        )

    return Algorithm(init, advance, finish)


def expert_of(config: ContinuousConfig, experiment: ContinuousExperiment) -> ContinuousRespondingExpert:
    """The real expert, which never stops learning: its rate falls over all that it takes part in."""
    return ContinuousRespondingExpert(
        experiment.problem.game,
        experiment.true_expert_reward,
        config.discount,
        iterations=config.iterations,
        steps=config.response_steps,
        first_steps=config.judging_steps // 4,
        batch=config.batch,
        hidden=config.hidden,
        learning_rate=config.learning_rate,
    )


def learner_of(config: ContinuousConfig, problem: ContinuousProblem) -> ContinuousLearner:
    """The learner of `gsiirl`, or of `paper`."""
    learner = front_door_of(config, problem).learner(config.iterations, config.trajectories)
    if config.algorithm != "paper":
        return learner
    outer_step = 1.0 / (config.smoothness * max(config.iterations, 1) ** 0.5)
    return replace(
        learner,
        inner_loop=MaximumLikelihood(1.0, growing_steps, optax.sgd(config.gradient_step_size)),
        upper=GradientSteps(SPSA("frozen", perturbation=1.0, decay=1.0), optax.sgd(outer_step)),
        remembered=1,
        lower_level="equilibrium",
    )


def _ma_irl(config: ContinuousConfig, experiment: ContinuousExperiment, judge: Judge) -> Algorithm:
    # At least as many solver steps an iteration as GSIIRL's forward model takes, spread over the matching steps.
    between = math.ceil(config.solver_steps / config.inner_steps)
    problem, front_door = experiment.problem, front_door_of(config, experiment.problem)
    ma_irl = ContinuousMAIRL(
        solver=front_door.solver(config.iterations * config.inner_steps * between, FOLLOWING_RATE),
        own_reward=problem.own_reward,
        rewards=Sides(problem.dependent_reward, problem.expert_reward),
        regularisation=config.regularisation,
        steps=config.inner_steps,
        solver_steps=between,
        optimiser=front_door.matching(),
    )
    expert = expert_of(config, experiment)

    def observe(state: ContinuousMAIRLState, model: Sides[PolicyNetwork], answer: PolicyNetwork) -> Record:
        record, modelled, real = judge.play(model, Sides(model.learner, answer))
        asked = jnp.asarray(float(config.trajectories * config.iterations), jnp.float32)
        return {
            **record,
            **judge.expert_reward(state.parameters.expert, modelled, real),
            "expert_trajectories": asked,
        }

    def init(key: PRNGKeyArray) -> PyTree:
        parameter_key, play_key, expert_key = jax.random.split(key, 3)
        true_play = judge.true.marl(play_key)
        state = ma_irl.init(parameter_key)
        return state, policies_of(true_play), expert.init(expert_key, state.solution.learner.policy)

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(carry: PyTree, offset: Array) -> tuple[PyTree, Record]:
            state, true_play, habits = carry
            start_key, update_key, expert_key = jax.random.split(jax.random.fold_in(key, first + offset), 3)
            # The share of the fixed demonstrations that this iteration looks at.
            starts = initial_states(problem.game, start_key, config.trajectories)
            seen = episodes_from(problem.game, true_play, starts)
            habits = expert.adapt(habits, state.solution.learner.policy, expert_key)
            record = observe(state, policies_of(state.solution), habits.policy)
            return (ma_irl.update(state, seen, update_key), true_play, habits), record

        return jax.lax.scan(one_iteration, state, jnp.arange(number))

    def finish(carry: PyTree, key: PRNGKeyArray) -> Ending:
        state, _, habits = carry
        settle_key, response_key = jax.random.split(key)
        model = front_door.settled(state.solution, ma_irl.modelled_rewards(state.parameters), settle_key)
        answer = judge.true.best_response(model.learner, (habits.policy, model.expert), response_key)
        learned = {"expert_reward": state.parameters.expert, "commitment": state.parameters.learner}
        return Ending(
            observe(state, model, answer),
            judge.paths(Sides(model.learner, answer)),
            learned,
            experiment.reward_map(state.parameters.expert),
            weights_of(learner=model.learner, expert=model.expert, response=answer),
        )

    return Algorithm(init, advance, finish)


def _marl(config: ContinuousConfig, experiment: ContinuousExperiment, judge: Judge) -> Algorithm:
    init, train, policies_in = _maddpg(experiment, config) if config.solver == "maddpg" else _pathwise(judge)

    def observe(policies: Sides[PolicyNetwork], response: PolicyNetwork) -> Record:
        record, _, _ = judge.play(policies, Sides(policies.learner, response))
        return {**record, **judge.truth(policies)}

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(state: PyTree, offset: Array) -> tuple[PyTree, Record]:
            policies = policies_in(state)
            # Best responses are found at the end alone.
            unknown = dict.fromkeys(("exploitability_learner", "exploitability_expert"), jnp.asarray(jnp.nan))
            record = observe(policies, policies.expert) | unknown
            return train(state, jax.random.fold_in(key, first + offset)), record

        return jax.lax.scan(one_iteration, state, jnp.arange(number))

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        policies = policies_in(state)
        response = judge.true.best_response(policies.learner, (policies.expert,), key)
        return Ending(
            observe(policies, response) | judge.exploitability(policies, response, key),
            judge.paths(Sides(policies.learner, response)),
            {},
            {},
            weights_of(learner=policies.learner, expert=policies.expert, response=response),
        )

    return Algorithm(init, advance, finish)


Training = tuple[
    Callable[[PRNGKeyArray], PyTree],
    Callable[[PyTree, PRNGKeyArray], PyTree],
    Callable[[PyTree], Sides[PolicyNetwork]],
]
"""How MARL begins, goes on for one iteration, and what it plays."""


def _pathwise(judge: Judge) -> Training:
    def train(state: Sides[Ascent], key: PRNGKeyArray) -> Sides[Ascent]:
        return judge.true.trainer.ascend(state, judge.true.rewards, key, TRAINING_CHUNK)[0]

    return judge.true.trainer.init, train, policies_of


def _maddpg(experiment: ContinuousExperiment, config: ContinuousConfig) -> Training:
    solver = Maddpg(experiment.problem.game, config.discount, config.hidden)

    def init(key: PRNGKeyArray) -> MaddpgState:
        # The replay is filled before the first update.
        return solver.train(experiment.true_rewards, key, 0)

    def train(state: MaddpgState, key: PRNGKeyArray) -> MaddpgState:
        return solver.go_on(state, experiment.true_rewards, key, MADDPG_CHUNK)

    return init, train, lambda state: state.policies


_ALGORITHMS = {"gsiirl": _gsiirl, "paper": _gsiirl, "ma-irl": _ma_irl, "marl": _marl}
