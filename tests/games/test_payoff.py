import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.games.payoff import DensePayoff, MatchingPayoff
from gsiirl.types import Sides


def random_matching(seed: int, learner_actions: int, expert_actions: int, matches: int) -> MatchingPayoff:
    random = np.random.default_rng(seed)
    return MatchingPayoff(*(jnp.asarray(random.normal(size=n)) for n in (learner_actions, expert_actions, matches)))


@pytest.mark.parametrize("shape", [(4, 4, 4), (5, 4, 4), (4, 5, 4)])
def test_structured_answers_are_those_of_the_matrix(shape):
    payoff = random_matching(0, *shape)
    matrix = DensePayoff(payoff.dense())
    random = np.random.default_rng(1)
    p, q = jnp.asarray(random.dirichlet(np.ones(shape[0]))), jnp.asarray(random.dirichlet(np.ones(shape[1])))
    np.testing.assert_allclose(payoff.learner_values(q), matrix.learner_values(q), atol=1e-14)
    np.testing.assert_allclose(payoff.expert_values(p), matrix.expert_values(p), atol=1e-14)
    np.testing.assert_allclose(payoff.expected(p, q), matrix.expected(p, q), atol=1e-14)


def test_structured_linear_solve_satisfies_its_equations():
    shape = (5, 4, 4)
    learner, expert = random_matching(2, *shape), random_matching(3, *shape)
    random = np.random.default_rng(4)
    policies = Sides(jnp.asarray(random.dirichlet(np.ones(5))), jnp.asarray(random.dirichlet(np.ones(4))))
    right = Sides(jnp.asarray(random.normal(size=(2, 5))), jnp.asarray(random.normal(size=(2, 4))))
    rate = jnp.asarray(1.7)
    found = learner.solve_coupled(expert, policies, rate, right)
    # Only the diagonal part couples: the other terms are constant over a side's own actions.
    z_l, z_e = np.zeros((5, 4)), np.zeros((5, 4))
    np.fill_diagonal(z_l, learner.match)
    np.fill_diagonal(z_e, expert.match)
    u, v, p, q = map(np.asarray, (found.learner, found.expert, policies.learner, policies.expert))
    np.testing.assert_allclose(u - 1.7 * (v * q) @ z_l.T, right.learner, atol=1e-13)
    np.testing.assert_allclose(v - 1.7 * (u * p) @ z_e, right.expert, atol=1e-13)


def test_dense_linear_solve_satisfies_its_equations():
    random = np.random.default_rng(5)
    learner, expert = (DensePayoff(jnp.asarray(random.normal(size=(3, 4)))) for _ in range(2))
    policies = Sides(jnp.asarray(random.dirichlet(np.ones(3))), jnp.asarray(random.dirichlet(np.ones(4))))
    right = Sides(jnp.asarray(random.normal(size=(2, 3))), jnp.asarray(random.normal(size=(2, 4))))
    found = learner.solve_coupled(expert, policies, jnp.asarray(0.8), right)
    u, v, p, q = map(np.asarray, (found.learner, found.expert, policies.learner, policies.expert))
    np.testing.assert_allclose(u - 0.8 * (v * q) @ np.asarray(learner.values).T, right.learner, atol=1e-13)
    np.testing.assert_allclose(v - 0.8 * (u * p) @ np.asarray(expert.values), right.expert, atol=1e-13)
