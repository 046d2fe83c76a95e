"""What was learned on one network, put to use on a changed one (`gsiirl transfer`).

The learner takes its r_e and its fitted r_ld along, sees no new demonstration, and searches for the best commitment
anew. The policy is then deployed against the true attacker of the changed network, and judged by the true rewards.
"""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.commitment import Commitment
from gsiirl.commitment.anew import best_answer, best_commitment
from gsiirl.compilation import QUICKLY
from gsiirl.errors import InputError
from gsiirl.experiments.security.changes import carried_over, changed, drawn
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.transfer.learned import OTHER_RUN, AbstractLearned, Judged, Kept, Model
from gsiirl.experiments.transfer.regret import RANDOM, TRUE, UNCHANGED
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.base import uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.program.cores import cores
from gsiirl.program.progress import Told, nobody
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.scenarios import AttackNetwork, read_network
from gsiirl.types import Sides

SEEN = ".lower.memory.kept.counts"
"""Where the checkpoint of a learner that keeps them has (seeds, M, T, S, A_e): how often each answer was seen."""
SEARCH_KEY = 0
"""All searches on a changed network begin from the same starts, those with the true rewards too."""


class World(eqx.Module):
    """A network's game with both true rewards, as weights of features; r_e is in units of the temperature."""

    game: AttackGraph
    own_reward: AbstractPayoff
    features: Sides[AbstractFeatures]
    true: Sides[Float[Array, " m"]]
    discount: float

    @classmethod
    def of(cls, network: AttackNetwork, config: SecurityConfig, temperature: float) -> Self:
        """The game of a network with the settings of a run."""
        game = AttackGraph.create(
            network, config.horizon, learner_no_op=config.learner_no_op, expert_no_op=config.expert_no_op
        )
        return cls(
            game=game,
            own_reward=rewards.own_reward(game, network),
            features=Sides(rewards.commitment_features(game), rewards.attack_features(game)),
            true=Sides(
                jnp.asarray(rewards.dependent_weights(network)),
                jnp.asarray(rewards.expert_weights(network) / temperature),
            ),
            discount=config.discount,
        )

    def commitment(self, dependent: Float[Array, " m"]) -> Commitment:
        """f with r_ld of these weights."""
        return Commitment(self.game, self.features.learner.payoff(dependent) + self.own_reward, self.discount)


@dataclass(frozen=True)
class Learned(AbstractLearned):
    """What every seed of a run learned, its policies and, where they are kept, the answers that it saw.

    `weights` are (n, N + 2 E) of r_ld in reward units, and (n, N + E) of r_e in units of the temperature. `policies`
    are tables (n, T, S, A_l).
    """

    config: SecurityConfig
    network: AttackNetwork
    temperature: float
    answers: np.ndarray | None
    """(n, S, A_e): how often each action of the attacker was seen in each state."""

    @classmethod
    def open(cls, path: Path, field: str = "DIR") -> Self:
        """The run in a folder.

        Raises:
            InputError: it holds no run of security that has ended with learned rewards.
        """
        kept = Kept.open(path, field)
        config = kept.config
        if not isinstance(config, SecurityConfig):
            raise InputError(field, f"{path} is a run of {config.experiment}", OTHER_RUN)
        if "learner.table" not in kept.policies:
            raise InputError(field, f"{path} is a run of {config.algorithm}, which keeps no learned reward", OTHER_RUN)
        network = read_network(path / "game.json", config.variant)
        temperature = config.expert_temperature(network)
        # Of the others the rewards are in reward units in any case.
        in_units_of_it = config.temperature == "unknown" and config.algorithm in ("gsiirl", "paper")
        unit = 1.0 if in_units_of_it else temperature
        weights = Sides(kept.learned.weights(kept.dependent), kept.learned.weights("expert_reward") / unit)
        policies = kept.policies["learner.table"]
        sound = kept.sound(field, weights.learner, weights.expert, policies)
        seeds, left_out = kept.parted(sound)
        checkpoint = kept.folder.load_checkpoint()
        seen = None if checkpoint is None else checkpoint.arrays.get(SEEN)
        return cls(
            folder=kept.folder,
            seeds=seeds,
            left_out=left_out,
            config=config,
            network=network,
            temperature=temperature,
            weights=Sides(weights.learner[sound], weights.expert[sound]),
            policies=policies[sound],
            answers=None if seen is None else seen.sum(axis=(1, 2))[sound],
        )

    @cached_property
    def world(self) -> World:
        """The network before any change."""
        return World.of(self.network, self.config, self.temperature)

    def drawn(self, number: int, seed: int) -> list[str]:
        return drawn(self.network, number, seed)

    def is_of_the_same_game(self, other: AbstractLearned) -> bool:
        if not isinstance(other, Learned):
            return False
        same = self.folder.game == other.folder.game and self.temperature == other.temperature
        return same and self.config.discount == other.config.discount

    def judge(self, changes: list[str], models: Mapping[str, Model]) -> Callable[[str, Told], Judged]:
        networks = {change: changed(self.network, change) for change in changes}

        def judge(change: str, tell: Told) -> Judged:
            with double_precision():
                return judged(self, networks[change], models, tell)

        return judge


