"""A reward that was learned, and how far the interactions leave it open.

What is known of the weights w is held as draws from the posterior p(w | all interactions). An interval at level c goes
from the (1 − c)/2 to the (1 + c)/2 quantile of the draws: of a weight, or of a reward value r(s, a) = Σ_i w_i φ_i.

A weight is *determined* where its standard deviation over the draws is at most half of the prior's: what was seen has
then told at least as much as three independent looks as vague as the prior.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import jax
import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.rewards.linear import AbstractFeatures, IndicatorFeatures, TabularFeatures
from gsiirl.runs.learned import DETERMINED, quantiles, share_of_prior

ALIKE = 0.25
"""By how much entries of a direction may differ from their mean, as a share of it, to be called a common constant."""
SHOWN = 5
"""Weights that the words for a direction name."""


class LearnedReward(Mapping[str, float]):
    """A reward that was learned: the weights of its features by name.

    Attributes:
        weights: (m,), in the order of the names, in reward units (of the temperature where that is unknown).
        draws: (K, m) draws from the posterior, in the same units; K is 0 where the reward has no posterior.
        prior_deviation: standard deviation of each weight's prior, in the same units; NaN where there is none.
    """

    def __init__(
        self,
        names: Sequence[str],
        weights: np.ndarray,
        features: AbstractFeatures,
        draws: np.ndarray | None = None,
        prior_deviation: float = np.nan,
    ) -> None:
        self.names, self.weights, self._features = names, weights, features
        self.draws = np.zeros((0, len(weights))) if draws is None else draws
        self.prior_deviation = prior_deviation

    def __getitem__(self, name: str) -> float:
        return float(self.weights[self._places[name]])

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.names)}

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"LearnedReward({len(self)} weights, {self.weights.min():.3g} to {self.weights.max():.3g})"

    @property
    def table(self) -> np.ndarray:
        """The reward of every (state, learner's action, expert's action), (S, A_l, A_e)."""
        return self._table(self.weights)

    def interval(self, level: float = 0.9) -> tuple[np.ndarray, np.ndarray]:
        """Between which values every reward r(s, a_l, a_e) lies with probability `level`: two tables (S, A_l, A_e).

        Raises:
            InputError: the level cannot be, or the reward has no posterior.
        """
        draws = self.draws_for("interval")
        return interval_of(np.stack([self._table(each) for each in draws]), level)

    def weight_intervals(self, level: float = 0.9) -> polars.DataFrame:
        """A row a weight: `name`, `estimate`, `low` and `high` of the interval at `level`, and whether `determined`.

        Raises:
            InputError: the level cannot be, or the reward has no posterior.
        """
        low, high = interval_of(self.draws_for("weight_intervals"), level)
        columns = {"estimate": self.weights, "low": low, "high": high, "determined": self.determined}
        return polars.DataFrame({"name": list(self.names), **columns})

    @property
    def determined(self) -> np.ndarray:
        """(m,) whether the interactions determined each weight.

        Raises:
            InputError: the reward has no posterior.
        """
        return share_of_prior(self.draws_for("determined"), self.prior_deviation) <= DETERMINED

    @property
    def undetermined(self) -> list[str]:
        """In words, what the interactions did not determine: single weights, then directions of several together.

        A direction is a unit vector v of the determined weights for which the deviation of v·w is above half of the
        prior's: an eigenvector of the covariance of the draws.

        Raises:
            InputError: the reward has no posterior.
        """
        determined, names = self.determined, list(self.names)
        words = [
            f"{name}: not pinned down by what was seen"
            for name, known in zip(names, determined, strict=True)
            if not known
        ]
        kept = np.flatnonzero(determined)
        if kept.size < 2:
            return words
        # Draws are few: their singular vectors are the eigenvectors of a covariance that may be large.
        centred = (self.draws[:, kept] - self.draws[:, kept].mean(axis=0)) / self.prior_deviation
        _, sizes, directions = np.linalg.svd(centred / np.sqrt(len(centred) - 1), full_matrices=False)
        for place in np.flatnonzero(sizes > DETERMINED):
            words.append(_described(directions[place], [names[each] for each in kept]))
        return words

    def anchored(self, name: str, value: float) -> "LearnedReward":
        """The reward in the units in which the weight of `name` is `value`.

        Where the temperature is unknown, rewards are learned in units of it; one cost that is known gives the rest.

        Raises:
            InputError: there is no such weight, or it has the other sign, or is 0.
        """
        if name not in self._places:
            raise InputError("name", f"{name!r} is no weight", f"choose from {', '.join(list(self.names)[:10])}")
        number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if not number or not np.isfinite(value) or self[name] * value <= 0:
            raise InputError("value", f"cannot be {value!r}", f"its sign must be that of the weight, {self[name]:.3g}")
        unit = value / self[name]
        return LearnedReward(
            self.names, self.weights * unit, self._features, self.draws * unit, self.prior_deviation * unit
        )

    def draws_for(self, wanted: str) -> np.ndarray:
        """The draws.

        Raises:
            InputError: naming what was `wanted`, where there are none.
        """
        if not len(self.draws):
            problem = "needs a posterior, and this reward has none"
            raise InputError(wanted, problem, 'fit the expert\'s reward with lower_level="likelihood"')
        return self.draws

    def _table(self, weights: np.ndarray) -> np.ndarray:
        if isinstance(self._features, IndicatorFeatures):
            return weights.reshape(self._features.shape)
        if isinstance(self._features, TabularFeatures):
            return np.asarray(self._features.table) @ weights
        return dense(self._features.payoff(jax.numpy.asarray(weights)))


def interval_of(draws: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Quantiles (1 − level)/2 and (1 + level)/2 along the first axis.

    Raises:
        InputError: the level is not between 0 and 1.
    """
    if isinstance(level, bool) or not isinstance(level, int | float) or not 0 < level < 1:
        raise InputError("level", f"cannot be {level!r}", "give a probability between 0 and 1, as 0.9")
    low, high = quantiles(draws, level)
    return np.asarray(low), np.asarray(high)


def dense(payoff: AbstractPayoff) -> np.ndarray:
    """The table of a payoff, in double precision whatever JAX is set to."""
    with jax.enable_x64(True):
        return np.asarray(payoff.dense())


def _described(direction: np.ndarray, names: list[str]) -> str:
    """Words for a direction that is not determined."""
    size = np.abs(direction)
    large = np.flatnonzero(size > 0.3 * size.max())
    named = [names[place] for place in large[np.argsort(-size[large], kind="stable")]]
    shown = ", ".join(sorted(named, key=names.index)[:SHOWN]) + (", ..." if len(named) > SHOWN else "")
    entries = direction[large]
    if np.all(np.abs(entries - entries.mean()) <= ALIKE * np.abs(entries.mean())):
        return f"a common constant in {shown}"
    return f"a combination of {shown}"
