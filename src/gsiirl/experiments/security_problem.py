"""From a configuration of the security experiment to the game, the two sides, and the truth that judges them."""

import math

import equinox as eqx
import jax.numpy as jnp
import optax

from gsiirl.baselines.ma_irl import MAIRL
from gsiirl.equilibria.logit import Logit
from gsiirl.evaluation.truth import Truth
from gsiirl.experiments.security import SecurityConfig
from gsiirl.expert import RespondingExpert
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.irl.dependent_reward import DependentValue
from gsiirl.learner import GSIIRL
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.scenarios import load_network, random_network
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.types import Sides


class SecurityProblem(eqx.Module):
    """Everything one run of the security experiment needs; only `expert` and `truth` hold the true expert reward."""

    network: AttackNetwork = eqx.field(static=True)
    game: AttackGraph
    learner: GSIIRL
    ma_irl: MAIRL
    expert: RespondingExpert
    truth: Truth
    true_weights: dict[str, list[float]] = eqx.field(static=True)


def network_of(config: SecurityConfig) -> AttackNetwork:
    """The attack network a configuration names."""
    if config.graph is not None:
        return load_network(config.graph, config.variant)
    return random_network(config.graph_seed, config.nodes, config.edges, config.variant)


def build(config: SecurityConfig, network: AttackNetwork) -> SecurityProblem:
    """Build the problem of a resolved configuration on its network."""
    assert config.temperature is not None, "the configuration is not resolved"
    assert config.reward_bound is not None, "the configuration is not resolved"
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
    return SecurityProblem(
        network=network,
        game=game,
        learner=GSIIRL.create(
            game,
            own_reward=own_reward,
            dependent_value=DependentValue(dependent_table),
            dependent_reward=dependent_reward,
            expert_reward=expert_reward,
            temperature=config.temperature,
            discount=config.discount,
            regularisation=config.regularisation,
            inner_steps=config.inner_steps,
            inner_step_size=config.inner_step_size,
            step_size=config.step_size,
            step_decay=config.step_decay,
            remembered=config.remembered,
        ),
        ma_irl=MAIRL(
            game=game,
            own_reward=own_reward,
            rewards=Sides(dependent_reward, expert_reward),
            forward_model=Logit(config.temperature),
            discount=config.discount,
            regularisation=config.regularisation,
            steps=config.inner_steps,
            optimiser=optax.adam(config.inner_step_size),
        ),
        expert=RespondingExpert(game, expert_table, config.temperature, config.discount),
        truth=Truth(game, Sides(dependent_table + own_reward, expert_table), config.temperature, config.discount),
        true_weights={"expert_reward": expert_weights.tolist(), "dependent_reward": dependent_weights.tolist()},
    )
