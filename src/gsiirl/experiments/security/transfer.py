"""What was learned on one network, put to use on a changed one (`gsiirl transfer`).

The learner takes its r_e and its fitted r_ld along, sees no new demonstration, and searches for the best commitment
anew. The policy is then deployed against the true attacker of the changed network, and judged by the true rewards.
"""

from dataclasses import asdict, dataclass
from functools import partial
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
from gsiirl.experiments.config import config_from_dict
from gsiirl.experiments.security.changes import carried_over, changed
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.base import uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.program.command import command
from gsiirl.program.progress import shown
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.runs import RunFolder, Statistics
from gsiirl.runs.files.atomic import refuse_unwritable
from gsiirl.runs.files.numbers import is_sound
from gsiirl.scenarios import AttackNetwork, read_network
from gsiirl.types import Sides

SEEN = ".lower.memory.kept.counts"
"""Where the checkpoint of a learner that keeps them has (seeds, M, T, S, A_e): how often each answer was seen."""
OTHER_RUN = "give the folder of a finished run of `gsiirl run security`"
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
class Learned:
    """What every seed of a run learned, its policies and, where they are kept, the answers that it saw."""

    folder: RunFolder
    config: SecurityConfig
    network: AttackNetwork
    temperature: float
    seeds: list[int]
    left_out: list[int]
    """Seeds whose rewards or policy are no numbers."""
    weights: Sides[np.ndarray]
    """(n, N + 2 E) of r_ld in reward units, (n, N + E) of r_e in units of the temperature."""
    policies: np.ndarray
    """(n, T, S, A_l)."""
    answers: np.ndarray | None
    """(n, S, A_e): how often each action of the attacker was seen in each state."""

    @classmethod
    def open(cls, path: Path, field: str = "DIR") -> Self:
        """The run in a folder.

        Raises:
            InputError: it holds no run of security that has ended with learned rewards.
        """
        folder = RunFolder.open(path)
        config = config_from_dict(folder.config, path / "config.json")
        if not isinstance(config, SecurityConfig):
            raise InputError(field, f"{path} is a run of {config.experiment}", OTHER_RUN)
        summary = folder.summary()
        if summary is None or not summary.completed:
            raise InputError(field, f"{path} holds a run that is not finished", f"run {command('resume', path)}")
        learned, policies = folder.load_learned(), folder.load_policies()
        if learned is None or policies is None or "learner.table" not in policies:
            raise InputError(field, f"{path} is a run of {config.algorithm}, which keeps no learned reward", OTHER_RUN)
        network = read_network(path / "game.json", config.variant)
        temperature = config.expert_temperature(network)
        # MA-IRL fits a reward of the learner's in place of reading r_ld.
        dependent = "dependent_reward" if "dependent_reward" in learned.arrays else "commitment"
        # Of the others the rewards are in reward units in any case.
        in_units_of_it = config.temperature == "unknown" and config.algorithm in ("gsiirl", "paper")
        unit = 1.0 if in_units_of_it else temperature
        weights = Sides(learned.weights(dependent), learned.weights("expert_reward") / unit)
        kept = zip(weights.learner, weights.expert, policies["learner.table"], strict=True)
        sound = np.array([all(np.all(is_sound(each)) for each in of_seed) for of_seed in kept])
        if not sound.any():
            raise InputError(field, f"{path} holds no seed whose rewards and policy are numbers", OTHER_RUN)
        checkpoint = folder.load_checkpoint()
        seen = None if checkpoint is None else checkpoint.arrays.get(SEEN)
        return cls(
            folder=folder,
            config=config,
            network=network,
            temperature=temperature,
            seeds=[seed for seed, good in zip(summary.seeds, sound.tolist(), strict=True) if good],
            left_out=[seed for seed, good in zip(summary.seeds, sound.tolist(), strict=True) if not good],
            weights=Sides(weights.learner[sound], weights.expert[sound]),
            policies=policies["learner.table"][sound],
            answers=None if seen is None else seen.sum(axis=(1, 2))[sound],
        )


