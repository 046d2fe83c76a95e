"""Types of the two vectors of parameters."""

from jaxtyping import Array, Float

LearnerVector = Float[Array, " n"]
"""θ_l."""
ExpertVector = Float[Array, " m"]
"""θ_e."""
