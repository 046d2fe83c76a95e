"""A continuous experiment as the runner sees it: its four algorithms, and what is recorded of each.

Everything reported is measured on the same `evaluation_episodes` initial states, whatever the algorithm, seed and
iteration. Returns are undiscounted sums under the true rewards.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.baselines.continuous_ma_irl import ContinuousMAIRL, ContinuousMAIRLState
from gsiirl.continuous_expert import ContinuousRespondingExpert
from gsiirl.continuous_learner import ContinuousGSIIRL, ContinuousState, TwinBranches, reward_gap
from gsiirl.equilibria.maddpg import Maddpg, MaddpgState
from gsiirl.equilibria.pathwise import Ascent, Pathwise, episodes_from, mean_return, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import weights_of
from gsiirl.evaluation.transition_similarity import epic, pearson
from gsiirl.evaluation.truth import named
from gsiirl.experiments.continuous import ContinuousConfig
from gsiirl.experiments.continuous_problem import ContinuousProblem
from gsiirl.experiments.prepared_run import Algorithm, Ending, Parameters, PreparedRun, Record
from gsiirl.hypergradients import SPSA, AbstractEstimator, Implicit
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps, growing_steps
from gsiirl.rewards.continuous import (
    AbstractTransitionFeatures,
    AbstractTransitionReward,
    LinearTransitionReward,
    NetworkReward,
)
from gsiirl.types import Sides, Transition

EVALUATION_KEY = 20261125
"""Of the initial states that all figures are measured on, and of the transitions that rewards are compared over."""
COMPARED = 4000
SAMPLE_PATHS = 12
CHUNK = 2
SMALL_GAP = 1e-3
TRAINING_CHUNK = 50
"""Solver steps in one iteration of `marl`."""
TRAINED_RATE, FOLLOWING_RATE = 0.02, 0.1
"""What the rate of policies falls to, of the first: of who trains once, and of who follows others to the end."""
MADDPG_CHUNK = 20
"""Episodes of all environments in one iteration of `marl` by MADDPG."""


def learnable_reward(
    config: ContinuousConfig, features: AbstractTransitionFeatures, scale: float
) -> AbstractTransitionReward:
    """r_e^θ as the configuration asks for it."""
    if config.reward == "network":
        return NetworkReward(features=features, scale=scale / math.sqrt(len(features.names)))
    return LinearTransitionReward(features=features, scale=scale)


def prepare_continuous(config: ContinuousConfig, problem: ContinuousProblem) -> PreparedRun:
    """The run of a resolved configuration on its problem."""
    judge = Judge(config, problem)
    rewards: dict[str, AbstractTransitionReward] = {"expert_reward": problem.expert_reward}
    rewards |= dict.fromkeys(("dependent_reward", "commitment"), problem.dependent_reward)
    chunk = MADDPG_CHUNK if config.solver == "maddpg" else TRAINING_CHUNK
    training = math.ceil((config.maddpg_episodes if config.solver == "maddpg" else config.training_steps) / chunk)
    return PreparedRun(
        game=problem.description,
        algorithm=_ALGORITHMS[config.algorithm](config, problem, judge),
        iterations=training if config.algorithm == "marl" else config.iterations,
        chunk=CHUNK,
        references=judge.random_alone if config.algorithm == "marl" else judge.references,
        parameters={name: Parameters(each.scale, tuple(each.names)) for name, each in rewards.items()},
    )


class Judge:
    """What the truth says of policies and of learned rewards."""

    def __init__(self, config: ContinuousConfig, problem: ContinuousProblem) -> None:
        self.config, self.problem = config, problem
        self.trainer = _solver(config, problem, config.training_steps)
        # Whoever answers alone takes one step at a time, without a shaking hand.
        self._tester = _solver(replace(config, expert_steps=1, noise=0.0), problem, config.training_steps)
        start_key, sample_key, self._key = jax.random.split(jax.random.key(EVALUATION_KEY), 3)
        self.starts = jax.vmap(problem.game.reset)(jax.random.split(start_key, config.evaluation_episodes))
        self._sample = jax.vmap(problem.anywhere)(jax.random.split(sample_key, COMPARED))

    def episodes(self, policies: Sides[PolicyNetwork]) -> Transition:
        """Episodes of a pair from the evaluation's initial states."""
        return episodes_from(self.problem.game, policies, self.starts)

    def returns(self, episodes: Transition) -> Sides[Array]:
        """Undiscounted returns of both sides under the true rewards."""
        return jax.tree.map(lambda reward: mean_return(reward, episodes, 1.0), self.problem.true_rewards)

    def play(
        self, model: Sides[PolicyNetwork], deployed: Sides[PolicyNetwork]
    ) -> tuple[Record, Transition, Transition]:
        """Returns of the pair as modelled, and of the pair as deployed with the experiment's own metrics of it."""
        modelled, real = self.episodes(model), self.episodes(deployed)
        record = {
            **named("model", self.returns(modelled)),
            **named("deployed", self.returns(real)),
            **self.problem.judge_episodes(real),
        }
        return record, modelled, real

    def expert_reward(self, parameters: Array, modelled: Transition, real: Transition) -> Record:
        """How right θ_e is, and how the modelled expert's features differ from the real one's."""
        reward, discount = self.problem.expert_reward, self.config.discount
        correlation = pearson(lambda seen: reward(parameters, seen), self.problem.true_expert_reward, self._sample)

        def each(episodes: Transition) -> Array:
            return jax.vmap(lambda one, other: reward_gap(reward, parameters, _alone(one), _alone(other), discount))(
                modelled, episodes
            )

        gaps = each(real)
        spread = jnp.sqrt(jnp.sum(jnp.var(gaps, axis=0)) / self.config.trajectories)
        return {
            "expert_reward_pearson": correlation,
            "expert_reward_epic": epic(correlation),
            "feature_gap": jnp.linalg.norm(jnp.mean(gaps, axis=0)),
            "feature_gap_noise": spread,
            **self.problem.judge_reward(parameters),
        }

    def dependent_reward_pearson(self, fitted: Array) -> Array:
        """Correlation of the fitted r_ld with the true one."""
        reward = self.problem.dependent_reward
        return pearson(lambda seen: reward(fitted, seen), self.problem.dependent_value, self._sample)

    def best_response(self, policies: Sides[PolicyNetwork], habit: PolicyNetwork, key: PRNGKeyArray) -> PolicyNetwork:
        """The better, for the true expert, of its habit trained on and of a fresh policy trained from scratch."""
        reward, steps = self.problem.true_expert_reward, self.config.training_steps

        def trained(start: Ascent) -> PolicyNetwork:
            return self._tester.respond(policies.learner, reward, start, key, steps).policy

        def worth(policy: PolicyNetwork) -> Array:
            return self.returns(self.episodes(Sides(policies.learner, policy))).expert

        return _best(trained, worth, self._tester.init(key).expert, habit)

    def best_answer(self, policies: Sides[PolicyNetwork], key: PRNGKeyArray) -> PolicyNetwork:
        """Likewise the learner's, under the true rewards, to the expert's policy."""
        reward, steps = self.problem.true_rewards.learner, self.config.training_steps

        def trained(start: Ascent) -> PolicyNetwork:
            return self._tester.answer(policies.expert, reward, start, key, steps).policy

        def worth(policy: PolicyNetwork) -> Array:
            return self.returns(self.episodes(Sides(policy, policies.expert))).learner

        return _best(trained, worth, self._tester.init(key).learner, policies.learner)

    def true_play(self, key: PRNGKeyArray) -> Sides[Ascent]:
        """What MARL comes to after `training_steps` with both true rewards."""
        start_key, ascent_key = jax.random.split(key)
        start = self.trainer.init(start_key)
        return self.trainer.ascend(start, self.problem.true_rewards, ascent_key, self.config.training_steps)[0]

    def exploitability(self, policies: Sides[PolicyNetwork], response: PolicyNetwork, key: PRNGKeyArray) -> Record:
        """What a best response gains over either side's policy, as a share of |return|; `response` is the expert's."""
        now = self.returns(self.episodes(policies))
        best = Sides(
            self.returns(self.episodes(Sides(self.best_answer(policies, key), policies.expert))).learner,
            self.returns(self.episodes(Sides(policies.learner, response))).expert,
        )
        gains = jax.tree.map(lambda after, before: (after - before) / jnp.abs(before), best, now)
        return {"exploitability_learner": gains.learner, "exploitability_expert": gains.expert}

    def truth(self, policies: Sides[PolicyNetwork]) -> Record:
        """What a MARL pair earns, under the names of a reference."""
        episodes = self.episodes(policies)
        rates = {f"truth_{name}": value for name, value in self.problem.judge_episodes(episodes).items()}
        return {**named("truth", self.returns(episodes)), **rates}

    def references(self) -> Record:
        """One MARL pair (`truth_`), and an untrained learner met by the true expert (`random_`)."""
        marl_key, random_key = jax.random.split(self._key)
        return {**self.truth(policies_of(self.true_play(marl_key))), **self.random(random_key)}

    def random_alone(self) -> Record:
        """The references of `marl`, which is its own truth."""
        return self.random(jax.random.split(self._key)[1])

    def random(self, key: PRNGKeyArray) -> Record:
        """What an untrained learner earns when the true expert has trained against it."""
        untrained = self.trainer.init(key)
        policies = policies_of(untrained)
        met = Sides(policies.learner, self.best_response(policies, policies.expert, key))
        return named("random", self.returns(self.episodes(met)))

    def paths(self, policies: Sides[PolicyNetwork]) -> dict[str, Array]:
        """Columns of a few sample episodes."""
        starts = jax.tree.map(lambda leaf: leaf[:SAMPLE_PATHS], self.starts)
        return self.problem.paths(episodes_from(self.problem.game, policies, starts))


