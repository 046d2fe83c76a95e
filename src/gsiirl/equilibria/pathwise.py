"""Both sides' policy networks ascend their own returns, by gradients through the game's dynamics.

    J_i(π) = E_{s_0 ~ P0}[Σ_t γ^t r_i(s_t, a_t, s_{t+1})],     π_i ← π_i + step of ∇_{π_i} J_i(π)

The dynamics and the rewards are differentiable, so that one episode gives an exact gradient of its own return; a step
averages over `batch` initial states. Two things keep the pair from settling where either side can be exploited
(measured in docs/equilibria.md). The expert may take `expert_steps` steps for one of the learner's: it then is near its
best response all along, as in two-time-scale gradient play (Heusel et al. 2017, Fiez and Ratliff 2021). And with
`noise` both hands shake while they learn, though not when they play: what one side reads from the other's moves is then
less than all of it, so that a side that must not be seen through (the agents of the deception) does not settle where it
always is.
"""

from functools import cache
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray, PyTree

from gsiirl.equilibria.policy_network import NoisyPolicy, PolicyNetwork
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.games.rollout import episodes_from, initial_states, play
from gsiirl.rewards.continuous import TransitionReward, mean_return
from gsiirl.types import Sides, Transition

Side = Literal["learner", "expert"]
TRAINED_RATE, FOLLOWING_RATE = 0.02, 0.1
"""The last learning rate, as a share of the first: of a pair that trains once, and of one that follows others."""


class Ascent(eqx.Module):
    """One side's policy on its way up, and what its optimiser remembers."""

    policy: PolicyNetwork
    optimiser: Any


class Progress(eqx.Module):
    """How the ascent went, a value a step: both sides' returns J_i and gradient norms ‖∇J_i‖ before the step."""

    returns: Sides[Float[Array, " steps"]]
    gradient_norms: Sides[Float[Array, " steps"]]


