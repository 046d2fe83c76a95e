"""From the paper's preset to the default, one change at a time."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gsiirl.experiments.config import load_config
from gsiirl.experiments.plans.plan import carry_out, check_folders, refuse_failures
from gsiirl.experiments.plans.planned_run import PlannedRun
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.runs import Ablation, AblationVariant


@dataclass(frozen=True)
class Change:
    """One setting in which the default differs from the paper's preset."""

    name: str
    description: str
    fields: dict[str, Any]
    budget: dict[str, Any] = field(default_factory=dict)
    """Settings that spend, from here on, the game solves which the change saves."""


ONE_POLICY = {
    "commitment": "policy",
    "feedback": "model",
    "explore": "estimate",
    "hand_back": "estimate",
    "starts": "one",
}
"""A commitment to a policy with nothing else changed."""

AWAY = dict.fromkeys(
    ("response", "hypergradient", "schedule", "honest_start", "perturbation", "perturbation_decay"), None
)
"""Settings of a commitment to a reward, which a commitment to a policy has not."""

CHANGES = (
    Change("response", "the response left out, not frozen", {"response": "well_specified"}, {"draws": 2}),
    Change(
        "played",
        "the policy as played, not the equilibrium, in the lower level",
        {"lower_level": "matching"},
        {"draws": 3},
    ),
    Change("memory", "16 remembered interactions, not the newest", {"remembered": 16}),
    Change("gradient", "the exact gradient, not SPSA", {"hypergradient": "implicit"}, {"draws": 1}),
    Change("steps", "Adam in both levels, not the paper's steps", {"schedule": "adam"}),
    Change("start", "the honest commitment tried before each step", {"honest_start": True}),
    Change("policy", "a policy for a commitment, not a reward", {**AWAY, **ONE_POLICY}),
    Change("starts", "many ascents in each iteration, not one", {"starts": "many"}),
    Change(
        "likelihood",
        "the conditional likelihood to convergence, not matching",
        {"lower_level": "likelihood", "remembered": None},
    ),
    Change(
        "thompson", "the best under a draw of the posterior is played, not under the estimate", {"explore": "thompson"}
    ),
    Change("average", "the best on average over the posterior is handed back", {"hand_back": "average"}),
    Change("informative", "policies that tell most are played in the first half", {"explore": "informative"}),
)
"""In the order in which they are made; with the last one the settings are the default's."""


def variants() -> Iterator[tuple[AblationVariant, dict[str, Any]]]:
    """Every variant with the fields it sets, from the paper's preset up."""
    fields: dict[str, Any] = {"algorithm": "paper"}
    yield AblationVariant("paper", "the paper's preset"), dict(fields)
    for change in CHANGES:
        fields |= change.fields | change.budget
        yield AblationVariant(change.name, change.description), dict(fields)


def run_ablation(
    base: Mapping[str, Any], graph_seeds: list[int], out: Path, jobs: int = 1, quiet: bool = False
) -> None:
    """Run every variant on every random graph, each into a run folder of its own under `out`, `jobs` at a time.

    What is finished there is kept, and what was interrupted is gone on with.

    Raises:
        InputError: a folder under `out` holds anything else, or a run could not be done.
    """
    ablation = Ablation(graphs=[f"graph-{seed}" for seed in graph_seeds], variants=[each for each, _ in variants()])
    planned = [
        PlannedRun(out / graph / variant.name, load_config(SecurityConfig, {**base, **fields, "graph_seed": seed}))
        for seed, graph in zip(graph_seeds, ablation.graphs, strict=True)
        for variant, fields in variants()
    ]
    check_folders(planned)
    ablation.write(out)
    refuse_failures(carry_out(planned, jobs, quiet))
