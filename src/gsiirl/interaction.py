"""The loop of Algorithm 1, the same for every game, learner and expert.

For k = 0, 1, …:

    the learner proposes a policy π_l(k)                                    `AbstractLearner.propose`
    the expert answers it, and d episodes of both are seen                  `AbstractExpert.meet`     line 4
    the learner learns from what was seen                                   `AbstractLearner.update`  lines 5-15

`interact` compiles the loop as one scan: runs of the command line use it. `live` makes one round at a time, for an
expert that JAX cannot trace: a person, a simulator.
"""

import abc
from collections.abc import Callable, Iterator
from typing import Any, Generic, NamedTuple, Protocol, TypeVar, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
import rich.console
import rich.progress
from jaxtyping import Array, Float, Key, PRNGKeyArray, PyTree

from gsiirl.compilation import QUICKLY
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.program.progress import draws
from gsiirl.types import Interaction, Trajectories, Transition

State = TypeVar("State")
Habits = TypeVar("Habits")
Record = dict[str, Array]
CHUNK = 5
"""Iterations of a finite game that a run compiles into one call; it shows progress between calls."""


class Proposal(eqx.Module):
    """What a learner brings to an interaction.

    `policy` is played. Where it is half of the forward model's joint policy, that is `model`; where it comes from a
    reward, that is `reward`.
    """

    policy: PyTree
    model: Any = None
    reward: Any = None


class Meeting(eqx.Module, Generic[State, Habits]):
    """One round: the learner's state before it, its proposal, the expert's habits after it, and what was seen."""

    state: State
    proposal: Proposal
    habits: Habits
    interaction: Interaction


class AbstractLearner(eqx.Module, Generic[State]):
    """A learner as pure functions of arrays. `update` never receives the expert's reward."""

    @abc.abstractmethod
    def init(self, key: PRNGKeyArray) -> State:
        """The state before any interaction."""

    @abc.abstractmethod
    def propose(self, state: State) -> Proposal:
        """What the learner wants to play next."""

    @abc.abstractmethod
    def update(self, state: State, interaction: Interaction, key: PRNGKeyArray) -> State:
        """The state after one interaction."""

    def probes(self, state: State, key: PRNGKeyArray) -> State | None:
        """States near `state`, along a leading axis, whose proposals the expert is also asked to answer; None for none.

        `key` is the one that the next `update` receives.
        """
        return None


class AbstractExpert(eqx.Module, Generic[Habits]):
    """An expert that JAX can trace. It alone holds the true expert reward."""

    @abc.abstractmethod
    def init(self, key: PRNGKeyArray, learner_policy: PyTree) -> Habits:
        """What the expert remembers before the first interaction."""

    @abc.abstractmethod
    def meet(self, habits: Habits, proposal: Proposal, number: int, key: PRNGKeyArray) -> tuple[Habits, Interaction]:
        """What it remembers afterwards, and `number` episodes of both."""


@runtime_checkable
class Demonstrator(Protocol):
    """Any expert of a finite game, traceable or not."""

    def demonstrate(self, learner_policy: Float[Array, "T S A_l"], number: int, key: PRNGKeyArray) -> Trajectories:
        """`number` episodes against `learner_policy`."""
        ...


@runtime_checkable
class ContinuousDemonstrator(Protocol):
    """Any expert of a continuous game that is no class of the library."""

    def demonstrate(self, learner_policy: PolicyNetwork, number: int, key: PRNGKeyArray) -> Transition:
        """`number` episodes against `learner_policy`, a function of (what the learner observes, t/T); axes (d, T)."""
        ...


def interact(
    learner: AbstractLearner[State],
    expert: AbstractExpert[Habits],
    carry: tuple[State, Habits],
    key: PRNGKeyArray,
    first_iteration: int | Array,
    iterations: int,
    trajectories: int,
    observe: Callable[[Meeting[State, Habits]], Record],
) -> tuple[tuple[State, Habits], Record]:
    """`iterations` rounds as one scan; records have a leading axis of rounds.

    The randomness of iteration k depends on `key` and k alone, so that a run cut into chunks is the same run.
    """

    def one_round(carry: tuple[State, Habits], offset: Array) -> tuple[tuple[State, Habits], Record]:
        state, habits = carry
        keys = jax.random.split(jax.random.fold_in(key, first_iteration + offset))
        met = _meeting(learner, expert, habits, state, trajectories, keys)
        return (learner.update(state, met.interaction, keys[1]), met.habits), observe(met)

    return jax.lax.scan(one_round, carry, jnp.arange(iterations))


