"""Record draws by BlackJAX from the posterior of a small game, for the tests.

Usage: python scripts/record_blackjax.py [--output tests/data/blackjax_posterior.npz]

Needs jax and blackjax, which this project does not depend on. Recorded with blackjax 1.7.1 and jax 0.10.2. The
log-posterior is written out here and shares no code with the package. Few choices were seen, so that the posterior is
far from Gaussian. No-U-turn sampling, 8 chains of 20,000 draws after 2,000 of warm-up.

Entries of the file (float64):

transitions [S, A_l, A_e, S], features [S, A_l, A_e, m], policies [N, T, S, A_l], counts [N, T, S, A_e]
discount, deviation                          that of the prior of every weight, in units of the temperature
mean [m], covariance [m, m], quantiles [3, m]   of all draws: 5 %, 50 %, 95 %
errors [m]                                   standard errors of the means, from the eight chains
"""

import argparse
from pathlib import Path

import blackjax  # pyright: ignore[reportMissingImports]
import jax
import jax.numpy as jnp
import numpy as np

STATES, LEARNER, EXPERT, HORIZON, WEIGHTS, INTERACTIONS = 3, 2, 3, 3, 4, 3
DISCOUNT, DEVIATION, EPISODES = 0.9, 2.0, 4
CHAINS, WARM_UP, DRAWS = 8, 2000, 20_000


def action_values(weights, transitions, features, policy):
    """Q/τ [T, S, A_e] of the soft best response, from the last step back."""
    after, found = jnp.zeros(STATES), []
    for time in range(HORIZON - 1, -1, -1):
        joint = features @ weights + DISCOUNT * transitions @ after
        values = jnp.einsum("sa,sae->se", policy[time], joint)
        after = jax.scipy.special.logsumexp(values, axis=1)
        found.append(values)
    return jnp.stack(found[::-1])


def main() -> None:
    """Draw the game and the data, then sample."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("tests/data/blackjax_posterior.npz"))
    jax.config.update("jax_enable_x64", True)
    source = np.random.default_rng(7)
    joint = (STATES, LEARNER, EXPERT)
    transitions = source.dirichlet(np.ones(STATES), joint)
    features = source.normal(size=(*joint, WEIGHTS))
    true = DEVIATION * source.normal(size=WEIGHTS)
    policies = source.dirichlet(np.ones(LEARNER), (INTERACTIONS, HORIZON, STATES))
    counts = np.zeros((INTERACTIONS, HORIZON, STATES, EXPERT))
    for place, policy in enumerate(policies):
        chances = np.asarray(jax.nn.softmax(action_values(true, transitions, features, policy)))
        for _ in range(EPISODES):
            here = source.integers(STATES)
            for time in range(HORIZON):
                mine = source.choice(LEARNER, p=policy[time, here])
                theirs = source.choice(EXPERT, p=chances[time, here])
                counts[place, time, here, theirs] += 1
                here = source.choice(STATES, p=transitions[here, mine, theirs])

    def log_density(weights):
        total = -0.5 * jnp.sum(weights**2) / DEVIATION**2
        for policy, seen in zip(policies, counts, strict=True):
            total += jnp.sum(seen * jax.nn.log_softmax(action_values(weights, transitions, features, policy)))
        return total

    def chain(key):
        warm_key, draw_key = jax.random.split(key)
        warm = blackjax.window_adaptation(blackjax.nuts, log_density)
        (state, settings), _ = warm.run(warm_key, jnp.zeros(WEIGHTS), WARM_UP)
        kernel = blackjax.nuts(log_density, **settings)

        def body(state, key):
            state, _ = kernel.step(key, state)
            return state, state.position

        return jax.lax.scan(body, state, jax.random.split(draw_key, DRAWS))[1]

    draws = np.asarray(jax.jit(jax.vmap(chain))(jax.random.split(jax.random.key(0), CHAINS)))
    flat = draws.reshape(-1, WEIGHTS)
    np.savez_compressed(
        parser.parse_args().output,
        transitions=transitions,
        features=features,
        policies=policies,
        counts=counts,
        discount=DISCOUNT,
        deviation=DEVIATION,
        mean=flat.mean(axis=0),
        covariance=np.cov(flat, rowvar=False),
        quantiles=np.quantile(flat, [0.05, 0.5, 0.95], axis=0),
        errors=draws.mean(axis=1).std(axis=0, ddof=1) / CHAINS**0.5,
    )


if __name__ == "__main__":
    main()
