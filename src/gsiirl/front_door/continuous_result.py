"""What comes of living with an expert in a continuous game: a policy to deploy, and two rewards."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import polars
from jaxtyping import Array, Float, PyTree

from gsiirl.arguments import seed_of, whole_number
from gsiirl.equilibria.pathwise import Pathwise
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.errors import InputError
from gsiirl.evaluation.continuous_result import ContinuousEvaluation, evaluate
from gsiirl.evaluation.true_returns import TrueReturns
from gsiirl.front_door.html import html_of
from gsiirl.front_door.results import AbstractResults
from gsiirl.front_door.transfer import network_for
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.problems.continuous_problem import ContinuousProblem, random_steps, reward_of, single_precision
from gsiirl.rewards.continuous import AbstractTransitionReward, TransitionReward
from gsiirl.types import Sides, Transition

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class LearnedTransitionReward(Mapping[str, float]):
    """A reward that was learned: the weights of its features by name, and a function of one step.

    `parameters` θ is in the unit ball; `weights` is the same in reward units, in the order of the names.
    """

    def __init__(self, reward: AbstractTransitionReward, parameters: np.ndarray) -> None:
        self.parameters, self._reward = parameters, reward

    @property
    def names(self) -> Sequence[str]:
        """A name for each weight."""
        return self._reward.names

    @property
    def weights(self) -> np.ndarray:
        """The weights, scale · θ."""
        return self._reward.scale * self.parameters

    def __getitem__(self, name: str) -> float:
        if name not in self.names:
            raise KeyError(name)
        return float(self.weights[self.names.index(name)])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __call__(self, transition: Transition) -> Float[Array, ""]:
        """r(s, a, s')."""
        return self._reward(jnp.asarray(self.parameters), transition)

    def __repr__(self) -> str:
        return f"LearnedTransitionReward({len(self)} weights, {self.weights.min():.3g} to {self.weights.max():.3g})"


@dataclass(frozen=True, repr=False, eq=False)
class ContinuousResult:
    """What one run of `GSIIRL.fit` comes out with in a continuous game.

    Attributes:
        policy: π_l to deploy, a network: (what the learner observes, t/T) ↦ its action in [−1, 1]^A.
        expert_policy: the answer to `policy` that the learner expects.
        expert_reward: r_e by the names of its weights; a function of one step.
        dependent_reward: r_ld fitted to the values read along what was visited.
        history: a row an iteration: whether the policy played was one to learn from (`exploring`), the learner's
            discounted return in what was seen (`earned`), and how far the weights of r_e moved (`reward_change`, in
            reward units).
        true_returns: what policies earn under a true r_e, given it, steps of training, of judging, and episodes.
        solver: the forward model, given the steps over which its rate falls.
    """

    problem: ContinuousProblem
    seed: int
    trajectories: int
    policy: PolicyNetwork
    expert_policy: PolicyNetwork
    expert_reward: LearnedTransitionReward
    dependent_reward: LearnedTransitionReward
    history: polars.DataFrame
    true_returns: Callable[[TransitionReward, int, int, int], TrueReturns]
    solver: Callable[[int], Pathwise]

    def __repr__(self) -> str:
        rounds = f"{len(self.history)} iterations of {self.trajectories}"
        return f"ContinuousResult({self.problem!r}, seed {self.seed}, {rounds})"

    def _repr_html_(self) -> str:
        return html_of(self)

    def plot(self) -> "Figure":
        """A figure: the expert's weights, and what the learner earned in each iteration, discounted.

        Iterations that were played to explore are left out. A notebook shows the figure;
        `result.plot().savefig("result.png")` writes it.
        """
        from gsiirl.front_door.plots import plotted_continuous

        return plotted_continuous(self)

    def act(self, state: PyTree, t: int, key: object = None) -> np.ndarray:
        """The action (A_l,) to take in `state` at step `t`, counted from 0.

        The policy is deterministic: `key` is not needed, and is there so that the call is that of a finite game.

        Raises:
            InputError: there is no such state or step.
        """
        game = self.problem.game
        step = whole_number("t", t, 0)
        if step >= game.horizon:
            raise InputError("t", f"cannot be {t!r}", f"give a whole number from 0 to {game.horizon - 1}")
        with single_precision():
            wanted = eqx.filter_eval_shape(game.reset, jax.random.key(0))
            alike = jax.tree.structure(state) == jax.tree.structure(wanted) and all(
                np.shape(given) == leaf.shape
                for given, leaf in zip(jax.tree.leaves(state), jax.tree.leaves(wanted), strict=True)
            )
            if not alike:
                raise InputError("state", f"is no state of {type(game).__name__}", "give one as reset or step make it")
            arrays = jax.tree.map(lambda given, leaf: jnp.asarray(given, leaf.dtype), state, wanted)
            return np.asarray(_action(game, self.policy, arrays, jnp.asarray(step / game.horizon, jnp.float32)))

    def policy_for(self, problem: object, seed: int = 0, *, training_steps: int = 1000) -> PolicyNetwork:
        """A policy π_l to deploy where the game has changed: both networks are trained anew under both learned rewards.

        `problem` is a `Problem` whose sides observe and do the same kinds of things as before, in the same order.
        Linear rewards are taken along weight by name, and whatever the scales; others need the settings that they had.
        The `dependent_value` of `problem` is not read. Half of the `training_steps` are taken both from this result's
        pair of policies and from a random one; where the learner expects to earn more, the search goes on.

        Like `policy`, what is returned is a function of what the learner observes and t/T.

        Raises:
            InputError: an argument cannot be, or `problem` has a reward feature of which nothing was learned.
        """
        steps, pair = whole_number("training_steps", training_steps, 1), Sides(self.policy, self.expert_policy)
        learned = Sides(self.dependent_reward.parameters, self.expert_reward.parameters)
        with single_precision():
            key, solver = jax.random.key(seed_of(seed)), self.solver(steps)
        return network_for(problem, self.problem, learned, pair, solver, key, steps)

    def evaluate(
        self, expert_reward: TransitionReward, *, training_steps: int = 1000, evaluation_episodes: int = 1000
    ) -> ContinuousEvaluation:
        """What the policy earns against the true expert, beside random play and MARL.

        `expert_reward` is the true r_e. Best responses and MARL take `training_steps` steps; returns are means over
        `evaluation_episodes` episodes.

        Raises:
            InputError: an argument cannot be.
        """
        if expert_reward is None:
            raise InputError("expert_reward", "is None", "give the true one, a function of one step")
        reward = reward_of("expert_reward", expert_reward, random_steps(self.problem.game))
        steps = whole_number("training_steps", training_steps, 1)
        with single_precision():
            true = self.true_returns(reward, steps, steps, whole_number("evaluation_episodes", evaluation_episodes, 1))
            pair = Sides(self.policy, self.expert_policy)
            return evaluate(true, pair, self.problem.discount, jax.random.key(self.seed))


class ContinuousResults(AbstractResults[ContinuousResult]):
    """The results of several seeds of a continuous game, as a list of them."""

    def evaluate(self, expert_reward: TransitionReward, **settings: int) -> polars.DataFrame:
        """`ContinuousResult.evaluate` of every seed, a row each."""
        return self._table(each.evaluate(expert_reward, **settings) for each in self)


@eqx.filter_jit
def _action(game: AbstractContinuousGame[Any], policy: PolicyNetwork, state: PyTree, time: Float[Array, ""]) -> Array:
    return policy(game.observe(state).learner, time)
