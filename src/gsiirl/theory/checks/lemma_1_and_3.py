"""Lemmas 1 and 3 against automatic differentiation of L and f, corrected and as the paper prints them.

The formulas come from `SoftJointModel` and `LemmaThree`; the derivatives from automatic differentiation of the
scalars L and f, which knows nothing of the formulas.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.equilibria.soft_joint import joint_occupancy
from gsiirl.runs.findings import Finding, Measurement, Panel
from gsiirl.theory.support.curves import curve, median
from gsiirl.theory.support.direct import LemmaThree
from gsiirl.theory.support.games import SIZES, TEMPERATURE, RandomProblem, of_norm
from gsiirl.theory.support.soft_joint_model import SoftJointModel

REGULARISATION = 0.1
NORM = 0.8
"""‖θ_l‖ = ‖θ_e‖, away from the truth and from 0."""
TOLERANCE = 1e-8
SMALLEST = 1e-17
"""Where an error of exactly 0 is drawn on the logarithmic axis."""

LEMMA_1 = {
    "no_temperature": "Lemma 1 without 1/τ",
    "no_discount": "Lemma 1 for the L of eq. 1, which has no discount",
    "marginal": "Lemma 1 for an L of ln π_e(a_e|s) alone",
    "conditional": "Lemma 1 for an L of ln π_e(a_e|s, a_l) alone",
    "no_weight": "∇L by A.1's μ_e(s), a sum without the weights π(a|s)",
    "tail_discount": "∇L by A.3's tail, discounted once too little",
}
LEMMA_3 = {
    "extra_term": "∇_{θ_l} f with the extra + μ_l(π)",
    "expert_gradient": "∇_{θ_e} f, no 1/τ",
    "mixed": "the mixed derivative, transposed to fit Lemma 2, no 1/τ²",
    "orientation": "the mixed derivative as oriented in print (games with n = m)",
    "hessian": "the Hessian, ∇r for ∇²r and + λ in every entry",
    "entrywise": "the corrected Hessian but for + λ in every entry",
}
OURS = {
    "lower_gradient": "∇_{θ_e} L, Lemma 1",
    "upper_gradient": "∇_{θ_l} L, Lemma 3",
    "learner_gradient": "∇_{θ_l} f, Lemma 3",
    "expert_gradient": "∇_{θ_e} f, Lemma 3",
    "mixed": "the mixed derivative of L, Lemma 3",
    "hessian": "the Hessian of L in θ_e, Lemma 3",
}


class Game(eqx.Module):
    """A model with the point (θ_l, θ_e) at which its derivatives are taken."""

    model: SoftJointModel
    learner: Float[Array, " n"]
    expert: Float[Array, " m"]

    @property
    def nonlinear(self) -> bool:
        """Whether its rewards are nonlinear."""
        return bool(self.model.curvature)

    @classmethod
    def draw(cls, seed: int, size: int, nonlinear: bool) -> "Game":
        """Game `seed` of SIZES[size] at τ = TEMPERATURE."""
        random = np.random.default_rng((seed, size))
        lengths = SIZES[size].learner_parameters, SIZES[size].expert_parameters
        curvature = jnp.asarray(nonlinear * 1.0)
        instance = RandomProblem.draw(seed, SIZES[size])
        model = SoftJointModel(instance, REGULARISATION, jnp.asarray(TEMPERATURE), curvature=curvature)
        return cls(model, *(of_norm(random, NORM, length) for length in lengths))

    def at_temperature(self, temperature: float) -> "Game":
        """The same game at another τ."""
        return eqx.tree_at(lambda game: game.model.temperature, self, jnp.asarray(temperature))

    def compare(self) -> "Comparison":
        """All formulas against automatic differentiation."""
        return Comparison(*jax.tree.map(float, _compare(self)))


class Comparison(NamedTuple):
    """Relative errors of our formulas (keys of OURS) and of the printed ones (keys of LEMMA_1 and LEMMA_3).

    `orientation` is missing where n ≠ m. `smallest_eigenvalue` is that of ∇²_{θ_e} L without λI, differentiated.
    """

    ours: dict[str, float]
    printed: dict[str, float]
    smallest_eigenvalue: float


class Exact(eqx.Module):
    """Derivatives of L, of its variants and of f by automatic differentiation of the scalars."""

    lower: Float[Array, "4 m"]
    """∇_{θ_e} of L, of the undiscounted L, and of L with the marginal and the conditional ln π_e for the joint ln π."""
    upper: Float[Array, " n"]
    mixed: Float[Array, "m n"]
    hessian: Float[Array, "m m"]
    learner_gradient: Float[Array, " n"]
    expert_gradient: Float[Array, " m"]

    @classmethod
    def of(cls, game: Game) -> "Exact":
        """All of them from one function of (θ_l, θ_e), the demonstrations D(θ_l) held."""
        model, size = game.model, game.learner.shape[0]
        demonstrating = model.demonstrating_policy(game.learner).joint
        discounted, undiscounted = (
            joint_occupancy(model.instance.game, demonstrating, discount) for discount in (model.discount, 1.0)
        )

        def scalars(both: Array) -> Float[Array, "5"]:
            policy = model.solve(both[:size], both[size:]).joint
            penalty = 0.5 * model.regularisation * jnp.vdot(both[size:], both[size:])
            log_likelihoods = [
                jnp.sum(discounted * jnp.log(policy)),
                jnp.sum(undiscounted * jnp.log(policy)),
                jnp.sum(discounted * jnp.log(jnp.sum(policy, 2, keepdims=True))),
                jnp.sum(discounted * jnp.log(policy / jnp.sum(policy, 3, keepdims=True))),
            ]
            objective = model.objective(both[:size], both[size:])
            return jnp.stack([*(penalty - each for each in log_likelihoods), objective])

        def first_derivatives(both: Array) -> tuple[Array, Array]:
            first = jax.jacfwd(scalars)(both)
            return first, first

        both = jnp.concatenate([game.learner, game.expert])
        second, first = jax.jacfwd(first_derivatives, has_aux=True)(both)
        return cls(
            lower=first[:4, size:],
            upper=first[0, :size],
            mixed=second[0, size:, :size],
            hessian=second[0, size:, size:],
            learner_gradient=first[4, :size],
            expert_gradient=first[4, size:],
        )


@eqx.filter_jit
def _compare(game: Game) -> tuple[dict[str, Array], dict[str, Array], Array]:
    exact, model, expert = Exact.of(game), game.model, game.expert
    demonstrations = model.demonstrations(game.learner)
    terms = model.lemma_three(game.learner, expert, demonstrations)
    lemma_1 = model.lower_gradient(game.learner, expert, demonstrations)
    learner_gradient, expert_gradient = terms.objective_gradients()
    identity = jnp.eye(expert.shape[0], dtype=expert.dtype)
    ours = {
        "lower_gradient": (lemma_1, exact.lower[0]),
        "upper_gradient": (model.upper_gradient(game.learner, expert, demonstrations), exact.upper),
        "learner_gradient": (learner_gradient, exact.learner_gradient),
        "expert_gradient": (expert_gradient, exact.expert_gradient),
        "mixed": (terms.mixed(), exact.mixed),
        "hessian": (terms.hessian() + model.regularisation * identity, exact.hessian),
    }

    # From here on as it is printed, which leaves 1/τ out everywhere.
    plain = eqx.tree_at(lambda each: each.temperature, terms, jnp.ones_like(terms.weights[0, 0, 0, 0]))
    plain_learner, plain_expert = plain.objective_gradients()
    surplus, penalty = terms.weights - demonstrations, model.regularisation * expert
    # A.1's μ_e(s) = Σ_a μ_e(s, a).
    unweighted = terms.expert.from_action - jnp.sum(terms.expert.from_action, (2, 3), keepdims=True)
    tail = _long_tail(model, terms, expert) - terms.expert.from_state[:, :, None, None, :]

    def demonstrated(table: Array) -> Array:
        return jnp.einsum("tsab,tsabk->k", demonstrations, table)

    printed = {
        "no_temperature": (model.expert_expectation(surplus, expert) + penalty, exact.lower[0]),
        "no_discount": (lemma_1, exact.lower[1]),
        "marginal": (lemma_1, exact.lower[2]),
        "conditional": (lemma_1, exact.lower[3]),
        "no_weight": (penalty - demonstrated(unweighted), exact.lower[0]),
        "tail_discount": (penalty - demonstrated(tail), exact.lower[0]),
        "extra_term": (
            plain_learner + model.learner_expectation(terms.weights, game.learner),
            exact.learner_gradient,
        ),
        "expert_gradient": (plain_expert, exact.expert_gradient),
        "mixed": (plain.mixed(), exact.mixed),
        "hessian": (_printed_hessian(model, plain, expert, demonstrations), exact.hessian),
        "entrywise": (terms.hessian() + model.regularisation, exact.hessian),
    }
    if exact.mixed.shape[0] == exact.mixed.shape[1]:
        printed["orientation"] = (plain.mixed(), exact.mixed.T)
    smallest = jnp.linalg.eigvalsh(exact.hessian)[0] - model.regularisation
    return _relative(ours), _relative(printed), smallest


def _long_tail(model: SoftJointModel, terms: LemmaThree, expert: Float[Array, " m"]) -> Float[Array, "T S A_l A_e m"]:
    """∇r_e(s, a) + E[Σ_{t'>t} γ^{t'−t−1} ∇r_e | s, a], A.3's second line."""
    now = jax.jacfwd(model.expert_reward)(expert)[None]
    return now + (terms.expert.from_action - now) / model.discount


