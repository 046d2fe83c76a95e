"""What is known of the expert's reward: the most probable weights, and how far the data leave them open.

The log-posterior of the weights θ (in units of the temperature) is

    Φ(θ) = ℓ(θ) − (α/2)‖θ‖²,

with the conditional likelihood ℓ and a Gaussian prior of standard deviation 1/√α for each weight. Where no `prior` is
given, α is chosen by the evidence (MacKay 1992): α = (g + ½) / (‖θ‖² + ½·3²), where g = m − α tr H⁻¹ weights are
determined by the data, H = F + αI, and half a weight of deviation 3 stands for what is known before.

`fit` finds the maximum by Levenberg's method, `draws` takes Gaussian draws N(θ̂, H⁻¹) with importance weights, and
`hamiltonian` draws from exp Φ itself by Hamiltonian Monte Carlo.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.memory import Memory
from gsiirl.limits import DENSE
from gsiirl.types import AnyArray

MOST_STEPS = 60
"""Levenberg's steps of one fit; what has not converged then goes on in the next iteration, and says so."""
RENEWED = 8
"""Where the Fisher information is costly, it is computed anew in one of so many iterations, and steps of a fit."""
FIRST_DEVIATION = 3.0
"""Standard deviation of the prior before anything was seen, in units of the temperature."""
PRIOR_WEIGHT = 0.5
"""As if so many more weights had been seen, of the deviation that is taken before anything was seen."""
DEVIATIONS = (0.05, 2000.0)
"""What the evidence may choose for it."""
SOLVER_STEPS = 100
"""Steps of conjugate gradients of one solve."""
OVERSAMPLED = 4
"""Weighted draws for each one that counts alike."""
CHAIN_STEPS = 100
"""Steps of a chain of Hamiltonian Monte Carlo, half of them to fit its step size."""


class Posterior(eqx.Module):
    """θ̂ (m,) with the Gaussian around it; in units of the temperature.

    `precision` H is None where there are more weights than `DENSE`. `decrement` is √(∇Φ' H⁻¹ ∇Φ), the distance from the
    maximum in standard deviations; `steps` counts Levenberg's steps of the last fit.
    """

    mean: Float[Array, " m"]
    prior_precision: Float[Array, ""]
    log_density: Float[Array, ""]
    precision: Float[Array, "m m"] | None
    decrement: Float[Array, ""]
    converged: Bool[Array, ""]
    steps: Int[Array, ""]


class Draws(eqx.Module):
    """Draws (K, m) from the posterior, with weights (K,) that sum to 1 and what these are worth in equal draws."""

    values: Float[Array, "K m"]
    weights: Float[Array, " K"]
    effective: Float[Array, ""]


class Derivatives(eqx.Module):
    """ℓ with its gradient and the Fisher information at one θ."""

    value: Float[Array, ""]
    gradient: Float[Array, " m"]
    fisher: Float[Array, "m m"]


