"""From the paper's preset to the default, one change at a time, and back from the default, one change taken away."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gsiirl.errors import InputError
from gsiirl.experiments.config import config_from_dict, load_config
from gsiirl.experiments.security import SecurityConfig
from gsiirl.runs import Ablation, RunFolder, Variant


@dataclass(frozen=True)
class Change:
    """One setting in which the default differs from the paper's preset: `default` and `paper` are fields' values."""

    name: str
    description: str
    default: dict[str, Any]
    paper: dict[str, Any]
    budget: dict[str, Any] = field(default_factory=dict)
    """Settings that spend, on the ladder from here on, the game solves which the change saves."""


CHANGES = (
    Change(
        "response",
        "the response left out, not frozen",
        {"response": "well_specified"},
        {"response": "frozen"},
        {"draws": 2},
    ),
    Change(
        "played",
        "the policy as played, not the equilibrium, in the lower level",
        {"lower_level": "played"},
        {"lower_level": "equilibrium"},
        {"draws": 3},
    ),
    Change("memory", "16 remembered interactions, not the newest", {"remembered": 16}, {"remembered": 1}),
    Change(
        "gradient",
        "the exact gradient, not SPSA",
        {"hypergradient": "implicit"},
        {"hypergradient": "spsa", "draws": 1},
        {"draws": 1},
    ),
    Change("steps", "Adam in both levels, not the paper's steps", {"schedule": "adam"}, {"schedule": "paper"}),
    Change("start", "the honest commitment tried before each step", {"honest_start": True}, {"honest_start": False}),
)
"""In the order of the ladder."""


def variants() -> Iterator[tuple[Variant, dict[str, Any]]]:
    """Every variant with the fields it sets: the ladder up from the paper's preset, then the default without each."""
    fields: dict[str, Any] = {"algorithm": "paper"}
    yield Variant("paper", "ladder", "the paper's preset"), dict(fields)
    for change in CHANGES:
        fields |= change.default | change.budget
        yield Variant(change.name, "ladder", change.description), dict(fields)
    for change in CHANGES:
        yield Variant(f"without-{change.name}", "without", change.description), {"algorithm": "gsiirl"} | change.paper


def run_ablation(base: Mapping[str, Any], graph_seeds: list[int], out: Path) -> None:
    """Run every variant on every random graph, each into a run folder of its own under `out`.

    What is finished there is kept, and what was interrupted is gone on with.

    Raises:
        InputError: a folder under `out` holds another run.
    """
    from gsiirl.experiments import runner

    ablation = Ablation(graphs=[f"graph-{seed}" for seed in graph_seeds], variants=[each for each, _ in variants()])
    # The ladder on all graphs comes first: it is what one wants to see.
    planned = [
        (out / graph / variant.name, load_config({**base, **fields, "graph_seed": seed}))
        for series in ("ladder", "without")
        for seed, graph in zip(graph_seeds, ablation.graphs, strict=True)
        for variant, fields in variants()
        if variant.series == series
    ]
    for folder, config in planned:
        if RunFolder.is_at(folder):
            _refuse_another(folder, config)
    ablation.write(out)
    for folder, config in planned:
        if RunFolder.is_at(folder):
            runner.resume(folder)
        else:
            runner.run(config, folder)


def _refuse_another(folder: Path, config: SecurityConfig) -> None:
    if config_from_dict(RunFolder.open(folder).config, folder / "config.json") != config.resolved():
        raise InputError("--out", f"{folder} holds a run with other settings", "use another folder")
