"""Theorem 1: what one hypergradient costs in the horizon T, in operations and in time."""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.hypergradients import SPSA, AbstractEstimator, BilevelProblem, HessianVectorCG, Implicit
from gsiirl.runs.findings import Curve, Finding, Measurement, Panel
from gsiirl.theory.support.direct import Direct
from gsiirl.theory.support.games import RandomProblem, Size
from gsiirl.theory.support.operations import Operations, count_operations
from gsiirl.theory.support.peak_memory import HORIZON, attack_graph_bilevel
from gsiirl.theory.support.printed_forms import printed_problem
from gsiirl.theory.support.slopes import fitted_slope, guide
from gsiirl.theory.support.soft_joint_model import SoftJointModel

REGULARISATION = 0.1
PRINTED_DIRECT, PRINTED_SPSA = "direct form as printed", "SPSA as printed"
IMPLICIT, PRODUCTS, PERTURBED, DIRECT = "Implicit", "HessianVectorCG", "SPSA", "direct form, corrected"
ESTIMATORS: dict[str, AbstractEstimator[Any]] = {
    PRINTED_DIRECT: Direct("frozen"),
    PRINTED_SPSA: SPSA("frozen"),
    IMPLICIT: Implicit("frozen"),
    PRODUCTS: HessianVectorCG("frozen"),
    PERTURBED: SPSA("frozen"),
    DIRECT: Direct("frozen"),
}
PAPER = (PRINTED_DIRECT, PRINTED_SPSA)
BOUNDED = (IMPLICIT, PRODUCTS, PERTURBED)
LONG = 64
"""Exponents are fitted over horizons from here on: below, fixed costs show in times."""
BATCH, ROUNDS, PATIENCE = 0.1, 5, 5.0
"""A program is timed ROUNDS times over about BATCH seconds of calls, and no more once that took PATIENCE seconds."""

Program = jax.stages.Wrapped


def small_game(horizon: int) -> SoftJointModel:
    """The paper's own model on a random game of 4 states and 2 by 2 actions, the same for every horizon."""
    size = Size(4, 2, 2, horizon, learner_parameters=4, expert_parameters=3)
    return SoftJointModel(RandomProblem.draw(0, size), REGULARISATION)


def small_point() -> tuple[Float[Array, "4"], Float[Array, "3"]]:
    """(θ_l, θ_e), inside the unit ball."""
    return jnp.asarray([0.4, -0.2, 0.3, 0.1]), jnp.asarray([0.3, 0.2, -0.4])


def small_program(name: str, horizon: int) -> Program:
    """∇f on the small game by the estimator of that name; the demonstrations D(θ_l) are computed in the same call."""
    model = small_game(horizon)

    def program(learner_parameters: Array, expert_parameters: Array) -> Array:
        if name in PAPER:
            problem = printed_problem(model, model.demonstrations(learner_parameters))
        else:
            problem = model.problem(learner_parameters, expert_parameters)
        return hypergradient(problem, ESTIMATORS[name], learner_parameters, expert_parameters)

    return jax.jit(program)


def large_program(name: str, horizon: int) -> tuple[Program, tuple[Array, Array]]:
    """∇f on the attack graph by the estimator of that name, and (θ_l, θ_e)."""
    bilevel, point = attack_graph_bilevel(horizon)
    problem = bilevel.problem(point.expert, jnp.zeros_like(point.expert))
    return jax.jit(lambda *parameters: hypergradient(problem, ESTIMATORS[name], *parameters)), (
        point.learner,
        point.expert,
    )


def hypergradient(
    problem: BilevelProblem,
    estimator: AbstractEstimator[Any],
    learner_parameters: Float[Array, " n"],
    expert_parameters: Float[Array, " m"],
) -> Float[Array, " n"]:
    """∇f in the first iteration."""
    state, key = estimator.init(expert_parameters), jax.random.key(0)
    return estimator.estimate(problem, learner_parameters, expert_parameters, state, key, jnp.asarray(0))[0].value


def operations(program: Program) -> Operations:
    """Of one call on the small game, with 2m steps of conjugate gradients: no estimator takes more there."""
    learner_parameters, expert_parameters = small_point()
    return count_operations(program, learner_parameters, expert_parameters, trips=2 * expert_parameters.size)


