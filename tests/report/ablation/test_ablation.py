import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars
import pytest
from report.structure import faults

from gsiirl.errors import InputError, InputWarning
from gsiirl.report import write_ablation_page
from gsiirl.report.ablation.figure import ablation_charts
from gsiirl.report.ablation.results import AblationResults
from gsiirl.report.curves import point_charts
from gsiirl.report.read.verdict import RULE
from gsiirl.runs import Ablation, AblationVariant, RunFolder, summarise
from gsiirl.runs.files.json_file import write_json

SEEDS, ITERATIONS, MARL, RANDOM = 6, 2, -5.0, -6.0
PLAN = Ablation(
    ["graph-0", "graph-3"],
    [
        AblationVariant("paper", "the paper's preset"),
        AblationVariant("memory", "a memory"),
        AblationVariant("nothing", "no change at all"),
        AblationVariant("harm", "a change for the worse"),
    ],
)
MEANS = {"paper": -6.5, "memory": -5.5, "nothing": -5.5, "harm": -7.0}


def write_variant(path: Path, mean: float, completed: bool = True, noisy: bool = True) -> None:
    """A run whose deployed return ends at `mean`, with seeds ± 0.3 about it, the same for every variant."""
    config = {
        "experiment": "security",
        "algorithm": "gsiirl",
        "seeds": SEEDS,
        "iterations": ITERATIONS,
        "graph_seed": 0,
    }
    run = RunFolder.create(path, config, {"name": "made up"})
    shape = (SEEDS, ITERATIONS + 1)
    offsets = np.linspace(-0.3, 0.3, SEEDS)[:, None]
    # A different fall of each variant's noise: without it, paired differences would have no spread at all.
    noise = 0.05 * noisy * np.random.default_rng(abs(int(100 * mean)) + len(path.name)).normal(size=shape)
    noise -= noise.mean(axis=0, keepdims=True)
    columns = {
        "deployed_return_learner": mean + offsets + noise,
        "expert_reward_pearson": np.full(shape, 0.9),
        "truth_return_learner": np.full(shape, MARL),
        "random_return_learner": np.full(shape, RANDOM),
        "game_solves": np.broadcast_to(7.0 * np.arange(ITERATIONS + 1), shape),
        "expert_trajectories": np.broadcast_to(100.0 * np.arange(ITERATIONS + 1), shape),
    }
    seed, iteration = np.indices(shape)
    rows = {"seed": seed, "iteration": iteration, **columns}
    run.append_metrics(0, {name: np.ascontiguousarray(column).reshape(-1) for name, column in rows.items()})
    if completed:
        run.write_summary(summarise(run.config, run.metrics(), completed=True))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    PLAN.write(tmp_path)
    for graph in PLAN.graphs:
        for variant in PLAN.variants:
            write_variant(tmp_path / graph / variant.name, MEANS[variant.name])
    return tmp_path


def test_the_plan_reads_back_as_written(tmp_path):
    PLAN.write(tmp_path)
    assert Ablation.read(tmp_path) == PLAN


def test_changes_are_judged_by_paired_differences(folder):
    results = AblationResults.read(folder)
    first, *changes = PLAN.variants
    assert (results.verdicts(first), results.verdict(first)) == ([], "")
    # Seeds differ by up to 0.6, their differences do not.
    told = ("better", f"cannot tell with {SEEDS} seeds", "worse")
    for variant, verdict in zip(changes, told, strict=True):
        assert results.verdict(variant) == f"{verdict} on 2"


def test_a_variant_that_changes_nothing_is_the_same(tmp_path):
    Ablation(["graph-0"], PLAN.variants[:2]).write(tmp_path)
    for variant in PLAN.variants[:2]:
        write_variant(tmp_path / "graph-0" / variant.name, -6.0, noisy=False)
    assert AblationResults.read(tmp_path).verdict(PLAN.variants[1]) == "the same on 1"


