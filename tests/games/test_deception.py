import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mpe2 import simple_adversary_v3
from mpe2_world import state_of

from gsiirl.games import Deception, DeceptionState
from gsiirl.rewards.deception import adversary_reward, dependent_reward, own_reward
from gsiirl.types import Sides, Transition

EPISODES = 100
TOLERANCE = 1e-5


@pytest.fixture(scope="module")
def compared() -> dict[str, float]:
    """Largest differences between mpe2 and the port over 100 episodes of random actions, step by step."""
    game = Deception()
    reference = simple_adversary_v3.parallel_env(N=2, max_cycles=game.horizon, continuous_actions=True)
    world = reference.unwrapped.world

    @jax.jit
    def step(state, actions):
        following = game.step(state, actions)
        seen = Transition(state, actions, following)
        return following, game.observe(following), (own_reward(seen) + dependent_reward(seen), adversary_reward(seen))

    largest: dict[str, float] = dict.fromkeys(("position", "velocity", "observation", "reward"), 0.0)
    steps = 0
    for episode in range(EPISODES):
        reference.reset(seed=episode)
        state = state_of(world)
        random = np.random.default_rng(episode)
        while reference.agents:
            chosen = {name: random.random(5).astype(np.float32) for name in reference.agents}
            observations, rewards, *_ = reference.step(chosen)
            force = {name: [each[2] - each[1], each[4] - each[3]] for name, each in chosen.items()}
            actions = Sides(
                jnp.asarray([*force["agent_0"], *force["agent_1"]], jnp.float32),
                jnp.asarray(force["adversary_0"], jnp.float32),
            )
            state, seen, (learner, expert) = step(state, actions)
            truth = state_of(world)
            pairs = {
                "position": (state.positions, truth.positions),
                "velocity": (state.velocities, truth.velocities),
                "observation": (
                    np.concatenate([seen.learner, seen.expert]),
                    np.concatenate([observations[name] for name in ("agent_0", "agent_1", "adversary_0")]),
                ),
                "reward": (
                    np.stack([learner, learner, expert]),
                    np.array([rewards[name] for name in ("agent_0", "agent_1", "adversary_0")]),
                ),
            }
            for name, (ours, theirs) in pairs.items():
                largest[name] = max(largest[name], float(np.abs(np.asarray(ours) - np.asarray(theirs)).max()))
            steps += 1
    assert steps == EPISODES * game.horizon
    return largest


@pytest.mark.parametrize("quantity", ["position", "velocity", "observation", "reward"])
def test_every_step_is_that_of_mpe2(compared, quantity):
    assert compared[quantity] <= TOLERANCE


def test_the_adversary_does_not_observe_its_target():
    game = Deception()
    state = game.reset(jax.random.key(0))
    elsewhere = DeceptionState(
        state.positions, state.velocities, state.landmarks, jax.tree.map(lambda index: 1 - index, state.targets)
    )
    np.testing.assert_array_equal(game.observe(state).expert, game.observe(elsewhere).expert)
    assert not np.array_equal(game.observe(state).learner, game.observe(elsewhere).learner)


@pytest.mark.parametrize("separate", [False, True])
def test_the_sides_share_a_target_unless_told_otherwise(separate):
    states = jax.vmap(Deception(separate_target=separate).reset)(jax.random.split(jax.random.key(1), 50))
    same = np.asarray(states.targets.learner == states.targets.expert)
    assert same.all() if not separate else not same.any()
    assert set(np.asarray(states.targets.learner)) == {0, 1}
