import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.games import CrossingState, Deception
from gsiirl.rewards import crossing, deception
from gsiirl.rewards.continuous import LinearTransitionReward, NetworkReward, length
from gsiirl.types import Sides, Transition


def crossing_step(seed: int = 0) -> Transition:
    keys = jax.random.split(jax.random.key(seed), 4)
    places = [jax.random.uniform(key, (2,), jnp.float32, -0.3, 0.3) for key in keys]
    state = CrossingState(Sides(places[0], places[1]))
    return Transition(state, Sides(3 * places[2], 3 * places[3]), state)


def deception_step(separate: bool = False, seed: int = 0) -> Transition:
    game = Deception(separate_target=separate)
    state = game.reset(jax.random.key(seed))
    actions = Sides(jnp.ones(4, jnp.float32), jnp.ones(2, jnp.float32))
    following = game.step(game.step(state, actions), actions)
    return Transition(state, actions, following)


def test_the_crossings_rewards_are_their_formulas():
    for seed in range(5):
        seen = crossing_step(seed)
        robot, human = (np.asarray(place, float) for place in jax.tree.leaves(seen.following.positions))
        distance, speed = np.linalg.norm(robot - human), np.linalg.norm(np.asarray(seen.actions.expert, float))

        def near(width, distance=distance):
            return np.exp(-((distance / width) ** 2) / 2)

        slow = np.exp(-((speed / 0.3) ** 2) / 2)
        assert float(crossing.own_reward(seen)) == pytest.approx(-np.hypot(robot[0], robot[1] - 0.5), rel=1e-5)
        expected = -np.hypot(human[0] + 0.5, human[1]) - 5 * near(0.1)
        assert float(crossing.human_reward(seen)) == pytest.approx(expected, rel=1e-5)
        assert float(crossing.dependent_reward(seen)) == pytest.approx(
            -near(0.2) - 0.1 * slow - 5 * near(0.1), rel=1e-5
        )


def test_the_robots_features_can_express_the_dependent_reward():
    seen = crossing_step()
    weights = jnp.array([5.0, 1.0, 0.0, 0.1], jnp.float32)
    value = LinearTransitionReward(features=crossing.RobotFeatures(), scale=1.0)(weights, seen)
    assert float(value) == pytest.approx(float(crossing.dependent_reward(seen)), rel=1e-5)


def test_no_feature_of_the_human_hands_over_its_goal():
    assert np.linalg.norm(crossing.CENTRES - np.array(crossing.HUMAN_GOAL), axis=1).min() > 0.1


@pytest.mark.parametrize(("separate", "feature"), [(False, 0), (True, 1)])
def test_the_adversarys_reward_is_one_of_its_features(separate, feature):
    for seed in range(4):
        seen = deception_step(separate, seed)
        value = deception.AdversaryDistances(sign=-1.0)(seen)[feature]
        assert float(value) == pytest.approx(float(deception.adversary_reward(seen)), rel=1e-6)


def test_learner_and_expert_together_get_minus_the_nearer_agents_distance():
    seen = deception_step()
    total = deception.own_reward(seen) + deception.dependent_reward(seen) + deception.adversary_reward(seen)
    assert float(total) == pytest.approx(float(deception.own_reward(seen)), abs=1e-6)


def test_a_length_has_a_derivative_at_zero():
    assert jax.grad(length)(jnp.zeros(2)).tolist() == [0.0, 0.0]
    np.testing.assert_allclose(jax.grad(length)(jnp.array([3.0, 4.0])), [0.6, 0.8], rtol=1e-6)


def test_a_network_reward_is_its_formula_and_its_gradient_that_of_finite_differences():
    reward = NetworkReward(features=crossing.RobotFeatures(), scale=2.0, hidden=3)
    seen = crossing_step()
    theta = reward.initial_parameters(jax.random.key(1))
    assert theta.shape == (reward.number_of_parameters,) == (3 * 4 + 3 + 3,)
    own, features = 10.0 * np.asarray(theta, float), np.asarray(reward.features(seen), float)
    hidden = np.tanh(own[:12].reshape(3, 4) @ features + own[12:15])
    value, gradient = jax.jit(jax.value_and_grad(reward))(theta, seen)
    assert float(value) == pytest.approx(2.0 * own[15:] @ hidden, rel=1e-4)
    points = jnp.asarray(np.asarray(theta) + 1e-2 * np.concatenate([np.eye(18), -np.eye(18)]), jnp.float32)
    values = jax.jit(jax.vmap(reward, (0, None)))(points, seen)
    np.testing.assert_allclose(gradient, (values[:18] - values[18:]) / 2e-2, rtol=2e-2, atol=2e-3)
