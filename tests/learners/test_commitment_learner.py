"""What the learner of a finite game plays while it learns."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from commitment_oracle import Batch, Floats, response
from small_games import HORIZON, JOINT, expected_counts, finite_game, problem_of

from gsiirl import GSIIRL

GAME = finite_game()


def nats(policy: Floats, weights: Floats, others: Floats) -> float:
    """How far two experts' answers to a policy are apart in an episode, where the first one lives."""
    first, second = (replace(GAME, expert=each.reshape(JOINT) * GAME.temperature) for each in (weights, others))
    counts = expected_counts(first, policy)
    seen = counts > 0
    apart = np.log(response(first, policy)[seen]) - np.log(response(second, policy)[seen])
    return float((counts[seen] * apart).sum())


def test_what_is_played_to_learn_tells_the_draw_from_the_estimate_best() -> None:
    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME)).learner(4))
    random = np.random.default_rng(0)
    estimate, draw = random.normal(size=(2, GAME.expert.size))
    policies = Batch(GAME).tidy(random.gamma(0.5, size=(3, HORIZON, *JOINT[:2])) + 1e-6)
    chosen = eqx.filter_jit(lambda *given: learner.commitment.policy(learner._telling(*given)))(
        jnp.log(policies), jnp.asarray([estimate, draw]), jax.random.key(0)
    )
    told = nats(np.asarray(chosen), draw, estimate)
    pure = Batch(GAME).tidy(np.broadcast_to(np.eye(JOINT[1])[:, None, None], (JOINT[1], HORIZON, *JOINT[:2])) + 1e-13)
    assert told >= max(nats(policy, draw, estimate) for policy in (*policies, *pure)) - 1e-9


def test_the_first_half_of_the_iterations_is_for_learning_alone() -> None:
    assert GSIIRL(problem_of(GAME)).learner(9).informative_rounds == 4
