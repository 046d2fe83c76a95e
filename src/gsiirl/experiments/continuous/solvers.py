"""The solvers of a continuous experiment, as its configuration asks for them."""

from dataclasses import replace

from gsiirl.equilibria.pathwise import Pathwise
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.problem import ContinuousProblem

TRAINED_RATE, FOLLOWING_RATE = 0.02, 0.1
"""What the rate of policies falls to, of the first: of who trains once, and of who follows others to the end."""


def solver_of(config: ContinuousConfig, problem: ContinuousProblem, steps: int, last_rate: float) -> Pathwise:
    """The forward model, whose rate falls to `last_rate` of the first over `steps` steps."""
    return Pathwise.create(
        problem.game,
        discount=config.discount,
        batch=config.batch,
        hidden=config.hidden,
        learning_rate=config.learning_rate,
        decay_steps=max(steps, 1),
        last_rate=last_rate,
        expert_steps=config.expert_steps,
        noise=config.noise,
    )


def responder_of(config: ContinuousConfig, problem: ContinuousProblem, steps: int, last_rate: float) -> Pathwise:
    """Likewise of who answers a policy alone: one step at a time, without a shaking hand."""
    return solver_of(replace(config, expert_steps=1, noise=0.0), problem, steps, last_rate)


def model_responder_of(config: ContinuousConfig, problem: ContinuousProblem) -> Pathwise:
    """Of the modelled expert, which answers what was played from what the real one was seen to do."""
    return replace(
        responder_of(
            replace(config, learning_rate=config.model_rate), problem, config.model_response_steps, FOLLOWING_RATE
        ),
        batch=min(config.compared, config.trajectories),
    )
