import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, Float

from gsiirl.baselines.maddpg import Maddpg, MaddpgState, Networks
from gsiirl.games import AbstractContinuousGame, Crossing, Deception, play
from gsiirl.rewards import deception
from gsiirl.types import Sides, Transition

pytestmark = pytest.mark.usefixtures("optax_promotion")


class Drift(AbstractContinuousGame[Array]):
    """Two numbers in [−1, 1], moved by a tenth of the action of their side; both see both."""

    horizon: int = eqx.field(static=True, default=3)

    @property
    def action_size(self) -> Sides[int]:
        return Sides(1, 1)

    def reset(self, key) -> Float[Array, " 2"]:
        return jax.random.uniform(key, (2,), jnp.float32, -1.0, 1.0)

    def step(self, state, actions) -> Float[Array, " 2"]:
        return state + 0.1 * jnp.concatenate([actions.learner, actions.expert])

    def observe(self, state) -> Sides[Float[Array, " 2"]]:
        return Sides(state, state)


REWARDS = Sides(lambda seen: -((seen.following[0] - 0.3) ** 2), lambda seen: seen.following[1] - seen.following[0])


SMALL = {"hidden": 8, "batch": 16, "environments": 4, "memory": 30, "warm_up": 2, "first_noise": 1.0}


def small(game=None, **settings) -> Maddpg:
    return Maddpg(game or Drift(), **SMALL | settings)


@pytest.fixture(scope="module")
def state(optax_promotion) -> MaddpgState:
    """`small` after two episodes of all environments to remember, and two to learn from."""
    return small().train(REWARDS, jax.random.key(0), 2)


@eqx.filter_jit
def update(maddpg: Maddpg, state: MaddpgState, rewards, key) -> MaddpgState:
    return maddpg.update(state, rewards, key)


@eqx.filter_jit
def goals_of(maddpg: Maddpg, targets: Networks, batch, rewards):
    return maddpg.critic_goals(targets, batch, rewards)


def transitions(game, seed: int, number: int) -> Transition:
    """One step each from random states with random actions."""
    start_key, learner_key, expert_key = jax.random.split(jax.random.key(seed), 3)
    state = jax.vmap(game.reset)(jax.random.split(start_key, number))
    size = game.action_size
    actions = Sides(
        jax.random.uniform(learner_key, (number, size.learner), jnp.float32, -1.0, 1.0),
        jax.random.uniform(expert_key, (number, size.expert), jnp.float32, -1.0, 1.0),
    )
    return Transition(state, actions, jax.vmap(game.step)(state, actions))


def difference(one, other) -> float:
    return max(
        float(jnp.max(jnp.abs(a - b))) for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    )


@pytest.mark.parametrize("updates", [0, 50, 100, 1000])
def test_exploration_is_gaussian_noise_of_the_scheduled_size(updates):
    maddpg = small(first_noise=0.2, last_noise=0.1, noisy_updates=100)
    state = eqx.tree_at(lambda one: one.updates, maddpg.init(jax.random.key(0)), jnp.asarray(updates, jnp.int32))
    seen, time = Drift().observe(jnp.asarray([0.1, -0.2], jnp.float32)), jnp.asarray(0.0, jnp.float32)
    actions = jax.vmap(lambda key: maddpg.act(state, seen, time, key))(jax.random.split(jax.random.key(1), 4000))
    expected = {0: 0.2, 50: 0.15, 100: 0.1, 1000: 0.1}[updates]
    for side in ("learner", "expert"):
        noise = getattr(actions, side) - getattr(state.policies, side)(getattr(seen, side), time)[None]
        assert float(jnp.std(noise)) == pytest.approx(expected, rel=0.05)
        assert abs(float(jnp.mean(noise))) < 0.02
    assert abs(np.corrcoef(actions.learner[:, 0], actions.expert[:, 0])[0, 1]) < 0.06


def test_exploration_stays_among_the_actions_of_the_game(state):
    taken = state.replay.stored.transition.actions
    for actions in (taken.learner, taken.expert):
        assert float(jnp.max(jnp.abs(actions))) == 1.0
    # Four episodes of three steps, and no two environments did the same.
    assert int(state.replay.rounds) == 4 * 3
    assert len(np.unique(np.asarray(taken.learner[0]))) > 1


def test_what_was_learnt_is_played_without_noise(state):
    maddpg = small()
    start = maddpg.game.reset(jax.random.key(3))
    first, again = play(maddpg.game, state.policies, start), play(maddpg.game, state.policies, start)
    jax.tree.map(np.testing.assert_array_equal, first, again)
    action = state.policies.learner(maddpg.game.observe(start).learner, jnp.asarray(0.0, jnp.float32))
    np.testing.assert_allclose(first.actions.learner[0], action, rtol=1e-6)


