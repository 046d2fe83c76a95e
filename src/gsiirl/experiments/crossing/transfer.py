"""What was learned in the crossing, put to use in a changed one (`gsiirl transfer`).

The robot takes its r_e and its fitted r_ld along, sees no new demonstration, and trains its forward model anew. Its
policy then meets the true human's best response in the changed crossing, and is judged by the true rewards.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.compilation import OF_A_RUN
from gsiirl.equilibria.anew import promised, stacked, trained_anew
from gsiirl.equilibria.pathwise import TRAINED_RATE, Ascent
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import policy_of
from gsiirl.equilibria.several_starts import best_of_starts
from gsiirl.errors import InputError
from gsiirl.evaluation.true_returns import TrueReturns
from gsiirl.experiments.continuous.experiment import front_door_of
from gsiirl.experiments.crossing.changes import Layout, boxes, changed, drawn
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.crossing.problem import build
from gsiirl.experiments.transfer.learned import OTHER_RUN, AbstractLearned, Judged, Kept, Model
from gsiirl.experiments.transfer.regret import RANDOM, TRUE, UNCHANGED
from gsiirl.games.crossing import Crossing
from gsiirl.problems.continuous_problem import single_precision
from gsiirl.program.progress import Told
from gsiirl.rewards import crossing as rewards
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import AnyArray, Number, Sides, Transition

ALONE = "own reward alone"
"""The row of a robot that trains for r_li, and takes no heed of the human."""
SEARCH_KEY = 0
"""Of the random pair of networks that every search begins from, besides the pair that a run ended with."""


class World(eqx.Module):
    """A crossing, and where its robot heads for; all numbers are traced, so that one compilation serves all layouts."""

    game: Crossing
    robot_goal: tuple[Number, Number]

    @classmethod
    def of(cls, layout: Layout, horizon: int) -> Self:
        """The crossing of a layout."""
        speeds = Sides(layout.robot_speed, layout.human_speed)
        world = cls(Crossing(horizon, Sides(*boxes(layout)), speeds), layout.robot_goal)
        return jax.tree.map(lambda number: jnp.asarray(number, jnp.float32), world)

    def own_reward(self, transition: Transition) -> Float[Array, ""]:
        """r_li."""
        return rewards.own_reward(transition, self.robot_goal)


@dataclass(frozen=True)
class LearnedCrossing(AbstractLearned):
    """What every seed of a run learned, and the networks that it ended with.

    `weights` are in the unit ball; `policies` are by name: `learner`, the `expert` of its model, and the true human's
    `response`.
    """

    config: CrossingConfig

    @classmethod
    def open(cls, path: Path, field: str = "DIR") -> Self:
        """The run in a folder.

        Raises:
            InputError: it holds no run of the crossing that has ended with learned rewards.
        """
        kept = Kept.open(path, field)
        if not isinstance(kept.config, CrossingConfig):
            raise InputError(field, f"{path} is a run of {kept.config.experiment}", OTHER_RUN)
        weights = Sides(kept.learned.arrays[kept.dependent], kept.learned.arrays["expert_reward"])
        sound = kept.sound(field, weights.learner, weights.expert, *kept.policies.values())
        seeds, left_out = kept.parted(sound)
        arrays = {name: each[sound] for name, each in kept.policies.items()}
        return cls(
            folder=kept.folder,
            seeds=seeds,
            left_out=left_out,
            weights=Sides(weights.learner[sound], weights.expert[sound]),
            config=kept.config,
            policies={name: policy_of(name, arrays) for name in ("learner", "expert", "response")},
        )

    def drawn(self, number: int, seed: int) -> list[str]:
        return drawn(number, seed)

    def is_of_the_same_game(self, other: AbstractLearned) -> bool:
        if not isinstance(other, LearnedCrossing):
            return False
        # Of networks of another width no row could be searched for beside these.
        fields = ("horizon", "discount", "reward", "hidden")
        return all(getattr(self.config, field) == getattr(other.config, field) for field in fields)

    def judge(self, changes: list[str], models: Mapping[str, Model]) -> Callable[[str, Told], Judged]:
        layouts = {change: changed(Layout(), change) for change in changes}
        with single_precision():
            procedure = Procedure(self.config)

        def judge(change: str, tell: Told) -> Judged:
            with single_precision():
                return judged(procedure, layouts[change], self, models)

        return judge


class Procedure:
    """The upper level in a changed crossing and what its policies earn there, each compiled once for all layouts."""

    def __init__(self, config: CrossingConfig) -> None:
        experiment = build(config)
        front_door = front_door_of(config, experiment.problem)
        self._config, self._problem, self._experiment = config, experiment.problem, experiment
        self._solver = front_door.solver(config.training_steps, TRAINED_RATE)
        self._answerer = front_door.responder(config.training_steps, TRAINED_RATE)
        self._tester = front_door.responder(config.judging_steps, TRAINED_RATE)
        compiled = partial(jax.jit, compiler_options=OF_A_RUN[config.device])
        self.committed = compiled(self._committed)
        self.committed_with_truth = compiled(self._committed_with_truth)
        self.against_clones = compiled(self._against_clones)
        self.untrained = compiled(self._untrained)
        self.worth = compiled(self._worth)

    def _committed(
        self, world: World, weights: Sides[Float[Array, "n ..."]], before: Any, key: PRNGKeyArray
    ) -> Sides[PolicyNetwork]:
        """The pairs (n) that the forward model comes to under n learned pairs of rewards, and from n pairs `before`."""

        def one(inputs: tuple[Sides[Array], Sides[PolicyNetwork]]) -> Sides[PolicyNetwork]:
            learned, pair = inputs
            modelled: Sides[TransitionReward] = Sides(
                lambda seen: self._problem.dependent_reward(learned.learner, seen) + world.own_reward(seen),
                lambda seen: self._problem.expert_reward(learned.expert, seen),
            )
            return self._trained(world, modelled, pair, key)

        return jax.lax.map(one, (weights, before))

    def _committed_with_truth(self, world: World, before: Any, key: PRNGKeyArray) -> Sides[PolicyNetwork]:
        """The pairs that it comes to under both true rewards."""
        return jax.lax.map(lambda pair: self._trained(world, self._true(world), pair, key), before)

    def _trained(
        self, world: World, modelled: Sides[TransitionReward], before: Sides[PolicyNetwork], key: PRNGKeyArray
    ) -> Sides[PolicyNetwork]:
        config, solver = self._config, replace(self._solver, game=world.game)
        return trained_anew(solver, modelled, before, key, config.training_steps, config.evaluation_episodes)

    def _against_clones(
        self, world: World, dependent: Float[Array, "n a"], before: Any, key: PRNGKeyArray
    ) -> PolicyNetwork:
        """The robot's best answers to n humans that go on as they did, whatever the robot does.

        `before` are pairs of a robot, from which a search begins, and such a human.
        """
        solver = replace(self._answerer, game=world.game)
        start_key, ascent_key, test_key = jax.random.split(key, 3)

        def one(inputs: tuple[Array, Sides[PolicyNetwork]]) -> PolicyNetwork:
            fitted, pair = inputs

            def modelled(seen: Transition) -> Array:
                return self._problem.dependent_reward(fitted, seen) + world.own_reward(seen)

            def climb(ascent: Ascent, key: PRNGKeyArray, steps: int) -> Ascent:
                return solver.answer(pair.expert, modelled, ascent, key, steps)

            def promise(ascent: Ascent) -> Array:
                together = Sides(ascent.policy, pair.expert)
                return promised(solver, modelled, together, test_key, self._config.evaluation_episodes)

            starts = stacked(solver.init_at(pair).learner, solver.init(start_key).learner)
            return best_of_starts(starts, climb, promise, ascent_key, self._config.training_steps).policy

        return jax.lax.map(one, (dependent, before))

    def _untrained(self, world: World, key: PRNGKeyArray) -> Sides[PolicyNetwork]:
        return self._judge(world).untrained(key)

    def _worth(self, world: World, pairs: Any, key: PRNGKeyArray) -> Float[Array, "n 2"]:
        """What n robots earn against the true human's best responses: discounted, and not.

        `pairs` are robots, and humans from which one of the searches for a best response starts.
        """
        judge = self._judge(world)

        def one(pair: Sides[PolicyNetwork]) -> Array:
            response = judge.best_response(pair.learner, (pair.expert,), key)
            episodes = judge.episodes(Sides(pair.learner, response))
            return jnp.stack([judge.returns(episodes, discount).learner for discount in (self._config.discount, 1.0)])

        return jax.lax.map(one, pairs)

    def _true(self, world: World) -> Sides[TransitionReward]:
        return Sides(
            lambda seen: self._problem.dependent_value(seen) + world.own_reward(seen),
            self._experiment.true_expert_reward,
        )

    def _judge(self, world: World) -> TrueReturns:
        config, tester = self._config, replace(self._tester, game=world.game)
        return TrueReturns(
            self._true(world), tester, tester, config.training_steps, config.judging_steps, config.evaluation_episodes
        )


def judged(procedure: Procedure, layout: Layout, learned: LearnedCrossing, models: Mapping[str, Model]) -> Judged:
    """Every row of one changed crossing: what is deployed earns there."""
    world = World.of(layout, learned.config.horizon)
    search_key, random_key, response_key = jax.random.split(jax.random.key(SEARCH_KEY), 3)
    ended = Sides(learned.policies["learner"], learned.policies["expert"])
    met = Sides(learned.policies["learner"], learned.policies["response"])
    nothing = jax.tree.map(lambda leaf: np.zeros_like(leaf[:1]), learned.weights)
    begun = {
        name: (model.weights, Sides(model.policies["learner"], model.policies["expert"]))
        for name, model in models.items()
    }
    begun[ALONE] = (nothing, jax.tree.map(lambda leaf: leaf[:1], ended))
    weights, pairs = _together(list(begun.values()))
    searched = procedure.committed(world, weights, pairs, search_key)
    found = _split(searched, {name: len(each.expert) for name, (each, _) in begun.items()})
    alone = found.pop(ALONE)
    answers = procedure.against_clones(world, jnp.asarray(learned.weights.learner), met, search_key)
    deployed = {
        TRUE: procedure.committed_with_truth(world, ended, search_key),
        **found,
        "clone": Sides(answers, met.expert),
        UNCHANGED: met,
        ALONE: alone,
        RANDOM: jax.tree.map(lambda leaf: leaf[None], procedure.untrained(world, random_key)),
    }
    values = np.asarray(procedure.worth(world, _together(list(deployed.values())), response_key))
    numbers = {name: jax.tree.leaves(pair)[0].shape[0] for name, pair in deployed.items()}
    returns = {name: each.T for name, each in _split(values, numbers).items()}
    return Judged({"layout": asdict(layout)}, returns)


def _together(trees: list[Any]) -> Any:
    """Trees of arrays, one after the other along the leading axis."""
    return jax.tree.map(lambda *leaves: jnp.concatenate(leaves), *trees)


def _split(together: Any, numbers: Mapping[str, int]) -> dict[str, Any]:
    """What stands one after the other along the leading axis, by name."""
    ends = np.cumsum([0, *numbers.values()]).tolist()
    bounds = zip(numbers, ends[:-1], ends[1:], strict=True)
    return {name: jax.tree.map(partial(_rows, first, last), together) for name, first, last in bounds}


def _rows(first: int, last: int, leaf: AnyArray) -> AnyArray:
    return leaf[first:last]
