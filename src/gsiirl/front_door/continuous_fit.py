"""The front door of continuous games: what the learner is made of, and a run of it."""

from dataclasses import KW_ONLY, dataclass, replace
from functools import cache, partial
from typing import Any

import equinox as eqx
import jax
import numpy as np
import optax
import polars
from jaxtyping import Array, Key, PRNGKeyArray, PyTree

from gsiirl.arguments import positive, whole_number
from gsiirl.demonstrations import continuous
from gsiirl.demonstrations.own_expert import OwnExpert
from gsiirl.equilibria.pathwise import FOLLOWING_RATE, TRAINED_RATE, Ascent, Pathwise, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.errors import FitWarning, InputError, warn
from gsiirl.evaluation.true_returns import TrueReturns
from gsiirl.experts.continuous_expert import ContinuousRespondingExpert
from gsiirl.front_door.abstract_fit import AbstractGSIIRL, Asked
from gsiirl.front_door.continuous_result import ContinuousResult, ContinuousResults, LearnedTransitionReward
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.interaction import AbstractExpert, ContinuousDemonstrator, live
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps
from gsiirl.learners.continuous_learner import ContinuousLearner, ContinuousState
from gsiirl.problems.continuous_problem import ContinuousProblem, single_precision
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides

Met = AbstractExpert[Any] | ContinuousDemonstrator
"""An expert of the library, or somebody's own."""
SMALL_GAP = 0.1
"""A gap of features, below which steps of the lower level are damped."""
HALVED_AFTER = 8.0
"""Iterations after which the lower level's first step is halved."""
AT_BOUND = 0.999
"""Norm of θ_l in the unit ball from which on a warning is given."""