def test_the_goals_of_critics_are_those_of_the_docstring(state):
    maddpg = small()
    batch = state.replay.sample(jax.random.key(0), 40)
    goals = goals_of(maddpg, state.targets, batch, REWARDS)
    for row in range(40):
        seen, step = jax.tree.map(lambda leaf, row=row: leaf[row], batch.transition), int(batch.time[row])
        time = jnp.asarray((step + 1) / 3, jnp.float32)
        view = jnp.concatenate([seen.following] * 3)
        actors = state.targets.actors
        actions = Sides(actors.learner(seen.following, time), actors.expert(seen.following, time))
        for side, reward in enumerate((REWARDS.learner, REWARDS.expert)):
            critic = jax.tree.map(lambda leaf, side=side: leaf[side], state.targets.critics)
            onward = 0.95 * critic(view, actions, time) if step + 1 < 3 else 0.0
            assert float(goals[side, row]) == pytest.approx(float(reward(seen) + onward), abs=1e-5)
    assert set(np.asarray(batch.time)) == {0, 1, 2}


def test_changed_rewards_change_the_goals_of_what_is_remembered(state):
    maddpg = small()
    batch = state.replay.sample(jax.random.key(0), 16)
    before = goals_of(maddpg, state.targets, batch, REWARDS)
    doubled = Sides(lambda seen: 2.0 * REWARDS.learner(seen), REWARDS.expert)
    after = goals_of(maddpg, state.targets, batch, doubled)
    np.testing.assert_allclose(after[0] - before[0], jax.vmap(REWARDS.learner)(batch.transition), atol=1e-6)
    np.testing.assert_array_equal(after[1], before[1])
    one, other = (update(maddpg, state, rewards, jax.random.key(1)) for rewards in (REWARDS, doubled))
    moved = jax.tree.map(
        lambda a, b: jnp.max(jnp.abs(a - b), axis=(1, 2)),
        *(each.networks.critics.layers[0].weight for each in (one, other)),
    )
    assert float(moved[0]) > 1e-6
    assert float(moved[1]) == 0.0


def test_targets_follow_the_networks_by_a_hundredth(state):
    maddpg = small()
    assert difference(state.networks, state.targets) > 1e-4
    moved = update(maddpg, state, REWARDS, jax.random.key(0))
    expected = jax.tree.map(lambda old, new: 0.99 * old + 0.01 * new, state.targets, moved.networks)
    assert difference(moved.targets, expected) < 1e-6
    assert int(moved.updates) == int(state.updates) + 1


def test_both_sides_and_both_their_networks_move(state):
    maddpg = small()
    moved = update(maddpg, state, REWARDS, jax.random.key(0))
    for before, after in zip(jax.tree.leaves(state.networks), jax.tree.leaves(moved.networks), strict=True):
        assert float(jnp.max(jnp.abs(after - before))) > 1e-6


def test_the_gradient_of_actors_agrees_with_finite_differences(state):
    maddpg = small()

    def double(tree):
        return jax.tree.map(lambda leaf: leaf.astype(jnp.float64) if eqx.is_inexact_array(leaf) else leaf, tree)

    networks, batch = double(state.networks), double(state.replay.sample(jax.random.key(0), 16))

    def losses(actors):
        return maddpg.actor_losses(Networks(actors, networks.critics), batch)

    slopes = jax.grad(lambda actors: jnp.sum(losses(actors)))(networks.actors)
    for side in range(2):
        direction = jax.tree.map(
            lambda leaf: jnp.asarray(np.random.default_rng(leaf.size).normal(size=leaf.shape)), networks.actors
        )
        # What one side plays is nothing to the loss of the other.
        still = jax.tree.map(jnp.zeros_like, direction)
        direction = Sides(direction.learner, still.expert) if side == 0 else Sides(still.learner, direction.expert)
        up, down = (
            losses(jax.tree.map(lambda leaf, along, h=h: leaf + h * along, networks.actors, direction))
            for h in (1e-5, -1e-5)
        )
        change = (up - down) / 2e-5
        along = sum(jnp.vdot(a, b) for a, b in zip(*map(jax.tree.leaves, (slopes, direction)), strict=True))
        # Time and the critics' view of the state are of single precision, as always.
        assert float(along) == pytest.approx(float(change[side]), rel=1e-5)
        assert abs(float(change[1 - side])) < 1e-10
        assert abs(float(change[side])) > 1e-4


@pytest.mark.slow
def test_a_critic_learns_a_known_value_and_the_actor_its_best_action():
    # One step: the learner is paid 1 − (a_l − s_0/2)² and the expert −(a_e + a_l)².
    game = Drift(horizon=1)
    rewards = Sides(
        lambda seen: 1.0 - (seen.actions.learner[0] - 0.5 * seen.state[0]) ** 2,
        lambda seen: -((seen.actions.expert[0] + 0.5 * seen.state[0]) ** 2),
    )
    maddpg = small(game, hidden=32, batch=128, environments=32, memory=200, learning_rate=3e-3, noisy_updates=1000)
    state = maddpg.train(rewards, jax.random.key(0), 1200)
    test = transitions(game, 5, 200)
    time, zeros = jnp.zeros(200, jnp.float32), jnp.zeros(200, jnp.int32)
    best = 0.5 * test.state[:, 0]
    np.testing.assert_allclose(jax.vmap(state.policies.learner)(test.state, time)[:, 0], best, atol=0.1)
    np.testing.assert_allclose(jax.vmap(state.policies.expert)(test.state, time)[:, 0], -best, atol=0.1)
    near = Sides(jnp.clip(best + 0.1, -1.0, 1.0)[:, None], jnp.clip(-best - 0.1, -1.0, 1.0)[:, None])
    values = maddpg._values(
        state.networks.critics, test.state, jax.tree.map(lambda leaf: jnp.stack([leaf] * 2), near), zeros
    )
    np.testing.assert_allclose(values[0], 0.99, atol=0.1)
    np.testing.assert_allclose(values[1], -0.01, atol=0.1)


