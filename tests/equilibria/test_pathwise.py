import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.pathwise import Pathwise, policies_of, steps_taken
from gsiirl.equilibria.policy_network import NoisyPolicy, PolicyNetwork
from gsiirl.games import Crossing, Deception
from gsiirl.games.rollout import episodes_from
from gsiirl.rewards import crossing as rewards
from gsiirl.rewards import deception
from gsiirl.rewards.continuous import mean_return
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")

GAME = Crossing(horizon=12)
TRUE = Sides(lambda seen: rewards.own_reward(seen) + rewards.dependent_reward(seen), rewards.human_reward)


def solver(**changes) -> Pathwise:
    settings = {"discount": 0.9, "batch": 8, "hidden": 8, "decay_steps": 200, "expert_steps": 1}
    return Pathwise.create(GAME, **(settings | changes))


def test_a_policy_stays_within_its_bounds_and_starts_with_small_actions():
    policy = PolicyNetwork.create(4, 2, 8, jax.random.key(0))
    far = policy(1e3 * jnp.ones(4, jnp.float32), jnp.asarray(0.5, jnp.float32))
    near = policy(jnp.zeros(4, jnp.float32), jnp.asarray(0.0, jnp.float32))
    assert float(jnp.max(jnp.abs(far))) <= 1.0
    assert float(jnp.max(jnp.abs(near))) <= 0.1


def test_noise_is_added_at_its_own_step_and_none_changes_nothing():
    policy = PolicyNetwork.create(4, 2, 8, jax.random.key(0))
    observation = jnp.linspace(-1.0, 1.0, 4, dtype=jnp.float32)
    for step in range(12):
        time = jnp.asarray(step / 12, jnp.float32)
        still = NoisyPolicy(policy, jnp.zeros((12, 2), jnp.float32))
        np.testing.assert_array_equal(still(observation, time), policy(observation, time))
        shaking = NoisyPolicy(policy, jnp.zeros((12, 2), jnp.float32).at[step].set(0.7))
        expected = jnp.tanh(policy.intention(observation, time) + 0.7)
        np.testing.assert_allclose(shaking(observation, time), expected, rtol=1e-6)


def test_the_gradient_through_an_episode_is_that_of_finite_differences():
    solve = solver()
    policies = policies_of(solve.init(jax.random.key(1)))
    starts = solve.starts(jax.random.key(2))
    leaves, structure = jax.tree.flatten(policies.learner)
    keys = jax.random.split(jax.random.key(3), len(leaves))
    move = jax.tree.unflatten(
        structure, [jax.random.normal(key, leaf.shape, leaf.dtype) for key, leaf in zip(keys, leaves, strict=True)]
    )

    def value(size):
        moved = jax.tree.map(lambda leaf, step: leaf + size * step, policies.learner, move)
        return mean_return(TRUE.learner, episodes_from(GAME, Sides(moved, policies.expert), starts), 0.9)

    size = jnp.asarray(0.0, jnp.float32)
    slope = float(jax.grad(value)(size))
    step = jnp.asarray(3e-3, jnp.float32)
    differences = float((value(step) - value(-step)) / (2 * step))
    assert slope == pytest.approx(differences, rel=1e-2, abs=1e-3)


@pytest.mark.slow
def test_each_side_follows_its_own_return_alone():
    solve = solver()
    state = solve.init(jax.random.key(0))

    def after(learner_factor, expert_factor):
        changed = Sides(
            lambda seen: learner_factor * rewards.own_reward(seen), lambda seen: expert_factor * TRUE.expert(seen)
        )
        return policies_of(solve.ascend(state, changed, jax.random.key(1), 1)[0])

    one, other_expert, other_learner = after(1.0, 1.0), after(1.0, -1.0), after(-1.0, 1.0)
    same = jax.tree.map(np.array_equal, one.learner, other_expert.learner)
    assert all(jax.tree.leaves(same))
    assert all(jax.tree.leaves(jax.tree.map(np.array_equal, one.expert, other_learner.expert)))
    assert not all(jax.tree.leaves(jax.tree.map(np.array_equal, one.expert, other_expert.expert)))


def test_sides_with_unlike_numbers_of_controls_shake_each_by_its_own():
    solve = Pathwise.create(
        Deception(horizon=3), discount=0.9, batch=2, hidden=4, decay_steps=10, expert_steps=1, noise=0.5
    )
    wanted = Sides(deception.own_reward, deception.adversary_reward)

    def stepped(key):
        state = solve.init(key)
        return state, solve.ascend(state, wanted, key, 1)[0]

    before, after = jax.eval_shape(stepped, jax.random.key(0))
    assert before == after