class Inference(eqx.Module):
    """How the posterior is found; `prior_deviation` is in units of the temperature, None for the evidence's choice."""

    likelihood: ConditionalLikelihood
    prior_deviation: Float[AnyArray, ""] | None = None
    tolerance: float = eqx.field(static=True, default=1e-3)

    @property
    def dense(self) -> bool:
        """Whether H is held as a matrix."""
        return self.likelihood.number_of_weights <= DENSE

    def start(self, dtype: jnp.dtype) -> Posterior:
        """The prior."""
        m = self.likelihood.number_of_weights
        deviation = FIRST_DEVIATION if self.prior_deviation is None else self.prior_deviation
        precision = jnp.asarray(deviation, dtype) ** -2
        zero = jnp.zeros((), dtype)
        return Posterior(
            mean=jnp.zeros(m, dtype),
            prior_precision=precision,
            log_density=zero,
            precision=precision * jnp.eye(m, dtype=dtype) if self.dense else None,
            decrement=zero,
            converged=jnp.asarray(True),
            steps=jnp.zeros((), jnp.int32),
        )

    def fit(self, before: Posterior, memory: Memory[Seen], key: PRNGKeyArray) -> Posterior:
        """The posterior of what is remembered, from where the last fit ended."""
        if self.dense:
            return self._fit_dense(before, memory)
        return self._fit_matrix_free(before, memory, key)

    def _fit_dense(self, before: Posterior, memory: Memory[Seen]) -> Posterior:
        """Levenberg's method. Where F is costly an old one is taken on, with that of the newest interaction added."""
        assert before.precision is not None, "a fit with matrices goes on from one with matrices"
        m, dtype = before.mean.shape[0], before.mean.dtype
        identity = jnp.eye(m, dtype=dtype)
        costly, held = self.likelihood.costly, memory.held

        def derivatives(theta: Array, fisher: Array, newest: Array) -> Derivatives:
            """ℓ and ∇ℓ at θ, and F of the `newest` interactions there: alone where these are all, else added."""
            value, gradient = self.likelihood.value_and_gradient(theta, memory)
            added = self.likelihood.fisher(theta, memory, newest)
            return Derivatives(value, gradient, jnp.where(newest >= held, added, fisher + added))

        def objective(theta: Array, value: Array, alpha: Array) -> Array:
            return value - 0.5 * alpha * jnp.sum(theta**2)

        def measured(theta: Array, at: Derivatives, alpha: Array) -> tuple[Array, Array]:
            """The decrement, and the α that the evidence prefers here."""
            factor = jax.scipy.linalg.cho_factor(at.fisher + alpha * identity)
            gradient = at.gradient - alpha * theta
            decrement = jnp.sqrt(jnp.vdot(gradient, jax.scipy.linalg.cho_solve(factor, gradient)))
            determined = m - alpha * jnp.trace(jax.scipy.linalg.cho_solve(factor, identity))
            return decrement, self._evidence(alpha, determined, theta)

        def unfinished(carry) -> Array:
            _, _, alpha, damping, decrement, better, step = carry
            settled = (decrement <= self.tolerance) & (jnp.abs(better / alpha - 1.0) < 0.01)
            return (step < 0) | (~settled & (step < MOST_STEPS) & (damping < 1e12))

        def body(carry):
            theta, at, alpha, damping, decrement, better, step = carry
            # The first round, step -1, only looks where the last fit ended.
            looks = step < 0
            # The prior moves once the weights have nearly settled under the old one.
            alpha = jnp.where(~looks & (decrement < 0.3), better, alpha)
            hessian = at.fisher + alpha * identity
            unit = jnp.trace(hessian) / m
            gradient = at.gradient - alpha * theta
            factor = jax.scipy.linalg.cho_factor(hessian + damping * unit * identity)
            candidate = jnp.where(looks, theta, theta + jax.scipy.linalg.cho_solve(factor, gradient))
            there = derivatives(candidate, at.fisher, counted_anew(held, step) if costly else held)
            gained = objective(candidate, there.value, alpha) - objective(theta, at.value, alpha)
            # At the maximum rounding decides; a step too short to matter is taken as it is.
            short = jnp.max(jnp.abs(candidate - theta)) < 1e-9 * (1.0 + jnp.max(jnp.abs(theta)))
            accepted = looks | (gained >= 0.0) | short
            theta, at = jax.tree.map(lambda a, b: jnp.where(accepted, a, b), (candidate, there), (theta, at))
            decrement, better = measured(theta, at, alpha)
            changed = jnp.where(accepted, jnp.maximum(0.1 * damping, 1e-10), jnp.maximum(10.0 * damping, 1e-6))
            return theta, at, alpha, jnp.where(looks, damping, changed), decrement, better, step + 1

        zero = jnp.zeros((), dtype)
        nothing = Derivatives(zero, jnp.zeros(m, dtype), before.precision - before.prior_precision * identity)
        start = (before.mean, nothing, before.prior_precision, jnp.asarray(1e-10, dtype), zero, zero, jnp.int32(-1))
        theta, at, alpha, _, decrement, _, steps = jax.lax.while_loop(unfinished, body, start)
        return Posterior(
            mean=theta,
            prior_precision=alpha,
            log_density=objective(theta, at.value, alpha),
            precision=at.fisher + alpha * identity,
            decrement=decrement,
            converged=decrement <= self.tolerance,
            steps=steps,
        )

    def _fit_matrix_free(self, before: Posterior, memory: Memory[Seen], key: PRNGKeyArray) -> Posterior:
        """As `_fit_dense`, with conjugate gradients in place of H, and tr H⁻¹ from one draw."""
        dtype = before.mean.dtype

        def objective(theta: Array, alpha: Array) -> Array:
            return self.likelihood.value(theta, memory) - 0.5 * alpha * jnp.sum(theta**2)

        def measured(theta: Array, alpha: Array) -> tuple[Array, Array, Array]:
            gradient = self.likelihood.gradient(theta, memory) - alpha * theta
            newton = self._solve(theta, alpha, gradient, memory)
            return gradient, jnp.sqrt(jnp.maximum(jnp.vdot(gradient, newton), 0.0)), newton

        def unfinished(carry) -> Array:
            decrement, step, length = carry[4], carry[6], carry[5]
            return (decrement > self.tolerance) & (step < MOST_STEPS) & (length > 1e-6)

        def body(carry):
            theta, value, gradient, newton, decrement, length, step = carry
            candidate = theta + length * newton
            there = objective(candidate, alpha)
            accepted = there >= value
            moved = jnp.where(accepted, candidate, theta)
            gradient, decrement, newton = measured(moved, alpha)
            length = jnp.where(accepted, jnp.minimum(1.0, 2.0 * length), 0.25 * length)
            return moved, jnp.where(accepted, there, value), gradient, newton, decrement, length, step + 1

        alpha = before.prior_precision
        gradient, decrement, newton = measured(before.mean, alpha)
        one = jnp.ones((), dtype)
        theta, value, _, _, decrement, _, steps = jax.lax.while_loop(
            unfinished,
            body,
            (before.mean, objective(before.mean, alpha), gradient, newton, decrement, one, jnp.zeros((), jnp.int32)),
        )
        draw = self._perturbed(theta, alpha, key, memory)
        determined = theta.shape[0] - alpha * jnp.sum(draw**2)
        better = self._evidence(alpha, determined, theta)
        return Posterior(
            mean=theta,
            prior_precision=better,
            log_density=value - 0.5 * (better - alpha) * jnp.sum(theta**2),
            precision=None,
            decrement=decrement,
            converged=decrement <= self.tolerance,
            steps=steps,
        )

    def draws(self, posterior: Posterior, memory: Memory[Seen], number: int, key: PRNGKeyArray) -> Draws:
        """`number` draws from N(θ̂, H⁻¹), weighted by exp(Φ) over their own density."""
        if posterior.precision is not None:
            noise = jax.random.normal(key, (number, posterior.mean.shape[0]), posterior.mean.dtype)
            lower = jnp.linalg.cholesky(posterior.precision)
            away = jax.scipy.linalg.solve_triangular(lower.T, noise.T, lower=False).T
            squares = jnp.sum(noise**2, axis=1)
        else:
            keys = jax.random.split(key, number)
            away = jax.lax.map(
                lambda each: self._perturbed(posterior.mean, posterior.prior_precision, each, memory), keys
            )
            squares = jax.lax.map(
                lambda each: jnp.vdot(
                    each,
                    self.likelihood.fisher_times(posterior.mean, each, memory) + posterior.prior_precision * each,
                ),
                away,
            )
        values = posterior.mean[None, :] + away
        densities = self._log_densities(values, posterior.prior_precision, memory)
        weights = jax.nn.softmax(densities + 0.5 * squares)
        return Draws(values, weights, 1.0 / jnp.sum(weights**2))

    def equal_draws(
        self, posterior: Posterior, memory: Memory[Seen], number: int, key: PRNGKeyArray
    ) -> Float[Array, "K m"]:
        """`number` draws from the posterior that count alike.

        Of four times as many weighted Gaussian draws they are resampled (systematically: draw i is kept ⌊K w_i⌋ or
        ⌈K w_i⌉ times). Where fewer than `number` / 2 of these count, Hamiltonian Monte Carlo takes their place, if
        there is a matrix to scale it by.
        """
        draw_key, place_key, chain_key = jax.random.split(key, 3)
        drawn = self.draws(posterior, memory, OVERSAMPLED * number, draw_key)
        dtype = drawn.weights.dtype
        steps = (jnp.arange(number, dtype=dtype) + jax.random.uniform(place_key, (), dtype)) / number
        place = jnp.searchsorted(jnp.cumsum(drawn.weights), steps)
        values = drawn.values[jnp.minimum(place, len(drawn.values) - 1)]
        if not self.dense:
            return values
        few = drawn.effective < 0.5 * number
        chains = self.hamiltonian(posterior, memory, number, jnp.where(few, CHAIN_STEPS, 0), chain_key)
        return jnp.where(few, chains, values)

    def hamiltonian(
        self, posterior: Posterior, memory: Memory[Seen], number: int, rounds: Int[Array, ""] | int, key: PRNGKeyArray
    ) -> Float[Array, "K m"]:
        """`number` chains of Hamiltonian Monte Carlo for exp Φ, each begun at θ̂ and gone on with for `rounds` steps.

        Momenta are scaled by H; all chains share a step size that is fitted in the first half.
        """
        assert posterior.precision is not None, "as many weights as that have no matrix to scale by"
        lower = jnp.linalg.cholesky(posterior.precision)
        alpha = posterior.prior_precision

        def placed(y: Array) -> Array:
            return posterior.mean + jax.scipy.linalg.solve_triangular(lower.T, y, lower=False)

        def value_and_slope(y: Array) -> tuple[Array, Array]:
            theta = placed(y)
            value, slope = self.likelihood.value_and_gradient(theta, memory)
            value, slope = value - 0.5 * alpha * jnp.sum(theta**2), slope - alpha * theta
            return value, jax.scipy.linalg.solve_triangular(lower, slope, lower=True)

        def one_step(y: Array, at: tuple[Array, Array], momentum: Array, uniform: Array, length: Array, looks: Array):
            # Lengths that vary keep a chain from going round in a circle.
            length = jnp.where(looks, 0.0, length * (0.7 + 0.6 * uniform[0]))

            def leap(_: Array, carry):
                y, p, (value, slope) = carry
                p = p + 0.5 * length * slope
                y = y + length * p
                value, slope = value_and_slope(y)
                return y, p + 0.5 * length * slope, (value, slope)

            moved, p, there = jax.lax.fori_loop(0, 8, leap, (y, momentum, at))
            log_ratio = there[0] - at[0] + 0.5 * (jnp.sum(momentum**2) - jnp.sum(p**2))
            chance = jnp.where(jnp.isfinite(log_ratio), jnp.exp(jnp.minimum(log_ratio, 0.0)), 0.0)
            accepted = looks | (uniform[1] < chance)
            return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), (moved, there), (y, at)), chance

        def one_round(index: Array, carry):
            (ys, ats), length = carry
            momentum_key, uniform_key = jax.random.split(jax.random.fold_in(key, index))
            momenta = jax.random.normal(momentum_key, ys.shape, ys.dtype)
            uniforms = jax.random.uniform(uniform_key, (number, 2), ys.dtype)
            # The first round has no length: it only looks where the chains begin.
            looks = index == 0
            state, chances = jax.vmap(one_step, (0, 0, 0, 0, None, None))(ys, ats, momenta, uniforms, length, looks)
            adapts = ~looks & (2 * index < rounds)
            length = jnp.where(adapts, length * jnp.exp(jnp.mean(chances) - 0.7), length)
            return state, length

        ys = jnp.zeros((number, posterior.mean.shape[0]), posterior.mean.dtype)
        first = (ys, (jnp.zeros(number, ys.dtype), jnp.zeros_like(ys))), jnp.asarray(0.2, ys.dtype)
        (ys, _), _ = jax.lax.fori_loop(0, jnp.where(rounds > 0, rounds + 1, 0), one_round, first)
        return jax.vmap(placed)(ys)

    def _log_densities(self, values: Float[Array, "K m"], alpha: Array, memory: Memory[Seen]) -> Float[Array, " K"]:
        def of_each(each: Seen) -> Array:
            return jax.vmap(lambda theta: self.likelihood.one_value(theta, each))(values)

        likelihoods = self.likelihood.over_memory(memory, of_each, 8 * values.shape[0])
        return likelihoods - 0.5 * alpha * jnp.sum(values**2, axis=1)

    def _evidence(self, alpha: Array, determined: Array, theta: Array) -> Array:
        """The prior's precision that the evidence prefers, for `determined` weights' worth of data."""
        if self.prior_deviation is not None:
            return alpha
        least, most = (deviation**-2 for deviation in DEVIATIONS[::-1])
        preferred = (determined + PRIOR_WEIGHT) / (jnp.sum(theta**2) + PRIOR_WEIGHT * FIRST_DEVIATION**2)
        return jnp.clip(preferred, least, most)

    def _solve(self, theta: Array, alpha: Array, right: Array, memory: Memory[Seen]) -> Array:
        def product(vector: Array) -> Array:
            return self.likelihood.fisher_times(theta, vector, memory) + alpha * vector

        return jax.scipy.sparse.linalg.cg(product, right, maxiter=SOLVER_STEPS, tol=1e-8)[0]

    def _perturbed(self, theta: Array, alpha: Array, key: PRNGKeyArray, memory: Memory[Seen]) -> Array:
        """A draw from N(0, H⁻¹): H⁻¹ of a draw from N(0, H)."""
        data_key, prior_key = jax.random.split(key)
        noise = self.likelihood.fisher_noise(theta, data_key, memory)
        noise += jnp.sqrt(alpha) * jax.random.normal(prior_key, theta.shape, theta.dtype)
        return self._solve(theta, alpha, noise, memory)


def counted_anew(held: Int[Array, ""], step: Int[Array, ""]) -> Int[Array, ""]:
    """Of how many of the newest interactions a step of a fit computes a costly F: of all `held`, of one, or of none."""
    at_first = jnp.where((held <= RENEWED) | (held % RENEWED == 0), held, 1)
    return jnp.where(step < 0, at_first, jnp.where(step % RENEWED == RENEWED - 1, held, 0))
