"""The estimators of the hypergradient on a quadratic bilevel problem, whose answer is known in closed form."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key

from gsiirl.hypergradients import SPSA, AbstractEstimator, FiniteDifference, HessianVectorCG, Implicit, ResponseKind
from gsiirl.hypergradients.spsa import Factors
from gsiirl.runs.findings import Finding, Measurement, Panel
from gsiirl.theory.support.curves import curve, fitted_slope
from gsiirl.theory.support.quadratic import EXPERT_SIZE, LEARNER_SIZE, REGULARISATION, Quadratic

STEP = 1e-2
"""Central differences of a quadratic are exact at any step: a large one leaves the least rounding."""
FACTOR_DRAWS, FACTOR_SEED, REACH = 10_000, 0, 0.05
KEYS, COMPOSED_SEED = 64, 1
PRINTED_DRAWS, PRINTED_SEED = 2000, 2


@eqx.filter_jit
def _estimates(
    estimator: AbstractEstimator, quadratic: Quadratic, solution: Float[Array, " m"], keys: Key[Array, " keys"]
) -> Float[Array, "keys n"]:
    state, first, held = estimator.init(solution), jnp.asarray(0), quadratic.problem()
    point = jnp.asarray(quadratic.point)
    # One after the other: batched eigenvalues and loops take twice as long to compile.
    return jax.lax.map(lambda key: estimator.estimate(held, point, solution, state, key, first)[0].value, keys)


def errors(estimator: AbstractEstimator, quadratic: Quadratic, keys: Key[Array, " keys"]) -> Float[np.ndarray, " keys"]:
    """The relative error of an estimate of ∇f, for each key."""
    expected = quadratic.hypergradient(estimator.response)
    found = np.asarray(_estimates(estimator, quadratic, jnp.asarray(quadratic.solution[0]), keys))
    return np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected)


def estimators(response: ResponseKind) -> dict[str, AbstractEstimator]:
    """Those that are exact on a quadratic problem."""
    return {
        "Implicit": Implicit(response),
        "HessianVectorCG": HessianVectorCG(response, step=STEP, tolerance=1e-14),
        "FiniteDifference": FiniteDifference(response, step=STEP),
    }


def exact_errors(quadratics: list[Quadratic], response: ResponseKind) -> dict[str, float]:
    """The worst relative error of each exact estimator over the problems."""
    key = jax.random.key(0)[None]
    return {
        name: float(np.max([errors(estimator, each, key) for each in quadratics]))
        for name, estimator in estimators(response).items()
    }


@eqx.filter_jit
def _factors(quadratic: Quadratic, solution: Float[Array, " m"], key: Key[Array, ""], draws: int) -> Factors:
    return SPSA("measured", draws=draws).factors(
        quadratic.problem(), jnp.asarray(quadratic.point), solution, key, jnp.asarray(REACH)
    )


def factor_scores(quadratic: Quadratic, seed: int, draws: int) -> np.ndarray:
    """(mean − truth) / standard error of every distinct entry of SPSA's four factors over `draws` draws."""
    drawn = _factors(quadratic, jnp.asarray(quadratic.solution[0]), jax.random.key(seed), draws)
    learner, expert = quadratic.objective_gradients()
    distinct = np.triu_indices(EXPERT_SIZE)
    pairs = (
        (np.asarray(drawn.learner_gradient), learner),
        (np.asarray(drawn.expert_gradient), expert),
        (np.asarray(drawn.hessian)[:, distinct[0], distinct[1]], quadratic.likelihood_hessian[distinct]),
        (np.asarray(drawn.mixed).reshape(draws, -1), quadratic.mixed.ravel()),
    )
    return np.concatenate(
        [(samples.mean(axis=0) - truth) / (samples.std(axis=0, ddof=1) / np.sqrt(draws)) for samples, truth in pairs]
    )


def composed_errors(quadratic: Quadratic, draws: int, keys: int) -> np.ndarray:
    """The relative error of SPSA's `measured` hypergradient from `draws` draws, for each of `keys` keys."""
    return errors(
        SPSA("measured", perturbation=REACH, draws=draws),
        quadratic,
        jax.random.split(jax.random.key(COMPOSED_SEED), keys),
    )


