"""Ask and tell: how a learner and an expert meet, whoever drives them.

A learner is three pure functions. `propose` says which policy it wants to play next, `update` takes in what was seen.
An expert that JAX can trace lives with it inside one `lax.scan`; any other is called from a host loop.
"""

import abc
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
import rich.progress
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.equilibria.base import AbstractSolution
from gsiirl.expert import AbstractExpert, SimulatedExpert
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.irl.estimated_policy import estimated_policy
from gsiirl.types import Interaction, Trajectories

State = TypeVar("State")
CHUNK = 5
"""Iterations compiled into one call; the host shows progress, and can be interrupted, between calls."""

Observe = Callable[[PyTree, AbstractSolution], dict[str, Array]]


@runtime_checkable
class Demonstrator(Protocol):
    """Whoever can be asked to live with a learner's policy."""

    def demonstrate(self, learner_policy: Float[Array, "T S A_l"], number: int, key: PRNGKeyArray) -> Trajectories:
        """`number` episodes against `learner_policy`."""
        ...


class AbstractLearner(eqx.Module, Generic[State]):
    """A learner by ask and tell. `update` never receives the expert's reward: there is no path for it."""

    @abc.abstractmethod
    def init(self, key: PRNGKeyArray) -> State:
        """The state before any interaction."""

    @abc.abstractmethod
    def propose(self, state: State) -> AbstractSolution:
        """The joint policy under what is believed now; its learner's half is what the learner wants to play next."""

    @abc.abstractmethod
    def committed_reward(self, state: State) -> AbstractPayoff:
        """The reward that the proposal's learner acts on; a `SimulatedExpert` is told it."""

    @abc.abstractmethod
    def probes(self, state: State, key: PRNGKeyArray) -> State | None:
        """Other states, along a leading axis, in which the learner also wants to be met; None where there are none.

        `key` is the one that the next `update` receives.
        """

    @abc.abstractmethod
    def update(self, state: State, interaction: Interaction, key: PRNGKeyArray) -> State:
        """One iteration of learning from one interaction."""


def interact(
    learner: AbstractLearner[State],
    expert: AbstractExpert | SimulatedExpert,
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
        record = observe(state, proposal)
        played, seen = _meet(learner, expert, state, proposal, trajectories, demonstration_key)
        probes = learner.probes(state, update_key)
        answers = None
        if probes is not None:
            # The same key for all: differences between them then feel little of the sampling noise.
            answers = jax.vmap(
                lambda probe: _meet(learner, expert, probe, learner.propose(probe), trajectories, demonstration_key)[1]
            )(probes)
        return learner.update(state, Interaction(played, seen, answers), update_key), record

    return jax.lax.scan(one_round, state, jnp.arange(iterations))


def _meet(
    learner: AbstractLearner[State],
    expert: AbstractExpert | SimulatedExpert,
    state: State,
    proposal: AbstractSolution,
    trajectories: int,
    key: PRNGKeyArray,
) -> tuple[Float[Array, "T S A_l"], Trajectories]:
    """The learner's policy as far as it knows it, and the demonstrations."""
    proposed = proposal.policies.learner
    if isinstance(expert, SimulatedExpert):
        seen = expert.demonstrate_told(learner.committed_reward(state), trajectories, key)
        return estimated_policy(seen.states, seen.actions.learner, proposed), seen
    return proposed, expert.demonstrate(proposed, trajectories, key)


def live(
    learner: AbstractLearner[State],
    expert: Demonstrator | SimulatedExpert,
    iterations: int,
    trajectories: int,
    seed: int,
    progress: bool = True,
) -> State:
    """The learner's state after `iterations` rounds with `expert`, of `trajectories` episodes each.

    An expert that JAX can trace is compiled together with the learner; any other expert is called from a host loop, one
    `demonstrate` a round. Both ways the randomness is the same function of `seed`.
    """
    init_key, key = jax.random.split(jax.random.key(seed))
    state = eqx.filter_jit(learner.init)(init_key)
    with rich.progress.Progress(disable=not progress) as bars:
        bar = bars.add_task("learning", total=iterations)
        if isinstance(expert, AbstractExpert | SimulatedExpert):
            advance = jax.jit(
                lambda state, first, number: interact(
                    learner, expert, state, key, first, number, trajectories, lambda state, proposal: {}
                )[0],
                static_argnums=2,
            )
            for first in range(0, iterations, CHUNK):
                number = min(CHUNK, iterations - first)
                state = jax.block_until_ready(advance(state, jnp.asarray(first), number))
                bars.update(bar, advance=number)
            return state
        propose, update = eqx.filter_jit(learner.propose), eqx.filter_jit(learner.update)
        probes_of = eqx.filter_jit(learner.probes)
        for iteration in range(iterations):
            demonstration_key, update_key = jax.random.split(jax.random.fold_in(key, iteration))
            played = propose(state).policies.learner
            seen = expert.demonstrate(played, trajectories, demonstration_key)
            probes, answers = probes_of(state, update_key), None
            if probes is not None:
                policies = eqx.filter_vmap(learner.propose)(probes).policies.learner
                each = [expert.demonstrate(policy, trajectories, demonstration_key) for policy in policies]
                answers = jax.tree.map(lambda *leaves: jnp.stack(leaves), *each)
            state = update(state, Interaction(played, seen, answers), update_key)
            bars.update(bar, advance=1)
    return state