def test_a_correlation_that_is_none_is_a_dash(folder):
    cell = AblationResults.read(folder).results["graph-0", "paper"]
    assert cell.correlation == "0.90"
    assert replace(cell, pearson=np.array([0.9, 0.0])).correlation == "\N{EN DASH}"


@pytest.mark.usefixtures("undrawn")
def test_the_page_can_be_read_by_all(folder):
    assert faults(write_ablation_page(folder).read_text()) == []


def test_how_it_was_made_is_told(folder):
    page = write_ablation_page(folder).read_text()
    assert "gsiirl ablation --graph-seeds 0,0 --seeds 6 --iterations 2 --out ablation" in page
    assert str(folder) not in page


def test_no_seed_is_left_out_for_ending_badly(folder):
    cell = AblationResults.read(folder).results["graph-0", "paper"]
    assert len(cell.deployed) == SEEDS
    assert cell.below_random == SEEDS
    assert cell.deployed.mean() == pytest.approx(MEANS["paper"])
    assert (cell.solves, cell.trajectories, cell.marl) == (14.0, 200.0, MARL)


def test_the_page_holds_every_variant_and_the_same_runs_give_the_same_bytes(folder):
    files = [write_ablation_page(folder), folder / "ablation.md", *sorted((folder / "figures").iterdir())]
    first = {path.name: path.read_bytes() for path in files}
    assert {"ablation.png", "ablation.svg", "index.html", "ablation.md"} == set(first)
    page, table = first["index.html"].decode(), first["ablation.md"].decode()
    for variant in PLAN.variants:
        assert variant.name in page
        assert f"| {variant.name}: {variant.description} |" in table
    assert "better on 2" in page
    assert f"cannot tell with {SEEDS} seeds on 2" in page
    assert RULE.split("(")[0] in page
    assert "http" not in page.replace("http://www.w3.org", "")
    write_ablation_page(folder)
    assert {path.name: path.read_bytes() for path in files} == first


def test_an_unfinished_run_is_named(folder):
    write_variant(folder / "graph-9" / "paper", -6.0, completed=False)
    Ablation(["graph-9"], PLAN.variants[:1]).write(folder)
    with pytest.raises(InputError, match=r"graph-9.paper: is not finished; run gsiirl ablation again"):
        write_ablation_page(folder)


def test_a_damaged_plan_is_named(tmp_path):
    write_json(tmp_path / "ablation.json", {"format_version": 1, "graphs": ["graph-0"]})
    with pytest.raises(InputError, match=r"ablation.json: is damaged"):
        write_ablation_page(tmp_path)


def test_a_plan_without_its_checksum_is_told(tmp_path: Path):
    PLAN.write(tmp_path)
    assert Ablation.read(tmp_path) == PLAN
    path = tmp_path / "ablation.json"
    path.write_bytes(path.read_bytes().replace(b'"checksum"', b'"unlisted"').replace(b"gsiirl-sha256:", b""))
    with pytest.warns(InputWarning, match="before files carried checksums"):
        assert Ablation.read(tmp_path) == PLAN


def test_the_chart_has_every_point_of_the_drawing(folder, monkeypatch):
    pytest.importorskip("altair")
    monkeypatch.setattr(point_charts, "charts_installed", lambda: True)
    found = ablation_charts(AblationResults.read(folder))
    assert found is not None
    (panel,) = found.panels
    assert ([each.label for each in found.runs], found.seeds) == (["graph 0", "graph 3"], [])
    content = json.loads(panel.specification)
    (rows,) = [each for each in content["datasets"].values() if isinstance(each, str)]
    table = polars.read_csv(rows.encode())
    assert table["at"].to_list() == 2 * ["paper", "+ memory", "+ nothing", "+ harm"]
    np.testing.assert_allclose(table["y"], 2 * [MEANS[each.name] - MARL for each in PLAN.variants], atol=1e-12)
    assert (table["low"] < table["y"]).all()
