# pyright: reportMissingImports=false
"""Train a peer's MADDPG (BenchMARL on VMAS) at physical deception as mpe2 steps it, and keep its policies.

    pip install benchmarl vmas        (in an environment of its own: gsiirl does not depend on them)
    python benchmarks/peer_maddpg.py --out peer.npz [--frames 600000] [--every 50000] [--threads 1]

VMAS has `simple_adversary`, but with a force of 1 · action where mpe2's is 5 ·, with the position moved after the
velocity rather than before, and with one target for all environments, drawn once; this is put right here. What is
observed and paid is mpe2's already. Sizes, learning rate, discount and targets' rate are those of
`gsiirl.baselines.maddpg`, the rest BenchMARL's defaults. Both sides are updated once for every 50 frames: with half as
many updates, the good agents of seed 0 did not learn.

peer.npz holds the weights of both groups after every `--every` frames along a leading axis, the last ones at its end,
and `frames`, `wall_seconds` and `cpu_seconds` until then.
"""

import argparse
import copy
import tempfile
import time
from typing import Any

import numpy as np
import torch
from benchmarl.algorithms import MaddpgConfig
from benchmarl.environments import VmasTask
from benchmarl.environments.vmas.common import VmasClass
from benchmarl.experiment import Callback, Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torchrl.envs.libs.vmas import VmasEnv
from vmas.scenarios.mpe.simple_adversary import Scenario
from vmas.simulator.core import World

HORIZON, ENVIRONMENTS, FORCE = 25, 100, 5.0


class Mpe2World(World):
    """Moves the position by the velocity before the force, as mpe2 does."""

    def _integrate_state(self, entity, substep):
        if entity.movable:
            state, step = entity.state, self._sub_dt
            state.pos = state.pos + state.vel * step
            state.vel = state.vel * (1 - self._drag) + self.forces_dict[entity] / entity.mass * step


class Target:
    """Stands in for the goal landmark that the scenario reads `state.pos` of: another one in every environment."""

    size = 0.08

    def __init__(self, world, which):
        self.world, self.which = world, which

    @property
    def state(self):
        return self

    @property
    def pos(self):
        places = torch.stack([landmark.state.pos for landmark in self.world.landmarks], dim=1)
        return places[torch.arange(len(self.which)), self.which]


class Mpe2Scenario(Scenario):
    def make_world(self, batch_dim, device, **kwargs):
        world = super().make_world(batch_dim, device, **kwargs)
        world.__class__ = Mpe2World
        self.which = torch.zeros(batch_dim, dtype=torch.long)
        for agent in world.agents:
            agent.action._u_multiplier = FORCE
        return world

    def reset_world_at(self, env_index=None):
        super().reset_world_at(env_index)
        drawn = slice(None) if env_index is None else slice(env_index, env_index + 1)
        self.which[drawn] = torch.randint(0, 2, self.which[drawn].shape)
        for agent in self.world.agents:
            agent.goal = Target(self.world, self.which)


class Task(VmasClass):
    def get_env_fun(self, num_envs, continuous_actions, seed, device):
        settings = {
            "num_envs": num_envs,
            "continuous_actions": continuous_actions,
            "seed": seed,
            "device": device,
            "clamp_actions": True,
            **copy.deepcopy(self.config),
        }
        return lambda: VmasEnv(scenario=Mpe2Scenario(), **settings)


class Snapshots(Callback):
    """The policies, and the time they took, after every `every` frames."""

    def __init__(self, every):
        super().__init__()
        self.every, self.taken, self.began = every, [], (time.perf_counter(), time.process_time())

    def on_train_end(self, training_td, group):
        experiment = self.experiment
        if group == list(experiment.train_group_map)[-1] and experiment.total_frames % self.every == 0:
            arrays = {
                f"{group}/{name}": value.detach().numpy().copy()
                for group, policy in experiment.group_policies.items()
                for name, value in policy.state_dict().items()
                if name.endswith((".weight", ".bias"))
            }
            wall, cpu = time.perf_counter() - self.began[0], time.process_time() - self.began[1]
            self.taken.append({**arrays, "frames": experiment.total_frames, "wall_seconds": wall, "cpu_seconds": cpu})


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", required=True)
    parser.add_argument("--frames", type=int, default=600_000)
    parser.add_argument("--every", type=int, default=50_000, help="a divisor of --frames, and a multiple of 2500")
    parser.add_argument("--updates", type=int, default=50, help="of either side, after every 2500 frames")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)

    config = ExperimentConfig.get_from_yaml()
    config.max_n_frames = options.frames
    config.off_policy_n_envs_per_worker = ENVIRONMENTS
    config.off_policy_collected_frames_per_batch = ENVIRONMENTS * HORIZON
    config.off_policy_n_optimizer_steps = options.updates
    config.off_policy_train_batch_size, config.off_policy_memory_size = 1024, 100_000
    config.lr, config.gamma, config.polyak_tau = 1e-3, 0.95, 0.01
    config.evaluation, config.render, config.loggers, config.create_json = False, False, [], False
    settings = {**VmasTask.SIMPLE_ADVERSARY.get_from_yaml().config, "max_steps": HORIZON}
    network = MlpConfig(num_cells=[64, 64], layer_class=torch.nn.Linear, activation_class=torch.nn.ReLU)
    with tempfile.TemporaryDirectory() as folder:
        config.save_folder = folder
        snapshots = Snapshots(options.every)
        experiment = Experiment(
            task=Task(name="SIMPLE_ADVERSARY", config=settings),
            algorithm_config=MaddpgConfig.get_from_yaml(),
            model_config=network,
            critic_model_config=network,
            seed=options.seed,
            config=config,
            callbacks=[snapshots],
        )
        snapshots.began = time.perf_counter(), time.process_time()
        experiment.run()
    last = snapshots.taken[-1]
    arrays: dict[str, Any] = {name: np.stack([each[name] for each in snapshots.taken]) for name in last}
    np.savez(options.out, **arrays)
    print(
        f"{last['frames']} frames with {options.threads} threads: "
        f"{last['wall_seconds']:.0f} s, of the processor {last['cpu_seconds']:.0f} s"
    )


if __name__ == "__main__":
    main()
