import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.theory.support.brute_force import Case, Measured
from gsiirl.theory.support.games import Size

SIZE = Size(states=3, learner_actions=2, expert_actions=2, horizon=3, learner_parameters=3, expert_parameters=2)


def case(unexpressed: float = 0.0) -> Case:
    """Under the model that compiles fast."""
    return Case.draw(0, SIZE, 0.1, unexpressed=unexpressed, forward_model="soft_joint")


@pytest.fixture(scope="module")
def inside() -> Measured:
    return Measured(case())


def test_brute_force_differentiates_what_is_solved_anew(inside):
    at = inside.case
    solve = jax.jit(lambda theta: at.solved_anew(theta))
    step = 1e-4
    direction = jnp.asarray([0.6, -0.3, 0.7])
    forth, back = (solve(at.commitment + sign * step * direction) for sign in (1.0, -1.0))
    assert (forth[0] - back[0]) / (2.0 * step) == pytest.approx(float(inside.brute.gradient @ direction), rel=1e-6)
    moved = (forth[1].parameters - back[1].parameters) / (2.0 * step)
    assert np.allclose(moved, inside.brute.response @ direction, rtol=1e-5, atol=1e-9)


def test_a_part_outside_the_class_is_in_the_demonstrations_and_in_no_feature(inside):
    outside = case(unexpressed=1.0).game
    assert np.array_equal(outside.expert_features, inside.case.game.expert_features)
    assert np.array_equal(
        outside.true_expert_reward().values, inside.case.game.true_expert_reward().values + outside.unexpressed
    )
    assert float(jnp.std(outside.unexpressed)) > 0.5
    assert not np.any(inside.case.game.unexpressed)