def transferred(learned: Learned, changes: list[str], beside: Learned | None, quiet: bool = False) -> dict[str, Any]:
    """Take a run, and another one beside it, through every change; writes and returns `transfer.json`.

    Raises:
        InputError: a change cannot be made, or the other run is of another game.
    """
    if beside is not None and not _same_game(learned, beside):
        raise InputError("--beside", f"{beside.folder.path} is a run of another game", "give one of the same network")
    networks = {change: changed(learned.network, change) for change in changes}
    models, names = [learned.weights], [learned.config.algorithm]
    if beside is not None:
        name = beside.config.algorithm if beside.config.algorithm != names[0] else f"{names[0]}, beside"
        models.append(beside.weights)
        names.append(name)
        # The learner's own losses can be read: whose attacker is the better one is told by r_e alone.
        fitted = np.repeat(learned.weights.learner.mean(axis=0, keepdims=True), len(beside.seeds), axis=0)
        models.append(Sides(fitted, beside.weights.expert))
        names.append(f"{name}, r_e alone")
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"), shown(quiet) as progress:
        before = World.of(learned.network, learned.config, learned.temperature)
        found = [
            {"change": change, **judged(before, learned, network, models, names)}
            for change, network in progress.track(networks.items(), description="changed networks")
        ]
    result = {
        "experiment": "security",
        "algorithm": learned.config.algorithm,
        "seeds": learned.seeds,
        "beside": None if beside is None else {"algorithm": beside.config.algorithm, "seeds": beside.seeds},
        "changes": found,
        "all_changes": _over_changes(found),
    }
    with refuse_unwritable(str(learned.folder.path), learned.folder.path, "make room or allow it, then try again"):
        learned.folder.write_transfer(result)
    return result


def _same_game(one: Learned, other: Learned) -> bool:
    same = one.folder.game == other.folder.game and one.temperature == other.temperature
    return same and one.config.discount == other.config.discount


def judged(
    before: World, learned: Learned, network: AttackNetwork, models: list[Sides[np.ndarray]], names: list[str]
) -> dict[str, Any]:
    """Every row of one changed network: what is deployed earns, and what it misses."""
    world = World.of(network, learned.config, learned.temperature)
    weights = [jax.tree.map(lambda leaf: carried_over(leaf, learned.network, network), model) for model in models]
    true = jax.tree.map(lambda leaf: np.asarray(leaf)[None], world.true)
    every = jax.tree.map(lambda *leaves: jnp.asarray(np.concatenate(leaves)), true, *weights)
    searched = np.asarray(_committed(world, every, jax.random.key(SEARCH_KEY)))
    ends = np.cumsum([1, *(len(each.expert) for each in weights)])
    groups = dict(zip(["true rewards", *names], np.split(searched, ends[:-1]), strict=True))
    if learned.answers is not None:
        clones = kept_where_same(learned.answers, before.game, world.game, "expert")
        groups["clone"] = np.asarray(_against_clones(world, weights[0].learner, jnp.asarray(clones)))
    groups["policy unchanged"] = kept_where_same(learned.policies, before.game, world.game, "learner")
    groups["random"] = np.asarray(uniform_policy(world.game))[None]
    values = np.asarray(_worth(world, jnp.asarray(np.concatenate(list(groups.values())))))
    parts = np.split(values, np.cumsum([len(each) for each in groups.values()])[:-1], axis=1)
    return {"states": world.game.number_of_states, "rows": _rows(dict(zip(groups, parts, strict=True)))}


def _rows(values: dict[str, np.ndarray]) -> dict[str, Any]:
    """Statistics over seeds of discounted and undiscounted returns [2, n], and of the regret to the first row."""
    best, random = values["true rewards"][0, 0], values["random"][0, 0]
    span = best - random
    # Where nothing can be won there is nothing to miss.
    share = 100.0 / span if span > 1e-9 * max(1.0, abs(best)) else 0.0
    return {
        name: {
            "discounted_return": asdict(Statistics.of(each[0])),
            "return": asdict(Statistics.of(each[1])),
            "regret": asdict(Statistics.of(best - each[0])),
            "regret_percent": asdict(Statistics.of(share * (best - each[0]))),
        }
        for name, each in values.items()
    }


def _over_changes(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Of every row the regret in per cent, over all seeds and changes: mean, median, 90 % and the worst."""
    together: dict[str, list[float]] = {}
    for each in found:
        for name, row in each["rows"].items():
            together.setdefault(name, []).extend(row["regret_percent"]["per_seed"])
    return {
        name: {
            "mean": float(np.mean(regrets)),
            "median": float(np.median(regrets)),
            "ninety_percent": float(np.quantile(regrets, 0.9)),
            "worst": float(np.max(regrets)),
        }
        for name, regrets in together.items()
    }


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


@partial(jax.jit, compiler_options=QUICKLY)
def _committed(world: World, weights: Sides[Float[Array, "n m"]], key: PRNGKeyArray) -> Float[Array, "n T S A_l"]:
    """The upper level for n beliefs about both rewards."""

    def one(believed: Sides[Float[Array, " m"]]) -> Float[Array, "T S A_l"]:
        reward = world.features.expert.payoff(believed.expert)
        return best_commitment(world.commitment(believed.learner), reward, key)

    return jax.lax.map(one, weights)


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