def _best(
    trained: Callable[[Ascent], PolicyNetwork],
    worth: Callable[[PolicyNetwork], Array],
    fresh: Ascent,
    habit: PolicyNetwork,
) -> PolicyNetwork:
    """The better of `fresh` trained and of `habit` trained on, with as fresh an optimiser."""
    starts = jax.tree.map(lambda *each: jnp.stack(each), Ascent(habit, fresh.optimiser), fresh)
    found = jax.vmap(trained)(starts)
    return jax.tree.map(lambda each: each[jnp.argmax(jax.vmap(worth)(found))], found)


def _solver(
    config: ContinuousConfig, problem: ContinuousProblem, steps: int, last_rate: float = TRAINED_RATE
) -> Pathwise:
    return Pathwise.create(
        problem.game,
        discount=config.discount,
        batch=config.batch,
        hidden=config.hidden,
        learning_rate=config.learning_rate,
        decay_steps=max(steps, 1),
        last_rate=last_rate,
        expert_steps=config.expert_steps,
        noise=config.noise,
    )


def _gsiirl(config: ContinuousConfig, problem: ContinuousProblem, judge: Judge) -> Algorithm:
    learner = _learner(config, problem)
    expert = _expert(config, problem)

    def observe(state: ContinuousState, played: PolicyNetwork, answer: PolicyNetwork) -> Record:
        record, modelled, real = judge.play(policies_of(state.solution), Sides(played, answer))
        return {
            **record,
            **judge.expert_reward(state.expert_parameters, modelled, real),
            "dependent_reward_pearson": judge.dependent_reward_pearson(learner.fitted_dependent_reward(state)),
            "expert_trajectories": (state.memory.count * config.trajectories).astype(jnp.float32),
        }

    def init(key: PRNGKeyArray) -> tuple[ContinuousState, Ascent]:
        learner_key, expert_key = jax.random.split(key)
        state = learner.init(learner_key)
        return state, expert.init(expert_key, learner.propose(state))

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(carry: tuple[ContinuousState, Ascent], offset: Array) -> tuple[PyTree, Record]:
            state, habits = carry
            demonstration_key, update_key = jax.random.split(jax.random.fold_in(key, first + offset))
            played = learner.propose(state)
            habits, seen = expert.demonstrate(habits, played, config.trajectories, demonstration_key)
            record = observe(state, played, habits.policy)
            return (learner.update(state, played, seen, update_key), habits), record

        return jax.lax.scan(one_iteration, state, jnp.arange(number))

    def finish(carry: tuple[ContinuousState, Ascent], key: PRNGKeyArray) -> Ending:
        state, habits = carry
        state = learner.settle(state, judge.trainer, key, config.settling_steps)
        answer = judge.best_response(policies_of(state.solution), habits.policy, key)
        learned = {
            "expert_reward": state.expert_parameters,
            "dependent_reward": learner.fitted_dependent_reward(state),
            "commitment": state.commitment,
        }
        return Ending(
            observe(state, learner.policy(state), answer),
            judge.paths(Sides(learner.policy(state), answer)),
            learned,
            problem.reward_map(state.expert_parameters),
            weights_of(learner=learner.policy(state), expert=state.solution.expert.policy, response=answer),
        )

    return Algorithm(init, advance, finish)


