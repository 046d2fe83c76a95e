"""Lemma 6: bias and variance of simultaneous perturbation against the perturbation p, for every factor of ∇f.

The bias is O(p²). With f and μ_e estimated from d sampled episodes, the variance of a difference is that of the
samples over 2p²: it grows as 1/p² unless both sides share their random numbers.
"""

from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key

from gsiirl.games.rollout import rollout
from gsiirl.hypergradients.problem import BilevelProblem
from gsiirl.hypergradients.spsa import SPSA, Factors
from gsiirl.irl.expectations import sampled_reward_gradient
from gsiirl.runs.findings import Finding, Measurement, Panel
from gsiirl.theory.support.curves import curve, extremes, fitted_slope, guide
from gsiirl.theory.support.games import DISCOUNT, SIZES, TEMPERATURE, RandomProblem, of_norm

SIZE = SIZES[0]
EPISODES = 50
BATCH = 20
"""Estimates made in one call."""
NORM = 0.7
"""‖θ_l‖ and ‖θ_e‖."""
NAMES = {
    "learner_gradient": "∇_{θ_l} f",
    "expert_gradient": "∇_{θ_e} f",
    "hessian": "H, likelihood part",
    "mixed": "M",
}
ITERATION = 100
"""The outer iteration at which schedules are compared."""


class Point(eqx.Module):
    """A random game with the (θ_l, θ_e) at which its factors are estimated."""

    game: RandomProblem
    learner: Float[Array, " n"]
    expert: Float[Array, " m"]

    @classmethod
    def draw(cls, seed: int) -> "Point":
        """Game `seed` of the first size, and a random point."""
        random = np.random.default_rng((seed, 6))
        learner, expert = (of_norm(random, NORM, each) for each in (SIZE.learner_parameters, SIZE.expert_parameters))
        return cls(RandomProblem.draw(seed, SIZE), learner, expert)


# --- exact evaluations -----------------------------------------------------------------------------------------------


def exact_problem(game: RandomProblem) -> BilevelProblem:
    """Both levels with exact expectations, the lower one as in the paper's line 6; differences do not see D."""
    nothing = jnp.zeros_like(game.true_parameters)
    return game.bilevel(0.0, "equilibrium").problem(nothing, nothing)


@jax.jit
def exact_factors(point: Point) -> Factors:
    """What SPSA estimates, by automatic differentiation; of H the symmetric part."""
    problem, size = exact_problem(point.game), point.learner.shape[0]
    objective, gradient = jax.jacfwd(lambda both: problem.evaluate(both[:size], both[size:]))(
        jnp.concatenate([point.learner, point.expert])
    )
    hessian = gradient[:, size:]
    return Factors(
        learner_gradient=objective[None, :size],
        expert_gradient=objective[None, size:],
        hessian=0.5 * (hessian + hessian.T)[None],
        mixed=gradient[None, :, :size],
        lower_gradient=jnp.zeros_like(point.expert),
    )


