"""What comes of living with an expert: a policy to deploy, two rewards, and how far to trust them."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np
import polars
from jaxtyping import Array, Float

from gsiirl.arguments import positive, seed_of
from gsiirl.commitment.objective import Commitment
from gsiirl.errors import FitWarning, InputError
from gsiirl.evaluation.result import Evaluation, evaluate
from gsiirl.front_door.html import html_of
from gsiirl.front_door.learned_reward import LearnedReward, interval_of
from gsiirl.front_door.results import AbstractResults
from gsiirl.front_door.saved_problem import problem_arrays, problem_settings
from gsiirl.front_door.transfer import policy_for
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.tabular import TabularGame
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.misfit.check import ModelCheck, check_model
from gsiirl.misfit.models import Observed
from gsiirl.problems.problem import Problem, joint_payoff
from gsiirl.program.presence import is_folder, is_there
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.runs.files.array_file import write_arrays
from gsiirl.runs.files.atomic import refuse_unwritable
from gsiirl.runs.files.damage import refuse_unreadable
from gsiirl.runs.files.json_file import FORMAT_VERSION, versioned, write_json
from gsiirl.runs.files.numbers import is_sound
from gsiirl.runs.files.table_file import write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEND = "save the result again"


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """What one run of `GSIIRL.fit` comes out with.

    Attributes:
        policy: π_l (T, S, A_l) to deploy: the commitment that is best on average over the posterior, or
            under the estimate with `hand_back="estimate"`.
        expert_policy: π_e (T, S, A_e), the response to `policy` that the point estimate of the expert's reward expects.
        expert_reward: r_e by the names of its weights; `.table` (S, A_l, A_e).
        dependent_reward: r_ld fitted to the values read along what was visited.
        history: a row an iteration: how well the fit converged (`fit_decrement`, in standard deviations from the
            maximum; `fit_converged`; `fit_steps`), the prior it chose, how many draws of the posterior count
            (`effective_draws`), and how much less the next policy played earns than the best, under the estimate
            (`played_loss`).
        played: the policies played while learning, (iterations, T, S, A_l); of long runs the last ones.
        answers: how often the expert did what against each of these, (iterations, T, S, A_e); not kept with
            `lower_level="matching"`, nor by runs of the command line.
        reached: (T, S), False where the game never arrives at that time, whatever is done; there the policy is uniform.
        effective_draws: how many of the draws that chose `policy` count; `sampled` whether they were too few, and
            Hamiltonian Monte Carlo took their place.
    """

    problem: Problem
    seed: int
    trajectories: int
    policy: np.ndarray
    expert_policy: np.ndarray
    expert_reward: LearnedReward
    dependent_reward: LearnedReward
    history: polars.DataFrame
    played: np.ndarray
    answers: np.ndarray
    reached: np.ndarray
    effective_draws: float
    sampled: bool

    @classmethod
    def learned(
        cls,
        *,
        problem: Problem,
        seed: int,
        trajectories: int,
        policy: np.ndarray,
        expert_policy: np.ndarray,
        expert_weights: np.ndarray,
        dependent_weights: np.ndarray,
        draws: np.ndarray,
        history: polars.DataFrame,
        played: np.ndarray,
        answers: np.ndarray,
        effective_draws: float,
        sampled: bool,
    ) -> "Result":
        """A result from arrays; where the game never arrives, the policy is made uniform.

        `draws` (K, m) of the expert's weights come from the posterior; K is 0 where there is none.
        """
        prior = history["prior_deviation"][-1] if "prior_deviation" in history.columns else np.nan
        reached = reachable(problem.game)
        allowed = problem.game.allowed.learner
        uniform = np.ones(policy.shape[1:]) if allowed is None else np.asarray(allowed, float)
        uniform = np.broadcast_to(uniform / uniform.sum(-1, keepdims=True), policy.shape)
        return cls(
            problem=problem,
            seed=seed,
            trajectories=trajectories,
            policy=np.where(reached[:, :, None], policy, uniform),
            expert_policy=np.array(expert_policy),
            expert_reward=LearnedReward(
                problem.expert_names,
                np.array(expert_weights),
                problem.expert_features,
                np.array(draws),
                problem.unit * prior,
            ),
            dependent_reward=LearnedReward(
                problem.dependent_names, np.array(dependent_weights), problem.dependent_features
            ),
            history=history,
            played=np.array(played),
            answers=np.array(answers),
            reached=reached,
            effective_draws=effective_draws,
            sampled=sampled,
        )

    def __repr__(self) -> str:
        return f"Result({self.problem!r}, seed {self.seed}, {len(self.history)} iterations of {self.trajectories})"

    def _repr_html_(self) -> str:
        return html_of(self)

    def plot(self) -> "Figure":
        """A figure: the expert's weights, what the learner earns, and how it commits itself.

        Weights and the return of `policy` have 90 % intervals where there is a posterior. Returns are discounted, and
        those that the estimate of the expert's reward expects. A notebook shows the figure;
        `result.plot().savefig("result.png")` writes it.
        """
        from gsiirl.front_door.plots import plotted

        return plotted(self)

    def act(self, state: int, t: int, key: Any) -> int:
        """The action to take in `state` at step `t`, drawn from the policy with NumPy alone.

        `key` is a seed, or a `numpy.random.Generator`, or a key of JAX. Where the game never arrives (`reached`) the
        action is drawn uniformly, and a `FitWarning` says so.

        Raises:
            InputError: there is no such state or step.
        """
        horizon, states, actions = self.policy.shape
        for name, value, limit in (("state", state, states), ("t", t, horizon)):
            whole = not (isinstance(value, bool) or np.ndim(value)) and np.asarray(value).dtype.kind in "iu"
            if not whole or not 0 <= value < limit:
                raise InputError(name, f"cannot be {value!r}", f"give a whole number from 0 to {limit - 1}")
        if not self.reached[t, state]:
            warnings.warn(
                f"state {state} was never to be met at step {t}: the game does not arrive there, and the policy is "
                "uniform; is the model of the game right?",
                FitWarning,
                stacklevel=2,
            )
        return int(_generator(key).choice(actions, p=self.policy[t, state]))

    def policy_for(self, problem: object, seed: int = 0) -> np.ndarray:
        """A policy π_l (T, S, A_l) to deploy where the game has changed: the best commitment, searched for anew.

        `problem` is a `Problem`. Both rewards are taken along, weight by name; its `dependent_value` is not read.

        Raises:
            InputError: it is none, or has a reward feature of which nothing was learned.
        """
        return policy_for(problem, self.problem, self.expert_reward, self.dependent_reward, seed)

    def answer_interval(self, policy: object, level: float = 0.9) -> tuple[np.ndarray, np.ndarray]:
        """Between which probabilities the expert's answer to a policy of the learner lies, with probability `level`.

        `policy` is π_l of shape (T, S, A_l) or (S, A_l), played or not. Returns the lower and upper bounds of
        π_e(a_e|s, t), each (T, S, A_e): quantiles of the soft best responses under draws of the posterior.

        Raises:
            InputError: the policy or the level cannot be, or the result has no posterior.
        """
        played = checked_policy("policy", policy, self.problem.game)
        draws = self.expert_reward.draws_for("answer_interval") / self.problem.unit
        with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
            model = ConditionalLikelihood(self.problem.game, self.problem.expert_features, self.problem.discount)
            answers = np.asarray(_answers(jax.tree.map(jax.numpy.asarray, model), played, jax.numpy.asarray(draws)))
        return interval_of(answers, level)

    def return_interval(self, level: float = 0.9, policy: object = None) -> tuple[float, float]:
        """Between which values the discounted return of a policy against the expert lies, with probability `level`.

        `policy` is `self.policy` unless given. f(π_l) is computed under draws of the posterior other than those that
        chose the policy; what is left open by the fit of r_ld, where only visited values are read, is not in it.

        Raises:
            InputError: the policy or the level cannot be, or the result has no posterior.
        """
        problem = self.problem
        played = checked_policy("policy", self.policy if policy is None else policy, problem.game)
        draws = self.expert_reward.draws_for("return_interval") / problem.unit
        with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
            commitment = Commitment(problem.game, problem.own_reward + problem.dependent_value, problem.discount)
            commitment, features = jax.tree.map(jax.numpy.asarray, (commitment, problem.expert_features))
            values = np.asarray(_values(commitment, features, played, jax.numpy.asarray(draws)))
        low, high = interval_of(values, level)
        return float(low), float(high)

    def check(self, seed: int = 0) -> ModelCheck:
        """Whether the expert behaved like a soft best response, and what fits better where it did not.

        `gsiirl.misfit.check` says how. `print(result.check())` says in a sentence what was found. It cannot see a wrong
        temperature: an expert with reward c·r_e at temperature c·τ behaves alike. `seed` is that of the simulated data.

        Raises:
            InputError: the result has no posterior, or keeps no answers of the expert.
        """
        problem, draws = self.problem, self.expert_reward.draws_for("check")
        if not len(self.answers):
            raise InputError("check", "needs the expert's answers, and this result keeps none", "fit it in Python")
        with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
            before = np.concatenate([self.played[:1], self.played[:-1]])
            return check_model(
                ConditionalLikelihood(problem.game, problem.expert_features, problem.discount),
                self.expert_reward.weights / problem.unit,
                float(problem.unit / self.expert_reward.prior_deviation) ** 2,
                draws / problem.unit,
                Observed(*map(jax.numpy.asarray, (self.played, before, self.answers))),
                jax.random.key(seed_of(seed)),
            )

    def evaluate(self, expert_reward: object, temperature: float | None = None) -> Evaluation:
        """What the policy earns against a soft best responder of the true reward, beside the best, random play, MARL.

        `expert_reward` is its r_e, an array (S, A_l, A_e); `temperature` its τ, which is the problem's unless given. An
        expert of another kind, or of another temperature, may answer otherwise: let it play against `policy`.

        Raises:
            InputError: an argument cannot be, or the temperature is missing.
        """
        if temperature is None and self.problem.temperature is None:
            raise InputError("temperature", "is not known to the problem", "give the true one to evaluate")
        true = self.problem.temperature if temperature is None else positive("temperature", temperature)
        if expert_reward is None:
            raise InputError("expert_reward", "is None", "give the true one, an array (S, A_l, A_e)")
        reward = joint_payoff("expert_reward", expert_reward, self.problem.game)
        assert true is not None
        return evaluate(self.problem, self.policy, self.played, reward, true, self.seed)

    def save(self, folder: str | Path) -> None:
        """Write the result, with the problem it is of, into a new or empty folder: safetensors, Parquet and JSON.

        Raises:
            InputError: the folder holds other files, or cannot be written.
        """
        path = Path(folder)
        with refuse_unreadable("folder", path, "use another folder"):
            if is_there(path) and (not is_folder(path) or any(path.iterdir())):
                raise InputError("folder", f"{path} is not empty", "use a new or empty folder")
        if not isinstance(self.problem.game, TabularGame):
            raise InputError("folder", "this problem's game is none of arrays", "keep its run folder instead")
        arrays = {
            "policy": self.policy,
            "expert_policy": self.expert_policy,
            "expert_weights": self.expert_reward.weights,
            "expert_draws": self.expert_reward.draws,
            "dependent_weights": self.dependent_reward.weights,
            "played": self.played,
            "answers": self.answers,
            **problem_arrays(self.problem),
        }
        content = {
            "kind": "result",
            "seed": self.seed,
            "trajectories": self.trajectories,
            "effective_draws": self.effective_draws,
            "sampled": self.sampled,
            **problem_settings(self.problem),
        }
        with refuse_unwritable("folder", path):
            write_arrays(path / "result.safetensors", arrays, {"format_version": str(FORMAT_VERSION)})
            columns = {name: self.history[name].to_numpy() for name in self.history.columns}
            types = {name: type(self.history.schema[name]) for name in self.history.columns}
            write_table(path / "history.parquet", columns, types)  # pyright: ignore[reportArgumentType]
            # Last, so that a folder without it is no result.
            write_json(path / "result.json", versioned(content))


class Results(AbstractResults[Result]):
    """The results of several seeds of a finite game, as a list of them."""

    def evaluate(self, expert_reward: object, temperature: float | None = None) -> polars.DataFrame:
        """`Result.evaluate` of every seed, a row each."""
        return self._table(each.evaluate(expert_reward, temperature) for each in self)


def check_shapes(result: Result, path: Path) -> None:
    """See that a result's arrays fit its problem.

    Raises:
        InputError: one does not.
    """
    game, draws, answers = result.problem.game, result.expert_reward.draws, result.answers
    actions = game.number_of_actions
    wanted = {
        "policy": (result.policy, (game.horizon, game.number_of_states, actions.learner)),
        "expert_policy": (result.expert_policy, (game.horizon, game.number_of_states, actions.expert)),
        "expert_weights": (result.expert_reward.weights, (len(result.problem.expert_names),)),
        "expert_draws": (draws, (*draws.shape[:1], len(result.problem.expert_names))),
        "dependent_weights": (result.dependent_reward.weights, (len(result.problem.dependent_names),)),
        "answers": (answers, (*answers.shape[:1], game.horizon, game.number_of_states, actions.expert)),
    }
    for name, (array, shape) in wanted.items():
        if array.shape != shape or array.dtype.kind != "f" or not is_sound(array).all():
            raise InputError(str(path), f"{name} is damaged: shape {array.shape} for {shape}, or not finite", MEND)


def checked_policy(argument: str, policy: object, game: AbstractTabularGame) -> Array:
    """π_l (T, S, A_l) of a user, who may leave the time out.

    Raises:
        InputError: the shape is another, or a row is no distribution.
    """
    shape = (game.horizon, game.number_of_states, game.number_of_actions.learner)
    array = np.asarray(policy, dtype=float)
    if array.shape == shape[1:]:
        array = np.broadcast_to(array, shape)
    if array.shape != shape:
        raise InputError(argument, f"has shape {array.shape}", f"give {shape}, or {shape[1:]} for every step alike")
    allowed = game.allowed.learner
    forbidden = allowed is not None and (array[:, ~np.asarray(allowed)] > 0).any()
    if forbidden or not (array >= 0).all() or not np.allclose(array.sum(axis=-1), 1.0, atol=1e-6):
        raise InputError(
            argument, "is no policy", "give probabilities that sum to 1 over the actions the learner may choose"
        )
    return jax.numpy.asarray(array)


def reachable(game: AbstractTabularGame) -> np.ndarray:
    """(T, S): whether the game can be in a state at a time, whatever the two sides do."""
    if not isinstance(game, TabularGame):
        return np.ones((game.horizon, game.number_of_states), bool)
    possible = np.asarray(game.probabilities) > 0
    for mask, axis in ((game.learner_actions, (2, 3)), (game.expert_actions, (1, 3))):
        if mask is not None:
            possible = possible & np.expand_dims(np.asarray(mask), axis)
    successors, here = np.asarray(game.successors), np.asarray(game.initial) > 0
    reached = []
    for _ in range(game.horizon):
        reached.append(here)
        follow = np.zeros_like(here)
        follow[successors[here][possible[here]]] = True
        here = follow
    return np.stack(reached)


def _generator(key: Any) -> np.random.Generator:
    if isinstance(key, np.random.Generator):
        return key
    if isinstance(key, jax.Array):
        typed = jax.numpy.issubdtype(key.dtype, jax.dtypes.prng_key)
        key = np.asarray(jax.random.key_data(key) if typed else key).ravel().tolist()
    try:
        return np.random.default_rng(key)
    except (TypeError, ValueError) as error:
        raise InputError("key", f"cannot be {key!r}", "give a seed, a numpy Generator, or a key of JAX") from error


@jax.jit
def _answers(
    likelihood: ConditionalLikelihood, policy: Float[Array, "T S A_l"], draws: Float[Array, "K m"]
) -> Float[Array, "K T S A_e"]:
    return jax.lax.map(lambda weights: jax.nn.softmax(likelihood.action_values(weights, policy)), draws)


@jax.jit
def _values(
    commitment: Commitment, features: AbstractFeatures, policy: Float[Array, "T S A_l"], draws: Float[Array, "K m"]
) -> Float[Array, " K"]:
    return jax.lax.map(lambda weights: commitment.value(policy, features.payoff(weights)), draws)
