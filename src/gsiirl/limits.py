"""Limits on what a learner holds in memory, which the estimate of a run's memory needs too. Loads no JAX."""

DENSE = 1500
"""Above as many weights no m x m matrix is held: systems are solved by conjugate gradients."""
MEMORY = 2**24
"""Numbers that remembered interactions may take: 128 MiB in double precision."""


def remembered(policy_size: int, iterations: int) -> int:
    """How many interactions are remembered: all, or as many as `MEMORY` holds of policies of so many numbers."""
    return max(1, min(iterations, max(8, MEMORY // policy_size)))
