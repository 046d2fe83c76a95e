import jax
import pytest

from gsiirl.equilibria.pathwise import policies_of
from gsiirl.experiments.continuous.judge import Judge
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.crossing.problem import build
from gsiirl.rewards.crossing import human_reward
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")


def judge_of(steps: int) -> Judge:
    config = CrossingConfig(
        horizon=6, hidden=8, batch=16, evaluation_episodes=32, training_steps=steps, judging_steps=steps
    ).resolved()
    return Judge(config, build(config))


@pytest.mark.slow
def test_a_best_response_goes_on_from_the_habit_that_is_worth_most():
    with jax.enable_x64(False):
        key = jax.random.key(0)
        judge, longer = judge_of(steps=4), judge_of(steps=100)
        untrained = policies_of(judge.true.trainer.init(key))
        trained = jax.jit(lambda: longer.true.best_response(untrained.learner, (), key))()
        habits = (trained, untrained.expert)
        found = jax.jit(lambda: judge.true.best_response(untrained.learner, habits, jax.random.key(1)))()

        def worth(policy):
            return float(judge.true.returns(judge.true.episodes(Sides(untrained.learner, policy))).expert)

        # Four steps from scratch do not come near; from the trained habit they lose next to nothing.
        assert worth(found) > worth(trained) - 0.1 * (worth(trained) - worth(untrained.expert))
        assert worth(trained) > worth(untrained.expert) + 0.2


def test_what_is_deployed_is_measured_on_the_deployed_pair_and_the_model_on_the_modelled_one():
    with jax.enable_x64(False):
        judge = judge_of(4)
        one, other = (policies_of(judge.true.trainer.init(jax.random.key(seed))) for seed in (0, 1))
        record, _, _ = jax.jit(judge.play)(one, other)
        for name, policies in (("model", one), ("deployed", other)):
            # Robot and human step by step from the same starts, and paid by their true rewards.
            episodes = judge.true.episodes(policies)
            for side, reward in (("learner", judge.true.rewards.learner), ("expert", human_reward)):
                paid = jax.vmap(jax.vmap(reward))(episodes)
                expected = float(paid.sum(axis=1).mean())
                assert float(record[f"{name}_return_{side}"]) == pytest.approx(expected, abs=1e-4)
        assert float(record["model_return_learner"]) != pytest.approx(
            float(record["deployed_return_learner"]), abs=1e-2
        )


@pytest.mark.slow
def test_a_random_learner_is_met_by_an_expert_that_has_answered_it():
    with jax.enable_x64(False):
        judge, key = judge_of(60), jax.random.key(3)
        record = jax.jit(judge.random)(key)
        untrained = policies_of(judge.true.trainer.init(key))
        unanswered = float(judge.true.returns(judge.true.episodes(untrained)).expert)
        assert float(record["random_return_expert"]) > unanswered + 0.1
