"""The front door: a problem, an expert, and what comes of living with it."""

from functools import partial
from typing import Any, Literal, Self, overload

import jax
import jax.numpy as jnp
import numpy as np
import polars
from jaxtyping import Array, PyTree

from gsiirl.arguments import signature_of
from gsiirl.commitment.objective import Commitment
from gsiirl.compilation import QUICKLY
from gsiirl.demonstrations import finite
from gsiirl.demonstrations.own_expert import OwnExpert
from gsiirl.errors import FitWarning, InputError, warn
from gsiirl.evaluation.result import LAST
from gsiirl.experts.tabular_expert import SimulatedExpert
from gsiirl.front_door.abstract_fit import AbstractGSIIRL, Asked
from gsiirl.front_door.continuous_fit import ContinuousGSIIRL
from gsiirl.front_door.result import Result, Results
from gsiirl.games.base import AbstractTabularGame
from gsiirl.interaction import AbstractExpert, Demonstrator, live
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.irl.inference import AbstractLowerLevel, LikelihoodLevel, LikelihoodState, MatchingLevel
from gsiirl.irl.posterior import Inference
from gsiirl.learners.commitment_learner import CommitmentLearner, Explore, Feedback, HandBack, LearnerState
from gsiirl.limits import remembered
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.problems.problem import Problem
from gsiirl.rewards.linear import Linear

LowerLevel = Literal["likelihood", "matching"]
FAR = 0.1
"""Standard deviations from the maximum of the fit from which on a warning is given."""
UNSURE = 0.05
"""Share of the largest difference of returns from which on a loss of what was played last gives a warning."""
KEPT = 2**20
"""Numbers that the policies played may take in a result; of longer runs it keeps those played last."""
EXPLORE, HAND_BACK = ("informative", "thompson", "estimate"), ("average", "estimate")
FINE = 2.0**40
"""Steps that the learner's largest reward is divided into."""
MATCHING_DEVIATION = 3.0
"""What `lower_level="matching"` takes for the size of a weight, in units of the temperature, where none is given."""


