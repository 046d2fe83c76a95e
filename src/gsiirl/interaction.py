"""Ask and tell: how a learner and an expert meet, whoever drives them.

A learner is three pure functions. `propose` says which policy it wants to play next, `update` takes in what was seen.
An expert that JAX can trace lives with it inside one `lax.scan`; any other is called from a host loop.
"""

import abc
from collections.abc import Callable
from typing import Generic, TypeVar

import equinox as eqx
import jax
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.equilibria.logit import LogitSolution
from gsiirl.expert import AbstractExpert
from gsiirl.types import Interaction

State = TypeVar("State")
Observe = Callable[[PyTree, LogitSolution], dict[str, Array]]


class AbstractLearner(eqx.Module, Generic[State]):
    """A learner by ask and tell. `update` never receives the expert's reward: there is no path for it."""

    @abc.abstractmethod
    def init(self, key: PRNGKeyArray) -> State:
        """The state before any interaction."""

    @abc.abstractmethod
    def propose(self, state: State) -> LogitSolution:
        """The joint policy under what is believed now; its learner's half is what the learner wants to play next."""

    @abc.abstractmethod
    def update(self, state: State, interaction: Interaction, key: PRNGKeyArray) -> State:
        """One iteration of learning from one interaction."""


def interact(
    learner: AbstractLearner[State],
    expert: AbstractExpert,
    state: State,
    key: PRNGKeyArray,
    first_iteration: int | Array,
    iterations: int,
    trajectories: int,
    observe: Observe,
) -> tuple[State, dict[str, Array]]:
    """`iterations` rounds of propose, demonstrate, update, as one scan; `observe` is recorded before each update.

    The randomness of iteration k depends on `key` and k alone, so that a run cut into chunks is the same run.
    """

    def one_round(state: State, offset: Array) -> tuple[State, dict[str, Array]]:
        demonstration_key, update_key = jax.random.split(jax.random.fold_in(key, first_iteration + offset))
        proposal = learner.propose(state)
        played = proposal.policies.learner
        record = observe(state, proposal)
        demonstrations = expert.demonstrate(played, trajectories, demonstration_key)
        return learner.update(state, Interaction(played, demonstrations), update_key), record

    return jax.lax.scan(one_round, state, jax.numpy.arange(iterations))
