r"""How soon `pathwise` is as strong at physical deception as a peer's MADDPG at its end.

    XLA_FLAGS="--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1" taskset -c 0 \
        python benchmarks/deception_time_to_strength.py --run pathwise=FOLDER --run maddpg=FOLDER --peer peer.npz

The strength of a side is its mean return against a panel of opponents: those of the runs and the peer's, as
`benchmarks/deception_cross_play.py` plays them. `pathwise` learns as `gsiirl run deception --algorithm marl` does, from
a seed of its own; the clock stands still while its strength is measured, every 50 steps. It is there as soon as both
sides are at least as strong as the peer's at its end, and there for good once neither is weaker at any later
measurement. Times are those of the clock and, since others may use the machine, of the processor.
"""

import argparse
import time
from collections.abc import Iterable
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from deception_cross_play import CONFIG, JUDGE, cross_play, last_of, policies_of_peer, sides_from
from jaxtyping import PyTree

from gsiirl.equilibria.pathwise import policies_of
from gsiirl.types import Sides

CHUNK = 50
SHOWN = (50, 100, 200, 500, 1000, 2000, 5000)


def strengths(policies: Sides[PyTree], panel: Iterable[Sides[PyTree]]) -> np.ndarray:
    """Returns [side, policy] of good agents and adversary, for all policies along a leading axis."""
    against = [
        (
            jnp.mean(cross_play(policies.learner, opponents.expert).learner, axis=1),
            jnp.mean(cross_play(opponents.learner, policies.expert).expert, axis=0),
        )
        for opponents in panel
    ]
    return np.mean(against, axis=0)


def clocks() -> np.ndarray:
    """Seconds of the clock, and of the processor in this process."""
    return np.array([time.perf_counter(), time.process_time()])


def row(name: str, steps: str, seconds: np.ndarray, strength: np.ndarray) -> str:
    wall, processor = seconds
    return f"| {name} | {steps} | {wall:.1f} | {processor:.1f} | {strength[0]:.2f} | {strength[1]:.2f} |"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--run", action="append", default=[], metavar="NAME=FOLDER")
    parser.add_argument("--peer", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=100)
    options = parser.parse_args()

    peer = np.load(options.peer)
    panel = list(sides_from(options.run, options.peer).values())
    snapshots = policies_of_peer(peer)
    peer_strengths = strengths(snapshots, panel)
    bar = strengths(last_of(snapshots), panel)[:, 0]
    peer_seconds = np.stack([peer["wall_seconds"], peer["cpu_seconds"]])
    print("| | trained for | seconds | of the processor | good agents | adversary |\n|---|---|---|---|---|---|")
    for place, frames in enumerate(peer["frames"]):
        print(row("peer", f"{frames} frames", peer_seconds[:, place], peer_strengths[:, place]))

    trainer, rewards = JUDGE.true.trainer, JUDGE.true.rewards
    key, init_key = jax.random.split(jax.random.key(options.seed))
    state = trainer.init(init_key)
    began = clocks()
    ascend = jax.jit(lambda state, key: trainer.ascend(state, rewards, key, CHUNK)[0])
    advance = ascend.lower(state, key).compile()
    compilation, seconds, history = clocks() - began, np.zeros(2), []
    for chunk in range(1, CONFIG.training_steps // CHUNK + 1):
        began = clocks()
        state = jax.block_until_ready(advance(state, jax.random.fold_in(key, chunk)))
        seconds = seconds + clocks() - began
        strength = strengths(jax.tree.map(lambda leaf: leaf[None], policies_of(state)), panel)[:, 0]
        history.append((seconds, bool(np.all(strength >= bar))))
        if chunk * CHUNK in SHOWN:
            print(row("pathwise", f"{chunk * CHUNK} steps", seconds, strength))

    print(f"\nCompilation of pathwise {compilation[0]:.1f} s, of the processor {compilation[1]:.1f} s.\n")
    print("| as strong as the peer at its end | | seconds | of the processor | times sooner | by the processor |")
    print("|---|---|---|---|---|---|")
    strong = [each for _, each in history]
    places = {"first": strong.index(True)} if any(strong) else {}
    if strong[-1]:
        places["for good"] = max((place + 1 for place, each in enumerate(strong) if not each), default=0)
    for name, place in places.items():
        for how, took in (("without", history[place][0]), ("with", history[place][0] + compilation)):
            figures = " | ".join(f"{figure:.1f}" for figure in (*took, *peer_seconds[:, -1] / took))
            print(f"| {name}, after {CHUNK * (place + 1)} steps | {how} compilation | {figures} |")


if __name__ == "__main__":
    main()
