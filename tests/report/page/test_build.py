"""A report is one page, figures and tables, written only where it may be."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import markupsafe
import numpy as np
import polars
import pytest
from report.synthetic import RING, SyntheticGame, dense_graph, write_comparison, write_run
from resealing import rewrite

from gsiirl.errors import InputError
from gsiirl.report import ReportFiles, build_report
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder, summarise

ONE_GAME = ("attack-graph", "recovery", "returns", "path")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return write_comparison(tmp_path_factory.mktemp("runs"))


@pytest.fixture(scope="module")
def files(runs: list[Path], tmp_path_factory: pytest.TempPathFactory) -> ReportFiles:
    return build_report(runs, tmp_path_factory.mktemp("report") / "out")


def table_of(files: ReportFiles) -> dict:
    return json.loads(files.table_json.read_text())


def content_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_every_file_is_written(files: ReportFiles) -> None:
    assert [path.name for path in files.figures] == [
        f"game-1-{name}.{ending}" for name in ONE_GAME for ending in ("png", "svg")
    ]
    for path in (files.page, files.table_markdown, files.table_json, *files.figures):
        assert path.stat().st_size > 0
    for path in files.figures:
        start = b"\x89PNG" if path.suffix == ".png" else b"<svg"
        assert path.read_bytes().startswith(start)
    assert sorted(table_of(files)["files"]) == sorted(content_of(files.page.parent))


def test_the_page_needs_nothing_but_itself(files: ReportFiles) -> None:
    page = files.page.read_text()
    assert "<script" not in page
    assert "http" not in page.replace("http://www.w3.org", "")
    assert len(page.encode()) < 1_000_000
    sources = re.findall(r'src="([^"]*)"', page)
    assert len(sources) == len(ONE_GAME)
    assert all(source.startswith("data:image/svg+xml,") for source in sources)


def test_figures_name_no_address_but_the_namespaces_of_svg(files: ReportFiles) -> None:
    for path in files.figures:
        if path.suffix == ".svg":
            addresses = set(re.findall(rb"https?://[^\"']*", path.read_bytes()))
            assert addresses == {b"http://www.w3.org/2000/svg", b"http://www.w3.org/1999/xlink"}


@pytest.mark.slow
def test_the_same_runs_give_the_same_bytes(runs: list[Path], files: ReportFiles, tmp_path: Path) -> None:
    build_report(runs, tmp_path / "again")
    assert content_of(tmp_path / "again") == content_of(files.page.parent)


def test_returns_are_those_of_the_summaries(runs: list[Path], files: ReportFiles) -> None:
    (group,) = table_of(files)["groups"]
    assert [row["algorithm"] for row in group["returns"]] == ["marl", "ma-irl", "gsiirl"]
    for row in group["returns"]:
        (path,) = [path for path in runs if path.name == row["algorithm"]]
        summary = RunFolder.open(path).summary()
        assert summary is not None
        for side in ("learner", "expert"):
            final = summary.final[f"deployed_return_{side}"]
            deployed = row[side]["deployed"]
            assert deployed["mean"] == pytest.approx(final.mean)
            assert deployed["std"] == pytest.approx(final.std)
            assert deployed["count"] == 3
            # Student's t with 2 degrees of freedom, 97.5 %.
            assert deployed["high"] - deployed["mean"] == pytest.approx(4.30265273 * final.std / np.sqrt(3))


def test_the_papers_figures_stand_beside_ours(files: ReportFiles) -> None:
    (group,) = table_of(files)["groups"]
    paper = {
        row["algorithm"]: (row["learner"]["paper"]["mean"], row["expert"]["paper"]["mean"]) for row in group["returns"]
    }
    assert paper == {"marl": (-16.96, 6.96), "ma-irl": (-17.08, 7.03), "gsiirl": (-17.38, 6.76)}
    for text in (files.page.read_text(), files.table_markdown.read_text()):
        assert "\N{MINUS SIGN}17.38 ± 3.59" in text
        assert "cannot be compared digit by digit" in text
        assert "undiscounted sums under the true rewards" in text


def test_page_and_markdown_show_the_numbers_of_the_table(files: ReportFiles) -> None:
    (group,) = table_of(files)["groups"]
    for row in group["returns"]:
        deployed = row["learner"]["deployed"]
        shown = f"\N{MINUS SIGN}{-deployed['mean']:.2f} ± {deployed['std']:.2f}"
        assert shown in files.page.read_text()
        assert shown in files.table_markdown.read_text()


@pytest.mark.usefixtures("undrawn")
def test_without_a_marl_run_its_row_comes_from_the_true_returns(runs: list[Path], tmp_path: Path) -> None:
    (group,) = table_of(build_report([runs[0]], tmp_path / "out"))["groups"]
    marl, gsiirl = group["returns"]
    assert (marl["algorithm"], gsiirl["algorithm"]) == ("marl", "gsiirl")
    assert marl["learner"]["deployed"]["mean"] == marl["learner"]["model"]["mean"] == pytest.approx(-6.3)
    assert marl["expert"]["deployed"]["mean"] == pytest.approx(4.2)


@pytest.mark.usefixtures("undrawn")
def test_a_marl_run_alone_makes_a_report(runs: list[Path], tmp_path: Path) -> None:
    files = build_report([path for path in runs if path.name == "marl"], tmp_path / "out")
    (group,) = table_of(files)["groups"]
    assert [row["algorithm"] for row in group["returns"]] == ["marl"]
    assert {path.stem for path in files.figures} == {"game-1-attack-graph"}


@pytest.mark.usefixtures("undrawn")
def test_failed_seeds_are_named_and_left_out(tmp_path: Path) -> None:
    paths = write_comparison(tmp_path / "runs", failed_seed=1)
    files = build_report(paths, tmp_path / "out")
    (group,) = table_of(files)["groups"]
    (row,) = [row for row in group["returns"] if row["algorithm"] == "gsiirl"]
    assert row["learner"]["deployed"]["count"] == 2
    assert row["learner"]["deployed"]["mean"] > -6
    (quality,) = [row for row in group["quality"] if row["algorithm"] == "gsiirl"]
    assert quality["failed_seeds"] == [1]
    page, markdown = files.page.read_text(), files.table_markdown.read_text()
    assert "1 of 3 seeds of GSIIRL failed (seed 1)" in page
    assert "2 of 3 (failed: 1)" in markdown
    # The means over all seeds stand beside those without it, in every table.
    overall = row["learner"]["deployed"]["all_seeds"]
    assert overall["count"] == 3
    assert overall["mean"] < -30
    told = f"all 3 seeds: \N{MINUS SIGN}{-overall['mean']:.2f} ± {overall['std']:.2f}"
    assert page.count(told) == 2
    assert markdown.count(f"({told})") == 2
    assert "all: 0.120 ± 0.000" in page


def test_a_run_whose_seeds_all_failed_is_told_and_drawn_nowhere(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "gsiirl", seeds=1, failed_seed=0)
    files = build_report([tmp_path / "run"], tmp_path / "out")
    (group,) = table_of(files)["groups"]
    assert group["returns"] == [
        {
            "label": "GSIIRL",
            "algorithm": "gsiirl",
            "source": "run run",
            "learner": {"paper": {"mean": -17.38, "std": 3.59}},
            "expert": {"paper": {"mean": 6.76, "std": 3.59}},
        }
    ]
    assert {path.stem for path in files.figures} == {"game-1-attack-graph"}
    assert "0 of 1 remain" in files.page.read_text()


@pytest.mark.usefixtures("undrawn")
def test_games_are_told_apart_and_each_has_its_figures(runs: list[Path], tmp_path: Path) -> None:
    zero_sum = write_run(tmp_path / "zero", "gsiirl", SyntheticGame(RING, variant="zero_sum"))
    dense = write_run(tmp_path / "dense", "gsiirl", SyntheticGame(dense_graph(), name="dense"))
    files = build_report([*runs, zero_sum.path, dense.path], tmp_path / "out")
    groups = table_of(files)["groups"]
    assert [(group["game"], group["variant"]) for group in groups] == [
        ("synthetic", "general_sum"),
        ("synthetic", "zero_sum"),
        ("dense", "general_sum"),
    ]
    assert {path.stem for path in files.figures} == {f"game-{game}-{name}" for game in (1, 2, 3) for name in ONE_GAME}


@pytest.mark.usefixtures("undrawn")
def test_two_runs_of_one_algorithm_carry_their_folders_names(runs: list[Path], tmp_path: Path) -> None:
    again = write_run(tmp_path / "again", "gsiirl", seeds=4)
    (group,) = table_of(build_report([runs[0], again.path, runs[0]], tmp_path / "out"))["groups"]
    assert [row["label"] for row in group["quality"]] == ["GSIIRL (gsiirl)", "GSIIRL (again)"]


@pytest.mark.usefixtures("undrawn")
def test_an_unknown_algorithm_is_shown_under_its_name(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "marl")
    rewrite(tmp_path / "run" / "config.json", '"marl"', '"their-own"')
    (tmp_path / "run" / "summary.json").unlink()
    files = build_report([tmp_path / "run"], tmp_path / "out")
    assert [row["label"] for row in table_of(files)["groups"][0]["quality"]] == ["their-own"]
    assert "their-own&#39;s defender reached" in files.page.read_text()


@pytest.mark.usefixtures("undrawn")
def test_an_interrupted_run_is_shown_as_far_as_it_came(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "gsiirl", iterations=7, completed=False)
    files = build_report([tmp_path / "run"], tmp_path / "out")
    (quality,) = table_of(files)["groups"][0]["quality"]
    assert (quality["completed"], quality["iterations"]) == (False, 7)
    assert "was interrupted: shown as far as iteration 7" in files.page.read_text()


def test_a_game_of_another_kind_has_returns_and_no_graph(tmp_path: Path) -> None:
    run = RunFolder.create(
        tmp_path / "run", {"experiment": "pursuit", "algorithm": "gsiirl"}, {"kind": "grid", "name": "maze"}
    )
    run.append_metrics(
        0,
        {
            "seed": np.array([0, 0]),
            "iteration": np.array([0, 1]),
            "deployed_return_learner": np.array([-3.0, -2.0]),
        },
    )
    files = build_report([run.path], tmp_path / "out")
    assert {path.stem for path in files.figures} == {"game-1-returns"}
    page = files.page.read_text()
    assert "GSIIRL&#39;s learner, deployed, earns \N{MINUS SIGN}2.00 an encounter." in page
    assert "attacker" not in page
    assert "Table 1" not in page


@pytest.mark.usefixtures("undrawn")
def test_names_of_the_users_are_text_and_nothing_else(tmp_path: Path) -> None:
    graph = {"nodes": ["a$x$", "b<b>"], "footholds": ["a$x$"], "edges": [("a$x$", "b<b>", 1.0)]}
    write_run(tmp_path / "run", "gsiirl", SyntheticGame(graph, name="<script>"), seeds=1, iterations=0)
    page = build_report([tmp_path / "run"], tmp_path / "out").page.read_text()
    assert "<script" not in page
    assert "&lt;script&gt;" in page


@pytest.mark.usefixtures("undrawn")
def test_one_host_where_nothing_can_be_gained_is_a_tie(tmp_path: Path) -> None:
    lone = {"nodes": ["a"], "footholds": [], "edges": [(None, "a", 0.5)]}
    run = write_run(tmp_path / "run", "gsiirl", SyntheticGame(lone), seeds=2, iterations=0)
    table = run.metrics()
    names = [name for name in table.columns if name.endswith("_return_learner")]
    rows = {name: table[name].to_numpy() for name in table.columns} | {name: np.full(2, -10.0) for name in names}
    rows["expert_reward_pearson"] = np.zeros(2)
    (run.path / "summary.json").unlink()
    run.append_metrics(0, {**rows, "deployed_return_learner": np.array([-10.0, -10.0 + 2e-15])})
    run.write_summary(summarise(run.config, run.metrics(), completed=True))
    files = build_report([run.path], tmp_path / "out")
    (group,) = table_of(files)["groups"]
    assert group["takeaways"][0].startswith("Nothing can be gained here")
    assert group["takeaways"][1] == "GSIIRL does the same as sharp MARL, MARL and random play."
    # A correlation that there is not has a dash, and no number anywhere.
    assert "expert_reward_pearson" not in group["quality"][0]
    assert "| Pearson, expert's reward |" in files.table_markdown.read_text()
    assert not re.search(r"\N{MINUS SIGN}0\.0+(?![0-9])", files.page.read_text())


@pytest.mark.usefixtures("undrawn")
def test_a_page_tells_how_it_was_made_and_no_path_of_the_machine(runs: list[Path], tmp_path: Path) -> None:
    copies = [tmp_path / "else" / path.name for path in runs]
    for path, copy in zip(runs, copies, strict=True):
        shutil.copytree(path, copy)
        rewrite(copy / "config.json", '"security"', f'"security", "graph": "{tmp_path}/mine.json"')
    # The same folder's name twice, so that labels would be alike.
    files = build_report([*copies, runs[0]], tmp_path / "out")
    page, markdown = files.page.read_text(), files.table_markdown.read_text()
    for text in (page, markdown, files.table_json.read_text()):
        assert str(tmp_path) not in text
        assert str(runs[0].parent) not in text
    for text in (page, markdown):
        assert "gsiirl run security --graph mine.json --algorithm ma-irl --seeds 3 --iterations 20 --out ma-irl" in text
        assert "2026-01-31" in text
    assert '<th scope="row">graph</th><td>mine.json</td>' in page


@pytest.mark.usefixtures("undrawn")
def test_a_variant_that_hands_the_learner_the_reward_says_so(tmp_path: Path) -> None:
    run = write_run(tmp_path / "zero", "gsiirl", SyntheticGame(RING, variant="zero_sum"), iterations=1)
    files = build_report([run.path], tmp_path / "out")
    told = "r_ld = \N{MINUS SIGN}r_e here"
    assert files.page.read_text().count(told) == 2
    assert f"is minus the attacker's reward. {told}" in files.table_markdown.read_text()


@pytest.mark.usefixtures("undrawn")
def test_names_of_any_kind_stand_whole_in_the_table_of_machines(tmp_path: Path) -> None:
    names = ["prod-eu-west-1-webserver-01", "prod-eu-west-1-webserver-02", "データベース", "{{ 7 * 7 }}", "a|<i>b</i>"]
    graph = {"nodes": names, "footholds": names[:1], "edges": [(names[0], name, 0.5) for name in names[1:]]}
    run = write_run(tmp_path / "run", "gsiirl", SyntheticGame(graph), seeds=1, iterations=0)
    files = build_report([run.path], tmp_path / "out")
    page, markdown = files.page.read_text(), files.table_markdown.read_text()
    for number, name in enumerate(names, start=1):
        assert f'<tr><td>{number}</td><th scope="row">{markupsafe.escape(name)}</th>' in page
    assert "| a\\|&lt;i>b&lt;/i> |" in markdown
    assert "| データベース |" in markdown


def test_a_folder_that_is_no_run_is_refused_and_nothing_written(runs: list[Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no run folder"):
        build_report([*runs, tmp_path], tmp_path / "out")
    with pytest.raises(InputError, match="no run folder is given"):
        build_report([], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_run_without_any_iteration_is_refused(tmp_path: Path) -> None:
    RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {})
    with pytest.raises(InputError, match=r"no finished iteration.*gsiirl resume"):
        build_report([tmp_path / "run"], tmp_path / "out")


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("game.json", '"success_probability"', '"chance"'),
        ("game.json", '"source": "web"', '"source": "nowhere"'),
        ("summary.json", '"failed_seeds"', '"seeds_that_failed"'),
        ("summary.json", '"per_seed"', '"each"'),
    ],
)
def test_a_damaged_run_is_named_in_one_line(tmp_path: Path, name: str, old: str, new: str) -> None:
    write_run(tmp_path / "run", "gsiirl")
    path = tmp_path / "run" / name
    rewrite(path, old, new)
    with pytest.raises(InputError, match=f"{name}: is damaged") as error:
        build_report([tmp_path / "run"], tmp_path / "out")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("below", [".", "report", "metrics/deep"])
@pytest.mark.usefixtures("undrawn")
def test_a_run_folder_is_never_written_into(tmp_path: Path, below: str) -> None:
    write_run(tmp_path / "run", "marl", seeds=1, iterations=1)
    before = content_of(tmp_path)
    with pytest.raises(InputError, match="is in the run folder"):
        build_report([tmp_path / "run"], tmp_path / "run" / below)
    assert content_of(tmp_path) == before


@pytest.mark.parametrize("name", ["index.html", "table.json", "figures/game-1-attack-graph.svg"])
@pytest.mark.usefixtures("undrawn")
def test_a_file_of_the_users_is_never_overwritten(tmp_path: Path, name: str) -> None:
    write_run(tmp_path / "run", "marl", seeds=1, iterations=1)
    mine = tmp_path / "out" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    with pytest.raises(InputError, match=f"holds {name}, not written by gsiirl report"):
        build_report([tmp_path / "run"], tmp_path / "out")
    assert content_of(tmp_path / "out") == {name: b"mine"}


def test_a_file_in_the_place_of_the_report_is_refused(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "marl", seeds=1, iterations=1)
    (tmp_path / "out").write_text("mine")
    for out in (tmp_path / "out", tmp_path / "out" / "below"):
        with pytest.raises(InputError) as error:
            build_report([tmp_path / "run"], out)
        assert error.value.field == "--out"
    assert (tmp_path / "out").read_text() == "mine"


@pytest.mark.usefixtures("undrawn")
def test_an_earlier_report_is_replaced_and_other_files_stay(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "marl", seeds=1, iterations=1)
    first = build_report([tmp_path / "run"], tmp_path / "out")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    first.page.write_text("stale")
    second = build_report([tmp_path / "run"], tmp_path / "out")
    assert second.page.read_text().startswith("<!DOCTYPE html>")
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


@pytest.mark.usefixtures("undrawn")
def test_reading_a_run_leaves_it_as_it_was(tmp_path: Path) -> None:
    write_run(tmp_path / "run", "gsiirl", completed=False)
    before = content_of(tmp_path / "run")
    build_report([tmp_path / "run"], tmp_path / "out")
    assert content_of(tmp_path / "run") == before


def test_runs_and_reports_import_no_jax_and_change_no_plotting_state() -> None:
    program = (
        "import sys, gsiirl.runs, gsiirl.report; "
        "bad = {'jax', 'jaxlib', 'equinox', 'matplotlib.pyplot'} & sys.modules.keys(); assert not bad, bad"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_a_metric_of_a_seed_that_failed_midway_does_not_bend_the_curves(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "gsiirl", failed_seed=1)
    curve = ReportedRun.read(run.path).curve("deployed_return_learner")
    assert curve is not None
    kept = run.metrics().filter(polars.col("seed") != 1)
    expected = kept.group_by("iteration").agg(polars.col("deployed_return_learner").mean()).sort("iteration")
    np.testing.assert_allclose(curve.mean, expected["deployed_return_learner"].to_numpy())
