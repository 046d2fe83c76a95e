"""The security experiment as the runner sees it: its five algorithms, and what is recorded of each."""

from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.baselines.lin2019 import Lin2019
from gsiirl.baselines.marl import marl
from gsiirl.compilation import QUICKLY
from gsiirl.equilibria import AbstractSolution, LogitSolution
from gsiirl.errors import InputError
from gsiirl.evaluation.identification import unseen_directions
from gsiirl.evaluation.rank_correlation import spearman
from gsiirl.evaluation.reward_similarity import RewardSimilarity
from gsiirl.experiments.policy_run import deployed_episodes, policy_algorithm, saved
from gsiirl.experiments.prepared_run import Algorithm, Ending, Parameters, PreparedRun, Record
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.cost import check_memory
from gsiirl.experiments.security.observed_attacks import observed_attacks
from gsiirl.experiments.security.problem import SecurityProblem, build
from gsiirl.experts.tabular_expert import RespondingExpert
from gsiirl.games.rollout import rollout
from gsiirl.interaction import CHUNK, interact
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.learners.commitment_learner import CommitmentLearner, LearnerState
from gsiirl.learners.reward_learner import RewardGSIIRL
from gsiirl.rewards.linear import Linear
from gsiirl.scenarios import read_network
from gsiirl.types import Policies, Sides, Trajectories


def prepare(config: SecurityConfig, saved_game: Path | None = None) -> PreparedRun:
    """The run of a resolved configuration; `saved_game` is the `game.json` of a run to go on with.

    Raises:
        InputError: when there is no such network, its game takes too much memory, or no equilibrium of it is found.
    """
    # A run goes on with the network as it was, wherever the file it came from may be now.
    network = config.network() if saved_game is None else read_network(saved_game, config.variant)
    check_memory(config, network)
    problem = build(config, network)
    bilevel = problem.bilevel
    # What the paper's way learns is in the unit ball; a policy's learner has weights in units of the temperature.
    by_policy = isinstance(problem.learner, CommitmentLearner) and config.algorithm in ("gsiirl", "paper")
    unit = 1.0 if config.temperature == "unknown" else bilevel.temperature
    scales = {name: float(bilevel.expert_reward.scale) for name in ("expert_reward", "dependent_reward", "commitment")}
    scales |= {"expert_reward": unit, "dependent_reward": 1.0} if by_policy else {}
    names = {"expert_reward": bilevel.expert_reward.features.names}
    names |= dict.fromkeys(("dependent_reward", "commitment"), bilevel.dependent_reward.features.names)
    names |= dict.fromkeys(("attacks", "chances"), network.edge_names)
    judged = _Judge(config, problem)
    return PreparedRun(
        game={
            **network.to_json_dict(),
            "horizon": config.horizon,
            "no_op": {"learner": config.learner_no_op, "expert": config.expert_no_op},
            "truth": problem.true_weights,
        },
        algorithm=_ALGORITHMS[config.algorithm](config, problem, judged),
        iterations=0 if config.algorithm in ("marl", "lin2019") else config.iterations,
        chunk=CHUNK,
        references=lambda: problem.truth.references() | judged.yardsticks.returns,
        parameters={name: Parameters(scales.get(name, 1.0), names[name]) for name in names},
    )


def _gsiirl(config: SecurityConfig, problem: SecurityProblem, judged: "_Judge") -> Algorithm:
    if isinstance(problem.learner, CommitmentLearner):
        return _policy_gsiirl(config, problem, problem.learner, judged)
    return _reward_gsiirl(config, problem, problem.learner, judged)


def _policy_gsiirl(
    config: SecurityConfig, problem: SecurityProblem, learner: CommitmentLearner, judged: "_Judge"
) -> Algorithm:
    """The default: a commitment to a policy."""
    padding = jnp.zeros(problem.game.number_of_edges)

    def dependent(state: LearnerState) -> Array:
        # No reward for blocks: those features are a commitment's alone.
        return jnp.concatenate([state.accessed.solve(), padding])

    def says(policies: Policies, expert_weights: Array, dependent_weights: Array) -> Record:
        return {
            **judged(policies, expert_weights, problem.bilevel.temperature),
            "dependent_reward_pearson": judged.dependent_reward_pearson(dependent_weights),
        }

    assert isinstance(problem.expert, RespondingExpert), "checked by the configuration"
    algorithm = policy_algorithm(
        learner,
        problem.expert,
        problem.truth,
        config.trajectories,
        says,
        dependent,
        lambda policy, key: _sample_paths(problem, policy, key),
    )

    def finish(state: LearnerState, key: PRNGKeyArray) -> Ending:
        ending = algorithm.finish(state, key)
        observed = observed_attacks(state.accessed.gram, problem.game)
        return ending._replace(learned=ending.learned | observed)

    return replace(algorithm, finish=finish)


