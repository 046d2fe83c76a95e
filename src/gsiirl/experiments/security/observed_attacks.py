"""How often interactions showed each attack, so that a report can tell what was learned from what was never seen."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.games.attack_graph import AttackGraph


def observed_attacks(gram: Float[Array, "n n"], game: AttackGraph) -> dict[str, Float[Array, " e"]]:
    """Of each edge the `attacks` that were seen, and those with a `chance`: possible, and not blocked.

    `gram` is Σ φφ' over everything visited, of ±φ_e (and perhaps more features after those): an attack on i → j adds 1
    to the square of the cost's feature, and, where it has a chance, the chance of success to its product with j's.
    """
    costs = game.number_of_nodes + jnp.arange(game.number_of_edges)
    # The chance of an attack that can be made at all.
    success = jnp.max(game.success, axis=0)
    with_a_chance = -gram[game.targets, costs] / jnp.where(success > 0, success, 1.0)
    return {"attacks": gram[costs, costs], "chances": with_a_chance}