@jax.jit
def all_estimates(point: Point, reach: Float[Array, ""]) -> Factors:
    """SPSA's estimates for every vector of signs Δ, equally often each: their mean is the expectation, exactly.

    One draw of SPSA is made in coordinates whose signs are flipped in all ways: wherever it goes, every Δ occurs.
    """
    problem = exact_problem(point.game)
    signs = all_signs(point.learner.shape[0]), all_signs(point.expert.shape[0])
    number = max(len(each) for each in signs)

    def estimate(learner_sign: Array, expert_sign: Array) -> Factors:
        def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
            objective, gradient = problem.evaluate(learner_sign * learner, expert_sign * expert)
            return objective, expert_sign * gradient

        flipped = SPSA("frozen").factors(
            BilevelProblem(evaluate=evaluate, regularisation=0.0),
            learner_sign * point.learner,
            expert_sign * point.expert,
            jax.random.key(0),
            reach,
        )
        return Factors(
            learner_gradient=flipped.learner_gradient * learner_sign[None, :],
            expert_gradient=flipped.expert_gradient * expert_sign[None, :],
            hessian=flipped.hessian * jnp.outer(expert_sign, expert_sign)[None],
            mixed=flipped.mixed * jnp.outer(expert_sign, learner_sign)[None],
            lower_gradient=flipped.lower_gradient,
        )

    several = jax.vmap(estimate)(*(jnp.asarray(np.tile(each, (number // len(each), 1))) for each in signs))
    return jax.tree.map(lambda leaf: leaf[:, 0], several)


def all_signs(size: int) -> Float[np.ndarray, "k {size}"]:
    """All 2^size vectors of ±1."""
    bits = np.arange(2**size)[:, None] >> np.arange(size)[None, :]
    return 1.0 - 2.0 * (bits & 1)


# --- sampled evaluations ---------------------------------------------------------------------------------------------


@jax.jit
def sampled_estimates(
    point: Point, reach: Float[Array, ""], keys: Key[Array, " N"], common: Float[Array, ""]
) -> Factors:
    """One SPSA estimate a key from sampled episodes; `common` = 1 shares random numbers among all evaluations."""
    game = point.game
    bilevel, rewards = game.bilevel(0.0, "equilibrium"), game.accessed + game.own_reward

    def estimate(key: Array) -> Factors:
        direction_key, sample_key = jax.random.split(key)

        def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
            policies = bilevel.solve(learner, expert).policies
            # The same point is evaluated once only: numbers of its own make it independent of all other points.
            own_key = jax.random.fold_in(sample_key, jnp.where(common > 0.0, 0, point_number(learner, expert)))
            episodes = jax.vmap(lambda each: rollout(each, game.game, policies))(jax.random.split(own_key, EPISODES))
            weights = DISCOUNT ** jnp.arange(game.game.horizon, dtype=learner.dtype)
            met = rewards[episodes.states, episodes.actions.learner, episodes.actions.expert]
            features = sampled_reward_gradient(bilevel.expert_reward, episodes, DISCOUNT, learner.dtype)
            return jnp.mean(met @ weights), features / TEMPERATURE

        problem = BilevelProblem(evaluate=evaluate, regularisation=0.0)
        return SPSA("frozen").factors(problem, point.learner, point.expert, direction_key, reach)

    # A few at a time: with thousands of small linear systems in one call, XLA's thread pool on a CPU was seen to stall.
    return jax.tree.map(lambda leaf: leaf[:, 0], jax.lax.map(estimate, keys, batch_size=BATCH))


def point_number(learner: Float[Array, " n"], expert: Float[Array, " m"]) -> Array:
    """A number that two points share by accident only: their bits, mixed."""
    both = jnp.concatenate([learner, expert])
    bits = jax.lax.bitcast_convert_type(both, jnp.uint32).ravel()
    # Knuth's multiplicative hash, with another odd factor for each word; sums wrap around.
    factors = jnp.uint32(2654435761) * (2 * jnp.arange(bits.shape[0], dtype=jnp.uint32) + jnp.uint32(1))
    mixed = jnp.sum(bits * factors, dtype=jnp.uint32)
    return mixed ^ (mixed >> jnp.uint32(15))


# --- the check -------------------------------------------------------------------------------------------------------


def biases(point: Point, reaches: Sequence[float]) -> dict[str, Float[np.ndarray, " k"]]:
    """‖E[estimate] − exact‖ / ‖exact‖ of every factor, for each p."""
    exact = exact_factors(point)

    def bias(estimates: Factors, name: str) -> float:
        truth = np.asarray(getattr(exact, name))[0]
        return float(np.linalg.norm(getattr(estimates, name).mean(axis=0) - truth) / np.linalg.norm(truth))

    return _of_every_factor(lambda reach: all_estimates(point, reach), reaches, bias)


def variances(estimates: Callable[[Array], Factors], reaches: Sequence[float]) -> dict[str, Float[np.ndarray, " k"]]:
    """E‖estimate − E[estimate]‖² of every factor, for each p."""
    return _of_every_factor(estimates, reaches, lambda drawn, name: float(getattr(drawn, name).var(axis=0).sum()))


def _of_every_factor(
    estimates: Callable[[Array], Factors], reaches: Sequence[float], measured: Callable[[Factors, str], float]
) -> dict[str, Float[np.ndarray, " k"]]:
    drawn = [jax.tree.map(np.asarray, estimates(jnp.asarray(reach))) for reach in reaches]
    return {name: np.asarray([measured(each, name) for each in drawn]) for name in NAMES}


def check(quick: bool) -> Finding:
    """Bias by enumerating all Δ, variance by sampling."""
    points = [Point.draw(seed) for seed in range(2 if quick else 6)]
    for_bias = [0.01, 0.02, 0.04] if quick else [0.01, 0.014, 0.02, 0.028, 0.04]
    small = [0.002, 0.006, 0.02] if quick else [0.002, 0.0036, 0.0063, 0.011, 0.02]
    for_variance = [*small, 0.06, 0.2, 0.5]
    number = 40 if quick else 400
    keys = jax.random.split(jax.random.key(0), number)

    bias = [biases(point, [*for_bias, 0.2]) for point in points]
    slopes = {name: [fitted_slope(for_bias, each[name][: len(for_bias)]) for each in bias] for name in NAMES}

    point = points[0]

    def sampled(common: float) -> Callable[[Array], Factors]:
        return lambda reach: sampled_estimates(point, reach, keys, jnp.asarray(common))

    independent, shared = (variances(sampled(common), for_variance) for common in (0.0, 1.0))
    exact = variances(lambda reach: all_estimates(point, reach), for_variance)
    schedules = {
        "the paper's p = 1/(k + 1)": 1.0 / (ITERATION + 1.0),
        "p = 0.05/(k + 1)^0.101": 0.05 / (ITERATION + 1.0) ** 0.101,
    }
    size = float(jnp.linalg.norm(exact_factors(point).learner_gradient))
    noise = {
        (schedule, numbers): float(variances(sampled(common), [reach])["learner_gradient"][0] ** 0.5) / size
        for schedule, reach in schedules.items()
        for numbers, common in (("independent random", 0.0), ("common random", 1.0))
    }

    measurements = [
        *(
            each
            for name, values in slopes.items()
            for each in extremes(f"slope of the bias of {NAMES[name]}", values, "over games", 1.9, 2.1)
        ),
        *(
            Measurement(
                f"slope of the variance of {NAMES[name]} for p ≤ {small[-1]:g}, independent samples",
                fitted_slope(small, independent[name][: len(small)]),
                at_least=-2.3,
                at_most=-1.7,
            )
            for name in NAMES
        ),
        *(
            Measurement(
                f"slope of the variance of {NAMES[name]} for p ≤ {small[-1]:g}, common random numbers",
                fitted_slope(small, shared[name][: len(small)]),
            )
            for name in NAMES
        ),
        Measurement(
            f"variance of ∇_{{θ_l}} f with exact evaluations at p = {small[0]:g} over that at p = {small[-1]:g}",
            float(exact["learner_gradient"][0] / exact["learner_gradient"][len(small) - 1]),
            at_least=0.9,
            at_most=1.1,
        ),
        Measurement(
            f"variance of ∇_{{θ_l}} f at p = {small[0]:g}, independent over common random numbers",
            float(independent["learner_gradient"][0] / shared["learner_gradient"][0]),
        ),
        *(
            Measurement(
                f"standard deviation of ∇_{{θ_l}} f over its norm, k = {ITERATION}, {schedule}, {numbers} numbers",
                value,
            )
            for (schedule, numbers), value in noise.items()
        ),
        Measurement(
            "the same with exact evaluations: the direction alone",
            float(exact["learner_gradient"][0] ** 0.5) / size,
        ),
    ]
    return Finding(
        key="lemma-6",
        title="Simultaneous perturbation: bias and variance",
        claim=(
            "The bias of every factor of ∇f is O(p²). Where f and μ_e are estimated from sampled episodes, the "
            "variance grows as 1/p² with independent samples; with exact evaluations it does not depend on small p."
        ),
        printed="The paper takes p = 1/k and bounds the bias alone, as if every evaluation were exact.",
        reading=(
            f"Logit equilibrium, n = {SIZE.learner_parameters}, m = {SIZE.expert_parameters}. Bias: norm of the exact "
            "expectation, over all vectors of signs, less the derivative, relative to it; medians over "
            f"{len(points)} games. Variance: trace of the covariance of one estimate of ∇_{{θ_l}} f in one game, from "
            f"{number} estimates with {EPISODES} episodes an evaluation. With p = 1/k and independent samples the "
            "variance of iteration k grows as k² while the step, of size 1/√K throughout, does not fall: at k = "
            f"{ITERATION} the bias that a smaller p saves is far below the noise that it adds. Common random numbers "
            "gain about one power of p and not two, because an action changes by a jump, if seldom."
        ),
        measurements=measurements,
        panels=[
            _bias_panel([*for_bias, 0.2], bias),
            Panel(
                "Variance of the estimate of ∇_{θ_l} f",
                "perturbation p",
                "trace of the covariance",
                [
                    curve("independent samples", for_variance, independent["learner_gradient"]),
                    curve("common random numbers", for_variance, shared["learner_gradient"]),
                    curve("exact evaluations", for_variance, exact["learner_gradient"]),
                    guide("slope -2", for_variance, float(independent["learner_gradient"][0]), -2.0),
                ],
            ),
        ],
    )


def _bias_panel(reaches: list[float], bias: list[dict[str, Float[np.ndarray, " k"]]]) -> Panel:
    medians = {name: np.median([each[name] for each in bias], axis=0) for name in NAMES}
    curves = [curve(NAMES[name], reaches, values) for name, values in medians.items()]
    curves.append(guide("slope 2", reaches, float(medians["mixed"][0]), 2.0))
    return Panel("Bias of one estimate", "perturbation p", "relative bias", curves)