@pytest.mark.slow
def test_both_sides_learn_to_reach_their_goals():
    solve = solver(hidden=16, batch=16, decay_steps=300, learning_rate=1e-2)
    state, progress = jax.jit(lambda key: solve.ascend(solve.init(key), TRUE, key, 300))(jax.random.key(0))
    episodes = episodes_from(GAME, policies_of(state), solve.starts(jax.random.key(9)))
    places = episodes.following.positions
    for side, goal in ((places.learner, rewards.ROBOT_GOAL), (places.expert, rewards.HUMAN_GOAL)):
        assert np.linalg.norm(np.asarray(side)[:, -1] - np.array(goal), axis=-1).max() < 0.2
    assert float(progress.returns.learner[-1]) > float(progress.returns.learner[0]) + 2.0
    assert np.isfinite(np.asarray(progress.gradient_norms.learner)).all()


def test_a_response_improves_the_expert_and_an_answer_the_learner():
    solve = solver(learning_rate=1e-2)
    state = solve.init(jax.random.key(0))
    policies, starts = policies_of(state), solve.starts(jax.random.key(5))
    response = jax.jit(lambda: solve.respond(policies.learner, TRUE.expert, state.expert, jax.random.key(1), 60))()
    answer = jax.jit(lambda: solve.answer(policies.expert, TRUE.learner, state.learner, jax.random.key(1), 60))()

    def value(side, learner, expert):
        return float(mean_return(getattr(TRUE, side), episodes_from(GAME, Sides(learner, expert), starts), 0.9))

    before = value("expert", policies.learner, policies.expert)
    assert value("expert", policies.learner, response.policy) > before + 1.0
    before = value("learner", policies.learner, policies.expert)
    assert value("learner", answer.policy, policies.expert) > before + 1.0


def test_noise_stays_for_half_of_the_steps_and_falls_to_nothing_in_the_other_half():
    noise = solver(noise=0.4, decay_steps=10).noise
    assert noise is not None
    found = np.array([noise(step) for step in (0, 5, 7, 10, 20)])
    np.testing.assert_allclose(found, [0.4, 0.4, 0.24, 0.0, 0.0], rtol=1e-6)
    assert solver().noise is None


@pytest.mark.slow
def test_how_much_hands_shake_depends_on_the_steps_that_were_taken_and_not_on_the_call():
    solve, still = solver(noise=0.4, decay_steps=4), solver(decay_steps=4)
    keys = jax.random.split(jax.random.key(1), 2)
    start = solve.init(jax.random.key(0))
    later = solve.ascend(start, TRUE, keys[0], 4)[0]
    assert int(steps_taken(later.learner)) == 4

    def first_return(solve, state):
        return float(solve.ascend(state, TRUE, keys[1], 1)[1].returns.expert[0])

    assert first_return(solve, start) != first_return(still, start)
    # Past the fall a step is one without noise.
    assert first_return(solve, later) == pytest.approx(first_return(still, later), rel=1e-5)


@pytest.mark.slow
def test_a_pair_settles_from_where_it_is_and_with_a_rate_of_its_own_beginning():
    solve, key = solver(), jax.random.key(4)
    state = solve.ascend(solve.init(jax.random.key(3)), TRUE, jax.random.key(5), 3)[0]
    begun = solve.init_at(policies_of(state))
    assert int(steps_taken(state.learner)) == 3
    assert int(steps_taken(begun.learner)) == int(steps_taken(begun.expert)) == 0
    jax.tree.map(np.testing.assert_array_equal, policies_of(begun), policies_of(state))
    expected = policies_of(solve.ascend(begun, TRUE, key, 2)[0])
    jax.tree.map(np.testing.assert_array_equal, solve.settle(policies_of(state), TRUE, key, 2), expected)


@pytest.mark.slow
def test_vmapped_seeds_equal_looped_seeds():
    solve = solver(expert_steps=2, noise=0.3)
    keys = jax.random.split(jax.random.key(0), 2)

    def train(key):
        return policies_of(solve.ascend(solve.init(key), TRUE, key, 3)[0])

    together, one_by_one = jax.jit(jax.vmap(train))(keys), [jax.jit(train)(key) for key in keys]
    for index, alone in enumerate(one_by_one):
        for first, second in zip(jax.tree.leaves(together), jax.tree.leaves(alone), strict=True):
            np.testing.assert_allclose(first[index], second, atol=2e-5)
