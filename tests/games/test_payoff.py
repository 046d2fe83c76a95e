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
    assert payoff.number_of_actions == matrix.number_of_actions == shape[:2]
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


def test_expected_payoffs_of_many_states_are_those_of_each():
    random = np.random.default_rng(6)
    payoff = MatchingPayoff(*(jnp.asarray(random.normal(size=(3, n))) for n in (5, 4, 4)))
    p, q = (jnp.asarray(random.dirichlet(np.ones(n), size=3)) for n in (5, 4))
    expected = np.einsum("sl,se,sle->s", p, q, payoff.dense())
    np.testing.assert_allclose(payoff.expected(p, q), expected, atol=1e-14)


@pytest.mark.parametrize("form", ["matching", "dense"])
def test_the_sign_of_the_coupled_system_is_that_of_its_determinant(form):
    shape, random, seen = (5, 4, 4), np.random.default_rng(7), set()
    for _ in range(20):
        payoffs = [MatchingPayoff(*(jnp.asarray(random.normal(size=n)) for n in shape)) for _ in range(2)]
        rate = float(random.uniform(1.0, 20.0))
        p, q = random.dirichlet(np.ones(5)), random.dirichlet(np.ones(4))
        if form == "dense":
            payoffs = [DensePayoff(each.dense()) for each in payoffs]
            z_l, z_e = (np.asarray(each.values) for each in payoffs)
        else:
            z_l, z_e = np.zeros((5, 4)), np.zeros((5, 4))
            np.fill_diagonal(z_l, payoffs[0].match)
            np.fill_diagonal(z_e, payoffs[1].match)
        system = np.block([[np.eye(5), -rate * z_l * q], [-rate * z_e.T * p, np.eye(4)]])
        sign = np.sign(np.linalg.det(system))
        policies = Sides(jnp.asarray(p), jnp.asarray(q))
        assert float(payoffs[0].coupled_sign(payoffs[1], policies, jnp.asarray(rate))) == sign
        seen.add(sign)
    assert seen == {-1.0, 1.0}


def test_payoffs_are_added_multiplied_and_negated_entry_by_entry():
    one, other = random_matching(8, 5, 4, 4), random_matching(9, 5, 4, 4)
    table, another = np.asarray(one.dense()), np.asarray(other.dense())
    np.testing.assert_allclose((one + other).dense(), table + another, atol=1e-14)
    np.testing.assert_allclose((one * 3.0).dense(), 3.0 * table, atol=1e-14)
    np.testing.assert_allclose((-one).dense(), -table, atol=1e-14)