def _meeting(
    learner: AbstractLearner[State],
    expert: AbstractExpert[Habits],
    habits: Habits,
    state: State,
    trajectories: int,
    keys: Key[Array, "2"],
) -> Meeting[State, Habits]:
    """Propose and meet, at the learner's probes too where it has any; `keys` are for the meeting and the update."""
    proposal = learner.propose(state)
    after, seen = expert.meet(habits, proposal, trajectories, keys[0])
    probes = learner.probes(state, keys[1])
    if probes is not None:
        # The same key for all: the sampling noise then nearly cancels in differences between them.
        answers = jax.vmap(
            lambda probe: expert.meet(habits, learner.propose(probe), trajectories, keys[0])[1].demonstrations
        )(probes)
        seen = Interaction(seen.learner_policy, seen.demonstrations, answers)
    return Meeting(state, proposal, after, seen)


class Round(NamedTuple):
    """One round of several seeds: everything has a leading axis of seeds."""

    states: Any
    policies: Any


def live(
    learner: AbstractLearner[Any],
    expert: AbstractExpert[Any] | Demonstrator | ContinuousDemonstrator,
    keys: Key[Array, "..."],
    iterations: int,
    trajectories: int,
    progress: bool,
) -> Iterator[Round]:
    """Round by round, with a progress bar on a terminal and in a notebook: the same rounds as those of `interact`.

    `keys` (seeds, 2) are those of the start and of the rounds. An expert that is no `AbstractExpert` is asked once a
    round and seed.
    """
    states = _start(learner, keys[:, 0])
    habits = _greet(learner, expert, states, keys[:, 0]) if isinstance(expert, AbstractExpert) else None
    console = rich.console.Console(stderr=True)
    with rich.progress.Progress(console=console, disable=not (progress and draws(console))) as bars:
        for iteration in bars.track(range(iterations), description="learning"):
            round_keys = _round_keys(keys[:, 1], jnp.asarray(iteration))
            if isinstance(expert, AbstractExpert):
                habits, met = _meet(learner, expert, habits, states, trajectories, round_keys)
            else:
                met = _asked(learner, expert, states, trajectories, round_keys)
            states = _update(learner, states, met, round_keys[:, 1])
            yield Round(states, met.learner_policy)


def _asked(
    learner: AbstractLearner[Any],
    expert: Demonstrator | ContinuousDemonstrator,
    states: Any,
    trajectories: int,
    keys: Key[Array, "..."],
) -> Interaction:
    """What an expert that JAX cannot trace answers in one round."""

    def answers(policies: PyTree) -> Any:
        each = [
            expert.demonstrate(jax.tree.map(lambda leaf: leaf[place], policies), trajectories, key)  # noqa: B023
            for place, key in enumerate(keys[:, 0])
        ]
        return jax.tree.map(lambda *leaves: jnp.stack(leaves), *each)

    policies, probes = _proposals(learner, states, keys)
    if probes is None:
        return Interaction(policies, answers(policies))
    number = jax.tree.leaves(probes)[0].shape[1]
    probed = [answers(jax.tree.map(lambda leaf: leaf[:, place], probes)) for place in range(number)]  # noqa: B023
    return Interaction(policies, answers(policies), jax.tree.map(lambda *leaves: jnp.stack(leaves, axis=1), *probed))


@eqx.filter_jit
def _start(learner: AbstractLearner[Any], keys: Key[Array, "..."]) -> Any:
    return jax.vmap(learner.init)(keys)


@eqx.filter_jit
def _greet(learner: AbstractLearner[Any], expert: AbstractExpert[Any], states: Any, keys: Key[Array, "..."]) -> Any:
    return jax.vmap(lambda state, key: expert.init(jax.random.fold_in(key, 1), learner.propose(state).policy))(
        states, keys
    )


@eqx.filter_jit
def _round_keys(keys: Key[Array, "..."], iteration: Array) -> Key[Array, "seeds 2"]:
    return jax.vmap(lambda key: jax.random.split(jax.random.fold_in(key, iteration)))(keys)


@eqx.filter_jit
def _meet(
    learner: AbstractLearner[Any],
    expert: AbstractExpert[Any],
    habits: Any,
    states: Any,
    trajectories: int,
    keys: Key[Array, "..."],
) -> tuple[Any, Interaction]:
    def one(habits: Any, state: Any, keys: Key[Array, "2"]) -> tuple[Any, Interaction]:
        met = _meeting(learner, expert, habits, state, trajectories, keys)
        return met.habits, met.interaction

    return jax.vmap(one)(habits, states, keys)


@eqx.filter_jit
def _proposals(learner: AbstractLearner[Any], states: Any, keys: Key[Array, "..."]) -> tuple[PyTree, PyTree | None]:
    def one(state: Any, key: Key[Array, "2"]) -> tuple[PyTree, PyTree | None]:
        probes = learner.probes(state, key[1])
        asked = None if probes is None else jax.vmap(lambda probe: learner.propose(probe).policy)(probes)
        return learner.propose(state).policy, asked

    return jax.vmap(one)(states, keys)


def _updated(learner: AbstractLearner[Any], states: Any, met: Interaction, keys: Key[Array, "..."]) -> Any:
    return jax.vmap(learner.update)(states, met, keys)


_update = eqx.filter_jit(_updated, compiler_options=QUICKLY)  # pyright: ignore[reportCallIssue] (passed on to jax.jit)