def check(quick: bool) -> Finding:
    """Operations and times against T on the small game, times on an attack graph, and the peak of memory there."""
    # Processor seconds are the cost only where the processor does the work.
    with jax.default_device(jax.devices("cpu")[0]):
        return _measured(quick)


def _measured(quick: bool) -> Finding:
    # It compiles in a process of its own meanwhile; nothing is timed before it has ended.
    memory = start_peak_memory()
    try:
        horizons = [8, 32, 128, 512] if quick else [8, 16, 32, 64, 128, 256, 512]
        programs = {(name, horizon): small_program(name, horizon) for name in ESTIMATORS for horizon in horizons}
        counts = _by_name({key: float(operations(program).total) for key, program in programs.items()})
        compiled = {key: _compiled(programs[key], small_point()) for key in programs if _is_timed(*key, quick)}
        peak, before = finish_peak_memory(memory)
    finally:
        memory.kill()
    times = _by_name(median_times(compiled))
    large: dict[str, dict[int, float]] = {}
    if not quick:
        sought = [(name, horizon) for name in BOUNDED for horizon in (64, 128, 256, 512)]
        large = _by_name(median_times({key: _compiled(*large_program(*key)) for key in sought}))
    return _finding(counts, times, large, peak, before)


def _is_timed(name: str, horizon: int, quick: bool) -> bool:
    """Quick calls leave out what takes seconds, what shows only fixed costs, and what nothing is compared with."""
    if not quick:
        return True
    if name == PRINTED_DIRECT:
        return horizon in (32, 128)
    return horizon >= LONG and name != DIRECT


def _compiled(program: Program, point: tuple[Array, Array]) -> Callable[[], object]:
    executable = program.lower(*point).compile()
    return lambda: jax.block_until_ready(executable(*point))


def _by_name(costs: dict[tuple[str, int], float]) -> dict[str, dict[int, float]]:
    names = dict.fromkeys(name for name, _ in costs)
    return {name: {horizon: cost for (each, horizon), cost in costs.items() if each == name} for name in names}


def median_times(programs: dict[tuple[str, int], Callable[[], object]]) -> dict[tuple[str, int], float]:
    """Processor seconds of one call of each program, of all threads: the median of several batches, taken in turns.

    Elapsed time would not do on a busy machine: calls longer than a slice of the scheduler are interrupted every time,
    shorter ones are not, and that looks like growth with T. Nor would single calls: the clock of a process hears of its
    other threads late, by about a millisecond.
    """
    calls = {}
    for key, run in programs.items():
        began = time.perf_counter()
        run()
        calls[key] = math.ceil(BATCH / (time.perf_counter() - began))
    seconds: dict[tuple[str, int], list[float]] = {key: [] for key in programs}
    for _ in range(ROUNDS):
        for key, run in programs.items():
            if calls[key] * sum(seconds[key]) < PATIENCE:
                began = time.process_time()
                for _ in range(calls[key]):
                    run()
                seconds[key].append((time.process_time() - began) / calls[key])
    return {key: float(np.median(each)) for key, each in seconds.items()}


def exponent(costs: dict[int, float]) -> float:
    """Slope of ln cost against ln T over the horizons of `fitted`."""
    horizons = fitted(costs)
    return fitted_slope(horizons, [costs[horizon] for horizon in horizons])


def fitted(costs: dict[int, float]) -> list[int]:
    """The horizons from LONG on, or the two longest where fewer are so long."""
    horizons = sorted(costs)
    long = [horizon for horizon in horizons if horizon >= LONG]
    return long if len(long) > 1 else horizons[-2:]