def printed_hessians(quadratic: Quadratic, seed: int, draws: int) -> np.ndarray:
    """Eq. 4 as printed, `draws` times: row i is (∇_e L(e + pΔ) − ∇_e L(e − pΔ))ᵀ / 2pΔ_i with one Rademacher Δ."""
    directions = np.random.default_rng(seed).choice([-1.0, 1.0], size=(draws, EXPERT_SIZE))
    # The difference of two gradients of a quadratic function.
    change = 2.0 * REACH * directions @ quadratic.hessian
    return change[:, None, :] / (2.0 * REACH * directions[:, :, None])


def indefinite_fraction(matrices: np.ndarray) -> float:
    """The fraction whose symmetric part has eigenvalues of both signs, beyond rounding."""
    values = np.linalg.eigvalsh(0.5 * (matrices + np.swapaxes(matrices, 1, 2)))
    margin = 1e-10 * np.abs(values).max(axis=1)
    return float(np.mean((values[:, 0] < -margin) & (values[:, -1] > margin)))


def check(quick: bool) -> Finding:
    """Every estimator on quadratic problems."""
    numbers = range(3) if quick else range(20)
    draws = [1, 30, 1000] if quick else [1, 3, 10, 30, 100, 300, 1000, 3000, 10_000]
    inside, sphere = ([Quadratic.draw(seed, on_sphere) for seed in numbers] for on_sphere in (False, True))

    responses: tuple[ResponseKind, ...] = ("frozen", "measured")
    measurements = [
        Measurement(f"{name}, {response}, {where}: worst relative error", error, at_most=1e-10)
        for where, quadratics in (("inside the ball", inside), ("on the sphere", sphere))
        for response in responses
        for name, error in exact_errors(quadratics, response).items()
    ]
    differences = np.max([each.response_error(kind) for each in [*inside, *sphere] for kind in responses])
    scores = factor_scores(inside[0], FACTOR_SEED, FACTOR_DRAWS)
    composed = np.stack([composed_errors(inside[0], number, KEYS) for number in draws])
    mean, deviation = composed.mean(axis=1), composed.std(axis=1, ddof=1) / np.sqrt(KEYS)
    printed = printed_hessians(inside[0], PRINTED_SEED, PRINTED_DRAWS)
    measurements += [
        Measurement(
            "closed form of de*/dl against differences of the constrained solution: worst relative error",
            float(differences),
            at_most=1e-8,
        ),
        Measurement(
            f"SPSA, mean of {FACTOR_DRAWS} draws of every factor ({scores.size} entries): "
            "largest distance from the truth, in standard errors",
            float(np.abs(scores).max()),
            at_most=4.0,
        ),
        Measurement(
            "SPSA, composed hypergradient: slope of ln(error) over ln(draws)", fitted_slope(draws, mean), at_most=-0.3
        ),
        Measurement(f"SPSA, composed hypergradient: mean relative error at {draws[-1]} draws", float(mean[-1])),
        Measurement(
            f"eq. 4 as printed, {PRINTED_DRAWS} draws of the Hessian: fraction whose symmetric part is indefinite",
            indefinite_fraction(printed),
        ),
    ]
    guide_line = curve("slope -1/2", draws, mean[-1] * np.sqrt(draws[-1] / np.asarray(draws)), "guide")
    return Finding(
        key="quadratic",
        title="Estimators on a problem with a closed form",
        claim=(
            "On a quadratic bilevel problem Implicit, HessianVectorCG and FiniteDifference give the hypergradient to "
            "rounding, inside the unit ball and on its sphere, with the demonstrations held or moving; SPSA's factors "
            "are unbiased, and the hypergradient composed of them converges as draws are added."
        ),
        printed=(
            "Eq. 4 estimates the Hessian by one draw of a matrix of rank one that is not symmetric and hands it to "
            "conjugate gradients, which need a positive definite one."
        ),
        reading=(
            f"n = {LEARNER_SIZE}, m = {EXPERT_SIZE}, λ = {REGULARISATION:g}; {len(numbers)} problems of each kind. The "
            "closed form is numpy: the multiplier by bisection, the response from the differentiated optimality "
            "conditions. SPSA's seeds and numbers of draws were fixed beforehand. The figure gives the composed "
            f"hypergradient's relative error, mean over {KEYS} keys with its standard error as the band, beside a line "
            "of slope -1/2. The fall is steeper at first: the symmetrised Hessian of one draw has rank two at most, "
            "and λ alone then bounds what is divided by."
        ),
        measurements=measurements,
        panels=[
            Panel(
                "SPSA, all factors estimated",
                "draws",
                "relative error of the hypergradient",
                [replace(curve("SPSA", draws, mean), spread=deviation.tolist()), guide_line],
            )
        ],
    )
