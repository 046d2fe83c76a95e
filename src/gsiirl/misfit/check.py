"""A check of the model of the expert against what it was seen to do.

First, could the model have produced this? For draws θ_k from the posterior, data are simulated in the states that were
visited (a posterior predictive check). Two measures of misfit are compared with their simulated values:

    G = 2 Σ_j Σ_(t,s,a_e) n ln(n / (n(t,s) π_e)),    X = Σ_(t,s,a_e) (Σ_j n − Σ_j n(t,s) π_e)² / Σ_j n(t,s) π_e(1 − π_e)

over interactions j; X sees what goes wrong in every interaction alike. The p-value is twice the smaller of the two.

Second, does another model (`gsiirl.misfit.models`) explain the same data better? Each is fitted anew, under the same
prior, and its gain is that of the largest log-posterior. The best one is named if it gains `CLEAR` nats, and one more
for each further parameter, and could itself have produced the data. Where a feature is missing, for instance, a chance
of lapses explains a part of what was seen and fits better, but not well.
"""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import polars
import scipy.optimize
from jaxtyping import Array, PRNGKeyArray

from gsiirl.compilation import QUICKLY
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.misfit.models import OTHERS, STANDARD, Model, Observed

CLEAR = 3.0
"""Nats by which another model must be more probable to be named.

Where the model in use is right, another one of as many parameters that is κ nats from it on average gains about
a normal draw of mean -κ and variance 2κ. It then gains 3 with a chance of at most 0.7 %, whatever κ is: the draw must
be (3 + κ)/√(2κ) ≥ √6 deviations above its mean.
"""
UNLIKELY = 0.01
"""p-value below which the model is said not to fit, though no other is known to fit better."""
SIMULATED = 200
AT_ONCE = 8
"""Interactions that are worked on at once."""
SOMETHING_ELSE = "something else"


class _Fit(NamedTuple):
    """A model at its most probable."""

    parameters: np.ndarray
    """(m + further parameters,), as `Model.log_policy` takes them."""
    log_posterior: float


@dataclass(frozen=True)
class ModelCheck:
    """What the check found.

    Attributes:
        p_value: how often data that the model itself makes fit it worse.
        gains: a row a model: `model`, `gain` (nats of log-posterior over the soft best response) and `named`.
        named: the model that fits clearly better; "something else" where none does and the p-value is below 0.01;
            None where nothing speaks against the soft best response.
        chances: what the named model adds: the chance of a lapse, or those of the best and the second-best action.
    """

    p_value: float
    gains: polars.DataFrame
    named: str | None
    chances: tuple[float, ...]

    def __repr__(self) -> str:
        return f"ModelCheck({str(self)!r})"

    def __str__(self) -> str:
        if self.named is None:
            return f"Nothing speaks against a soft best response (p = {self.p_value:.2g})."
        if self.named == SOMETHING_ELSE:
            return (
                f"The expert is no soft best response under these features (p = {self.p_value:.2g}), and none of the "
                "other models fits better: perhaps a feature is missing."
            )
        gain = self.gains.filter(polars.col("model") == self.named)["gain"][0]
        [words] = [model.words for model in OTHERS if model.name == self.named]
        return f"Another expert fits better by {gain:.1f} nats: {words.format(*self.chances)}."


def check_model(
    expert: ConditionalLikelihood,
    weights: np.ndarray,
    precision: float,
    draws: np.ndarray,
    seen: Observed,
    key: PRNGKeyArray,
) -> ModelCheck:
    """Check the model that `weights` (m,) are the estimate of.

    `weights` and the `draws` (K, m) from their posterior are in units of the temperature, `precision` is that of their
    prior, and `seen` holds the interactions in their order, along a first axis.
    """
    expert = jax.tree.map(jnp.asarray, expert)
    p_value = p_value_of(STANDARD, expert, draws, seen, key)
    standard = _fitted(STANDARD, expert, weights, precision, seen).log_posterior
    found = {model: _fitted(model, expert, weights, precision, seen) for model in OTHERS}
    gains = {model: each.log_posterior - standard for model, each in found.items()}
    clear = {model: gain for model, gain in gains.items() if gain >= CLEAR + len(model.further)}
    best = max(clear, key=lambda model: clear[model] - len(model.further), default=None)
    if best is not None and p_value_of(best, expert, found[best].parameters[None], seen, key) < UNLIKELY:
        best = None
    table = polars.DataFrame(
        {
            "model": [model.name for model in gains],
            "gain": list(gains.values()),
            "named": [model is best for model in gains],
        }
    )
    if best is None:
        return ModelCheck(p_value, table, SOMETHING_ELSE if p_value < UNLIKELY else None, ())
    return ModelCheck(p_value, table, best.name, best.chances(found[best].parameters[len(weights) :]))