def start_peak_memory() -> "subprocess.Popen[str]":
    """Begin to measure the peak of memory, in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "gsiirl.theory.support.peak_memory"],
        stdout=subprocess.PIPE,
        text=True,
        # Memory of the machine, not of a device.
        env=os.environ | {"JAX_PLATFORMS": "cpu"},
    )


def finish_peak_memory(process: "subprocess.Popen[str]") -> tuple[float, float]:
    """The peak of the whole process and the peak before the hypergradient was called, in GiB.

    Raises:
        RuntimeError: the process failed, or found no finite hypergradient.
    """
    answer, _ = process.communicate()
    if process.returncode != 0:
        raise RuntimeError(f"gsiirl.theory.support.peak_memory ended with status {process.returncode}")
    found = json.loads(answer)
    if not found["finite"]:
        raise RuntimeError("the hypergradient on 256 states is not finite")
    return found["after"] / 2**30, found["before"] / 2**30


def _finding(
    counts: dict[str, dict[int, float]],
    times: dict[str, dict[int, float]],
    large: dict[str, dict[int, float]],
    peak: float,
    before: float,
) -> Finding:
    longest, compared = max(counts[IMPLICIT]), max(times[PRINTED_DIRECT])
    measurements = [
        Measurement(
            f"{what}, {name}: exponent of T, from T = {fitted(of_name)[0]} to {fitted(of_name)[-1]}",
            exponent(of_name),
            at_most=1.1 if name in BOUNDED else None,
        )
        for what, costs in (("operations", counts), ("time", times), ("time on 256 states", large))
        for name, of_name in costs.items()
    ]
    measurements += [
        Measurement(
            f"operations at T = {longest}: direct form as printed, over Implicit",
            counts[PRINTED_DIRECT][longest] / counts[IMPLICIT][longest],
            at_least=10.0,
        ),
        Measurement(
            f"time at T = {compared}: direct form as printed, over Implicit",
            times[PRINTED_DIRECT][compared] / times[IMPLICIT][compared],
            at_least=10.0,
        ),
        Measurement(
            f"peak memory of Implicit at T = {HORIZON} on 256 states, Python and JAX included",
            peak,
            at_most=2.0,
            unit="GiB",
        ),
        Measurement("of which above the peak of loading and compiling", peak - before, unit="GiB"),
    ]
    panels = [
        _panel("Operations, 4 states", "operations", counts, guides=(1, 2, 3)),
        _panel("Time, 4 states", "processor seconds", times, guides=(1, 2, 3)),
    ]
    if large:
        panels.append(_panel("Time, 256 states", "processor seconds", large, guides=(1,)))
    return Finding(
        key="theorem-1",
        title="Cost of one hypergradient in the horizon",
        claim=(
            "Every factor of the hypergradient comes from a fixed number of sweeps over the horizon: one hypergradient "
            "costs O(T), exactly and by SPSA alike."
        ),
        printed=(
            "O(T³) directly and O(T²) with SPSA. Those are the costs of computing state frequencies afresh for every "
            "later step (T²), and that inside a sum over steps (T³), as appendix A.9 does; no factor asks for it."
        ),
        reading=_reading(counts, times, compared),
        measurements=measurements,
        panels=panels,
    )


def _reading(counts: dict[str, dict[int, float]], times: dict[str, dict[int, float]], compared: int) -> str:
    longest = max(counts[IMPLICIT])
    more = counts[PRINTED_DIRECT][longest] / counts[IMPLICIT][longest]
    longer = times[PRINTED_DIRECT][compared] / times[IMPLICIT][compared]
    return (
        "Each curve is the cost of one hypergradient; all but SPSA give the same numbers. Operations are counted, not "
        "timed: elements written, and multiply-adds of products, with conjugate gradients charged twice as many steps "
        "as r_e has parameters, which is no fewer than they take. The forms as printed are given the advantage that "
        "one walk serves every factor and all starting times are walked side by side. "
        f"At T = {longest} the direct form as printed takes {more:.0f} times the operations of Implicit, and at "
        f"T = {compared} it takes {longer:.0f} times the time. Times are processor seconds, which other programs on "
        "the machine disturb little. The slopes in the legends are fitted to all points; the exponents in the table "
        f"are fitted to T ≥ {LONG} where that leaves two points, since for shorter horizons a fixed cost per call "
        "hides the growth."
    )


def _panel(title: str, label: str, costs: dict[str, dict[int, float]], guides: Sequence[int]) -> Panel:
    curves = [
        Curve(
            name, [float(each) for each in of_name], list(of_name.values()), role="paper" if name in PAPER else "ours"
        )
        for name, of_name in costs.items()
    ]
    horizons = sorted({horizon for of_name in costs.values() for horizon in of_name})
    lowest = 0.5 * min(min(of_name.values()) for of_name in costs.values())
    curves += [guide(f"slope {slope}", horizons, lowest, slope) for slope in guides]
    return Panel(title, "horizon T", label, curves)
