"""Players of a finished run: what it learned, and the true expert that has got used to that."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.errors import InputError
from gsiirl.experiments.security.problem import SecurityProblem
from gsiirl.pettingzoo.playable_security import compromised_nodes
from gsiirl.pettingzoo.players import NetworkPlayer, TablePlayer
from gsiirl.pettingzoo.stage import Stage, stage_of_run
from gsiirl.program.command import command
from gsiirl.runs import RunFolder
from gsiirl.runs.files.damage import START_AGAIN, refuse_damaged


def learned_player(folder: str | Path, agent: str, seed: int | None = None) -> TablePlayer | NetworkPlayer:
    """What one seed of a run has for a policy of `agent` at its end; of the first seed, where none is named.

    For the learner (`defender`, `robot`, `good_agents`) that is what it learned to do. For the expert (`attacker`,
    `human`, `adversary`) it is what the learner takes the expert to do; the true one is `expert_player`.

    Raises:
        InputError: the run has not ended, is damaged, or has no such agent or seed.
    """
    kept = _Kept.open(Path(folder), seed)
    names = kept.stage.agents
    if agent not in (names.learner, names.expert):
        raise InputError("agent", f"cannot be {agent!r}", f"choose {names.learner} or {names.expert}")
    return kept.player("learner" if agent == names.learner else "expert")


def expert_player(folder: str | Path, seed: int | None = None) -> TablePlayer | NetworkPlayer:
    """The true expert's answer to the policy that one seed of a run learned: whom the run calls deployed against.

    In security it is the expert's soft best response, which is exact; in continuous games the best response that the
    run found.

    Raises:
        InputError: the run has not ended, is damaged, or has no such seed.
    """
    kept = _Kept.open(Path(folder), seed)
    experiment = kept.stage.experiment
    if not isinstance(experiment, SecurityProblem):
        return kept.player("response")
    learned = kept.player("learner")
    assert isinstance(learned, TablePlayer), "policies of security are tables"
    return answer_to(experiment, learned.table)


def answer_to(problem: SecurityProblem, learner_policy: np.ndarray) -> TablePlayer:
    """The true attacker's soft best response to a defender's policy (T, S, A_l)."""
    with jax.enable_x64(True):
        table = eqx.filter_jit(problem.truth.expert_response)(jnp.asarray(learner_policy, float))
    return TablePlayer(np.asarray(table), compromised_nodes(problem.game))


@dataclass(frozen=True)
class _Kept:
    """One seed of a finished run, and its policies."""

    stage: Stage
    policies: Mapping[str, np.ndarray]
    place: int
    path: Path

    @classmethod
    def open(cls, path: Path, seed: int | None) -> "_Kept":
        folder = RunFolder.open(path)
        summary = folder.summary()
        if summary is None or not summary.completed:
            raise InputError(str(path), "holds a run that is not finished", f"run {command('resume', path)}")
        if not summary.kept_seeds:
            raise InputError(str(path), "holds failed seeds only", "give another run")
        policies = folder.load_policies()
        if policies is None:
            raise InputError(str(path), "keeps no policies: an earlier version ran it", START_AGAIN)
        chosen = summary.kept_seeds[0] if seed is None else seed
        if chosen not in summary.kept_seeds:
            known = ", ".join(map(str, summary.kept_seeds))
            raise InputError("seed", f"{chosen} is none of {path} that did not fail", f"choose from {known}")
        return cls(stage_of_run(folder), policies, summary.seeds.index(chosen), path)

    def player(self, name: str) -> TablePlayer | NetworkPlayer:
        """The player of the policy of that name.

        Raises:
            InputError: the run holds none of this game.
        """
        experiment = self.stage.experiment
        with refuse_damaged(self.path / "policies.safetensors", START_AGAIN):
            if not isinstance(experiment, SecurityProblem):
                return NetworkPlayer(NumpyPolicy.of(self.policies, name, self.place))
            table = self.policies[f"{name}.table"][self.place]
            game = experiment.game
            shape = (game.horizon, game.number_of_states, getattr(game.number_of_actions, name))
            if table.shape != shape:
                raise ValueError(f"{name}.table is of shape {table.shape}, and the game's is {shape}")
            return TablePlayer(table, compromised_nodes(game))