def p_value_of(
    model: Model, expert: ConditionalLikelihood, draws: np.ndarray, seen: Observed, key: PRNGKeyArray
) -> float:
    """How often data that a model itself makes fit it worse than those that were seen.

    `draws` (K, m + further parameters) are from its posterior. A single one, the most probable, does as well: that it
    was fitted to what was seen makes the p-value larger.
    """
    chosen = np.linspace(0, len(draws) - 1, SIMULATED).round().astype(int)
    real, simulated = _discrepancies(model, expert, jnp.asarray(draws[chosen]), seen, key)
    shares = np.mean(np.asarray(simulated) >= np.asarray(real), axis=0)
    return float(min(1.0, 2.0 * shares.min()))


@partial(jax.jit, static_argnums=0, compiler_options=QUICKLY)
def _discrepancies(
    model: Model, expert: ConditionalLikelihood, draws: Array, seen: Observed, key: PRNGKeyArray
) -> tuple[Array, Array]:
    """G and X of what was seen and of what is simulated, (draws, 2) each."""
    visits, m = jnp.sum(seen.counts, axis=-1), expert.number_of_weights

    def of_counts(counts: Array, policies: Array) -> Array:
        expected = visits[..., None] * policies
        some = counts > 0
        deviance = 2.0 * jnp.sum(jnp.where(some, counts * jnp.log(jnp.where(some, counts / expected, 1.0)), 0.0))
        spread = jnp.sum(expected * (1.0 - policies), axis=0)
        square = jnp.sum(counts - expected, axis=0) ** 2
        # Cells where less than one choice in all can be expected to differ tell nothing but noise.
        return jnp.stack([deviance, jnp.sum(jnp.where(spread > 1.0, square / jnp.where(spread > 0, spread, 1.0), 0.0))])

    def of_draw(each: tuple[Array, Array]) -> tuple[Array, Array]:
        both, key = each
        policies = jnp.exp(
            jax.lax.map(lambda one: model.log_policy(expert, both[:m], both[m:], one), seen, batch_size=AT_ONCE)
        )
        made = jax.random.multinomial(key, visits, policies)
        return of_counts(seen.counts, policies), of_counts(made, policies)

    return jax.lax.map(of_draw, (draws, jax.random.split(key, len(draws))))


def _fitted(model: Model, expert: ConditionalLikelihood, weights: np.ndarray, precision: float, seen: Observed) -> _Fit:
    """The most probable parameters under a model."""
    size, m = jnp.asarray(np.linalg.norm(weights)), len(weights)
    sizes = model.sharper or (1.0,)
    both, lost = np.concatenate([np.asarray(weights, float), np.asarray(model.further)]), np.inf
    for sharper in sizes:

        def minus(both: np.ndarray, sharper: float = sharper) -> tuple[float, np.ndarray]:
            at = (jnp.asarray(both), jnp.asarray(precision), size, jnp.asarray(sharper))
            value, slope = _log_posterior(model, expert, *at, seen)
            return -float(value), -np.asarray(slope)

        found = scipy.optimize.minimize(minus, both, jac=True, method="L-BFGS-B", options={"maxiter": 300})
        both, lost = np.array(_sized(model, jnp.asarray(found.x), m, size)), float(found.fun)
    both[:m] *= sizes[-1]
    return _Fit(both, -lost)


def _sized(model: Model, both: Array, m: int, size: Array) -> Array:
    """The parameters, with weights of `size` where the model does not tell it."""
    if not model.sharper:
        return both
    # Nothing is added that counts; but at 0 a norm has no slope.
    length = jnp.sqrt(jnp.sum(both[:m] ** 2) + 1e-30)
    return jnp.concatenate([both[:m] * size / length, both[m:]])


@partial(jax.jit, static_argnums=0, compiler_options=QUICKLY)
def _log_posterior(
    model: Model,
    expert: ConditionalLikelihood,
    both: Array,
    precision: Array,
    size: Array,
    sharper: Array,
    seen: Observed,
) -> tuple[Array, Array]:
    m = expert.number_of_weights

    def of_one(each: Observed, both: Array) -> Array:
        return jnp.sum(each.counts * model.log_policy(expert, sharper * both[:m], both[m:], each))

    def value(both: Array) -> Array:
        both = _sized(model, both, m, size)
        likelihoods = jax.lax.map(lambda each: of_one(each, both), seen, batch_size=AT_ONCE)
        return jnp.sum(likelihoods) - 0.5 * precision * jnp.sum(both[:m] ** 2)

    return jax.value_and_grad(value)(both)