@pytest.mark.slow
def test_many_seeds_at_once_are_the_same_as_one_by_one(state):
    maddpg = small()
    keys = jnp.stack([jax.random.key(0), jax.random.key(1)])
    together = jax.vmap(lambda key: maddpg.train(REWARDS, key, 2))(keys)
    for index, alone in enumerate((state, maddpg.train(REWARDS, keys[1], 2))):
        assert difference(alone, jax.tree.map(lambda leaf, index=index: leaf[index], together)) < 1e-5
    assert difference(*(jax.tree.map(lambda leaf, k=k: leaf[k], together.networks) for k in (0, 1))) > 1e-3


def test_a_host_loop_over_any_environment_trains_too():
    # The environment is NumPy's; of the game only observations, sizes and the horizon are used.
    maddpg = small()
    state = maddpg.init(jax.random.key(0))
    act = jax.jit(jax.vmap(maddpg.act, in_axes=(None, 0, None, 0)))
    now = np.random.default_rng(0).uniform(-1, 1, (4, 2)).astype(np.float32)
    for step in range(3):
        keys = jax.random.split(jax.random.key(step), 5)
        seen = Sides(jnp.asarray(now), jnp.asarray(now))
        actions = act(state, seen, jnp.asarray(step / 3, jnp.float32), keys[1:])
        following = now + np.float32(0.1) * np.concatenate([actions.learner, actions.expert], axis=1)
        transition = Transition(jnp.asarray(now), actions, jnp.asarray(following))
        state = maddpg.remember(state, transition, jnp.asarray(step, jnp.int32))
        state = update(maddpg, state, REWARDS, keys[0])
        now = following
    assert int(state.updates) == int(state.replay.rounds) == 3
    np.testing.assert_array_equal(state.replay.stored.transition.following[2], now)


def test_training_goes_on_with_what_is_remembered(state):
    longer = eqx.filter_jit(small().go_on)(state, REWARDS, jax.random.key(1), 3)
    assert int(state.updates) == 2 * 3
    assert int(longer.updates) == 5 * 3
    assert int(longer.replay.rounds) == (2 + 5) * 3


@pytest.mark.slow
def test_each_side_of_the_crossing_learns_to_head_for_its_goal():
    game = Crossing(horizon=8)
    goals = Sides(jnp.asarray([0.0, 0.5], jnp.float32), jnp.asarray([-0.5, 0.0], jnp.float32))
    rewards = Sides(
        lambda seen: -jnp.sum((seen.following.positions.learner - goals.learner) ** 2),
        lambda seen: -jnp.sum((seen.following.positions.expert - goals.expert) ** 2),
    )
    maddpg = small(game, hidden=32, batch=128, environments=16, memory=400, learning_rate=3e-3)
    state = maddpg.train(rewards, jax.random.key(0), 100)
    starts = jax.vmap(game.reset)(jax.random.split(jax.random.key(1), 50))
    ends = jax.tree.map(lambda leaf: leaf[:, -1], jax.vmap(lambda one: play(game, state.policies, one))(starts))
    # Eight steps cover 0.8 of the 0.9 to 1 that there are to go.
    places = ends.following.positions
    assert float(jnp.mean(jnp.linalg.norm(places.learner - goals.learner[None], axis=1))) < 0.3
    assert float(jnp.mean(jnp.linalg.norm(places.expert - goals.expert[None], axis=1))) < 0.3


def test_critics_see_what_nobody_observes():
    game = Deception()
    maddpg = small(game)
    state = game.reset(jax.random.key(0))
    faster = eqx.tree_at(lambda one: one.velocities, state, state.velocities + 1.0)
    for one, other in zip(*map(jax.tree.leaves, (game.observe(state), game.observe(faster))), strict=True):
        np.testing.assert_array_equal(one, other)
    assert difference(maddpg.view(state), maddpg.view(faster)) == 1.0


def test_reals_stay_in_single_precision():
    maddpg = small(Deception())
    state = maddpg.init(jax.random.key(0))
    remembered = maddpg.remember(state, transitions(Deception(), 0, 4), jnp.asarray(0, jnp.int32))
    rewards = Sides(deception.own_reward, deception.adversary_reward)
    after = jax.eval_shape(lambda one: maddpg.update(one, rewards, jax.random.key(1)), remembered)
    assert {str(leaf.dtype) for leaf in jax.tree.leaves(after) if leaf.dtype.kind == "f"} == {"float32"}
    assert jax.tree.structure(after) == jax.tree.structure(state)
