"""How many element operations a function takes, counted in its jaxpr: a cost that no machine's noise touches."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import jax
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn
from jax.interpreters.partial_eval import dce_jaxpr

FACTORISATIONS = {"cholesky", "eigh", "lu"}
INPUT_SIZED = {"argmax", "argmin"}


@dataclass(frozen=True)
class Operations:
    """Element operations of one call, and the loops and conditionals whose cost no jaxpr tells."""

    total: int
    while_loops: int
    conditionals: int


def count_operations(function: Callable[..., Any], *arguments: Any, trips: int = 1) -> Operations:
    """Element operations of `function(*arguments)`.

    A primitive counts its output elements; a matrix product its multiply-adds, a reduction its input elements, a
    gather or scatter the elements moved, a factorisation n³ of an n × n matrix. The body of a scan counts as often as
    the scan is long. A while loop runs until something is met, which the jaxpr does not tell: its body counts `trips`
    times. A conditional counts its cheapest branch. So the total is a lower bound wherever `while_loops` run longer
    than `trips`, or `conditionals` take another branch; without either it is exact. What nobody uses does not count:
    the compiler leaves it out.
    """
    whole = jax.make_jaxpr(function)(*arguments).jaxpr
    used, _ = dce_jaxpr(whole, [True] * len(whole.outvars))
    return _count(used, trips)


def _count(jaxpr: Jaxpr, trips: int) -> Operations:
    total = while_loops = conditionals = 0
    for equation in jaxpr.eqns:
        name = equation.primitive.name
        inner = [_count(each, trips) for each in _executed(equation)]
        while_loops += (name == "while") + sum(each.while_loops for each in inner)
        conditionals += (name == "cond") + sum(each.conditionals for each in inner)
        if not inner:
            total += _own(equation)
        elif name == "cond":
            total += min(each.total for each in inner)
        else:
            repeated = {"scan": equation.params.get("length", 1), "while": trips}.get(name, 1)
            total += repeated * sum(each.total for each in inner)
    return Operations(total, while_loops, conditionals)


def _executed(equation: JaxprEqn) -> Iterator[Jaxpr]:
    """The jaxprs that an equation runs."""
    name, parameters = equation.primitive.name, equation.params
    if name == "custom_linear_solve":
        # The others serve derivatives, or check the solution.
        yield parameters["jaxprs"].solve.jaxpr
    elif name == "cond":
        yield from (branch.jaxpr for branch in parameters["branches"])
    elif not name.startswith(("reduce", "scatter")):  # those carry the jaxpr of their own element operation
        for value in parameters.values():
            if isinstance(value, ClosedJaxpr):
                yield value.jaxpr
            elif isinstance(value, Jaxpr):
                yield value


def _own(equation: JaxprEqn) -> int:
    """Element operations of a primitive that runs no other jaxpr."""
    name = equation.primitive.name
    shapes = [_shape(each) for each in equation.invars]
    output = sum(math.prod(_shape(each)) for each in equation.outvars)
    if name == "dot_general":
        (contracted, _), _ = equation.params["dimension_numbers"]
        return output * math.prod(shapes[0][axis] for axis in contracted)
    if name.startswith("reduce") or name in INPUT_SIZED:
        return math.prod(shapes[0])
    if name.startswith("scatter"):
        return math.prod(shapes[2])
    if name == "dynamic_update_slice":
        return math.prod(shapes[1])
    if name in FACTORISATIONS:
        return math.prod(shapes[0]) * shapes[0][-1]
    if name == "triangular_solve":
        return output * shapes[0][-1]
    return output


def _shape(variable: Any) -> tuple[int, ...]:
    """() of what is no array, such as a token."""
    return tuple(getattr(variable.aval, "shape", ()))
