"""The search for the best policy to commit to: many ascents at once, and new ones begun near the best.

f has many local maxima, and at small temperatures plateaus between them. Three things help against that, each for a
part of the starts: a high temperature of the expert that falls to the true one (on every other step, the others being
at the true one); first steps that take the expert's answer as given, which lead to a simultaneous equilibrium; and
starts beside the best policy so far, one decision of it changed, or many.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.commitment.objective import Commitment
from gsiirl.games.base import AbstractTabularGame, learner_policy

Objective = Callable[[Array, PyTree, Array, Array], Array]
"""f of (policy, a start's own parameters, temperature, reaction), to be made large."""

SMALLEST = -30.0
"""Least logit: a probability that rounding still notices, and from which an ascent can come back."""
SMALL = 2**12
"""A game whose two policies have fewer numbers is searched with more starts, steps and rounds."""
MOST_NEIGHBOURS = 256
"""As many policies with one decision changed are looked at; drawn at random where there are more."""


class Starts(eqx.Module):
    """Where N ascents begin.

    `logits` of the policies, the expert's first `temperature`, and the part of an ascent whose steps take the expert's
    answer as given (`simultaneous`).
    """

    logits: Float[Array, "N T S A_l"]
    temperature: Float[Array, " N"]
    simultaneous: Float[Array, " N"]

    @classmethod
    def plain(cls, logits: Float[Array, "N T S A_l"]) -> "Starts":
        """Ascents of f itself."""
        number = logits.shape[0]
        return cls(logits, jnp.ones(number, logits.dtype), jnp.zeros(number, logits.dtype))

    def and_also(self, others: "Starts") -> "Starts":
        """These and others."""
        return jax.tree.map(lambda a, b: jnp.concatenate([a, b]), self, others)


class Search(eqx.Module):
    """Adam on logits of π_l, in batches. `rate` is the first step on a logit and falls to a tenth of that."""

    game: AbstractTabularGame
    steps: int = eqx.field(static=True, default=60)
    rate: float = eqx.field(static=True, default=0.3)

    @property
    def shape(self) -> tuple[int, int, int]:
        """(T, S, A_l)."""
        return self.game.horizon, self.game.number_of_states, self.game.number_of_actions.learner

    def ascend(
        self, objective: Objective, starts: Starts, parameters: PyTree
    ) -> tuple[Float[Array, "N T S A_l"], Float[Array, " N"]]:
        """The best logits that each ascent passed through, and their f; `parameters` have a leading axis N.

        All at once in a small game; elsewhere one after the other, which caches like better.
        """
        if is_small(self.game):
            return jax.vmap(lambda start, each: self._ascend(objective, start, each))(starts, parameters)
        return jax.lax.map(lambda each: self._ascend(objective, *each), (starts, parameters))

    def random(self, number: int, spread: Float[Array, ""], key: PRNGKeyArray) -> Starts:
        """`number` starts: uniform, random pure and random mixed policies, a part of each begun in every way."""
        drawn = jax.random.uniform(key, (number, *self.shape), self.game.initial.dtype, 1e-9, 1.0)
        pure = self._nearly_pure(jnp.argmax(drawn, axis=-1))
        mixed = jnp.log(jnp.maximum(-jnp.log(drawn), 1e-3))
        index = jnp.arange(number)
        kind = jnp.where(index == 0, 0, 1 + index % 2)[:, None, None, None]
        logits = jnp.where(kind == 0, 0.0, jnp.where(kind == 2, pure, mixed))
        way = (index // 2) % 3
        return Starts(
            logits=jax.nn.log_softmax(logits, axis=-1),
            temperature=jnp.where(way == 0, jnp.maximum(spread, 1.0), 1.0),
            simultaneous=jnp.where(way == 1, 0.5, 0.0).astype(drawn.dtype),
        )

    def neighbours(
        self, objective: Objective, logits: Float[Array, "T S A_l"], parameters: PyTree, number: int, key: PRNGKeyArray
    ) -> Float[Array, "N T S A_l"]:
        """The `number` best of the policies that differ from `logits` in one decision, made nearly pure."""
        horizon, states, actions = self.shape
        every = horizon * states * actions
        place = jnp.arange(every)
        if every > MOST_NEIGHBOURS:
            place = jax.random.randint(key, (MOST_NEIGHBOURS // 4,), 0, every)
        time, state, action = jnp.unravel_index(place, self.shape)

        def changed(time: Array, state: Array, action: Array) -> Array:
            return logits.at[time, state].set(self._nearly_pure(action))

        def value(time: Array, state: Array, action: Array) -> Array:
            one = jnp.ones((), logits.dtype)
            return objective(learner_policy(self.game, changed(time, state, action)), parameters, one, one)

        values = jax.vmap(value)(time, state, action)
        # A decision that must not be made is as good as none: masks leave the policy as it was there.
        best = jax.lax.top_k(values, min(number, values.shape[0]))[1]
        best = best[jnp.arange(number) % best.shape[0]]
        return jax.vmap(changed)(time[best], state[best], action[best])

    def disturbed(self, logits: Float[Array, "N T S A_l"], key: PRNGKeyArray) -> Float[Array, "N T S A_l"]:
        """Policies in which about a fifth of the decisions is replaced by random pure ones."""
        drawn = jax.random.uniform(key, (*logits.shape[:3], 2), logits.dtype)
        pure = self._nearly_pure((drawn[..., 1] * self.shape[2]).astype(jnp.int32))
        return jnp.where((drawn[..., 0] < 0.2)[..., None], pure, logits)

    def best(
        self, objective: Objective, starts: Starts, parameters: PyTree, rounds: int, key: PRNGKeyArray
    ) -> tuple[Float[Array, "N T S A_l"], Float[Array, " N"]]:
        """All N ascents, then `rounds` more from beside the best ones; logits and f, the best first.

        Every start has the same `parameters`.
        """
        number = starts.logits.shape[0]
        same = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf[None], (number, *jnp.shape(leaf))), parameters)
        plain = Starts.plain(starts.logits)

        def one_round(carry: tuple[Starts, Array, Array], key: PRNGKeyArray):
            begun, logits, values = carry
            more = self.ascend(objective, begun, same)
            both = ranked(jnp.concatenate([logits, more[0]]), jnp.concatenate([values, more[1]]))
            logits, values = both[0][:number], both[1][:number]
            near_key, far_key = jax.random.split(key)
            near = self.neighbours(objective, logits[0], parameters, number // 2, near_key)
            far = self.disturbed(logits[: number - number // 2], far_key)
            return (eqx.tree_at(lambda at: at.logits, plain, jnp.concatenate([near, far])), logits, values), None

        nothing = jnp.full(number, -jnp.inf, starts.logits.dtype)
        (_, logits, values), _ = jax.lax.scan(
            one_round, (starts, starts.logits, nothing), jax.random.split(key, rounds + 1)
        )
        return logits, values

    def _ascend(self, objective: Objective, start: Starts, parameters: PyTree) -> tuple[Array, Array]:
        one = jnp.ones((), start.logits.dtype)

        def f(logits: Array, temperature: Array, reaction: Array) -> Array:
            return objective(learner_policy(self.game, logits), parameters, temperature, reaction)

        def step(carry, index: Array):
            logits, mean, square, best, best_value = carry
            done = index / self.steps
            true = index % 2 == 0
            temperature = jnp.where(true, one, start.temperature ** (1.0 - done))
            reaction = jnp.where(done < start.simultaneous, 0.0, one)
            value, slope = jax.value_and_grad(f)(logits, temperature, reaction)
            better = true & (value > best_value)
            best, best_value = jnp.where(better, logits, best), jnp.where(better, value, best_value)
            mean, square = 0.9 * mean + 0.1 * slope, 0.9 * square + 0.1 * slope**2
            # Both means are short by the same factor of their weights; and f's unit must not matter.
            short = 1.0 - 0.9 ** (index + 1)
            up = (mean / short) / (jnp.sqrt(square / short) + 1e-30)
            moved = jax.nn.log_softmax(logits + self.rate * 0.1**done * up, axis=-1)
            return (jnp.maximum(moved, SMALLEST), mean, square, best, best_value), None

        nothing = jnp.zeros_like(start.logits)
        carry = (start.logits, nothing, nothing, start.logits, -jnp.inf * one)
        (logits, _, _, best, best_value), _ = jax.lax.scan(
            step, carry, jnp.arange(self.steps, dtype=start.logits.dtype)
        )
        last = f(logits, one, one)
        better = last > best_value
        return jnp.where(better, logits, best), jnp.where(better, last, best_value)

    def _nearly_pure(self, choice: Array) -> Array:
        """Logits that choose action `choice` (modulo A_l) with all but a fiftieth of the probability."""
        actions = self.shape[2]
        chosen = jax.nn.one_hot(choice % actions, actions, dtype=self.game.initial.dtype)
        return jnp.log(0.02 / actions + 0.98 * chosen)


def is_small(game: AbstractTabularGame) -> bool:
    """Whether a search can afford more."""
    return game.policy_size < SMALL


def logits_of(policy: Float[Array, "*b T S A_l"]) -> Float[Array, "*b T S A_l"]:
    """Logits of a policy to begin an ascent from."""
    return jnp.maximum(jnp.log(policy), SMALLEST)


def ranked(logits: Float[Array, "N T S A_l"], values: Float[Array, " N"]) -> tuple[Array, Array]:
    """Both in the order of the values, the largest first."""
    order = jnp.argsort(-values)
    return logits[order], values[order]


def committed(
    commitment: Commitment, reward_of: Callable[[Array], object], weights: Float[Array, " K"] | None = None
) -> Objective:
    """f as an objective of θ, or of several θ (K, m) averaged with `weights`."""

    def one(policy: Array, theta: Array, temperature: Array, reaction: Array) -> Array:
        return commitment.value(policy, reward_of(theta), temperature, reaction)  # pyright: ignore[reportArgumentType]

    def several(policy: Array, thetas: Array, temperature: Array, reaction: Array) -> Array:
        assert weights is not None
        return jnp.vdot(weights, jax.vmap(lambda theta: one(policy, theta, temperature, reaction))(thetas))

    return one if weights is None else several
