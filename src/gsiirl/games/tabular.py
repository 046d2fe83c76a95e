"""A tabular game given by plain arrays."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from gsiirl.arguments import array_of, numbers, whole_number
from gsiirl.errors import InputError
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import DensePayoff
from gsiirl.types import AnyArray, Sides


class TabularGame(AbstractTabularGame):
    """A finite game: at most K successors of each (s, a_l, a_e), a start distribution and a horizon.

    `successors` (S, A_l, A_e, K) are state indices, `probabilities` (S, A_l, A_e, K) sum to one over K, `initial` (S,)
    is P0, `horizon` is T. `learner_actions` (S, A_l) and `expert_actions` (S, A_e) say which actions may be chosen, and
    `terminal` (S,) in which states an episode is over; None stands for all actions, and for no such state. Where
    `dense` is set, the k-th successor is state k everywhere, and expectations are matrix products.

    The arrays are NumPy's, in double precision whatever JAX is set to.
    """

    successors: Int[AnyArray, "S A_l A_e K"]
    probabilities: Float[AnyArray, "S A_l A_e K"]
    initial: Float[AnyArray, " S"]
    horizon: int = eqx.field(static=True)
    learner_actions: Bool[AnyArray, "S A_l"] | None = None
    expert_actions: Bool[AnyArray, "S A_e"] | None = None
    terminal_states: Bool[AnyArray, " S"] | None = None
    dense: bool = eqx.field(static=True, default=False)

    @classmethod
    def from_arrays(
        cls,
        transitions: object,
        *,
        initial: object,
        horizon: int,
        learner_actions: object = None,
        expert_actions: object = None,
        terminal: object = None,
    ) -> "TabularGame":
        """Build a game from arrays that NumPy can read.

        Args:
            transitions: P[s, a_l, a_e, s'] of shape (S, A_l, A_e, S); or a pair (successors, probabilities), both of
                shape (S, A_l, A_e, K), for games in which few states can follow.
            initial: P0 of shape (S,), the distribution of the first state.
            horizon: T, the number of steps of an episode.
            learner_actions: booleans of shape (S, A_l), False where the learner may not choose the action.
            expert_actions: booleans of shape (S, A_e), the same of the expert.
            terminal: booleans of shape (S,), or a list of states, in which an episode is over: neither side earns or
                does anything there. Their own transitions are not read.

        Raises:
            InputError: naming the argument that cannot be, and the mend.
        """
        successors, probabilities = _successors_of(transitions)
        states, learner_count, expert_count, _ = successors.shape
        horizon = whole_number("horizon", horizon, 1)
        start = numbers("initial", initial)
        if start.shape != (states,):
            raise InputError("initial", f"has shape {start.shape}", f"give one probability a state: shape ({states},)")
        over = _states_of(terminal, states)
        dense = successors.shape[3] == states and bool((successors == np.arange(states)).all())
        if over is not None:
            # Nothing happens after the end, so that a terminal state follows itself.
            ended, each = over[:, None, None, None], np.arange(states)[:, None, None, None]
            probabilities = np.where(ended, np.arange(successors.shape[3]) == (each if dense else 0), probabilities)
            successors = successors if dense else np.where(ended, each, successors)
        _check_distributions("transitions", probabilities)
        _check_distributions("initial", start)
        return cls(
            successors=successors,
            probabilities=probabilities / probabilities.sum(-1, keepdims=True),
            initial=start / start.sum(),
            horizon=horizon,
            learner_actions=_actions_of("learner_actions", learner_actions, (states, learner_count), over),
            expert_actions=_actions_of("expert_actions", expert_actions, (states, expert_count), over),
            terminal_states=over,
            dense=dense,
        )

    @property
    def number_of_actions(self) -> Sides[int]:
        return Sides(self.successors.shape[1], self.successors.shape[2])

    @property
    def allowed(self) -> Sides[Bool[Array, "S A"] | None]:
        masks = Sides(self.learner_actions, self.expert_actions)
        return Sides(*(None if mask is None else jnp.asarray(mask) for mask in (masks.learner, masks.expert)))

    @property
    def terminal(self) -> Bool[Array, " S"] | None:
        return None if self.terminal_states is None else jnp.asarray(self.terminal_states)

    def continuation(self, values: Float[Array, " S"]) -> DensePayoff:
        if self.dense:
            return DensePayoff(self.probabilities @ values)
        return DensePayoff(jnp.sum(self.probabilities * values[self.successors], axis=-1))

    def advance(self, distribution: Float[Array, " S"], policies: Sides[Float[Array, "..."]]) -> Float[Array, " S"]:
        joint = jnp.einsum("s,sl,se->sle", distribution, policies.learner, policies.expert)
        if self.dense:
            return joint.ravel() @ self.probabilities.reshape(joint.size, -1)
        return jnp.zeros_like(distribution).at[self.successors].add(joint[..., None] * self.probabilities)

    def reset(self, key: PRNGKeyArray) -> Int[Array, ""]:
        return jax.random.categorical(key, jnp.log(self.initial))

    def step(self, key: PRNGKeyArray, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Int[Array, ""]:
        chosen = state, actions.learner, actions.expert
        successor = jax.random.categorical(key, jnp.log(jnp.asarray(self.probabilities)[chosen]))
        return jnp.asarray(self.successors)[chosen][successor]

    def possible(
        self, states: Int[AnyArray, " n"], actions: Sides[Int[AnyArray, " n"]], following: Int[AnyArray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        chosen = states, actions.learner, actions.expert
        probabilities = np.asarray(self.probabilities)[chosen]
        if self.dense:
            return probabilities[np.arange(len(states)), following] > 0
        return np.any(
            (np.asarray(self.successors)[chosen] == np.asarray(following)[:, None]) & (probabilities > 0), axis=1
        )


def _successors_of(transitions: object) -> tuple[np.ndarray, np.ndarray]:
    """Successors and their probabilities, (S, A_l, A_e, K) each."""
    if isinstance(transitions, tuple):
        if len(transitions) != 2:
            raise InputError(
                "transitions",
                f"is a tuple of {len(transitions)}",
                "give P[s, a_l, a_e, s'], or the pair (successors, probabilities)",
            )
        indices, probabilities = numbers("successors", transitions[0]), numbers("probabilities", transitions[1])
        if indices.ndim != 4 or indices.shape != probabilities.shape or 0 in indices.shape:
            raise InputError(
                "transitions",
                f"is a pair of shapes {indices.shape} and {probabilities.shape}",
                "give both the shape (states, learner's actions, expert's actions, successors)",
            )
        states = indices.shape[0]
        if (indices != np.round(indices)).any() or indices.min() < 0 or indices.max() >= states:
            raise InputError("successors", "an index is no state", f"give whole numbers from 0 to {states - 1}")
        return indices.astype(np.int64), probabilities
    dense = numbers("transitions", transitions)
    if dense.ndim != 4 or dense.shape[0] != dense.shape[3] or 0 in dense.shape:
        raise InputError(
            "transitions",
            f"has shape {dense.shape}",
            "give P[s, a_l, a_e, s'] of shape (states, learner's actions, expert's actions, states)",
        )
    # Keep no more columns than any (s, a) has successors: the others have probability 0 everywhere. Small games keep
    # all, so that games of one shape share their compiled programs.
    kept = dense.shape[3] if dense.shape[3] <= 16 else max(1, int((dense != 0).sum(-1).max()))
    if kept == dense.shape[3]:
        return np.broadcast_to(np.arange(kept), dense.shape).copy(), dense
    order = np.argsort(dense == 0, axis=-1, kind="stable")[..., :kept]
    return order.astype(np.int64), np.take_along_axis(dense, order, axis=-1)


def _check_distributions(argument: str, table: np.ndarray) -> None:
    if table.min() < 0:
        place = np.argwhere(table < 0)[0].tolist()
        raise InputError(argument, f"has the probability {table[tuple(place)]:g} at {place}", "give 0 or more")
    totals = np.atleast_1d(table.sum(-1))
    if np.abs(totals - 1).max() > 1e-6:
        place = np.argwhere(np.abs(totals - 1) > 1e-6)[0].tolist()
        where = f" at {place}" if table.ndim > 1 else ""
        raise InputError(
            argument, f"has probabilities that sum to {totals[tuple(place)]:.6g}{where}", "make them sum to 1"
        )


def _states_of(terminal: object, states: int) -> np.ndarray | None:
    if terminal is None:
        return None
    given = array_of("terminal", terminal)
    if given.dtype == bool and given.shape == (states,):
        over = given.copy()
    elif given.ndim == 1 and given.size == 0:
        return None
    else:
        mend = f"give {states} booleans, or a list of states from 0 to {states - 1}"
        if given.dtype.kind not in "iu" or given.ndim != 1:
            raise InputError("terminal", f"is an array of {given.dtype} of shape {given.shape}", mend)
        if given.min() < 0 or given.max() >= states:
            raise InputError("terminal", f"holds {given[(given < 0) | (given >= states)][0]}, which is no state", mend)
        if np.unique(given).size < given.size:
            # Zeros and ones that were meant as booleans would be read as the states 0 and 1.
            raise InputError("terminal", "names a state twice", mend)
        over = np.isin(np.arange(states), given)
    return over if over.any() else None


def _actions_of(argument: str, mask: object, shape: tuple[int, int], terminal: np.ndarray | None) -> np.ndarray | None:
    if mask is None:
        return None
    allowed = array_of(argument, mask)
    if allowed.shape != shape or allowed.dtype != bool:
        raise InputError(
            argument, f"is an array of {allowed.dtype} of shape {allowed.shape}", f"give booleans of shape {shape}"
        )
    allowed = allowed.copy()
    if terminal is not None:
        # Nothing is chosen there; what the mask says of it must not matter.
        allowed[terminal] = True
    if not allowed.any(1).all():
        state = int(np.flatnonzero(~allowed.any(1))[0])
        raise InputError(argument, f"allows no action in state {state}", "allow at least one in every state")
    return None if allowed.all() else allowed
