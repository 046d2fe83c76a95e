"""Run folders as finished runs leave them, with random policies in place of learned ones."""

import itertools
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import polars

from gsiirl.experiments.config import ExperimentConfig, config_to_dict
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.problem import build
from gsiirl.runs import RunFolder, Summary, summarise
from gsiirl.types import Sides

HIDDEN = 5
SIZES = {
    CrossingConfig.experiment: {"learner": (4, 2), "expert": (4, 2), "response": (4, 2)},
    DeceptionConfig.experiment: {"learner": (20, 4), "expert": (8, 2), "response": (8, 2)},
}


def finished(path: Path, config: ExperimentConfig, game: dict[str, Any], policies: Any, **returns: Any) -> RunFolder:
    """A run that ended with these policies and returns [seeds]; one that is no number makes its seed fail."""
    folder = RunFolder.create(path, config_to_dict(config), game)
    folder.save_policies(policies)
    seeds = [*range(config.first_seed, config.first_seed + config.seeds)]
    columns = {"seed": seeds, "iteration": [0] * len(seeds), **returns}
    folder.write_summary(summarise(folder.config, polars.DataFrame(columns), completed=True))
    return folder


def security_run(path: Path, seeds: int = 2, failed: int | None = None, **settings: Any) -> tuple[RunFolder, Summary]:
    """Of a random defender for each seed, and of an attacker as modelled that is not the true one's answer."""
    config = SecurityConfig(seeds=seeds, first_seed=3, **settings).resolved()
    network = config.network()
    random = np.random.default_rng(0)
    with jax.enable_x64(True):
        problem = build(config, network)
        game, truth, returns = problem.game, problem.truth, []
        actions = game.number_of_actions
        tables = {
            side: random.dirichlet(np.full(number, 0.3), (seeds, game.horizon, game.number_of_states))
            for side, number in (("learner", actions.learner), ("expert", actions.expert))
        }
        # The last defender nearly always blocks one of two edges, so that seeds can be told apart.
        tables["learner"][-1] = 0.1 * tables["learner"][-1] + 0.45 * np.eye(actions.learner)[:2].sum(axis=0)
        for table in tables["learner"]:
            deployed = Sides(jnp.asarray(table), truth.expert_response(jnp.asarray(table)))
            returns.append([float(each) for each in jax.tree.leaves(truth.returns(deployed))])
    earned = np.array(returns)
    if failed is not None:
        earned[failed - 3] = np.nan
    folder = finished(
        path,
        config,
        {**network.to_json_dict(), "horizon": config.horizon},
        {f"{side}.table": table for side, table in tables.items()},
        deployed_return_learner=earned[:, 0],
        deployed_return_expert=earned[:, 1],
    )
    summary = folder.summary()
    assert summary is not None
    return folder, summary


def continuous_run(path: Path, config: CrossingConfig | DeceptionConfig) -> RunFolder:
    """Of random networks, far from small actions."""
    random, weights = np.random.default_rng(0), {}
    for name, (observation, actions) in SIZES[config.experiment].items():
        sizes = (observation + 1, HIDDEN, HIDDEN, actions)
        for layer, (inputs, outputs) in enumerate(itertools.pairwise(sizes)):
            for part, shape in (("weight", (outputs, inputs)), ("bias", (outputs,))):
                drawn = random.normal(size=(config.seeds, *shape))
                weights[f"{name}.layers.{layer}.{part}"] = drawn.astype(np.float32)
    return finished(path, config, {"kind": config.experiment}, weights, deployed_return_learner=np.zeros(config.seeds))
