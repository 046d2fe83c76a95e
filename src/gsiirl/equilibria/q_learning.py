"""Two independent Q-learners on a tabular game: the forward model of the paper's security experiment (A.10.3).

Each side i keeps Q_i,t(s, a_i) over its own actions, zero at the start and after the last step (Q_i,T = 0), and after
every step moves it towards what it has seen, whatever the other side did:

    Q_i,t(s, a_i) ← Q_i,t(s, a_i) + α (r_i(s, a) + γ max_{a'} Q_i,t+1(s', a') − Q_i,t(s, a_i))
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from gsiirl.equilibria.base import AbstractForwardModel, AbstractSolution
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Number, Policies, Sides

BEST = 0.6
"""How often the best action is picked over the second best; the paper says only "best with 60 %"."""

GREEDY = 0.7
"""How often a side in training picks among its two best actions, and not among all of them."""


class QLearningSolution(AbstractSolution):
    """What the learners play after training, with the quality of what they learnt.

    `policies` and `tables` (the Q_i,t) are (T, S, A); `visits` (T, S, A) counts how often a side tried an action.
    `residual` is the mean, over all visits of both sides, of
    |Q_i,t(s, a_i) − E[r_i(s, a) + γ max_{a'} Q_i,t+1(s', a')]|, where a_-i is drawn from the other side's training
    behaviour at the final tables: computed from the game, not sampled, in reward units. `converged` says whether it is
    below the tolerance times the range of the rewards (with zero in it, where the tables start).
    """

    policies: Policies
    tables: Sides[Float[Array, "T S A"]]
    visits: Sides[Float[Array, "T S A"]]
    residual: Float[Array, ""]
    converged: Bool[Array, ""]


class QLearning(AbstractForwardModel):
    """Independent Q-learning of both sides; it need not converge, and need not end near an equilibrium when it does.

    A state visited at time t in training plays its best action with 0.6 and its second best with 0.4, ties going to the
    lower index; one that was never visited knows nothing, and plays uniformly. In training that is mixed with uniform
    play, 0.7 to 0.3.

    `episodes` are played `batch` at a time (the last batch is filled up), and the tables move after each batch, every
    entry towards the mean of its c targets with rate min(1, c (n + c)^−`rate_decay`), where n counts its visits before.
    With a batch of one this is the online rule with the rate (1 + n)^−`rate_decay`. All random numbers follow from
    `seed`, whatever the rewards: two solves differ by their rewards alone, and more episodes continue the same run.
    `tolerance` is that of `converged`.
    """

    episodes: int = eqx.field(static=True, default=100_000)
    batch: int = eqx.field(static=True, default=256)
    rate_decay: float = 0.7
    tolerance: float = 0.02
    seed: int | Int[Array, ""] = 0

    def solve(self, game: AbstractTabularGame, rewards: Sides[AbstractPayoff], discount: Number) -> QLearningSolution:
        """What both sides have learnt in `game` under `rewards` (payoffs over all states)."""
        dtype = game.initial.dtype
        dense = Sides(rewards.learner.dense(), rewards.expert.dense())
        key = jax.random.key(self.seed)
        times = jnp.arange(game.horizon)[:, None]

        def learn(table, visits, reward, own_actions, joint_actions, states, following):
            # The targets of a whole episode hold the tables from before it, as online: at time t the update reads
            # Q_t+1, which changes only later in the episode.
            values = jnp.concatenate([jnp.max(table[1:], axis=-1), jnp.zeros((1, game.number_of_states), dtype)])
            targets = reward[states, joint_actions.learner, joint_actions.expert] + discount * values[times, following]
            seen = jnp.stack([targets, jnp.ones_like(targets)], axis=-1)
            total, count = jnp.moveaxis(
                jnp.zeros((*table.shape, 2), dtype).at[times, states, own_actions].add(seen), -1, 0
            )
            visits = visits + count
            some = jnp.maximum(count, 1.0)
            rate = jnp.minimum(1.0, count * jnp.maximum(visits, 1.0) ** -self.rate_decay)
            return table + rate * (total / some - table), visits

        def update(carry, index):
            tables, visits = carry
            states, actions, following = _play(jax.random.fold_in(key, index), game, tables, visits, self.batch)
            learner = learn(tables.learner, visits.learner, dense.learner, actions.learner, actions, states, following)
            expert = learn(tables.expert, visits.expert, dense.expert, actions.expert, actions, states, following)
            return (Sides(learner[0], expert[0]), Sides(learner[1], expert[1])), None

        shape = game.horizon, game.number_of_states
        actions = game.number_of_actions
        nothing = Sides(jnp.zeros((*shape, actions.learner), dtype), jnp.zeros((*shape, actions.expert), dtype))
        updates = -(-self.episodes // self.batch)
        (tables, visits), _ = jax.lax.scan(update, (nothing, nothing), jnp.arange(updates))
        residual = _residual(game, rewards, discount, tables, visits)
        largest = jnp.maximum(jnp.max(dense.learner), jnp.max(dense.expert))
        smallest = jnp.minimum(jnp.min(dense.learner), jnp.min(dense.expert))
        spread = jnp.maximum(largest, 0.0) - jnp.minimum(smallest, 0.0)
        policies = jax.tree.map(lambda table, seen: exploit(table, _visited(seen)), tables, visits)
        return QLearningSolution(
            policies=policies,
            tables=tables,
            visits=visits,
            residual=residual,
            converged=residual <= self.tolerance * spread,
        )


def exploit(table: Float[Array, "*b A"], visited: Bool[Array, "*b"]) -> Float[Array, "*b A"]:
    """0.6 on the best action and 0.4 on the second best, ties to the lower index; uniform where not `visited`."""
    actions, dtype = table.shape[-1], table.dtype
    best, second = _two_best(table)
    # A single action is its own second best, and gets both shares.
    policy = BEST * jax.nn.one_hot(best, actions, dtype=dtype) + (1.0 - BEST) * jax.nn.one_hot(
        second, actions, dtype=dtype
    )
    return jnp.where(visited[..., None], policy, 1.0 / actions)


def explore(table: Float[Array, "*b A"], visited: Bool[Array, "*b"]) -> Float[Array, "*b A"]:
    """The behaviour in training: 0.7 · `exploit` + 0.3 / A."""
    return GREEDY * exploit(table, visited) + (1.0 - GREEDY) / table.shape[-1]


def _two_best(table: Float[Array, "*b A"]) -> tuple[Int[Array, "*b"], Int[Array, "*b"]]:
    best = jnp.argmax(table, axis=-1)
    others = jnp.where(jax.nn.one_hot(best, table.shape[-1], dtype=bool), -jnp.inf, table)
    return best, jnp.argmax(others, axis=-1)


def _visited(visits: Float[Array, "*b A"]) -> Bool[Array, "*b"]:
    return jnp.any(visits > 0, axis=-1)


def _play(
    key: PRNGKeyArray, game: AbstractTabularGame, tables: Sides, visits: Sides, batch: int
) -> tuple[Int[Array, "T B"], Sides[Int[Array, "T B"]], Int[Array, "T B"]]:
    """Episodes under `explore`: states, actions, and the states that follow."""
    reset_key, action_key, step_key = jax.random.split(key, 3)
    horizon, dtype = game.horizon, game.initial.dtype
    # One draw each for every step, made before anything is known: the same ones under any rewards.
    draws = jax.random.uniform(action_key, (horizon, 2, batch), dtype)
    step_keys = jax.random.split(step_key, (horizon, batch))
    ranked = jax.tree.map(lambda table, seen: (*_two_best(table), _visited(seen)), tables, visits)

    def one_step(states, inputs):
        (learner_draw, expert_draw), keys, now = inputs
        actions = Sides(
            _pick(learner_draw, states, now.learner, game.number_of_actions.learner),
            _pick(expert_draw, states, now.expert, game.number_of_actions.expert),
        )
        following = jax.vmap(game.step)(keys, states, actions).astype(states.dtype)
        return following, (states, actions, following)

    # Not `game.reset`, which draws a number for every state: that took half of the time of a whole solve.
    reached = jnp.cumsum(game.initial)
    starts = jnp.searchsorted(reached, reached[-1] * jax.random.uniform(reset_key, (batch,), dtype), side="right")
    return jax.lax.scan(one_step, starts.astype(int), (draws, step_keys, ranked))[1]


def _pick(draw, states, ranked, actions):
    """Actions distributed as `explore`, from one uniform draw each."""
    best, second, visited = (leaf[states] for leaf in ranked)
    uniform = jnp.where(visited, (draw - GREEDY) / (1.0 - GREEDY), draw)
    anything = jnp.clip((actions * uniform).astype(best.dtype), 0, actions - 1)
    greedy = jnp.where(draw < GREEDY * BEST, best, second)
    return jnp.where(visited & (draw < GREEDY), greedy, anything)


def _residual(
    game: AbstractTabularGame,
    rewards: Sides[AbstractPayoff],
    discount: Number,
    tables: Sides,
    visits: Sides,
) -> Float[Array, ""]:
    behaviour = jax.tree.map(lambda table, seen: explore(table, _visited(seen)), tables, visits)

    def backward(following, inputs):
        now, counts, behaviour_now = inputs
        # Reward and continuation apart: they need not be payoffs of one form.
        learner = rewards.learner.learner_values(behaviour_now.expert)
        learner += discount * game.continuation(following.learner).learner_values(behaviour_now.expert)
        expert = rewards.expert.expert_values(behaviour_now.learner)
        expert += discount * game.continuation(following.expert).expert_values(behaviour_now.learner)
        total = jnp.sum(counts.learner * jnp.abs(now.learner - learner))
        total += jnp.sum(counts.expert * jnp.abs(now.expert - expert))
        return jax.tree.map(lambda table: jnp.max(table, axis=-1), now), total

    nothing = jnp.zeros_like(game.initial)
    _, totals = jax.lax.scan(backward, Sides(nothing, nothing), (tables, visits, behaviour), reverse=True)
    return jnp.sum(totals) / (jnp.sum(visits.learner) + jnp.sum(visits.expert))
