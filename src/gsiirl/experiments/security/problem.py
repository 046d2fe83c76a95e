"""From a configuration of the security experiment to the game, the two sides, and the truth that judges them."""

import math
from dataclasses import replace
from typing import TypeVar

import equinox as eqx
import jax.numpy as jnp
import optax

from gsiirl.baselines.ma_irl import MAIRL
from gsiirl.commitment import Commitment
from gsiirl.equilibria import AbstractForwardModel, Logit, QLearning, SoftJoint
from gsiirl.evaluation.truth import Truth
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experts.tabular_expert import RespondingExpert, SimulatedExpert
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.hypergradients import SPSA, AbstractEstimator, FiniteDifference, HessianVectorCG, Implicit, ResponseKind
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.irl.inference import LikelihoodLevel, MatchingLevel
from gsiirl.irl.posterior import Inference
from gsiirl.learners.bilevel import Bilevel
from gsiirl.learners.commitment_learner import CommitmentLearner
from gsiirl.learners.reward_learner import RewardGSIIRL
from gsiirl.limits import remembered
from gsiirl.problems.problem import Problem
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.types import Sides

Value = TypeVar("Value")


class SecurityProblem(eqx.Module):
    """Everything one run of the security experiment needs; only `expert` and `truth` hold the true expert reward."""

    network: AttackNetwork = eqx.field(static=True)
    game: AttackGraph
    learner: CommitmentLearner | RewardGSIIRL
    bilevel: Bilevel
    ma_irl: MAIRL
    expert: RespondingExpert | SimulatedExpert
    truth: Truth
    true_weights: dict[str, list[float]] = eqx.field(static=True)

    @property
    def reward_learner(self) -> RewardGSIIRL:
        """The learner, where it commits to a reward."""
        assert isinstance(self.learner, RewardGSIIRL), "this one commits to a policy"
        return self.learner


def build(config: SecurityConfig, network: AttackNetwork) -> SecurityProblem:
    """Build the problem of a resolved configuration on its network."""
    assert config.reward_bound is not None, "the configuration is not resolved"
    temperature = config.expert_temperature(network)
    game = AttackGraph.create(
        network, config.horizon, learner_no_op=config.learner_no_op, expert_no_op=config.expert_no_op
    )
    attack, dependent = rewards.attack_features(game), rewards.commitment_features(game)
    expert_weights = rewards.expert_weights(network)
    dependent_weights = rewards.dependent_weights(network)
    # All that is known of the rewards beforehand is their unit: no weight exceeds the bound.
    scale = config.reward_bound * math.sqrt(len(attack.names))
    expert_reward, dependent_reward = Linear(attack, scale), Linear(dependent, scale)
    own_reward = rewards.own_reward(game, network)
    dependent_table = dependent.payoff(jnp.asarray(dependent_weights))
    expert_table = attack.payoff(jnp.asarray(expert_weights))
    forward_model = _forward_model(config, temperature)
    bilevel = Bilevel(
        game=game,
        own_reward=own_reward,
        accessed=dependent_table,
        dependent_reward=dependent_reward,
        expert_reward=expert_reward,
        forward_model=forward_model,
        temperature=temperature,
        discount=config.discount,
        regularisation=config.regularisation,
        lower_level="equilibrium" if config.lower_level == "equilibrium" else "played",
    )
    if config.expert == "simulated":
        expert = SimulatedExpert(game, expert_table, forward_model, config.discount)
    else:
        expert = RespondingExpert(game, expert_table, temperature, config.discount)
    return SecurityProblem(
        network=network,
        game=game,
        learner=_policy_learner(config, bilevel) if config.commitment == "policy" else _reward_learner(config, bilevel),
        bilevel=bilevel,
        ma_irl=MAIRL(
            game=game,
            own_reward=own_reward,
            rewards=Sides(dependent_reward, expert_reward),
            forward_model=forward_model,
            temperature=temperature,
            discount=config.discount,
            regularisation=config.regularisation,
            steps=config.inner_steps,
            optimiser=optax.adam(config.inner_step_size),
        ),
        expert=expert,
        truth=Truth(
            game,
            Sides(dependent_table + own_reward, expert_table),
            forward_model,
            temperature,
            config.discount,
        ),
        true_weights={"expert_reward": expert_weights.tolist(), "dependent_reward": dependent_weights.tolist()},
    )


def told(config: SecurityConfig, problem: SecurityProblem) -> Problem:
    """What the defender is told, for `gsiirl.GSIIRL`."""
    bilevel = problem.bilevel
    return Problem(
        bilevel.game,
        own_reward=bilevel.own_reward,
        dependent_value=bilevel.accessed,
        discount=config.discount,
        temperature=None if config.temperature == "unknown" else float(bilevel.temperature),
        expert_features=bilevel.expert_reward.features,
        dependent_features=bilevel.dependent_reward.features,
    )


def _policy_learner(config: SecurityConfig, bilevel: Bilevel) -> CommitmentLearner:
    """The default; what it knows of the attacker's rewards are their features, and no bound."""
    game = bilevel.game
    # Where the temperature is unknown the learner's rewards are in units of it, as everything inside it is anyway.
    model = ConditionalLikelihood(game, bilevel.expert_reward.features, config.discount)
    if config.lower_level == "likelihood":
        lower = LikelihoodLevel(Inference(model))
    else:
        reward = Linear(model.features, bilevel.expert_reward.scale / bilevel.temperature)
        lower = MatchingLevel(model, reward, config.regularisation, config.inner_steps, config.inner_step_size)
    return CommitmentLearner(
        commitment=Commitment(game, bilevel.accessed + bilevel.own_reward, config.discount),
        own_reward=bilevel.own_reward,
        accessed=bilevel.accessed,
        dependent_features=rewards.dependent_features(game),  # pyright: ignore[reportArgumentType]
        lower=lower,
        explore=_given(config.explore),
        hand_back=_given(config.hand_back),
        feedback=_given(config.feedback),
        many_starts=config.starts == "many",
        informative_rounds=config.iterations // 2,
        remembered=config.remembered or remembered(game.policy_size, config.iterations),
    )


def _reward_learner(config: SecurityConfig, bilevel: Bilevel) -> RewardGSIIRL:
    if config.schedule == "paper":
        preset = RewardGSIIRL.paper(
            bilevel,
            iterations=config.iterations,
            smoothness=_given(config.smoothness),
            inner_step_size=config.inner_step_size,
        )
    else:
        preset = RewardGSIIRL.create(
            bilevel,
            inner_steps=config.inner_steps,
            inner_step_size=config.inner_step_size,
            step_size=config.step_size,
            step_decay=config.step_decay,
        )
    return replace(
        preset,
        bilevel=bilevel,
        hypergradient=_hypergradient(config),
        remembered=_given(config.remembered),
        honest_start=_given(config.honest_start),
    )


def _hypergradient(config: SecurityConfig) -> AbstractEstimator:
    response: ResponseKind = _given(config.response)
    match _given(config.hypergradient):
        case "implicit":
            return Implicit(response)
        case "hvp_cg":
            return HessianVectorCG(response)
        case "finite_difference":
            return FiniteDifference(response)
        case _:
            return SPSA(response, _given(config.perturbation), _given(config.perturbation_decay), config.draws)


def _forward_model(config: SecurityConfig, temperature: float) -> AbstractForwardModel:
    match config.solver:
        case "q_learning":
            return QLearning()
        case "soft_joint":
            return SoftJoint(temperature)
        case _:
            return Logit(temperature)


def _given(value: Value | None) -> Value:
    assert value is not None, "the configuration is not resolved"
    return value