def _expert(config: ContinuousConfig, problem: ContinuousProblem) -> ContinuousRespondingExpert:
    """The real expert, which never stops learning: its rate falls over all that it takes part in."""
    first = config.training_steps // 4
    steps = first + config.iterations * config.response_steps
    return ContinuousRespondingExpert(
        _responder(config, problem, steps), problem.true_expert_reward, config.response_steps, first
    )


def _responder(config: ContinuousConfig, problem: ContinuousProblem, steps: int) -> Pathwise:
    """Who answers a policy alone: one step at a time, without a shaking hand."""
    return _solver(replace(config, expert_steps=1, noise=0.0), problem, steps, FOLLOWING_RATE)


def _learner(config: ContinuousConfig, problem: ContinuousProblem) -> ContinuousGSIIRL:
    if config.algorithm == "paper":
        steps, inner = growing_steps, optax.sgd(config.inner_step_size)
        outer = optax.sgd(1.0 / (config.smoothness * max(config.iterations, 1) ** 0.5))
    else:
        steps = constant_steps(config.inner_steps, config.first_inner_steps)
        inner = _matching(config)
        # A branch that has lost its way would else throw the commitment far off.
        outer = optax.chain(optax.clip_by_global_norm(1.0), optax.sgd(config.step_size))
    return ContinuousGSIIRL(
        solver=_solver(config, problem, config.iterations * config.solver_steps, FOLLOWING_RATE),
        own_reward=problem.own_reward,
        accessed=problem.dependent_value,
        dependent_reward=problem.dependent_reward,
        expert_reward=problem.expert_reward,
        inner_loop=MaximumLikelihood(1.0, steps, inner, on_sphere=config.algorithm != "paper"),
        hypergradient=_hypergradient(config),
        regularisation=config.regularisation,
        trajectories=config.trajectories,
        optimiser=outer,
        solver_steps=config.solver_steps,
        response_steps=config.response_steps,
        remembered=config.remembered or 1,
        compared=min(config.compared, config.trajectories),
        lower_level="equilibrium" if config.algorithm == "paper" else "played",
    )