def _reward_gsiirl(
    config: SecurityConfig, problem: SecurityProblem, learner: RewardGSIIRL, judged: "_Judge"
) -> Algorithm:
    """The paper's way: a commitment to a reward."""
    asked = config.trajectories * (3 if config.response == "measured" else 1)

    def observe(state: PyTree, proposal: AbstractSolution) -> Record:
        fitted = learner.fitted_dependent_reward(state)
        return {
            **judged(proposal.policies, state.expert_parameters, learner.expert_reward.scale),
            **_solved(proposal),
            "dependent_reward_pearson": judged.dependent_reward_pearson(fitted),
            "expert_trajectories": (state.memory.count * asked).astype(fitted.dtype),
            "game_solves": state.solves.astype(fitted.dtype),
        }

    def learned(state: PyTree) -> Record:
        return {
            "expert_reward": state.expert_parameters,
            "dependent_reward": learner.fitted_dependent_reward(state),
            "commitment": state.commitment,
            **observed_attacks(state.accessed.gram / learner.dependent_reward.scale**2, problem.game),
        }

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        proposal = learner.forward(state)
        paths = _sample_paths(problem, proposal.policies.learner, key)
        return Ending(observe(state, proposal), paths, learned(state), {}, saved(proposal.policies))

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        (state, _), records = interact(
            learner,
            problem.expert,
            (state, None),
            key,
            first,
            number,
            config.trajectories,
            lambda met: observe(met.state, met.proposal.model),
        )
        return state, records

    return Algorithm(learner.init, advance, finish)


def _ma_irl(config: SecurityConfig, problem: SecurityProblem, judged: "_Judge") -> Algorithm:
    ma_irl, true_play = problem.ma_irl, _true_play(config, problem)
    scale = problem.bilevel.expert_reward.scale
    number_of_demonstrations = _shown(config)

    def init(key: PRNGKeyArray) -> PyTree:
        parameter_key, demonstration_key = jax.random.split(key)
        return ma_irl.init(parameter_key, _demonstrations(config, problem, true_play.policies, demonstration_key))

    def observe(state: PyTree, proposal: AbstractSolution) -> Record:
        asked = jnp.asarray(float(number_of_demonstrations))
        found = judged(proposal.policies, state.parameters.expert, scale)
        return {**found, **_solved(proposal), "expert_trajectories": asked}

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(state: PyTree, _: None) -> tuple[PyTree, Record]:
            return ma_irl.update(state), observe(state, ma_irl.propose(state))

        return jax.lax.scan(one_iteration, state, None, length=number)

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        proposal = ma_irl.propose(state)
        learned = {"expert_reward": state.parameters.expert, "commitment": state.parameters.learner}
        paths = _sample_paths(problem, proposal.policies.learner, key)
        return Ending(observe(state, proposal), paths, learned, {}, saved(proposal.policies))

    return Algorithm(init, advance, finish)


def _lin2019(config: SecurityConfig, problem: SecurityProblem, judged: "_Judge") -> Algorithm:
    """Both rewards by one linear program, and the forward model under them."""
    bilevel, true_play = problem.bilevel, _true_play(config, problem)
    scale, rewards = bilevel.expert_reward.scale, problem.ma_irl.rewards
    assert config.reward_bound is not None, "the configuration is not resolved"
    program = Lin2019(
        game=problem.game,
        own_reward=bilevel.own_reward,
        features=Sides(rewards.learner.features, rewards.expert.features),
        discount=config.discount,
        bound=config.reward_bound,
        violation_weight=config.violation_weight,
        zero_sum=config.variant == "zero_sum",
    )

    def init(key: PRNGKeyArray) -> PyTree:
        # MA-IRL's demonstrations.
        demonstrations = _demonstrations(config, problem, true_play.policies, jax.random.split(key)[1])
        learned = program.learn(*program.estimate(demonstrations))
        if program.zero_sum:
            # The weights of −φ_e are those of φ_e, and blocks have none.
            learned = Sides(jnp.pad(learned.learner, (0, problem.game.number_of_edges)), learned.expert)
        return jax.tree.map(lambda weights: weights / scale, learned)

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        solution = bilevel.solve(state.learner, state.expert)
        record = {
            **judged(solution.policies, state.expert, scale),
            **_solved(solution),
            "expert_trajectories": jnp.asarray(float(_shown(config))),
        }
        learned = {"expert_reward": state.expert, "commitment": state.learner}
        paths = _sample_paths(problem, solution.policies.learner, key)
        return Ending(record, paths, learned, {}, saved(solution.policies))

    return Algorithm(init, lambda state, key, first, number: (state, {}), finish)


