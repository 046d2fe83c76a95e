"""Policy networks as named arrays, as a run folder keeps them."""

from jaxtyping import Array

from gsiirl.equilibria.policy_network import PolicyNetwork


def weights_of(**policies: PolicyNetwork) -> dict[str, Array]:
    """The weights of policies by name; `learner=policy` gives `learner.layers.0.weight` and so on."""
    return {
        f"{name}.layers.{index}.{part}": getattr(layer, part)
        for name, policy in policies.items()
        for index, layer in enumerate(policy.layers)
        for part in ("weight", "bias")
    }
