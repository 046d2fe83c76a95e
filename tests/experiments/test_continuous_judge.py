import jax
import pytest

from gsiirl.equilibria.pathwise import policies_of
from gsiirl.experiments.continuous_judge import Judge
from gsiirl.experiments.crossing import CrossingConfig
from gsiirl.experiments.crossing_problem import build
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")


def judge_of(steps: int) -> Judge:
    config = CrossingConfig(horizon=6, hidden=8, batch=16, evaluation_episodes=32, training_steps=steps).resolved()
    return Judge(config, build(config))


@pytest.mark.slow
def test_a_best_response_goes_on_from_the_habit_that_is_worth_most():
    with jax.enable_x64(False):
        key = jax.random.key(0)
        judge, untrained = judge_of(steps=4), policies_of(judge_of(4).trainer.init(key))
        trained = jax.jit(lambda: judge_of(100).best_response(untrained.learner, (), key))()
        habits = (trained, untrained.expert)
        found = jax.jit(lambda: judge.best_response(untrained.learner, habits, jax.random.key(1)))()

        def worth(policy):
            return float(judge.returns(judge.episodes(Sides(untrained.learner, policy))).expert)

        # Four steps from scratch do not come near; from the trained habit they lose next to nothing.
        assert worth(found) > worth(trained) - 0.1 * (worth(trained) - worth(untrained.expert))
        assert worth(trained) > worth(untrained.expert) + 0.2