def judged(learned: Learned, network: AttackNetwork, models: Mapping[str, Model], tell: Told = nobody) -> Judged:
    """Every row of one changed network: what is deployed earns there."""
    before, world = learned.world, World.of(network, learned.config, learned.temperature)

    def carried(leaf: np.ndarray) -> np.ndarray:
        return carried_over(leaf, learned.network, network)

    weights = {name: jax.tree.map(carried, model.weights) for name, model in models.items()}
    true = jax.tree.map(lambda leaf: np.asarray(leaf)[None], world.true)
    every = jax.tree.map(lambda *leaves: np.concatenate(leaves), true, *weights.values())
    searched = _searched(world, every, tell)
    ends = np.cumsum([1, *(len(each.expert) for each in weights.values())])
    policies = dict(zip([TRUE, *weights], np.split(searched, ends[:-1]), strict=True))
    if learned.answers is not None:
        clones = kept_where_same(learned.answers, before.game, world.game, "expert")
        fitted = carried(learned.weights.learner)
        policies["clone"] = np.asarray(_against_clones(world, fitted, jnp.asarray(clones)))
    policies[UNCHANGED] = kept_where_same(learned.policies, before.game, world.game, "learner")
    policies[RANDOM] = np.asarray(uniform_policy(world.game))[None]
    values = np.asarray(_worth(world, jnp.asarray(np.concatenate(list(policies.values())))))
    ends = np.cumsum([len(each) for each in policies.values()])
    returns = dict(zip(policies, np.split(values, ends[:-1], axis=1), strict=True))
    return Judged({"states": world.game.number_of_states}, returns)


def kept_where_same(table: np.ndarray, before: AttackGraph, after: AttackGraph, side: str) -> np.ndarray:
    """A side's policies (or counts of its actions) (..., S, A) of one game, as policies of another.

    States are the same where the same nodes are compromised, actions where they are of the same edge. What was chosen
    and is gone is left out. Elsewhere, and where nothing is left, all actions are alike.
    """
    no_op = getattr(before.no_op, side)
    states = _places([tuple(np.ravel(mask)) for mask in np.asarray(before.masks)])
    actions = _places([*before.edge_names, *(["no-op"] if no_op else [])])
    state_of = [states.get(tuple(np.ravel(mask)), -1) for mask in np.asarray(after.masks)]
    action_of = [actions.get(name, -1) for name in [*after.edge_names, *(["no-op"] if no_op else [])]]
    # A row and a column of nothing, for what was not there.
    padded = np.pad(table, [(0, 0)] * (table.ndim - 2) + [(0, 1), (0, 1)])
    kept = padded[..., state_of, :][..., action_of]
    total = kept.sum(axis=-1, keepdims=True)
    return np.where(total > 0, kept / np.where(total > 0, total, 1.0), 1.0 / kept.shape[-1])


def _places(names: list[Any]) -> dict[Any, int]:
    return {name: place for place, name in enumerate(names)}


def _searched(world: World, weights: Sides[np.ndarray], tell: Told) -> np.ndarray:
    """The upper level for n beliefs (n, m) about both rewards, on all cores: policies (n, T, S, A_l)."""
    pairs = zip(weights.learner, weights.expert, strict=True)
    believed = [Sides(jnp.asarray(dependent), jnp.asarray(expert)) for dependent, expert in pairs]
    tell(0, len(believed))

    def search(each: Sides[Float[Array, " m"]]) -> np.ndarray:
        with double_precision():  # which holds for one thread
            return np.asarray(_committed(world, each, jax.random.key(SEARCH_KEY)))

    first = search(believed[0])  # alone: it compiles the program of all
    tell(1, len(believed))
    with ThreadPoolExecutor(len(cores())) as pool:
        others = [pool.submit(search, each) for each in believed[1:]]
        try:
            for done, each in enumerate(as_completed(others), 2):
                each.result()
                tell(done, len(believed))
        finally:
            for each in others:
                each.cancel()
    return np.stack([first, *(each.result() for each in others)])


@contextmanager
def double_precision() -> Iterator[None]:
    """Inside, numbers are of 64 bits."""
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        yield


@partial(jax.jit, compiler_options=QUICKLY)
def _committed(world: World, believed: Sides[Float[Array, " m"]], key: PRNGKeyArray) -> Float[Array, "T S A_l"]:
    """The upper level for one belief about both rewards."""
    reward = world.features.expert.payoff(believed.expert)
    return best_commitment(world.commitment(believed.learner), reward, key)


@jax.jit
def _against_clones(
    world: World, dependent: Float[Array, "n m"], clones: Float[Array, "n S A_e"]
) -> Float[Array, "n T S A_l"]:
    """The best answers to attackers that play as they were seen to, whatever the defender does."""

    def one(weights: Array, clone: Array) -> Array:
        always = jnp.broadcast_to(clone, (world.game.horizon, *clone.shape))
        return best_answer(world.commitment(weights), always)

    return jax.vmap(one)(dependent, clones)


@jax.jit
def _worth(world: World, policies: Float[Array, "n T S A_l"]) -> Float[Array, "2 n"]:
    """What n policies earn against the true attacker's answers, under the true rewards: discounted, and not."""
    commitment, reward = world.commitment(world.true.learner), world.features.expert.payoff(world.true.expert)
    discounted = jax.lax.map(lambda policy: commitment.value(policy, reward), policies)
    return jnp.stack([discounted, jax.lax.map(lambda policy: commitment.value(policy, reward, discount=1.0), policies)])
