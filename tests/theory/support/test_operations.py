import jax
import jax.numpy as jnp
import pytest

from gsiirl.theory.support.operations import Operations, count_operations


def total(function, *arguments, **settings) -> int:
    return count_operations(function, *arguments, **settings).total


def test_matrix_product_counts_multiply_adds():
    assert total(jnp.matmul, jnp.ones((2, 3)), jnp.ones((3, 5))) == 2 * 3 * 5
    batched = jax.vmap(jnp.matmul)
    assert total(batched, jnp.ones((4, 2, 3)), jnp.ones((4, 3, 5))) == 4 * 2 * 3 * 5


def test_elementwise_counts_outputs_and_reductions_count_inputs():
    assert total(jnp.sin, jnp.ones((4, 6))) == 24
    assert total(lambda x: jax.lax.reduce_sum_p.bind(x, axes=(1,), out_sharding=None), jnp.ones((4, 6))) == 24


def test_gather_and_scatter_count_the_elements_moved():
    table, rows = jnp.ones((100, 3)), jnp.arange(2)

    def gather(table):
        return jax.lax.dynamic_slice(table, (1, 0), (2, 3))

    def scatter(table):
        return table.at[rows].add(jnp.zeros((2, 3)), mode="promise_in_bounds")

    assert total(gather, table) == 6
    # A broadcast of the rows' numbers to (2, 1), another of zeros to (2, 3), and what is added.
    assert total(scatter, table) <= 6 + 6 + 10


def test_scan_counts_its_body_as_often_as_it_is_long():
    def once(x):
        return jnp.dot(x, x)

    def repeated(x):
        return jax.lax.scan(lambda carry, _: (jnp.dot(carry, carry), None), x, None, length=7)[0]

    square = jnp.ones((5, 5))
    assert total(once, square) == 125
    assert total(repeated, square) == 7 * 125


def test_nested_scans_multiply():
    def inner(x):
        return jax.lax.scan(lambda carry, _: (jnp.sin(carry), None), x, None, length=3)[0]

    def outer(x):
        return jax.lax.scan(lambda carry, _: (inner(jax.jit(jnp.cos)(carry)), None), x, None, length=4)[0]

    assert count_operations(outer, jnp.ones(10)) == Operations(total=4 * (10 + 3 * 10), while_loops=0, conditionals=0)


def test_while_loop_counts_its_body_as_often_as_told_and_is_reported():
    def halve(x):
        return jax.lax.while_loop(lambda x: x[0] > 1.0, jnp.sin, x)

    x = jnp.ones(6)
    once = count_operations(halve, x)
    assert once.while_loops == 1
    # The body's 6, and the condition's slice, squeeze and comparison.
    assert once.total == 6 + 3
    assert total(halve, x, trips=5) == 5 * once.total


def test_conditional_counts_its_cheapest_branch_and_is_reported():
    def choose(x):
        return jax.lax.cond(x[0, 0] > 0.0, lambda: x @ x, lambda: jnp.sin(x))

    cheapest = count_operations(choose, jnp.ones((5, 5)))
    assert cheapest.conditionals == 1
    assert 25 <= cheapest.total < 125


@pytest.mark.parametrize("right_hand_sides", [1, 2])
def test_linear_system_counts_its_factorisation_once(right_hand_sides):
    matrix, wanted = 2.0 * jnp.eye(8), jnp.ones((8, right_hand_sides))
    counted = total(jnp.linalg.solve, matrix, wanted)
    elimination = 8**3 + 2 * 8 * 8 * right_hand_sides
    assert elimination <= counted <= elimination + 400


def test_what_nobody_uses_does_not_count():
    def waste(x):
        return jax.lax.scan(lambda carry, _: ((jnp.sin(carry[0]), carry[1] @ carry[1]), None), (x, x), None, length=5)

    square = jnp.ones((3, 3))
    assert total(lambda x: waste(x)[0][0], square) == 5 * 9
    assert total(lambda x: waste(x)[0], square) == 5 * (9 + 27)