class GSIIRL(AbstractGSIIRL[Demonstrator, Result, Results]):
    """General-sum interactive inverse reinforcement learning for a finite game.

    Of a continuous game's problem it makes a `ContinuousGSIIRL`, which has settings of its own.

    Args:
        problem: what the learner is told.
        lower_level: how the expert's reward is estimated: by the conditional `likelihood`, to convergence, with a
            posterior; or by `matching` features (the paper's Lemma 1), a few steps an iteration.
        explore: what is played while learning. `thompson`: the best commitment under one draw of the posterior.
            `informative`: the same in the second half of the iterations, and in the first half the policies that tell
            most about the expert, whatever they earn. `estimate`: the best commitment under the estimate, all that
            `matching`, without a posterior, can do.
        hand_back: the policy to deploy: the best on `average` over the posterior, or under the `estimate`.
        feedback: where values of r_ld are read: everywhere (`model`), or only along what was `visited`.
        many_starts: False leaves a single ascent, from the policy before.
    """

    @overload
    def __new__(  # pyright: ignore[reportOverlappingOverload] (`__init__` says what is wrong with other problems)
        cls,
        problem: ContinuousProblem,
        *,
        hidden: int = ...,
        batch: int = ...,
        learning_rate: float = ...,
        noise: float = ...,
        expert_steps: int = ...,
        solver_steps: int = ...,
        settling_steps: int = ...,
        inner_steps: int = ...,
        first_inner_steps: int = ...,
        inner_step_size: float = ...,
        regularisation: float = ...,
        remembered: int = ...,
        compared: int = ...,
        cloning_steps: int = ...,
        model_response_steps: int = ...,
        model_rate: float = ...,
    ) -> ContinuousGSIIRL: ...

    @overload
    def __new__(cls, problem: object, **settings: Any) -> Self: ...

    def __new__(cls, *arguments: Any, **settings: Any) -> Any:
        """A learner of the kind that the problem is of."""
        problem = arguments[0] if arguments else settings.get("problem")
        if isinstance(problem, ContinuousProblem):
            return ContinuousGSIIRL(*arguments, **settings)
        return super().__new__(cls)

    def __init__(
        self,
        problem: Problem,
        *,
        lower_level: LowerLevel = "likelihood",
        explore: Explore | None = None,
        hand_back: HandBack | None = None,
        feedback: Feedback = "model",
        many_starts: bool = True,
    ) -> None:
        if not isinstance(problem, Problem):
            raise InputError("problem", f"is {type(problem).__name__}", "give a gsiirl.Problem")
        self.problem = problem
        has_posterior = lower_level == "likelihood"
        self._lower_level = _one_of("lower_level", lower_level, ("likelihood", "matching"))
        self._explore: Any = _one_of(
            "explore", ("informative" if has_posterior else "estimate") if explore is None else explore, EXPLORE
        )
        self._hand_back: Any = _one_of(
            "hand_back", ("average" if has_posterior else "estimate") if hand_back is None else hand_back, HAND_BACK
        )
        self._feedback: Any = _one_of("feedback", feedback, ("model", "visited"))
        if not isinstance(many_starts, bool):
            raise InputError("many_starts", f"cannot be {many_starts!r}", "give True or False")
        self._many_starts = many_starts
        if not has_posterior and (self._explore, self._hand_back) != ("estimate", "estimate"):
            raise InputError("lower_level", "matching has no posterior", 'use explore="estimate", hand_back="estimate"')

    def __repr__(self) -> str:
        return f"GSIIRL({self.problem!r})"

    def _lived(self, expert: Demonstrator, asked: Asked) -> list[Result]:
        game = self.problem.game
        if isinstance(expert, SimulatedExpert):
            raise InputError(
                "expert",
                "a SimulatedExpert is told a reward to act on, and this learner commits to a policy",
                "use a RespondingExpert, or gsiirl.RewardGSIIRL",
            )
        if isinstance(expert, AbstractExpert):
            _check_same_game(expert, game)
            known: Any = expert
        else:
            known = OwnExpert(expert, partial(finite.checked, game=game), partial(finite.doubts, game=game))
        with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
            learner, keys = jax.tree.map(jnp.asarray, self.learner(asked.iterations)), asked.keys()
            rows, played, answers, states = [], list[np.ndarray](), list[np.ndarray](), None
            met = jax.tree.map(jnp.asarray, known) if isinstance(known, AbstractExpert) else known
            for one in live(learner, met, keys, asked.iterations, asked.trajectories, asked.progress):
                states, policies = one.states, np.asarray(one.policies)
                kept = max(10, KEPT // policies.size)
                played = [*played[1 - kept :], policies]
                if isinstance(states.lower, LikelihoodState):
                    answers = [*answers[1 - kept :], np.asarray(states.lower.memory.kept.counts[:, 0])]
                rows.append(jax.tree.map(np.asarray, _report(learner, states)))
                asked.tell(len(rows), rows[-1])
            assert states is not None, "there is at least one iteration"
            ended = jax.tree.map(np.asarray, _end(learner, states, keys[:, 2]))
            draws = np.asarray(_posterior_draws(learner, states, keys[:, 2]))
            weights = {
                "expert": np.asarray(jax.vmap(learner.lower.estimate)(states.lower)),
                "dependent": np.asarray(jax.vmap(lambda fit: fit.solve())(states.accessed)),
            }
        results = [
            Result.learned(
                problem=self.problem,
                seed=seed,
                trajectories=asked.trajectories,
                policy=ended.policies.learner[place],
                expert_policy=ended.policies.expert[place],
                expert_weights=self.problem.unit * weights["expert"][place],
                dependent_weights=weights["dependent"][place],
                draws=self.problem.unit * draws[place],
                history=_history([{name: row[name][place] for name in row} for row in rows], asked.trajectories),
                played=np.stack([each[place] for each in played]),
                answers=np.array([each[place] for each in answers]).reshape(-1, *ended.policies.expert[place].shape),
                effective_draws=float(ended.effective_draws[place]),
                sampled=bool(ended.sampled[place]),
            )
            for place, seed in enumerate(asked.seeds)
        ]
        for each in results:
            _warn(each, learner.draws if self._hand_back == "average" else 0)
        return results

    def _together(self, results: list[Result]) -> Results:
        return Results(results)

    def learner(self, iterations: int) -> CommitmentLearner:
        """The learner as pure functions, for a run of `iterations`."""
        problem = self.problem
        reward = problem.own_reward + problem.dependent_value
        unit = max((float(np.abs(leaf).max()) for leaf in jax.tree.leaves(reward)), default=0.0) or 1.0
        # Rounded, so that the unit in which rewards are given tips no comparison of two commitments.
        rounded = jax.tree.map(lambda leaf: np.round(np.asarray(leaf) / unit * FINE) / FINE, reward)
        return CommitmentLearner(
            commitment=Commitment(problem.game, rounded, problem.discount),
            own_reward=problem.own_reward,
            accessed=problem.dependent_value,
            dependent_features=problem.dependent_features,
            lower=self._lower(),
            explore=self._explore,
            hand_back=self._hand_back,
            feedback=self._feedback,
            many_starts=self._many_starts,
            informative_rounds=iterations // 2,
            unit=unit,
            remembered=remembered(problem.game.policy_size, iterations),
        )

    def _lower(self) -> AbstractLowerLevel:
        problem = self.problem
        likelihood = ConditionalLikelihood(problem.game, problem.expert_features, problem.discount)
        scale = problem.reward_scale
        deviation = None if scale is None else scale / problem.unit
        if self._lower_level == "likelihood":
            return LikelihoodLevel(Inference(likelihood, None if deviation is None else np.asarray(deviation)))
        size = (MATCHING_DEVIATION if deviation is None else deviation) * problem.expert_features.number**0.5
        return MatchingLevel(likelihood, Linear(problem.expert_features, size), 1e-3)


GSIIRL.__signature__ = signature_of(GSIIRL)  # pyright: ignore[reportAttributeAccessIssue] (what a notebook shows)


@jax.jit
def _report(learner: CommitmentLearner, states: LearnerState) -> dict[str, Array]:
    return jax.vmap(learner.report)(states)


@partial(jax.jit, compiler_options=QUICKLY)
def _end(learner: CommitmentLearner, states: LearnerState, keys: Array) -> PyTree:
    return jax.vmap(learner.end)(states, keys)


@partial(jax.jit, compiler_options=QUICKLY)
def _posterior_draws(learner: CommitmentLearner, states: LearnerState, keys: Array) -> Array:
    # Apart from the keys that the end splits.
    return jax.vmap(lambda state, key: learner.posterior_draws(state, jax.random.fold_in(key, 1)))(states, keys)


def _check_same_game(expert: Any, game: AbstractTabularGame) -> None:
    theirs = getattr(expert, "game", None)
    if not isinstance(theirs, AbstractTabularGame):
        return
    shapes = [(each.horizon, each.number_of_states, each.number_of_actions) for each in (theirs, game)]
    if shapes[0] != shapes[1]:
        raise InputError(
            "expert",
            f"lives in a game of {theirs.number_of_states} states and {theirs.horizon} steps",
            f"the problem's has {game.number_of_states} states and {game.horizon} steps: use the same game",
        )
    rules = [(each.allowed.learner, each.allowed.expert, each.terminal) for each in (theirs, game)]
    for name, one, other in zip(("learner_actions", "expert_actions", "terminal"), *rules, strict=True):
        if (one is None) != (other is None) or (one is not None and not np.array_equal(one, other)):  # pyright: ignore[reportArgumentType]
            raise InputError("expert", f"lives in a game of other {name} than the problem's", "use the same game")


def _history(rows: list[dict[str, np.floating]], trajectories: int) -> polars.DataFrame:
    columns: dict[str, Any] = {
        "iteration": np.arange(1, len(rows) + 1),
        "expert_trajectories": trajectories * np.arange(1, len(rows) + 1),
    }
    return polars.DataFrame(columns | {name: np.asarray([row[name] for row in rows]) for name in rows[0]})


def _warn(result: Result, draws: int) -> None:
    last = result.history.row(-1, named=True)
    if not last.get("fit_decrement", 0.0) <= FAR:  # not even a number, perhaps
        warn(
            f"seed {result.seed}: the estimate of the expert's reward has not converged "
            f"(it is {last['fit_decrement']:.1e} standard deviations from the maximum); more iterations help",
            FitWarning,
        )
    if draws and result.effective_draws < 0.1 * draws and not result.sampled:
        warn(
            f"seed {result.seed}: the posterior is far from Gaussian ({result.effective_draws:.1f} of {draws} draws "
            "count), so that the average the policy was chosen by is rough; more trajectories help",
            FitWarning,
        )
    lost = result.history["played_loss"][-LAST:].mean() if "played_loss" in result.history.columns else 0.0
    if result.history.height >= 2 * LAST and lost > UNSURE * _largest_difference(result.problem):  # pyright: ignore[reportOperatorIssue, reportOptionalOperand]
        warn(
            f"seed {result.seed}: in the last {LAST} iterations the policies that were played are expected to earn "
            f"{lost:.2g} less than the best one found (`played_loss`): too little is known of the expert's reward yet; "
            "more iterations or trajectories help",
            FitWarning,
        )


def _largest_difference(problem: Problem) -> float:
    """By how much two returns of the learner can differ."""
    reward = np.asarray((problem.own_reward + problem.dependent_value).dense())
    return float(np.ptp(reward) * np.sum(float(problem.discount) ** np.arange(problem.game.horizon)))


def _one_of(argument: str, value: str, names: tuple[str, ...]) -> str:
    if value not in names:
        raise InputError(argument, f"cannot be {value!r}", f"choose {' or '.join(names)}")
    return value