class Pathwise(eqx.Module):
    """The solver; its states are pairs of ascents, `Sides[Ascent]`, from which the next call goes on."""

    game: AbstractContinuousGame
    discount: float = eqx.field(static=True)
    batch: int = eqx.field(static=True)
    hidden: int = eqx.field(static=True)
    optimiser: Sides[optax.GradientTransformation] = eqx.field(static=True)
    expert_steps: int = eqx.field(static=True)
    noise: optax.Schedule | None = eqx.field(static=True)

    @classmethod
    def create(
        cls,
        game: AbstractContinuousGame,
        *,
        discount: float,
        batch: int = 64,
        hidden: int = 64,
        learning_rate: float = 3e-3,
        decay_steps: int = 1000,
        last_rate: float = FOLLOWING_RATE,
        expert_steps: int = 2,
        noise: float = 0.0,
    ) -> "Pathwise":
        """With Adam for both sides, its rate falling along half a cosine to `last_rate` of the first one.

        The fall takes `decay_steps` steps of the learner, and as long for the expert; gradients are clipped to norm 1.
        The noise falls to nothing along a line in the second half of these steps.
        """
        optimiser = Sides(
            _adam(learning_rate, decay_steps, last_rate), _adam(learning_rate, decay_steps * expert_steps, last_rate)
        )
        falling = _falling(noise, max(decay_steps // 2, 1)) if noise else None
        return cls(game, discount, batch, hidden, optimiser, expert_steps, falling)

    def init(self, key: PRNGKeyArray) -> Sides[Ascent]:
        """Random policies."""
        reset_key, *keys = jax.random.split(key, 3)
        observations = self.game.observe(self.game.reset(reset_key))

        def fresh(side: str, one: PRNGKeyArray) -> PolicyNetwork:
            observation, actions = getattr(observations, side), getattr(self.game.action_size, side)
            return PolicyNetwork.create(observation.shape[0], actions, self.hidden, one)

        return self.init_at(Sides(fresh("learner", keys[0]), fresh("expert", keys[1])))

    def init_at(self, policies: Sides[PolicyNetwork]) -> Sides[Ascent]:
        """Ascents that begin at `policies`, with optimisers that remember nothing."""

        def fresh(side: str) -> Ascent:
            policy: Any = getattr(policies, side)
            return Ascent(policy, getattr(self.optimiser, side).init(policy))

        return Sides(fresh("learner"), fresh("expert"))

    def ascend(
        self, state: Sides[Ascent], rewards: Sides[TransitionReward], key: PRNGKeyArray, steps: int
    ) -> tuple[Sides[Ascent], Progress]:
        """`steps` steps of both sides together, from `state`; the expert takes `expert_steps` for each of them."""

        def one_step(state: Sides[Ascent], key: PRNGKeyArray) -> tuple[Sides[Ascent], Progress]:
            both_key, response_key = jax.random.split(key)
            noise = None if self.noise is None else jnp.asarray(self.noise(steps_taken(state.learner)))
            values, pull_back = jax.vjp(
                lambda at: self._noisy_returns(at, rewards, both_key, noise), policies_of(state)
            )
            zero, one = jnp.zeros_like(values.learner), jnp.ones_like(values.learner)
            # One rollout, pulled back twice: each side wants the gradient of its own return alone.
            gradients = Sides(pull_back(Sides(one, zero))[0].learner, pull_back(Sides(zero, one))[0].expert)
            learner = moved(self.optimiser.learner, state.learner, gradients.learner)
            expert = moved(self.optimiser.expert, state.expert, gradients.expert)

            def one_response(expert: Ascent, key: PRNGKeyArray) -> tuple[Ascent, None]:
                def value(policy: PolicyNetwork) -> Array:
                    return self._noisy_returns(Sides(state.learner.policy, policy), rewards, key, noise).expert

                return self.responded(expert, jax.grad(value)(expert.policy)), None

            # Not unrolled: a step of the expert is compiled once, however many it takes.
            expert, _ = jax.lax.scan(one_response, expert, jax.random.split(response_key, self.expert_steps - 1))
            norms = Sides(optax.tree.norm(gradients.learner), optax.tree.norm(gradients.expert))
            return Sides(learner, expert), Progress(values, norms)

        return jax.lax.scan(one_step, state, jax.random.split(key, steps))

    def settle(
        self, policies: Sides[PolicyNetwork], rewards: Sides[TransitionReward], key: PRNGKeyArray, steps: int
    ) -> Sides[PolicyNetwork]:
        """The pair that `steps` steps lead to from `policies`, with optimisers that remember nothing.

        Its rate and noise fall over this solver's `decay_steps`.
        """
        return policies_of(self.ascend(self.init_at(policies), rewards, key, steps)[0])

    def respond(
        self, learner_policy: PolicyNetwork, reward: TransitionReward, response: Ascent, key: PRNGKeyArray, steps: int
    ) -> Ascent:
        """`steps` steps of the expert alone towards its best response to `learner_policy` under `reward`."""
        return self.climb("expert", learner_policy, reward, response, key, steps)

    def answer(
        self, expert_policy: PolicyNetwork, reward: TransitionReward, answer: Ascent, key: PRNGKeyArray, steps: int
    ) -> Ascent:
        """`steps` steps of the learner alone towards its best response to `expert_policy` under `reward`."""
        return self.climb("learner", expert_policy, reward, answer, key, steps)

    def starts(self, key: PRNGKeyArray) -> PyTree:
        """A batch of initial states."""
        return initial_states(self.game, key, self.batch)

    def climb(
        self,
        side: Side,
        other: PolicyNetwork,
        reward: TransitionReward,
        ascent: Ascent,
        key: PRNGKeyArray,
        steps: int,
    ) -> Ascent:
        """`steps` steps of one side alone along its return under `reward`, against the `other` side's policy."""
        optimiser: optax.GradientTransformation = getattr(self.optimiser, side)

        def one_step(ascent: Ascent, key: PRNGKeyArray) -> tuple[Ascent, None]:
            starts = self.starts(key)

            def value(policy: PolicyNetwork) -> Array:
                return mean_return(reward, episodes_from(self.game, joint(side, policy, other), starts), self.discount)

            return moved(optimiser, ascent, jax.grad(value)(ascent.policy)), None

        return jax.lax.scan(one_step, ascent, jax.random.split(key, steps))[0]

    def _noisy_returns(
        self,
        policies: Sides[PolicyNetwork],
        rewards: Sides[TransitionReward],
        key: PRNGKeyArray,
        noise: Float[Array, ""] | None,
    ) -> Sides[Float[Array, ""]]:
        """Both sides' discounted returns, the mean over a batch of episodes in which both hands shake by `noise`."""
        start_key, noise_key = jax.random.split(key)
        starts = self.starts(start_key)
        if noise is None:
            episodes = episodes_from(self.game, policies, starts)
        else:
            sizes = self.game.action_size
            shape = (self.batch, self.game.horizon, sizes.learner + sizes.expert)
            shakes = noise * jax.random.normal(noise_key, shape, jnp.float32)

            def episode(start: PyTree, shake: Array) -> Transition:
                ours, theirs = jnp.split(shake, [sizes.learner], axis=1)
                shaking = Sides(NoisyPolicy(policies.learner, ours), NoisyPolicy(policies.expert, theirs))
                return play(self.game, shaking, start)

            episodes = jax.vmap(episode)(starts, shakes)
        return jax.tree.map(lambda reward: mean_return(reward, episodes, self.discount), rewards)

    def responded(self, response: Ascent, gradient: PyTree) -> Ascent:
        """One step of the expert along `gradient`."""
        return moved(self.optimiser.expert, response, gradient)


# Of the same settings the same object, so that a solver made anew compiles nothing anew.
@cache
def _adam(learning_rate: float, steps: int, last_rate: float) -> optax.GradientTransformation:
    rate = optax.cosine_decay_schedule(learning_rate, steps, last_rate)
    return optax.chain(optax.clip_by_global_norm(1.0), optax.adam(rate))


@cache
def _falling(noise: float, half: int) -> optax.Schedule:
    return optax.linear_schedule(noise, 0.0, half, half)


def moved(optimiser: optax.GradientTransformation, ascent: Ascent, gradient: PyTree) -> Ascent:
    """One step of ascent along `gradient`."""
    policy: Any = ascent.policy
    step, remembered = optimiser.update(jax.tree.map(jnp.negative, gradient), ascent.optimiser, policy)
    after: Any = optax.apply_updates(policy, step)
    return Ascent(after, remembered)


def steps_taken(ascent: Ascent) -> Int[Array, ""]:
    """Steps that an ascent's optimiser has made."""
    return optax.tree.get(
        ascent.optimiser, "count", filtering=lambda path, _: path[-1].tuple_name == "ScaleByScheduleState"
    )


def joint(side: Side, policy: PolicyNetwork, other: PolicyNetwork) -> Sides[PolicyNetwork]:
    """The joint policy in which `side` plays `policy` and the other side `other`."""
    return Sides(policy, other) if side == "learner" else Sides(other, policy)


def policies_of(solution: Sides[Ascent]) -> Sides[PolicyNetwork]:
    """The joint policy of a pair of ascents."""
    return Sides(solution.learner.policy, solution.expert.policy)