def _printed_hessian(
    model: SoftJointModel,
    plain: LemmaThree,
    expert_parameters: Float[Array, " m"],
    demonstrations: Float[Array, "T S A_l A_e"],
) -> Float[Array, "m m"]:
    """E^π[Σ_t γ^t ((μ_e(s, a) − μ_e(s)) μ_e(s, a)ᵀ + ∇²r_e)] − (1/d) Σ_D γ^t ∇r_e + λ.

    A vector taken from a matrix, and a number added to one: read as for every row, and for every entry.
    """
    modelled = jnp.sum(plain.weights, 0)
    curvature = jax.hessian(lambda theta: jnp.vdot(modelled, model.expert_reward(theta)))(expert_parameters)
    with_curvature = eqx.tree_at(lambda each: each.expert_curvature, plain, curvature)
    demonstrated = model.expert_expectation(demonstrations, expert_parameters)
    return with_curvature.hessian() - demonstrated[None, :] + model.regularisation


def _relative(pairs: dict[str, tuple[Array, Array]]) -> dict[str, Float[Array, ""]]:
    return {key: jnp.linalg.norm(found - exact) / jnp.linalg.norm(exact) for key, (found, exact) in pairs.items()}


def check(quick: bool) -> Finding:
    """Lemmas 1 and 3 on random games with linear and nonlinear rewards."""
    sizes, seeds = (range(2), range(2)) if quick else (range(len(SIZES)), range(8))
    games = [Game.draw(seed, size, nonlinear) for nonlinear in (False, True) for size in sizes for seed in seeds]
    here = [game.compare() for game in games]
    at_one = [game.at_temperature(1.0).compare() for game in games]
    linear, nonlinear = (
        [each for found in (here, at_one) for game, each in zip(games, found, strict=True) if game.nonlinear == kind]
        for kind in (False, True)
    )

    # numpy's extremes, because Python's may pass over a nan.
    measurements = [
        Measurement(
            f"{name}, corrected: worst relative error, {kind} rewards",
            float(np.max([each.ours[key] for each in found])),
            at_most=TOLERANCE,
        )
        for kind, found in (("linear", linear), ("nonlinear", nonlinear))
        for key, name in OURS.items()
    ]
    measurements += [
        Measurement(
            "smallest eigenvalue of the Hessian of L less λ, linear rewards: the smallest of all games",
            float(np.min([each.smallest_eigenvalue for each in linear])),
            at_least=-TOLERANCE,
        ),
        Measurement(
            "nonlinear rewards: fraction of games where the Hessian of L, λI included, has an eigenvalue below 0",
            float(np.mean([each.smallest_eigenvalue + REGULARISATION < 0.0 for each in nonlinear])),
        ),
    ]
    for temperature, found in ((TEMPERATURE, here), (1.0, at_one)):
        for key, name in (LEMMA_1 | LEMMA_3).items():
            values = [each.printed[key] for each in found if key in each.printed]
            measurements.append(Measurement(f"{name}: median relative error at τ = {temperature:g}", median(values)))

    return Finding(
        key="lemmas-1-and-3",
        title="First and second derivatives of L and f",
        claim=(
            "For the joint softmax policy at any temperature τ, with L discounted, averaged over demonstrations and "
            "taken of the joint ln π(a_l, a_e|s), Lemma 1 and the corrected Lemma 3 are the derivatives of L and f, "
            "for linear and for smooth nonlinear rewards. With linear rewards L is convex."
        ),
        printed=(
            "Both lemmas leave out 1/τ (1/τ² in second derivatives). Eq. 1 has neither the discount nor the average "
            "over demonstrations. Lemma 3 adds μ_l(π) to ∇_{θ_l} f although the accessed r_ld does not depend on θ_l, "
            "has ∇r where ∇²r belongs and + λ for + λI, and gives the mixed derivative as m by n where Lemma 2 needs "
            "n by m. A.1's μ_e(s) lacks the weights π(a|s); the second line of A.3 discounts the tail once too little. "
            "Section 6.2 calls L convex, although Assumption 1 admits rewards that are not linear."
        ),
        reading=(
            "Relative error (Frobenius norm) against automatic differentiation of the scalars L and f, one point a "
            f"game, at τ = {TEMPERATURE:g}; the first half of the games has linear rewards, the second nonlinear ones. "
            "Lines at rounding level are the corrected formulas (the worst of the six). Everything of the paper's that "
            "lacks 1/τ is printed for τ = 1 in effect; the table therefore gives its errors at τ = 1 too, where only "
            "the other slips remain. ∇r in the Hessian, a vector, is read as taken from every row. Errors of Lemma 1 "
            "for another L are those of the corrected formula against that L's own gradient. The "
            "demonstrations are those of an expert whose reward is linear; a nonlinear reward cannot express it, and "
            "away from its minimum L is then often not convex: conjugate gradients stop there and report it."
        ),
        measurements=measurements,
        panels=[
            _panel("Lemma 1 and its proof", LEMMA_1, here),
            _panel("Lemma 3", LEMMA_3, here),
        ],
    )


def _panel(title: str, names: dict[str, str], found: list[Comparison]) -> Panel:
    numbers = range(1, len(found) + 1)
    curves = [curve("corrected, worst of six", numbers, [np.max([SMALLEST, *each.ours.values()]) for each in found])]
    for key, name in names.items():
        there = {number: each.printed[key] for number, each in zip(numbers, found, strict=True) if key in each.printed}
        curves.append(curve(name, [*there], np.maximum(SMALLEST, [*there.values()]), "paper"))
    return Panel(f"{title}, at τ = {TEMPERATURE:g}", "game", "relative error", curves, log_x=False)
