"""Pictures of a result: what the expert wants, what was earned, how the learner commits."""

from collections.abc import Sequence
from io import BytesIO
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gsiirl.commitment.objective import Commitment
from gsiirl.front_door.learned_reward import interval_of
from gsiirl.games.base import AbstractTabularGame
from gsiirl.problems.problem import Problem
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.runs.learned import LEVEL
from gsiirl.types import Sides

SHOWN = 20
"""Weights, or states and steps, that a panel has room for: the largest weights, and those that are met most."""
LEARNED, UNDETERMINED, FAINT = "#2563eb", "#94a3b8", "#64748b"


class NotebookFigure(Figure):
    """A figure that belongs to no window, and that a notebook shows whatever matplotlib is set to."""

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        self.savefig(buffer, format="png", dpi=100)
        return buffer.getvalue()


def plotted(result: Any) -> Figure:
    """A `Result`: the expert's weights, what the learner earns, and how it commits itself."""
    reward, problem = result.expert_reward, result.problem
    known = len(reward.draws) > 0
    figure, (wanted, earned, committed) = new_figure(3)
    interval = interval_of(reward.draws, LEVEL) if known else None
    draw_weights(wanted, list(reward.names), reward.weights, interval, reward.determined if known else None)
    policies = np.concatenate([result.played, result.policy[None]])
    returns = expected_returns(problem, reward.weights / problem.unit, policies)
    ending = result.return_interval(LEVEL) if known else None
    draw_returns(earned, returns[:-1], float(returns[-1]), ending, "discounted return, as expected")
    draw_commitment(committed, result.policy, visited(problem, result.policy, result.expert_policy))
    return figure


def plotted_continuous(result: Any) -> Figure:
    """A `ContinuousResult`: the expert's weights, and what the learner earned."""
    figure, (wanted, earned) = new_figure(2)
    draw_weights(wanted, list(result.expert_reward.names), result.expert_reward.weights, None, None)
    exploring = result.history["exploring"].to_numpy().astype(bool)
    draw_returns(
        earned, np.where(exploring, np.nan, result.history["earned"].to_numpy()), None, None, "discounted return"
    )
    return figure


def expected_returns(problem: Problem, weights: np.ndarray, policies: np.ndarray) -> np.ndarray:
    """f(π_l) of every policy (K, T, S, A_l), if the expert's reward has these weights, in units of the temperature."""
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        commitment = Commitment(problem.game, problem.own_reward + problem.dependent_value, problem.discount)
        known = (commitment, problem.expert_features, policies, weights)
        return np.asarray(_values(*jax.tree.map(jax.numpy.asarray, known)))


def visited(problem: Problem, policy: np.ndarray, expert_policy: np.ndarray) -> np.ndarray:
    """(T, S) how often each state is met at each step, where the two policies meet."""
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        known = (problem.game, Sides(policy, expert_policy))
        return np.asarray(_distributions(*jax.tree.map(jax.numpy.asarray, known)))


def new_figure(panels: int) -> tuple[Figure, list[Axes]]:
    """A figure with panels in a row."""
    figure = NotebookFigure(figsize=(4.5 * panels, 3.6), layout="constrained")
    every = [figure.add_subplot(1, panels, place + 1) for place in range(panels)]
    for axes in every:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(colors=FAINT, labelsize=8)
    return figure, every


def draw_weights(
    axes: Axes,
    names: Sequence[str],
    weights: np.ndarray,
    interval: tuple[np.ndarray, np.ndarray] | None,
    determined: np.ndarray | None,
) -> None:
    """A point a weight with its interval; grey where the interactions did not determine it."""
    order = np.argsort(-np.abs(weights), kind="stable")[:SHOWN]
    order = np.sort(order)[::-1]
    known = np.ones(len(weights), bool) if determined is None else determined
    for place, weight in enumerate(order):
        colour = LEARNED if known[weight] else UNDETERMINED
        if interval is not None:
            axes.plot([interval[0][weight], interval[1][weight]], [place, place], color=colour, linewidth=2)
        axes.plot(weights[weight], place, "o", color=colour, markersize=4)
    axes.axvline(0.0, color="#cbd5e1", linewidth=1, zorder=0)
    axes.set_yticks(range(len(order)), [_short(str(names[int(weight)])) for weight in order])
    left = len(weights) - len(order)
    axes.set_title(
        _with_note("What the expert wants", f"the {SHOWN} largest of {len(weights)}" if left else ""), **_TITLE
    )
    axes.set_xlabel("weight, with its 90 % interval" if interval is not None else "weight", color=FAINT, fontsize=8)


def draw_returns(
    axes: Axes, earned: np.ndarray, ending: float | None, interval: tuple[float, float] | None, words: str
) -> None:
    """What the policies played earn, a point an iteration, and the one that is handed back."""
    axes.plot(np.arange(1, len(earned) + 1), earned, ".-", color=LEARNED, linewidth=1, markersize=4, label="played")
    if ending is not None:
        axes.axhline(ending, color=FAINT, linewidth=1, linestyle="--", label="handed back")
        if interval is not None:
            axes.axhspan(*interval, color=FAINT, alpha=0.15, linewidth=0, label="its 90 % interval")
        axes.legend(frameon=False, fontsize=8)
    axes.set_title("What the learner earns", **_TITLE)
    axes.set_xlabel("iteration", color=FAINT, fontsize=8)
    axes.set_ylabel(words, color=FAINT, fontsize=8)


def draw_commitment(axes: Axes, policy: np.ndarray, often: np.ndarray) -> None:
    """The probability of every action, a row a step and state; those that are met most, in the order of time."""
    met = np.argwhere(often > 0.0)
    most = np.sort(np.argsort(-often[tuple(met.T)], kind="stable")[:SHOWN])
    shown = met[most]
    axes.imshow(policy[tuple(shown.T)], vmin=0.0, vmax=1.0, cmap="Blues", aspect="auto")
    for row, (step, state) in enumerate(shown):
        for action, chance in enumerate(policy[step, state]):
            if chance >= 0.005 and policy.shape[2] <= 6:
                dark = "white" if chance > 0.6 else "#0f172a"
                axes.text(action, row, f"{chance:.2f}", ha="center", va="center", fontsize=7, color=dark)
    axes.set_yticks(range(len(shown)), [f"step {step}, state {state}" for step, state in shown])
    axes.set_xlabel("the learner's action", color=FAINT, fontsize=8)
    left = len(met) - len(shown)
    axes.set_title(
        _with_note("The commitment", f"where it is met most, {SHOWN} of {len(met)}" if left else ""), **_TITLE
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


@jax.jit
def _distributions(game: AbstractTabularGame, policies: Sides[Float[Array, "..."]]) -> Float[Array, "T S"]:
    def one(distribution: Float[Array, " S"], now: Sides[Float[Array, "..."]]) -> tuple[Array, Array]:
        return game.advance(distribution, now), distribution

    return jax.lax.scan(one, jax.numpy.asarray(game.initial), policies)[1]


@jax.jit
def _values(
    commitment: Commitment, features: AbstractFeatures, policies: Float[Array, "K T S A_l"], weights: Float[Array, " m"]
) -> Float[Array, " K"]:
    return jax.lax.map(lambda policy: commitment.value(policy, features.payoff(weights)), policies)


_TITLE: dict[str, Any] = {"loc": "left", "fontsize": 10, "fontweight": "bold", "color": "#0f172a"}


def _with_note(title: str, note: str) -> str:
    return f"{title}\n({note})" if note else title


def _short(name: str) -> str:
    return name if len(name) <= 28 else name[:27] + "…"
