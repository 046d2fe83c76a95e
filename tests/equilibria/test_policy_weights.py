import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import policy_of, weights_of


def test_a_policy_comes_back_from_its_weights_one_or_many():
    several = jax.vmap(lambda key: PolicyNetwork.create(4, 2, 8, key))(jax.random.split(jax.random.key(0), 3))
    one = PolicyNetwork.create(5, 1, 8, jax.random.key(1))
    kept = {name: np.asarray(array) for name, array in weights_of(learner=several, expert=one).items()}
    seen, time = jnp.linspace(-1.0, 1.0, 5, dtype=jnp.float32), jnp.asarray(0.25, jnp.float32)
    np.testing.assert_array_equal(policy_of("expert", kept)(seen, time), one(seen, time))
    again = policy_of("learner", kept)
    actions = [jax.vmap(lambda policy: policy(seen[:4], time))(each) for each in (again, several)]
    assert actions[0].shape == (3, 2)
    np.testing.assert_array_equal(*actions)
