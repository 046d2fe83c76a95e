"""The fields that every experiment's configuration has."""

from typing import ClassVar, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

CHECKED = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

MANY = 1_000_000
"""The bound of a number of iterations, episodes or steps: above what anybody needs, and below where arithmetic ends."""
MOST_SEEDS = 10_000
"""With the bound of `first_seed`, no seed is beyond 32 bits: JAX's integers of single precision would wrap around."""


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class RunConfig:
    """Everything that decides a run: the fields are flags, TOML keys and entries of `config.json`."""

    experiment: ClassVar[str]
    """The name of the experiment on the command line."""
    preparation: ClassVar[str]
    """Module and name of the function that prepares a run of it."""
    double_precision: ClassVar[bool]
    """Whether its arrays are float64."""

    algorithm: Literal["gsiirl", "paper", "ma-irl", "lin2019", "marl"] = "gsiirl"
    """Which algorithm learns: `gsiirl` (our preset), `paper` (the same with the paper's settings), `ma-irl`, or
    `lin2019` (the linear programs of Lin et al.); `marl` is given both true rewards."""
    seeds: int = Field(default=10, ge=1, le=MOST_SEEDS)
    """Number of seeds."""
    first_seed: int = Field(default=0, ge=0, le=2**31 - MOST_SEEDS)
    """The first seed; the others follow."""
    iterations: int = Field(default=50, ge=0, le=MANY)
    """Outer iterations K."""
    trajectories: int = Field(default=100, ge=1, le=MANY)
    """Trajectories asked of the expert in each interaction."""
    device: Literal["cpu", "gpu"] = "cpu"
    """Where the arrays live."""
