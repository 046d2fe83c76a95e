"""The true expert, used to somebody who plays the learner's side."""

import equinox as eqx
import jax
import numpy as np

from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import network_of, weights_of
from gsiirl.errors import InputError
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.continuous.run import expert_of
from gsiirl.experiments.security.problem import SecurityProblem
from gsiirl.games.base import uniform_policy
from gsiirl.pettingzoo.players import NetworkPlayer, TablePlayer
from gsiirl.pettingzoo.run_players import answer_to
from gsiirl.pettingzoo.stage import Stage, stage

Known = TablePlayer | NetworkPlayer


def responding_player(experiment: str, to: Known | None = None, seed: int = 0, **settings: object) -> Known:
    """The true expert of a game, which has got used to `to`: a player that `learned_player` returned.

    Without `to` it is used to a learner that knows nothing: in security one that picks edges at random, in continuous
    games an untrained network. In security the answer is exact. In continuous games it is the expert as a run begins
    with it: it has practised for a quarter of `judging_steps`, from networks that `seed` draws; that takes a while.
    `settings` are those of `parallel_env`.

    Raises:
        InputError: there is no such experiment, a setting is unknown or cannot be, or `to` is of another game.
    """
    made = stage(experiment, settings)
    if isinstance(made.experiment, SecurityProblem):
        return answer_to(made.experiment, _table(made.experiment, to))
    with jax.enable_x64(False):
        return NetworkPlayer(_practised(made, made.experiment, to, jax.random.key(seed)))


def _table(problem: SecurityProblem, to: Known | None) -> np.ndarray:
    """The policy (T, S, A_l) that the attacker is to answer."""
    with jax.enable_x64(True):
        uniform = np.asarray(uniform_policy(problem.game))
    if to is None:
        return uniform
    if not isinstance(to, TablePlayer) or to.table.shape != uniform.shape:
        raise InputError("to", "is no policy of a defender in this game", "give one that learned_player returned")
    return to.table


def _practised(made: Stage, experiment: ContinuousExperiment, to: Known | None, key: jax.Array) -> NumpyPolicy:
    """The network of an expert that has practised against `to`."""
    assert isinstance(made.config, ContinuousConfig), "its experiment is continuous"
    network_key, expert_key = jax.random.split(key)
    [seen, _] = (len(low) for low, _ in (made.game.bounds.learner, made.game.bounds.expert))
    actions = experiment.problem.game.action_size.learner
    met = PolicyNetwork.create(seen - 1, actions, made.config.hidden, network_key)
    if to is not None:
        if not isinstance(to, NetworkPlayer) or not _fits(to.policy, seen, actions):
            raise InputError("to", "is no policy of the learner in this game", "give one that learned_player returned")
        met = network_of(list(to.policy.layers))
    habits = eqx.filter_jit(expert_of(made.config, experiment).init)(expert_key, met)
    weights = {name: np.asarray(array)[None] for name, array in weights_of(expert=habits.policy).items()}
    return NumpyPolicy.of(weights, "expert", 0)


def _fits(policy: NumpyPolicy, inputs: int, outputs: int) -> bool:
    return (policy.layers[0][0].shape[1], policy.layers[-1][0].shape[0]) == (inputs, outputs)
