"""Theorem 1: what one hypergradient costs in the horizon T, in operations and in time."""

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.equilibria.logit import Logit
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.hypergradients import SPSA, AbstractEstimator, BilevelProblem, HessianVectorCG, Implicit
from gsiirl.learners.bilevel import Bilevel
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.runs.findings import Finding, Measurement, Panel
from gsiirl.scenarios import random_network
from gsiirl.theory.support.curves import curve, fitted_slope, guide
from gsiirl.theory.support.direct import Direct
from gsiirl.theory.support.games import RandomProblem, Size, of_norm
from gsiirl.theory.support.operations import Operations, count_operations
from gsiirl.theory.support.printed_forms import printed_problem
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
NODES, EDGES = 8, 10
"""Of the attack graph."""
LONG, LONGEST = 64, 512
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


def attack_graph_bilevel(horizon: int) -> tuple[Bilevel, tuple[Float[Array, " n"], Float[Array, " m"]]]:
    """Both levels on a random attack graph with all of its 256 states, as a run has them, and a point (θ_l, θ_e)."""
    network = random_network(0, NODES, EDGES, "general_sum")
    game = AttackGraph.create(network, horizon, starts=range(2**NODES))
    commitment, attack = rewards.commitment_features(game), rewards.attack_features(game)
    scale = 1.5 * len(attack.names) ** 0.5
    bilevel = Bilevel(
        game=game,
        own_reward=rewards.own_reward(game, network),
        accessed=commitment.payoff(jnp.asarray(rewards.dependent_weights(network))),
        dependent_reward=Linear(commitment, scale),
        expert_reward=Linear(attack, scale),
        forward_model=Logit(0.4),
        temperature=0.4,
        discount=0.95,
    )
    random = np.random.default_rng(0)
    return bilevel, (of_norm(random, 0.5, len(commitment.names)), of_norm(random, 0.5, len(attack.names)))


def large_program(name: str, horizon: int) -> tuple[Program, tuple[Array, Array]]:
    """∇f on the attack graph by the estimator of that name, and (θ_l, θ_e)."""
    bilevel, point = attack_graph_bilevel(horizon)
    problem = bilevel.problem(point[1], jnp.zeros_like(point[1]))
    return jax.jit(lambda *parameters: hypergradient(problem, ESTIMATORS[name], *parameters)), point


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
    """Operations and times against T on the small game, times on an attack graph, and the memory taken there."""
    # Processor seconds are the cost only where the processor does the work.
    with jax.default_device(jax.devices("cpu")[0]):
        return _measured(quick)


def _measured(quick: bool) -> Finding:
    horizons = [8, 32, 128, LONGEST] if quick else [8, 16, 32, 64, 128, 256, LONGEST]
    programs = {(name, horizon): small_program(name, horizon) for name in ESTIMATORS for horizon in horizons}
    counts = _by_name({key: float(operations(program).total) for key, program in programs.items()})
    compiled = {key: programs[key].lower(*small_point()).compile() for key in programs if _is_timed(*key, quick)}
    times = _by_name(median_times({key: _call(each, small_point()) for key, each in compiled.items()}))
    sought = [(name, horizon) for name in BOUNDED for horizon in ((64, 128, 256, LONGEST) if not quick else ())]
    weighed = IMPLICIT, LONGEST
    written = {key: large_program(*key) for key in {*sought, weighed}}
    executables = {key: program.lower(*point).compile() for key, (program, point) in written.items()}
    calls = {key: _call(each, written[key][1]) for key, each in executables.items()}
    if not jnp.all(jnp.isfinite(calls[weighed]())):
        raise RuntimeError("the hypergradient on 256 states is not finite")
    large = _by_name(median_times({key: calls[key] for key in sought}))
    return _finding(counts, times, large, gibibytes(executables[weighed]))


def gibibytes(compiled: jax.stages.Compiled) -> float:
    """The memory that a compiled program takes: for its arguments, its results, and what it holds meanwhile."""
    memory = compiled.memory_analysis()
    assert memory is not None, "the compiler says nothing of memory"
    held = memory.argument_size_in_bytes + memory.output_size_in_bytes + memory.temp_size_in_bytes
    return held / 2**30


def _is_timed(name: str, horizon: int, quick: bool) -> bool:
    """Quick calls leave out what takes seconds, what shows only fixed costs, and what nothing is compared with."""
    if not quick:
        return True
    if name == PRINTED_DIRECT:
        return horizon in (32, 128)
    return horizon >= LONG and name != DIRECT


def _call(compiled: jax.stages.Compiled, point: tuple[Array, Array]) -> Callable[[], Array]:
    return lambda: jax.block_until_ready(compiled(*point))


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


def _finding(
    counts: dict[str, dict[int, float]],
    times: dict[str, dict[int, float]],
    large: dict[str, dict[int, float]],
    memory: float,
) -> Finding:
    longest, compared = max(counts[IMPLICIT]), max(times[PRINTED_DIRECT])
    more = counts[PRINTED_DIRECT][longest] / counts[IMPLICIT][longest]
    longer = times[PRINTED_DIRECT][compared] / times[IMPLICIT][compared]
    measurements = [
        Measurement(
            f"{what}, {name}: exponent of T, from T = {fitted(of_name)[0]} to {fitted(of_name)[-1]}",
            exponent(of_name),
            at_most=1.1 if name in BOUNDED else None,
        )
        for what, costs in (("operations", counts), ("time", times), ("time on 256 states", large))
        for name, of_name in costs.items()
    ]
    program = f"memory that Implicit's compiled program takes at T = {LONGEST} on 256 states"
    measurements += [
        Measurement(f"operations at T = {longest}: direct form as printed, over Implicit", more, at_least=10.0),
        Measurement(f"time at T = {compared}: direct form as printed, over Implicit", longer, at_least=10.0),
        Measurement(program, memory, at_most=2.0, unit="GiB"),
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
        reading=(
            "Each curve is the cost of one hypergradient; all but SPSA give the same numbers. Operations are counted, "
            "not timed: elements written, and multiply-adds of products, with conjugate gradients charged twice as "
            "many steps as r_e has parameters, which is no fewer than they take. The forms as printed are given the "
            "advantage that one walk serves every factor and all starting times are walked side by side. "
            f"At T = {longest} the direct form as printed takes {more:.0f} times the operations of Implicit, and at "
            f"T = {compared} it takes {longer:.0f} times the time. Times are processor seconds, which other programs "
            "on the machine disturb little. The slopes in the legends are fitted to all points; the exponents in the "
            f"table are fitted to T ≥ {LONG} where that leaves two points, since for shorter horizons a fixed cost per "
            "call hides the growth."
        ),
        measurements=measurements,
        panels=panels,
    )


def _panel(title: str, label: str, costs: dict[str, dict[int, float]], guides: Sequence[int]) -> Panel:
    curves = [
        curve(name, [*of_name], [*of_name.values()], "paper" if name in PAPER else "ours")
        for name, of_name in costs.items()
    ]
    horizons = sorted({horizon for of_name in costs.values() for horizon in of_name})
    lowest = 0.5 * min(min(of_name.values()) for of_name in costs.values())
    curves += [guide(f"slope {slope}", horizons, lowest, slope) for slope in guides]
    return Panel(title, "horizon T", label, curves)
