"""The results of several seeds together, of finite and of continuous games."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Generic, Protocol, TypeVar, overload, runtime_checkable

import numpy as np
import polars

from gsiirl.front_door.html import html_of_several


@runtime_checkable
class OneSeed(Protocol):
    """What the result of one seed has."""

    @property
    def seed(self) -> int:
        """The seed."""
        ...

    @property
    def problem(self) -> Any:
        """The problem it is of."""
        ...

    @property
    def expert_reward(self) -> Any:
        """The learned reward of the expert, with `names` and `weights`."""
        ...


One = TypeVar("One", bound=OneSeed)


class AbstractResults(Sequence[One], Generic[One]):
    """The results of several seeds, as a list of them."""

    def __init__(self, results: Sequence[One]) -> None:
        self._results = list(results)

    @overload
    def __getitem__(self, index: int) -> One: ...

    @overload
    def __getitem__(self, index: slice) -> list[One]: ...

    def __getitem__(self, index: Any) -> Any:
        return self._results[index]

    def __len__(self) -> int:
        return len(self._results)

    def __repr__(self) -> str:
        seeds = [each.seed for each in self._results]
        return f"{type(self).__name__}({self._results[0].problem!r}, seeds {seeds[0]} to {seeds[-1]})"

    def _repr_html_(self) -> str:
        return html_of_several(self)

    @property
    def mean(self) -> dict[str, float]:
        """Mean over seeds of every weight of the expert's reward."""
        weights = np.mean([each.expert_reward.weights for each in self._results], axis=0)
        return dict(zip(self._results[0].expert_reward.names, weights.tolist(), strict=True))

    @property
    def spread(self) -> dict[str, float]:
        """Standard deviation over seeds (n − 1) of every weight of the expert's reward."""
        every = [each.expert_reward.weights for each in self._results]
        spread = np.std(every, axis=0, ddof=1) if len(every) > 1 else np.zeros_like(every[0])
        return dict(zip(self._results[0].expert_reward.names, spread.tolist(), strict=True))

    def _table(self, evaluations: Iterable[Mapping[str, Any]]) -> polars.DataFrame:
        """The numbers of an evaluation of every seed, a row each."""
        rows = []
        for each, evaluation in zip(self._results, evaluations, strict=True):
            numbers = {name: value for name, value in evaluation.items() if isinstance(value, float)}
            rows.append({"seed": each.seed, **numbers})
        return polars.DataFrame(rows)
