"""A security problem small enough for tests to run whole."""

from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.problem import SecurityProblem, build


def tiny_config(**changes: object) -> SecurityConfig:
    """Four nodes, five edges, three steps, two seeds, two chunks of five iterations of five trajectories."""
    settings: dict[str, object] = {
        "nodes": 4,
        "edges": 5,
        "horizon": 3,
        "seeds": 2,
        "iterations": 10,
        "trajectories": 5,
        "inner_steps": 2,
        "remembered": 3,
    }
    return SecurityConfig(**(settings | changes))  # pyright: ignore[reportArgumentType] (checked by pydantic)


def tiny_problem(**changes: object) -> SecurityProblem:
    """The problem of `tiny_config`."""
    config = tiny_config(**changes).resolved()
    return build(config, config.network())
