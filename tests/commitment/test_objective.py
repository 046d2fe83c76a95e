"""f, the expert's response and the gradient against the definition spelled out in NumPy and against differences."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import Batch, FiniteGame, Floats, learner_return, response
from small_games import HORIZON, JOINT, finite_game, tabular

from gsiirl.commitment.objective import Commitment
from gsiirl.equilibria.response import respond
from gsiirl.games import DensePayoff

TEMPERATURES = (1.0, 0.1, 0.02)


def commitment_of(game: FiniteGame) -> Commitment:
    """With JAX's arrays, so that games share a compiled program."""
    finite = tabular(game)
    return jax.tree.map(
        jnp.asarray, Commitment(finite, DensePayoff(game.own[:, :, None] + game.dependent), game.discount)
    )


def some_policies(game: FiniteGame, number: int) -> Floats:
    random = np.random.default_rng(7)
    return Batch(game).tidy(random.gamma(0.5, size=(number, HORIZON, *JOINT[:2])) + 1e-6)


@jax.jit
def answer_to(commitment: Commitment, policy, reward: DensePayoff, temperature):
    return respond(commitment.game, policy, reward, temperature, commitment.discount).policy


@jax.jit
def value_of(commitment: Commitment, policy, reward: DensePayoff, temperature, discount):
    return commitment.value(policy, reward, temperature, discount=discount)


@jax.jit
def slope_of(commitment: Commitment, logits, reward: DensePayoff, temperature, reaction):
    return jax.value_and_grad(lambda z: commitment.value(commitment.policy(z), reward, temperature, reaction))(logits)


@pytest.mark.parametrize("temperature", TEMPERATURES)
@pytest.mark.parametrize("seed", range(3))
def test_the_response_and_the_return_are_the_oracles(seed: int, temperature: float) -> None:
    game = finite_game(seed, temperature)
    commitment, reward, tau = commitment_of(game), DensePayoff(jnp.asarray(game.expert)), jnp.asarray(temperature)
    for policy in some_policies(game, 4):
        played = jnp.asarray(policy)
        np.testing.assert_allclose(
            np.asarray(answer_to(commitment, played, reward, tau))[:, ~game.terminal],  # pyright: ignore[reportOptionalOperand]
            response(game, policy)[:, ~game.terminal],  # pyright: ignore[reportOptionalOperand]
            atol=1e-12,
        )
        for discount in (game.discount, 1.0):
            value = value_of(commitment, played, reward, tau, jnp.asarray(discount))
            np.testing.assert_allclose(value, learner_return(game, policy, discount), atol=1e-12)


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_a_reward_in_units_of_the_temperature_gives_the_same_response(temperature: float) -> None:
    game = finite_game(4, temperature)
    commitment, policy = commitment_of(game), jnp.asarray(some_policies(game, 1)[0])
    plain = answer_to(commitment, policy, DensePayoff(jnp.asarray(game.expert)), jnp.asarray(temperature))
    unit = answer_to(commitment, policy, DensePayoff(jnp.asarray(game.expert / temperature)), jnp.asarray(1.0))
    np.testing.assert_allclose(unit, plain, atol=1e-12)


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_the_gradient_is_that_of_differences(temperature: float) -> None:
    game = finite_game(2, temperature)
    commitment, reward, tau = commitment_of(game), DensePayoff(jnp.asarray(game.expert)), jnp.asarray(temperature)
    one = jnp.asarray(1.0)
    logits = np.random.default_rng(3).normal(size=(HORIZON, *JOINT[:2]))
    _, slope = slope_of(commitment, jnp.asarray(logits), reward, tau, one)

    def difference(place: tuple[int, ...], step: float) -> float:
        moved = [logits.copy(), logits.copy()]
        moved[0][place] += step
        moved[1][place] -= step
        ends = [float(slope_of(commitment, jnp.asarray(each), reward, tau, one)[0]) for each in moved]
        return (ends[0] - ends[1]) / (2 * step)

    # Richardson's extrapolation of two central differences: the error is of fourth order in the step.
    step = 1e-3 * min(1.0, 5 * temperature)
    numeric = np.zeros_like(logits)
    for place in np.ndindex(logits.shape):
        numeric[place] = (4 * difference(place, step / 2) - difference(place, step)) / 3
    assert np.abs(numeric).max() > 1e-3
    np.testing.assert_allclose(slope, numeric, rtol=0, atol=1e-7 * np.abs(numeric).max())


def test_without_reaction_the_gradient_takes_the_answer_as_given() -> None:
    game = finite_game(2)
    commitment, reward, tau = commitment_of(game), DensePayoff(jnp.asarray(game.expert)), jnp.asarray(0.3)
    logits = jnp.asarray(np.random.default_rng(3).normal(size=(HORIZON, *JOINT[:2])))
    value, slope = slope_of(commitment, logits, reward, tau, jnp.asarray(0.0))
    fixed = response(game, np.asarray(commitment.policy(logits)))
    assert game.terminal is not None
    alive = 1.0 - game.terminal.astype(float)

    def return_of(logits: Floats) -> float:
        policy = np.asarray(commitment.policy(jnp.asarray(logits)))
        here, total = game.initial * alive, 0.0
        for time in range(HORIZON):
            joint = here[:, None, None] * policy[time][:, :, None] * fixed[time][:, None, :]
            total += game.discount**time * (joint * (game.own[:, :, None] + game.dependent)).sum()
            here = np.einsum("sab,sabn->n", joint, game.transitions) * alive
        return float(total)

    np.testing.assert_allclose(value, return_of(np.asarray(logits)), atol=1e-12)
    for place in [(0, 0, 0), (1, 0, 1), (2, 0, 0)]:
        up, down = np.array(logits), np.array(logits)
        up[place] += 1e-5
        down[place] -= 1e-5
        np.testing.assert_allclose(slope[place], (return_of(up) - return_of(down)) / 2e-5, atol=1e-9)


def test_a_policy_of_logits_does_nothing_that_is_forbidden() -> None:
    game = finite_game()
    policy = np.asarray(commitment_of(game).policy(jnp.asarray(np.random.default_rng(0).normal(size=(HORIZON, 3, 2)))))
    np.testing.assert_allclose(policy.sum(-1), 1.0, atol=1e-15)
    assert (policy[:, ~game.learner_actions] == 0).all()  # pyright: ignore[reportOptionalOperand]


def test_the_range_of_answers_is_that_against_uniform_play() -> None:
    game = replace(finite_game(1, temperature=1.0), terminal=None)
    found = jax.jit(Commitment.range_of_answers)(commitment_of(game), DensePayoff(jnp.asarray(game.expert)))
    uniform = Batch(game).tidy(np.ones((1, HORIZON, *JOINT[:2])))[0]
    # At temperature 1 differences of values are those of logarithms of the answers; state 0 forbids the last action.
    logs = np.log(np.maximum(response(game, uniform), 1e-300))
    wide = max(np.ptp(logs[:, 0, :2], axis=-1).max(), np.ptp(logs[:, 1:], axis=-1).max())
    np.testing.assert_allclose(found, wide, atol=1e-12)