@dataclass(frozen=True, repr=False, eq=False)
class ContinuousGSIIRL(
    AbstractGSIIRL[AbstractExpert[Any] | ContinuousDemonstrator, ContinuousResult, ContinuousResults]
):
    """General-sum interactive inverse reinforcement learning for a continuous game; `gsiirl.GSIIRL` makes one of it.

    Both sides are networks that ascend their returns by gradients through the dynamics.

    Args:
        problem: what the learner is told.
        hidden: width of the networks' two hidden layers.
        batch: episodes of a gradient step.
        learning_rate: Adam's first step on the networks; it falls to a tenth, and in settling to a fiftieth.
        noise: standard deviation of the noise on both sides' actions, before the outer tanh, in the forward model: for
            games in which a side must not be seen through.
        expert_steps: steps of the forward model's expert for each of its learner's.
        solver_steps: steps of the forward model in an iteration.
        settling_steps: its steps after the last iteration, under the last rewards, before its policies are handed back.
        inner_steps: steps on the weights of r_e in an iteration; `first_inner_steps` in the first one.
        inner_step_size: the first of these, in the unit ball.
        regularisation: λ of the lower level's squared norm.
        remembered: interactions that the weights of r_e are fitted to; `compared` episodes of each in a step.
        cloning_steps: steps of a network that imitates what the expert was seen to do in an interaction.
        model_response_steps: steps that the modelled expert takes from there; the first is `model_rate`.

    Raises:
        InputError: naming the argument that cannot be, and the mend.
    """

    problem: ContinuousProblem
    _: KW_ONLY
    hidden: int = 64
    batch: int = 64
    learning_rate: float = 3e-3
    noise: float = 0.0
    expert_steps: int = 2
    solver_steps: int = 20
    settling_steps: int = 0
    inner_steps: int = 20
    first_inner_steps: int = 300
    inner_step_size: float = 0.03
    regularisation: float = 1e-3
    remembered: int = 8
    compared: int = 25
    cloning_steps: int = 300
    model_response_steps: int = 25
    model_rate: float = 2e-3

    def __post_init__(self) -> None:
        if not isinstance(self.problem, ContinuousProblem):
            raise InputError("problem", f"is {type(self.problem).__name__}", "give a gsiirl.Problem")
        for name in ("learning_rate", "inner_step_size", "regularisation", "model_rate"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        if self.noise != 0:
            object.__setattr__(self, "noise", positive("noise", self.noise))
        for name in ("hidden", "batch", "expert_steps", "solver_steps", "inner_steps", "first_inner_steps"):
            object.__setattr__(self, name, whole_number(name, getattr(self, name), 1))
        for name, least in (("remembered", 1), ("compared", 1), ("cloning_steps", 1), ("model_response_steps", 0)):
            object.__setattr__(self, name, whole_number(name, getattr(self, name), least))
        object.__setattr__(self, "settling_steps", whole_number("settling_steps", self.settling_steps, 0))

    def __repr__(self) -> str:
        return f"ContinuousGSIIRL({self.problem!r})"

    def _lived(self, expert: Met, asked: Asked) -> list[ContinuousResult]:
        with single_precision():
            met = _met(expert, self.problem.game)
            learner, keys = self.learner(asked.iterations, asked.trajectories), asked.keys()
            rows, states = [], None
            for one in live(learner, met, keys, asked.iterations, asked.trajectories, asked.progress):
                states = one.states
                rows.append(jax.tree.map(np.asarray, _report(learner, states)))
                asked.tell(len(rows), rows[-1])
            assert states is not None, "there is at least one iteration"
            policies, dependent = _end(self, learner, states, keys[:, 2])
            expert_weights = np.asarray(states.expert_parameters)
        # With axes of seeds and iterations.
        records = {name: np.stack([row[name] for row in rows], axis=1) for name in rows[0]}
        results = [
            ContinuousResult(
                problem=self.problem,
                seed=seed,
                trajectories=asked.trajectories,
                policy=_at(place, policies.learner),
                expert_policy=_at(place, policies.expert),
                expert_reward=LearnedTransitionReward(self.problem.expert_reward, expert_weights[place]),
                dependent_reward=LearnedTransitionReward(self.problem.dependent_reward, np.asarray(dependent)[place]),
                history=_history(self.problem.expert_reward.scale, _at(place, records), asked.trajectories),
                true_returns=self.true_returns,
                solver=partial(self.solver, last_rate=TRAINED_RATE),
            )
            for place, seed in enumerate(asked.seeds)
        ]
        for each in results:
            _warn(each)
        return results

    def _together(self, results: list[ContinuousResult]) -> ContinuousResults:
        return ContinuousResults(results)

    def learner(self, iterations: int, trajectories: int) -> ContinuousLearner:
        """The learner as pure functions, for a run of `iterations` of `trajectories` episodes."""
        problem, compared = self.problem, min(self.compared, trajectories)
        responder = replace(self, learning_rate=self.model_rate, batch=compared)
        return ContinuousLearner(
            solver=self.solver(iterations * self.solver_steps, FOLLOWING_RATE),
            responder=responder.responder(self.model_response_steps, FOLLOWING_RATE),
            own_reward=problem.own_reward,
            accessed=problem.dependent_value,
            dependent_reward=problem.dependent_reward,
            expert_reward=problem.expert_reward,
            inner_loop=MaximumLikelihood(
                1.0, constant_steps(self.inner_steps, self.first_inner_steps), self.matching(), on_sphere=True
            ),
            upper=None,
            regularisation=self.regularisation,
            trajectories=trajectories,
            solver_steps=self.solver_steps,
            model_response_steps=self.model_response_steps,
            cloning_steps=self.cloning_steps,
            remembered=self.remembered,
            compared=compared,
            lower_level="played",
        )

    def solver(self, steps: int, last_rate: float) -> Pathwise:
        """The forward model, whose rate falls to `last_rate` of the first over `steps` steps."""
        return Pathwise.create(
            self.problem.game,
            discount=self.problem.discount,
            batch=self.batch,
            hidden=self.hidden,
            learning_rate=self.learning_rate,
            decay_steps=max(steps, 1),
            last_rate=last_rate,
            expert_steps=self.expert_steps,
            noise=self.noise,
        )

    def responder(self, steps: int, last_rate: float) -> Pathwise:
        """The solver of one side that answers the other alone: one step at a time, without noise."""
        return replace(self, expert_steps=1, noise=0.0).solver(steps, last_rate)

    def matching(self) -> optax.GradientTransformation:
        """Steps on the weights of r_e along gaps of features; see `damped`."""
        return damped(self.inner_step_size, HALVED_AFTER * self.inner_steps)

    def settled(
        self, solution: Sides[Ascent], rewards: Sides[TransitionReward], key: PRNGKeyArray
    ) -> Sides[PolicyNetwork]:
        """The pair that a learner ends with: its forward model, trained on under the last rewards as MARL trains.

        In the iterations it follows rewards that move; it settles as its rate and the noise fall under rewards that
        stay.
        """
        if not self.settling_steps:
            return policies_of(solution)
        trainer = self.solver(self.settling_steps, TRAINED_RATE)
        return trainer.settle(policies_of(solution), rewards, key, self.settling_steps)

    def true_returns(
        self, expert_reward: TransitionReward, training_steps: int, judging_steps: int, episodes: int
    ) -> TrueReturns:
        """What policies earn when r_e is `expert_reward`, over `episodes`.

        A pair trains for `training_steps` steps, a best response for `judging_steps`.
        """
        return TrueReturns(
            self.problem.true_rewards(expert_reward),
            self.solver(training_steps, TRAINED_RATE),
            self.responder(judging_steps, TRAINED_RATE),
            training_steps,
            judging_steps,
            episodes,
        )


@cache
def damped(first: float, halved: float) -> optax.GradientTransformation:
    """Adam, but a gap well below `SMALL_GAP` makes a step smaller than a whole one.

    Else the sampling noise of features that already match would move their weights as fast as a real gap. Steps fall
    from `first` to a half over `halved` steps: those of `HALVED_AFTER` iterations. The first iteration has more steps
    than others, and counts as several.
    """
    return optax.adam(lambda step: first / (1.0 + step / halved), b2=0.99, eps=SMALL_GAP)


def _met(expert: Any, game: AbstractContinuousGame[Any]) -> Any:
    """The expert that a run meets.

    Raises:
        InputError: it is none of this game.
    """
    if isinstance(expert, ContinuousRespondingExpert):
        theirs = expert.solver.game
        shapes = [
            (each.horizon, each.action_size, jax.tree.leaves(eqx.filter_eval_shape(each.reset, jax.random.key(0))))
            for each in (theirs, game)
        ]
        if shapes[0] != shapes[1]:
            raise InputError("expert", f"lives in another {type(theirs).__name__}", "use the game of the problem")
        return expert
    if isinstance(expert, AbstractExpert):
        raise InputError(
            "expert", f"{type(expert).__name__} lives in a finite game", "use a gsiirl.ContinuousRespondingExpert"
        )
    return OwnExpert(expert, partial(continuous.checked, game=game), partial(continuous.doubts, game=game))


@eqx.filter_jit
def _report(learner: ContinuousLearner, states: ContinuousState) -> dict[str, Array]:
    return jax.vmap(learner.report)(states)


@eqx.filter_jit
def _end(
    fit: ContinuousGSIIRL, learner: ContinuousLearner, states: ContinuousState, keys: Key[Array, " seeds"]
) -> tuple[Sides[PolicyNetwork], Array]:
    def one(state: ContinuousState, key: PRNGKeyArray) -> tuple[Sides[PolicyNetwork], Array]:
        rewards = learner.rewards(state.commitment, state.expert_parameters)
        return fit.settled(state.solution, rewards, key), learner.fitted_dependent_reward(state)

    return jax.vmap(one)(states, keys)


def _history(scale: float, record: dict[str, np.ndarray], trajectories: int) -> polars.DataFrame:
    iterations = np.arange(1, len(record["earned"]) + 1)
    moved = np.linalg.norm(scale * np.diff(record["expert_parameters"], axis=0), axis=1)
    columns: dict[str, Any] = {
        "iteration": iterations,
        "expert_trajectories": trajectories * iterations,
        "exploring": record["exploring"],
        "earned": record["earned"],
        "reward_change": [None, *moved.tolist()],
    }
    return polars.DataFrame(columns, schema_overrides={"reward_change": polars.Float64})


def _at(place: int, tree: PyTree) -> Any:
    return jax.tree.map(lambda leaf: leaf[place], tree)


def _warn(result: ContinuousResult) -> None:
    leaves = jax.tree.leaves((result.policy, result.expert_reward.parameters, result.dependent_reward.parameters))
    if not all(np.isfinite(np.asarray(leaf)).all() for leaf in leaves):
        warn(
            f"seed {result.seed}: what was learned is not finite: the dynamics, a reward or a feature has no finite "
            "derivative somewhere; a smooth one, or a smaller learning_rate, helps",
            FitWarning,
        )
    if np.linalg.norm(result.dependent_reward.parameters) > AT_BOUND:
        warn(
            f"seed {result.seed}: the weights of r_ld are at their bound; a larger dependent_scale helps",
            FitWarning,
        )
