"""MADDPG (Lowe et al. 2017, Algorithm 1) for the two sides of a continuous game.

Each side i has an actor μ_i(o_i, t), which acts on what the side observes, and a critic Q_i(x, a, t), which sees the
whole state of the game, x, and both sides' actions. From steps (s, a, s') at time t, drawn from a replay, and target
networks Q', μ', an update is

    y_i = r_i(s, a, s') + γ [t + 1 < T] Q'_i(x', μ'(o', t + 1), t + 1)
    critic:   descend  E (Q_i(x, a, t) − y_i)²
    actor:    descend  −E Q_i(x, (μ_i(o_i, t), a_−i), t) + ρ E mean(μ_i²)
    targets:  θ' ← (1 − κ) θ' + κ θ

The settings are those of the authors' code (openai/maddpg), with these differences:

- the actors are deterministic, in (−1, 1) by tanh, and explore by Gaussian noise on the action, clipped to [−1, 1],
  whose scale falls with the number of updates; the authors sample a Gaussian of learnt variance, in target actions too;
- ρ = 0.03 weighs squared actions; their 1e-3, the squared outputs before squashing, which grow far above 1;
- x is the observations and the numbers of the state (the paper allows it), not the observations alone: in physical
  deception nobody observes velocities, and without them in x actors learn to overshoot;
- the horizon is finite, so that time is an input and the last step bootstraps nothing; theirs bootstraps through it;
- Adam's step is 1e-3, not 1e-2, which drives actors to the bounds of the actions;
- both sides learn from the same batch, once for every step of all environments, and only then; theirs after every 100
  steps of one environment, from a batch each.
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray, PyTree

from gsiirl.baselines.replay import Experience, Replay
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.games.rollout import initial_states
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides, Transition


class Critic(eqx.Module):
    """Q(x, a, t/T): a network of two hidden ReLU layers."""

    layers: tuple[eqx.nn.Linear, ...]

    @classmethod
    def create(cls, view_size: int, action_sizes: Sides[int], hidden: int, key: PRNGKeyArray) -> "Critic":
        """Random weights; one more input than is seen and done, for the time."""
        sizes = (view_size + action_sizes.learner + action_sizes.expert + 1, hidden, hidden, 1)
        keys = jax.random.split(key, len(sizes) - 1)
        return cls(
            tuple(
                eqx.nn.Linear(inputs, outputs, dtype=jnp.float32, key=one)
                for inputs, outputs, one in zip(sizes[:-1], sizes[1:], keys, strict=True)
            )
        )

    def __call__(
        self, view: Float[Array, " x"], actions: Sides[Float[Array, "..."]], time: Float[Array, ""]
    ) -> Float[Array, ""]:
        value = jnp.concatenate([view, actions.learner, actions.expert, time[None]])
        for layer in self.layers[:-1]:
            value = jax.nn.relu(layer(value))
        return self.layers[-1](value)[0]


class Networks(eqx.Module):
    """Both actors, and both critics as one `Critic` whose arrays have a leading axis: learner, expert."""

    actors: Sides[PolicyNetwork]
    critics: Critic


class Optimisers(eqx.Module):
    """What the optimiser remembers of each actor, and of the critics (with their leading axis)."""

    actors: Sides[Any]
    critics: Any


class MaddpgState(eqx.Module):
    """All that changes in training."""

    networks: Networks
    targets: Networks
    optimisers: Optimisers
    replay: Replay
    updates: Int[Array, ""]
    """How many updates there were."""

    @property
    def policies(self) -> Sides[PolicyNetwork]:
        """What both sides have learnt to play, without exploration."""
        return self.networks.actors


class Maddpg(eqx.Module):
    """The solver: settings, and pure functions from state to state.

    A host loop over any environment is, with E the number of `environments`,

        state = maddpg.init(key)
        actions = jax.vmap(maddpg.act, in_axes=(None, 0, None, 0))(state, observations, time, keys)
        state = maddpg.remember(state, transitions, step)
        state = maddpg.update(state, rewards, key)

    in any rhythm, once something is remembered. It needs of `game` how long an episode is, what a state looks like and
    what is observed of it; how states follow each other is the environment's own matter. `train` is that loop in one
    compiled program, for a game that JAX can step; `vmap` over keys for more seeds.
    """

    game: AbstractContinuousGame
    discount: float = eqx.field(static=True, default=0.95)
    hidden: int = eqx.field(static=True, default=64)
    """Width of the two hidden layers of every network."""
    batch: int = eqx.field(static=True, default=1024)
    """Steps that an update learns from."""
    environments: int = eqx.field(static=True, default=100)
    """Environments E that step together."""
    memory: int = eqx.field(static=True, default=1000)
    """Steps of all environments that are remembered: E times as many single ones."""
    warm_up: int = eqx.field(static=True, default=10)
    """Episodes of all environments before the first update, in `train`."""
    updates_per_step: int = eqx.field(static=True, default=1)
    """Updates after each step of all environments, in `train`."""
    learning_rate: float = eqx.field(static=True, default=1e-3)
    """Adam's step, of actors and critics."""
    largest_gradient: float = eqx.field(static=True, default=0.5)
    """Norm to which the gradient of each network is clipped."""
    target_rate: float = eqx.field(static=True, default=0.01)
    """κ, how far the targets move in an update."""
    action_penalty: float = eqx.field(static=True, default=0.03)
    """Weight of mean squared actions in the actors' losses."""
    first_noise: float = eqx.field(static=True, default=0.5)
    """Standard deviation of exploration at the start, in units of the largest action."""
    last_noise: float = eqx.field(static=True, default=0.1)
    """Standard deviation of exploration after `noisy_updates` updates; linear in between."""
    noisy_updates: int = eqx.field(static=True, default=10_000)

    def init(self, key: PRNGKeyArray) -> MaddpgState:
        """Random networks, and nothing remembered."""
        reset_key, learner_key, expert_key, critic_key = jax.random.split(key, 4)
        start, sizes = self.game.reset(reset_key), self.game.action_size
        observations, view = self.game.observe(start), self.view(start)
        actors = Sides(
            PolicyNetwork.create(observations.learner.size, sizes.learner, self.hidden, learner_key),
            PolicyNetwork.create(observations.expert.size, sizes.expert, self.hidden, expert_key),
        )
        critics = jax.vmap(lambda one: Critic.create(view.size, sizes, self.hidden, one))(jax.random.split(critic_key))
        networks = Networks(actors, critics)
        actions = jax.tree.map(lambda size: jnp.zeros(size, jnp.float32), sizes)
        example = Experience(Transition(start, actions, start), jnp.zeros((), jnp.int32))
        return MaddpgState(
            networks=networks,
            targets=networks,
            optimisers=Optimisers(
                Sides(self._fresh(actors.learner), self._fresh(actors.expert)), jax.vmap(self._fresh)(critics)
            ),
            replay=Replay.create(example, self.memory, self.environments),
            updates=jnp.zeros((), jnp.int32),
        )

    def act(
        self, state: MaddpgState, observations: Sides[Float[Array, "..."]], time: Float[Array, ""], key: PRNGKeyArray
    ) -> Sides[Float[Array, "..."]]:
        """Exploring actions at `time` = t/T: μ_i(o_i, t) + noise, clipped to [−1, 1]; without: `state.policies`."""
        learner_key, expert_key = jax.random.split(key)
        scale = self.noise(state.updates)

        def explore(policy: PolicyNetwork, observation: Array, one: PRNGKeyArray) -> Array:
            action = policy(observation, time)
            return jnp.clip(action + scale * jax.random.normal(one, action.shape, action.dtype), -1.0, 1.0)

        return Sides(
            explore(state.policies.learner, observations.learner, learner_key),
            explore(state.policies.expert, observations.expert, expert_key),
        )

    def noise(self, updates: Int[Array, ""]) -> Float[Array, ""]:
        """Standard deviation of exploration after `updates` updates."""
        share = jnp.minimum(updates.astype(jnp.float32) / self.noisy_updates, 1.0)
        return self.first_noise + share * (self.last_noise - self.first_noise)

    def remember(self, state: MaddpgState, transitions: Transition, step: Int[Array, ""]) -> MaddpgState:
        """With one more transition of each of the E environments, all made at t = `step` of an episode."""
        steps = jnp.full(self.environments, step, jnp.int32)
        return eqx.tree_at(lambda one: one.replay, state, state.replay.add(Experience(transitions, steps)))

    def update(self, state: MaddpgState, rewards: Sides[TransitionReward], key: PRNGKeyArray) -> MaddpgState:
        """A step of each critic and each actor on a batch of what is remembered, as it is rewarded now."""
        return self.learn(state, state.replay.sample(key, self.batch), rewards)

    def learn(self, state: MaddpgState, batch: Experience, rewards: Sides[TransitionReward]) -> MaddpgState:
        """A step of each critic and then of each actor on `batch`; then the targets follow."""
        networks, optimisers = state.networks, state.optimisers
        goals = self.critic_goals(state.targets, batch, rewards)
        slope = jax.grad(lambda critics: jnp.sum(self.critic_losses(critics, batch, goals)))(networks.critics)
        critics, critic_optimisers = jax.vmap(self._descend)(networks.critics, slope, optimisers.critics)
        # A side's loss depends on its own actor alone: the gradient of the sum holds the gradient of each.
        slopes = jax.grad(lambda actors: jnp.sum(self.actor_losses(Networks(actors, critics), batch)))(networks.actors)
        learner, learner_optimiser = self._descend(networks.actors.learner, slopes.learner, optimisers.actors.learner)
        expert, expert_optimiser = self._descend(networks.actors.expert, slopes.expert, optimisers.actors.expert)
        moved = Networks(Sides(learner, expert), critics)
        return MaddpgState(
            networks=moved,
            targets=jax.tree.map(lambda old, new: old + self.target_rate * (new - old), state.targets, moved),
            optimisers=Optimisers(Sides(learner_optimiser, expert_optimiser), critic_optimisers),
            replay=state.replay,
            updates=state.updates + 1,
        )

    def critic_goals(
        self, targets: Networks, batch: Experience, rewards: Sides[TransitionReward]
    ) -> Float[Array, "2 b"]:
        """y_i = r_i(s, a, s') + γ [t + 1 < T] Q'_i(x', μ'(o', t + 1), t + 1), a row for each side."""
        transition, following = batch.transition, batch.time + 1
        reward = jnp.stack([jax.vmap(rewards.learner)(transition), jax.vmap(rewards.expert)(transition)])
        actions = self._actions(targets.actors, transition.following, following)
        values = self._values(targets.critics, transition.following, _for_both(actions), following)
        discounts = jnp.where(following < self.game.horizon, self.discount, 0.0).astype(jnp.float32)
        return reward.astype(jnp.float32) + discounts[None, :] * values

    def critic_losses(self, critics: Critic, batch: Experience, goals: Float[Array, "2 b"]) -> Float[Array, " 2"]:
        """E (Q_i(x, a, t) − y_i)²."""
        transition = batch.transition
        values = self._values(critics, transition.state, _for_both(transition.actions), batch.time)
        return jnp.mean((values - goals) ** 2, axis=1)

    def actor_losses(self, networks: Networks, batch: Experience) -> Float[Array, " 2"]:
        """−E Q_i(x, (μ_i(o_i, t), a_−i), t) + ρ E mean(μ_i²)."""
        taken = batch.transition.actions
        own = self._actions(networks.actors, batch.transition.state, batch.time)
        actions = Sides(jnp.stack([own.learner, taken.learner]), jnp.stack([taken.expert, own.expert]))
        values = self._values(networks.critics, batch.transition.state, actions, batch.time)
        efforts = jnp.stack([jnp.mean(own.learner**2), jnp.mean(own.expert**2)])
        return self.action_penalty * efforts - jnp.mean(values, axis=1)

    @eqx.filter_jit
    def train(self, rewards: Sides[TransitionReward], key: PRNGKeyArray, episodes: int) -> MaddpgState:
        """From nothing: `warm_up` episodes of all environments to remember, then `episodes` to learn from."""
        init_key, warm_up_key, train_key = jax.random.split(key, 3)
        state = self._play(self.init(init_key), rewards, warm_up_key, self.warm_up, 0)
        return self.go_on(state, rewards, train_key, episodes)

    def go_on(
        self, state: MaddpgState, rewards: Sides[TransitionReward], key: PRNGKeyArray, episodes: int
    ) -> MaddpgState:
        """`episodes` more episodes of all environments, with updates; the rewards may have changed meanwhile."""
        return self._play(state, rewards, key, episodes, self.updates_per_step)

    def view(self, state: PyTree) -> Float[Array, " x"]:
        """x, what critics see of a state of the game: both observations and all numbers of the state."""
        observations = self.game.observe(state)
        numbers = [leaf.astype(jnp.float32).reshape(-1) for leaf in jax.tree.leaves(state)]
        return jnp.concatenate([observations.learner, observations.expert, *numbers])

    def _play(
        self, state: MaddpgState, rewards: Sides[TransitionReward], key: PRNGKeyArray, episodes: int, updates: int
    ) -> MaddpgState:
        """`episodes` episodes of all environments, with so many updates after every step."""
        game = self.game

        def one_step(carry: tuple[MaddpgState, PyTree], inputs: tuple[Array, PRNGKeyArray]) -> tuple[Any, None]:
            (state, now), (step, step_key) = carry, inputs
            act_key, update_key = jax.random.split(step_key)
            actions = jax.vmap(self.act, in_axes=(None, 0, None, 0))(
                state,
                jax.vmap(game.observe)(now),
                _share(step, game.horizon),
                jax.random.split(act_key, self.environments),
            )
            following = jax.vmap(game.step)(now, actions)
            state = self.remember(state, Transition(now, actions, following), step)
            state, _ = jax.lax.scan(
                lambda one, one_key: (self.update(one, rewards, one_key), None),
                state,
                jax.random.split(update_key, updates),
            )
            return (state, following), None

        def one_episode(state: MaddpgState, episode_key: PRNGKeyArray) -> tuple[MaddpgState, None]:
            reset_key, play_key = jax.random.split(episode_key)
            starts = initial_states(game, reset_key, self.environments)
            steps = jnp.arange(game.horizon, dtype=jnp.int32)
            (state, _), _ = jax.lax.scan(one_step, (state, starts), (steps, jax.random.split(play_key, game.horizon)))
            return state, None

        return jax.lax.scan(one_episode, state, jax.random.split(key, episodes))[0]

    def _actions(
        self, actors: Sides[PolicyNetwork], states: PyTree, steps: Int[Array, " b"]
    ) -> Sides[Float[Array, "..."]]:
        observations, time = jax.vmap(self.game.observe)(states), _share(steps, self.game.horizon)
        return Sides(
            jax.vmap(actors.learner)(observations.learner, time), jax.vmap(actors.expert)(observations.expert, time)
        )

    def _values(
        self, critics: Critic, states: PyTree, actions: Sides[Float[Array, "..."]], steps: Int[Array, " b"]
    ) -> Float[Array, "2 b"]:
        """Q_i(x, a, t) of both critics, each with actions of its own: `actions` have leading axes 2 and b."""
        views, time = jax.vmap(self.view)(states), _share(steps, self.game.horizon)
        return jax.vmap(lambda critic, own: jax.vmap(critic)(views, own, time))(critics, actions)

    @property
    def _optimiser(self) -> optax.GradientTransformation:
        return optax.chain(optax.clip_by_global_norm(self.largest_gradient), optax.adam(self.learning_rate))

    def _fresh(self, network: Any) -> Any:
        """What the optimiser remembers of a network that has not moved."""
        return self._optimiser.init(network)

    def _descend(self, network: Any, slope: Any, remembered: Any) -> tuple[Any, Any]:
        """One network a step down its gradient."""
        step, remembered = self._optimiser.update(slope, remembered, network)
        return optax.apply_updates(network, step), remembered


def _for_both(actions: Sides[Float[Array, "..."]]) -> Sides[Float[Array, "..."]]:
    """The same actions for each of the two critics."""
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf[None], (2, *leaf.shape)), actions)


def _share(steps: Int[Array, "*b"], horizon: int) -> Float[Array, "*b"]:
    """t/T."""
    return steps.astype(jnp.float32) / horizon
