import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.pathwise import Pathwise
from gsiirl.experts.continuous_expert import POLICIES, ContinuousRespondingExpert, Habits
from gsiirl.games import Crossing
from gsiirl.games.rollout import episodes_from
from gsiirl.interaction import Proposal
from gsiirl.rewards import crossing as rewards
from gsiirl.rewards.continuous import mean_return
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")

GAME = Crossing(horizon=4)
SOLVER = Pathwise.create(GAME, discount=0.9, batch=16, hidden=4, decay_steps=100, learning_rate=0.02)


def expert(steps: int, first_steps: int) -> ContinuousRespondingExpert:
    """Its rate falls over 100 steps."""
    return ContinuousRespondingExpert(
        GAME,
        rewards.human_reward,
        discount=0.9,
        iterations=(100 - first_steps) // max(steps, 1),
        steps=steps,
        first_steps=first_steps,
        batch=16,
        hidden=4,
        learning_rate=0.02,
    )


@pytest.fixture(scope="module")
def practised():
    learner_policy = SOLVER.init(jax.random.key(0)).learner.policy
    with jax.numpy_dtype_promotion("standard"):
        return learner_policy, jax.jit(expert(1, 60).init)(jax.random.key(1), learner_policy)


def worth(learner_policy, policy) -> float:
    starts = SOLVER.starts(jax.random.key(2))
    return float(mean_return(rewards.human_reward, episodes_from(GAME, Sides(learner_policy, policy), starts), 0.9))


@pytest.mark.slow
def test_it_practises_from_different_starts_and_gets_better(practised):
    learner_policy, habits = practised
    weights = np.asarray(jax.tree.leaves(habits.practised.policy)[0])
    assert weights.shape[0] == POLICIES
    assert np.abs(weights[0] - weights[1]).max() > 0.1
    untrained = SOLVER.init(jax.random.key(3)).expert.policy
    assert worth(learner_policy, habits.policy) > worth(learner_policy, untrained) + 0.1


@pytest.mark.parametrize("stuck", range(POLICIES))
def test_it_plays_the_policy_that_earns_it_most_when_another_is_stuck(practised, stuck):
    learner_policy, habits = practised

    def frozen(leaf):
        return leaf.at[stuck].set(0.0)  # a policy that stands still

    policies = jax.tree.map(frozen, habits.practised.policy)
    before = Habits(eqx.tree_at(lambda one: one.policy, habits.practised, policies), jnp.asarray(stuck))
    after = jax.jit(expert(0, 0).adapt)(before, learner_policy, jax.random.key(4))
    assert int(after.best) == 1 - stuck
    for found, kept in zip(jax.tree.leaves(after.policy), jax.tree.leaves(policies), strict=True):
        np.testing.assert_array_equal(found, kept[1 - stuck])


def test_its_demonstrations_are_played_by_the_policy_it_has_chosen(practised):
    learner_policy, habits = practised
    meet = jax.jit(expert(1, 1).meet, static_argnums=2)
    adapted, met = meet(habits, Proposal(learner_policy), 3, jax.random.key(5))
    seen = met.demonstrations
    starts = jax.tree.map(lambda leaf: leaf[:, 0], seen.state)
    again = episodes_from(GAME, Sides(learner_policy, adapted.policy), starts)
    np.testing.assert_allclose(seen.actions.expert, again.actions.expert, atol=1e-6)
