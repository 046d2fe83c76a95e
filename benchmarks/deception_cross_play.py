"""Who beats whom at physical deception: every good agents' side against every adversary.

    python benchmarks/deception_cross_play.py --run pathwise=FOLDER --run maddpg=FOLDER --peer peer.npz

A folder is one that `gsiirl run deception --algorithm marl` has filled, peer.npz what `benchmarks/peer_maddpg.py`
writes. All pairs play from the initial states that runs are measured on. A figure is the mean over these and over all
pairs of a seed of one run and a seed of the other, so that in a run against itself few of the pairs have learned
together.
"""

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PyTree

from gsiirl.experiments.continuous.judge import Judge
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.deception.mpe2_evaluation import PlayedRun
from gsiirl.experiments.deception.problem import build
from gsiirl.games import play
from gsiirl.types import Sides

CONFIG = DeceptionConfig(algorithm="marl").resolved()
JUDGE = Judge(CONFIG, build(CONFIG))
"""Holds the initial states that runs are measured on as well."""
LAYERS = 3


class StoredPolicy(eqx.Module):
    """A network as its weights, with a tanh at its end; each of `members` acts on its share of what is observed."""

    weights: tuple[Float[Array, "..."], ...]
    biases: tuple[Float[Array, "..."], ...]
    activation: Callable[[Array], Array] = eqx.field(static=True)
    members: int = eqx.field(static=True, default=1)

    def __call__(self, observation: Float[Array, " o"], time: Float[Array, ""]) -> Float[Array, " A"]:
        return jax.vmap(partial(self._act, time))(observation.reshape(self.members, -1)).ravel()

    def _act(self, time: Array, observation: Array) -> Array:
        value = jnp.append(observation, time)
        for layer in range(LAYERS):
            value = self.weights[layer] @ value + self.biases[layer]
            value = self.activation(value) if layer < LAYERS - 1 else jnp.tanh(value)
        return value


def policies_of_run(folder: Path) -> Sides[StoredPolicy]:
    """Both sides' policies as a run learned them together (the pair `model`), along a leading axis of seeds."""
    run = PlayedRun.open(folder)
    if run.config.horizon != CONFIG.horizon:
        raise SystemExit(f"{folder} has episodes of {run.config.horizon} steps, not of {CONFIG.horizon}")

    def stored(name: str) -> StoredPolicy:
        weights, biases = (
            tuple(jnp.asarray(run.weights[f"{name}.layers.{layer}.{part}"]) for layer in range(LAYERS))
            for part in ("weight", "bias")
        )
        return StoredPolicy(weights, biases, jnp.tanh)

    return Sides(stored("learner"), stored("expert"))


def policies_of_peer(arrays: Mapping[str, np.ndarray]) -> Sides[StoredPolicy]:
    """Both sides' policies of the peer along a leading axis of snapshots: ReLU, one network for both good agents."""

    def stored(group: str, members: int) -> StoredPolicy:
        names = [f"{group}/module.0.mlp.params.{2 * layer}" for layer in range(LAYERS)]
        weights = [arrays[f"{name}.weight"] for name in names]
        biases = [arrays[f"{name}.bias"] for name in names]
        # A column of zeros for the time, which it does not see.
        weights[0] = np.pad(weights[0], [(0, 0)] * (weights[0].ndim - 1) + [(0, 1)])
        return StoredPolicy(
            tuple(jnp.asarray(weight.reshape(-1, *weight.shape[-2:])) for weight in weights),
            tuple(jnp.asarray(bias.reshape(-1, bias.shape[-1])) for bias in biases),
            jax.nn.relu,
            members,
        )

    return Sides(stored("agent", 2), stored("adversary", 1))


def last_of(policies: PyTree) -> PyTree:
    """The last along the leading axis, which stays."""
    return jax.tree.map(lambda leaf: leaf[-1:], policies)


@eqx.filter_jit
def cross_play(agents: PyTree, adversaries: PyTree) -> Sides[Float[Array, "agents adversaries"]]:
    """Mean undiscounted returns of good agents and adversary, for all pairs along their leading axes."""

    def of_pair(learner: Callable, expert: Callable) -> Sides[Array]:
        episodes = jax.vmap(lambda start: play(JUDGE.true.game, Sides(learner, expert), start))(JUDGE.true.starts)
        return JUDGE.true.returns(episodes)

    return jax.vmap(lambda learner: jax.vmap(partial(of_pair, learner))(adversaries))(agents)


def table(sides: Mapping[str, Sides[StoredPolicy]]) -> str:
    """Agents' return / adversary's return in Markdown, and what either comes to on average over its opponents."""
    returns = {
        (row, column): jax.tree.map(
            lambda values: float(jnp.mean(values)), cross_play(sides[row].learner, sides[column].expert)
        )
        for row in sides
        for column in sides
    }
    lines = [f"| good agents \\ adversary | {' | '.join(sides)} | agents' mean |", "|---" * (len(sides) + 2) + "|"]
    for row in sides:
        cells = [f"{returns[row, column].learner:.2f} / {returns[row, column].expert:.2f}" for column in sides]
        mean = np.mean([returns[row, column].learner for column in sides])
        lines.append(f"| {row} | {' | '.join(cells)} | {mean:.2f} |")
    means = [f"{np.mean([returns[row, column].expert for row in sides]):.2f}" for column in sides]
    return "\n".join([*lines, f"| adversary's mean | {' | '.join(means)} | |"])


def sides_from(runs: list[str], peer: Path | None) -> dict[str, Sides[StoredPolicy]]:
    """The policies of NAME=FOLDER runs, and of the peer as it ended."""
    sides = {name: policies_of_run(Path(folder)) for name, _, folder in (run.partition("=") for run in runs)}
    return sides | ({} if peer is None else {"peer": last_of(policies_of_peer(np.load(peer)))})


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--run", action="append", default=[], metavar="NAME=FOLDER")
    parser.add_argument("--peer", type=Path)
    options = parser.parse_args()
    sides = sides_from(options.run, options.peer)
    print(table(sides))
    seeds = ", ".join(f"{name} {policies.learner.biases[0].shape[0]}" for name, policies in sides.items())
    episodes, horizon = CONFIG.evaluation_episodes, CONFIG.horizon
    print(f"\nMeans over {episodes} episodes of {horizon} steps and all pairs of seeds: {seeds}.")


if __name__ == "__main__":
    main()