def _matching(config: ContinuousConfig) -> optax.GradientTransformation:
    """Steps along gaps of features. Adam, but a gap well below `SMALL_GAP` makes a step smaller than a whole one.

    Else the sampling noise of features that already match would move their weights as fast as a real gap.
    """
    # The steps of one iteration count as one: the rate falls with the iterations.
    decay = config.step_decay * config.inner_steps
    return optax.adam(lambda step: config.inner_step_size / (1.0 + step / decay), eps=SMALL_GAP)


def _hypergradient(config: ContinuousConfig) -> AbstractEstimator | TwinBranches:
    assert config.response is not None, "the configuration is not resolved"
    assert config.perturbation is not None, "the configuration is not resolved"
    match config.hypergradient:
        case "branches":
            return TwinBranches(config.perturbation, config.period)
        case "direct":
            return Implicit(config.response)
        case _:
            decay = 1.0 if config.algorithm == "paper" else 0.101
            return SPSA(config.response, config.perturbation, decay)


def _ma_irl(config: ContinuousConfig, problem: ContinuousProblem, judge: Judge) -> Algorithm:
    # As many solver steps an iteration as GSIIRL's forward model takes, spread over the matching steps.
    between = max(1, config.solver_steps // config.inner_steps)
    ma_irl = ContinuousMAIRL(
        solver=_solver(config, problem, config.iterations * config.inner_steps * between, FOLLOWING_RATE),
        own_reward=problem.own_reward,
        rewards=Sides(problem.dependent_reward, problem.expert_reward),
        regularisation=config.regularisation,
        steps=config.inner_steps,
        solver_steps=between,
        optimiser=_matching(config),
    )
    expert = _expert(config, problem)

    def observe(state: ContinuousMAIRLState, answer: PolicyNetwork) -> Record:
        model = policies_of(state.solution)
        record, modelled, real = judge.play(model, Sides(model.learner, answer))
        asked = jnp.asarray(float(config.trajectories * config.iterations), jnp.float32)
        return {
            **record,
            **judge.expert_reward(state.parameters.expert, modelled, real),
            "expert_trajectories": asked,
        }

    def init(key: PRNGKeyArray) -> PyTree:
        parameter_key, play_key, expert_key = jax.random.split(key, 3)
        true_play = judge.true_play(play_key)
        state = ma_irl.init(parameter_key)
        return state, policies_of(true_play), expert.init(expert_key, state.solution.learner.policy)

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(carry: PyTree, offset: Array) -> tuple[PyTree, Record]:
            state, true_play, habits = carry
            start_key, update_key, expert_key = jax.random.split(jax.random.fold_in(key, first + offset), 3)
            # The share of the fixed demonstrations that this iteration looks at.
            starts = jax.vmap(problem.game.reset)(jax.random.split(start_key, config.trajectories))
            seen = episodes_from(problem.game, true_play, starts)
            habits = expert.adapt(habits, state.solution.learner.policy, expert_key)
            record = observe(state, habits.policy)
            return (ma_irl.update(state, seen, update_key), true_play, habits), record

        return jax.lax.scan(one_iteration, state, jnp.arange(number))

    def finish(carry: PyTree, key: PRNGKeyArray) -> Ending:
        state, _, habits = carry
        model = policies_of(state.solution)
        answer = judge.best_response(model, habits.policy, key)
        learned = {"expert_reward": state.parameters.expert, "commitment": state.parameters.learner}
        return Ending(
            observe(state, answer),
            judge.paths(Sides(model.learner, answer)),
            learned,
            problem.reward_map(state.parameters.expert),
            weights_of(learner=model.learner, expert=model.expert, response=answer),
        )

    return Algorithm(init, advance, finish)


def _marl(config: ContinuousConfig, problem: ContinuousProblem, judge: Judge) -> Algorithm:
    init, train, policies_in = _maddpg(problem, config) if config.solver == "maddpg" else _pathwise(judge)

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
        response = judge.best_response(policies, policies.expert, key)
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
        return judge.trainer.ascend(state, judge.problem.true_rewards, key, TRAINING_CHUNK)[0]

    return judge.trainer.init, train, policies_of


def _maddpg(problem: ContinuousProblem, config: ContinuousConfig) -> Training:
    solver = Maddpg(problem.game, config.discount, config.hidden)

    def init(key: PRNGKeyArray) -> MaddpgState:
        # The replay is filled before the first update.
        return solver.train(problem.true_rewards, key, 0)

    def train(state: MaddpgState, key: PRNGKeyArray) -> MaddpgState:
        return solver.go_on(state, problem.true_rewards, key, MADDPG_CHUNK)

    return init, train, lambda state: state.policies


_ALGORITHMS = {"gsiirl": _gsiirl, "paper": _gsiirl, "ma-irl": _ma_irl, "marl": _marl}


def _alone(episode: Transition) -> Transition:
    """One episode as a set of one."""
    return jax.tree.map(lambda leaf: leaf[None], episode)
