import jax
import jax.numpy as jnp
import numpy as np
import pytest
from problems import tiny_problem

from gsiirl.interaction import interact, live
from gsiirl.types import Trajectories

pytestmark = pytest.mark.usefixtures("optax_promotion")

TRAJECTORIES = 20


@pytest.fixture(scope="module")
def problem():
    return tiny_problem()


def leaves_equal(first, second, tolerance: float) -> None:
    for one, other in zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True):
        np.testing.assert_allclose(np.asarray(one), np.asarray(other), rtol=0, atol=tolerance)


def test_a_run_cut_into_chunks_is_the_same_run(problem):
    def run(state, first, number):
        return interact(
            problem.learner,
            problem.expert,
            state,
            jax.random.key(1),
            first,
            number,
            TRAJECTORIES,
            lambda _, proposal: problem.truth.evaluate(proposal.policies),
        )

    advance = jax.jit(run, static_argnums=2)
    start = problem.learner.init(jax.random.key(0))
    whole, record = advance(start, jnp.asarray(0), 6)
    half, first = advance(start, jnp.asarray(0), 3)
    cut, second = advance(half, jnp.asarray(3), 3)
    leaves_equal(whole, cut, 1e-12)
    leaves_equal(record, jax.tree.map(lambda a, b: jnp.concatenate([a, b]), first, second), 1e-12)


def test_an_expert_in_plain_python_teaches_the_same_as_a_traced_one(problem):
    class Stranger:
        """Knows nothing of the library's classes."""

        asked = 0

        def demonstrate(self, learner_policy, number, key) -> Trajectories:
            self.asked += number
            return problem.expert.demonstrate(learner_policy, number, key)

    stranger = Stranger()
    told = live(problem.learner, stranger, 3, TRAJECTORIES, seed=5, progress=False)
    traced = live(problem.learner, problem.expert, 3, TRAJECTORIES, seed=5, progress=False)
    leaves_equal(told, traced, 1e-9)
    assert stranger.asked == 3 * TRAJECTORIES


def test_fit_returns_weights_in_reward_units(problem):
    learned = problem.learner.fit(problem.expert, iterations=2, trajectories=TRAJECTORIES, seed=0, progress=False)
    scale = problem.learner.expert_reward.scale
    np.testing.assert_allclose(learned.expert_reward, scale * learned.state.expert_parameters)
    assert float(jnp.linalg.norm(learned.commitment)) <= float(problem.learner.dependent_reward.scale) * (1 + 1e-12)