def _marl(config: SecurityConfig, problem: SecurityProblem, judged: "_Judge") -> Algorithm:
    true_play = _true_play(config, problem)

    def finish(_: PyTree, key: PRNGKeyArray) -> Ending:
        policies = true_play.policies
        record = {**problem.truth.evaluate(policies), **_solved(true_play), "regret": judged.regret(policies.learner)}
        return Ending(record, _sample_paths(problem, policies.learner, key), {}, {}, saved(policies))

    return Algorithm(
        init=lambda key: jnp.zeros(()), advance=lambda state, key, first, number: (state, {}), finish=finish
    )


_ALGORITHMS = {"gsiirl": _gsiirl, "paper": _gsiirl, "ma-irl": _ma_irl, "lin2019": _lin2019, "marl": _marl}


def _true_play(config: SecurityConfig, problem: SecurityProblem) -> AbstractSolution:
    """Play of the true game, from which both baselines start."""
    truth = problem.truth
    play = marl(problem.game, truth.rewards, truth.forward_model, config.discount)
    if isinstance(play, LogitSolution) and not play.converged:
        problem_found = f"at {truth.temperature:g} the game's equilibrium is not found"
        raise InputError("temperature", problem_found, "give one nearer to the size of the rewards")
    return play


def _shown(config: SecurityConfig) -> int:
    """Demonstrations that those who only watch get: as many as GSIIRL asks for in all its interactions."""
    return config.trajectories * max(config.iterations, 1)


def _demonstrations(
    config: SecurityConfig, problem: SecurityProblem, policies: Policies, key: PRNGKeyArray
) -> Trajectories:
    """Episodes of the true game, as two that know both rewards play it."""
    keys = jax.random.split(key, _shown(config))
    return jax.vmap(lambda one: rollout(one, problem.game, policies))(keys)


class _Judge:
    """What the truth says of a joint policy and of the expert's reward it was made with.

    The yardsticks are the same for all seeds and iterations, and are found once.
    """

    def __init__(self, config: SecurityConfig, problem: SecurityProblem) -> None:
        bilevel = problem.bilevel
        self.yardsticks = jax.jit(lambda: problem.truth.yardsticks(), compiler_options=QUICKLY)()
        self._truth, self._features = problem.truth, bilevel.expert_reward.features
        self._expert = RewardSimilarity.of(problem.game, bilevel.expert_reward.features, config.discount)
        model = ConditionalLikelihood(problem.game, bilevel.expert_reward.features, config.discount)
        self._identified = self._expert.without(unseen_directions(model))
        self._dependent = RewardSimilarity.of(problem.game, bilevel.dependent_reward.features, config.discount)
        self._true_expert, self._true_dependent = (
            jnp.asarray(problem.true_weights[name]) for name in ("expert_reward", "dependent_reward")
        )

    def __call__(self, policies: Policies, expert_parameters: Array, scale: float | Array) -> Record:
        """`expert_parameters` times `scale` are the weights of the learned r_e, in reward units."""
        return {
            **self._truth.evaluate(policies),
            "regret": self.regret(policies.learner),
            **self._alike(expert_parameters),
            **self._truth.misfit(policies.learner, Linear(self._features, scale), expert_parameters),
        }

    def _alike(self, expert_parameters: Array) -> Record:
        """How alike the learned r_e and the true one are; `_identified`: apart from what no answer can show."""
        both = expert_parameters, self._true_expert
        tables = [self._features.payoff(weights).dense() for weights in both]
        return {
            "expert_reward_pearson": self._expert.pearson(*both),
            "expert_reward_spearman": spearman(*tables),
            "expert_reward_epic": self._expert.epic(*both),
            "expert_reward_starc": self._expert.starc(*both),
            "expert_reward_pearson_identified": self._identified.pearson(*both),
            "expert_reward_epic_identified": self._identified.epic(*both),
            "expert_reward_starc_identified": self._identified.starc(*both),
        }

    def regret(self, learner_policy: Array) -> Array:
        """Of a policy that is deployed."""
        return self._truth.regret(learner_policy, self.yardsticks)

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


def _sample_paths(problem: SecurityProblem, played: Array, key: PRNGKeyArray) -> dict[str, Array]:
    """Episodes of the learner's policy and the true expert's response to it."""
    paths = deployed_episodes(problem.truth, played, key)
    masks = jnp.asarray(problem.game.masks)[paths.states]
    # A large network's masks are in several words, and in as many columns.
    words = [masks] if masks.ndim == paths.states.ndim else jnp.moveaxis(masks, -1, 0)
    return {
        **{f"state_{word}" if word else "state": each for word, each in enumerate(words)},
        "learner_action": paths.actions.learner,
        "expert_action": paths.actions.expert,
    }
