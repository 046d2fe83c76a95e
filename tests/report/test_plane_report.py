"""Reports of the crossing and of deception, alone and beside each other."""

import base64
import io
import json
import re
from pathlib import Path

import numpy as np
import polars
import pytest
from PIL import Image
from report.synthetic import write_run
from report.synthetic_plane import DECEPTION, FEATURES, LITTLE, STEPS, write_plane_comparison, write_plane_run

from gsiirl.errors import InputError
from gsiirl.report import ReportFiles, build_report
from gsiirl.report.deception_figures import deception_figures
from gsiirl.report.figure_style import figure_style
from gsiirl.report.figures import draw_figures
from gsiirl.report.group import GameGroup, group_runs
from gsiirl.report.rates_figure import draw_rates
from gsiirl.report.returns_figure import draw_returns
from gsiirl.report.run import ReportedRun
from gsiirl.report.weights_figure import draw_weights
from gsiirl.runs import RunFolder

ONE_GAME = {
    "crossing": ["animation", "returns", "rates", "reward-map", "path"],
    "deception": ["animation", "returns", "weights", "path"],
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("runs")
    return {
        "crossing": write_plane_comparison(folder / "crossing", "crossing", failed_seed=1),
        "deception": write_plane_comparison(folder / "deception", "deception"),
        "security": [write_run(folder / "security", "gsiirl").path],
    }


@pytest.fixture(scope="module")
def files(runs: dict[str, list[Path]], tmp_path_factory: pytest.TempPathFactory) -> ReportFiles:
    return build_report([*runs["crossing"], *runs["deception"], *runs["security"]], tmp_path_factory.mktemp("out"))


def group_of(paths: list[Path]) -> GameGroup:
    (group,) = group_runs([ReportedRun.read(path) for path in paths])
    return group


def table_of(files: ReportFiles) -> dict:
    return json.loads(files.table_json.read_text())


def test_each_game_has_its_figures(files: ReportFiles) -> None:
    names = list(dict.fromkeys(path.stem for path in files.figures))
    for number, experiment in enumerate(("crossing", "deception"), start=1):
        assert [name for name in names if name.startswith(f"game-{number}-")] == [
            f"game-{number}-{name}" for name in ONE_GAME[experiment]
        ]


def test_captions_of_what_was_lived_through_say_who_explores(runs: dict[str, list[Path]]) -> None:
    told = {
        experiment: {
            figure.name
            for figure in draw_figures(group_of(runs[experiment]))
            if "Encounters that GSIIRL plays to see more, not to earn, are left out." in figure.caption
        }
        for experiment in ("crossing", "deception")
    }
    assert told == {"crossing": {"game-1-returns", "game-1-rates"}, "deception": {"game-1-returns"}}


def test_curves_leave_out_what_is_played_to_see_more(runs: dict[str, list[Path]]) -> None:
    run = group_of(runs["crossing"]).of("gsiirl")
    assert run is not None
    earned, rates = run.curve("deployed_return_learner"), run.curve("collision_rate")
    assert earned is not None
    assert rates is not None
    assert run.metrics["deployed_return_learner"].min() == LITTLE
    assert earned.mean.min() > LITTLE / 2
    assert earned.iteration.tolist() == rates.iteration.tolist() == [0, 1, 3, 4, 6, 7, 9, 10]


def test_captions_are_silent_and_curves_whole_where_nobody_explores(tmp_path: Path) -> None:
    folder = write_plane_run(tmp_path / "run", "crossing", "gsiirl", exploring=False)
    group = group_of([folder.path])
    assert group.exploring == ""
    run = group.of("gsiirl")
    assert run is not None
    curve = run.curve("deployed_return_learner")
    assert curve is not None
    assert curve.iteration.tolist() == list(range(11))


def test_animations_are_small_and_show_every_step(files: ReportFiles) -> None:
    page = files.page.read_text()
    animations = [path for path in files.figures if path.suffix == ".gif"]
    assert [path.stem for path in animations] == ["game-1-animation", "game-2-animation"]
    for path in animations:
        content = path.read_bytes()
        assert len(content) < 400_000
        assert base64.b64encode(content).decode() in page
        with Image.open(io.BytesIO(content)) as image:
            assert getattr(image, "n_frames", 1) == STEPS + 1
            assert image.convert("RGB").getpixel((1, 1)) == (255, 255, 255)


def test_the_same_runs_give_the_same_bytes(runs: dict[str, list[Path]], files: ReportFiles, tmp_path: Path) -> None:
    again = build_report([*runs["crossing"], *runs["deception"], *runs["security"]], tmp_path / "again")
    for first, second in zip(files.figures, again.figures, strict=True):
        assert first.read_bytes() == second.read_bytes(), first.name
    assert files.page.read_bytes() == again.page.read_bytes()


def test_the_page_needs_nothing_but_itself_and_names_the_sides(files: ReportFiles) -> None:
    page = files.page.read_text()
    assert "http" not in page
    assert all(source.startswith("data:image/") for source in re.findall(r'src="([^"]*)"', page))
    assert "(here a robot, or two agents that hide their target, or the defender of a network)" in page
    for heading in ("robot (learner)", "human (expert)", "good agents (learner)", "adversary (expert)"):
        assert heading in page


def test_table_1_stands_on_top_with_the_papers_figures(files: ReportFiles) -> None:
    table = table_of(files)["table_1"]
    assert [column["column"] for column in table] == ["MPE", "HRI", "CS"]
    paper = {
        column["column"]: [
            (row["algorithm"], row["learner"]["paper"]["mean"])
            for row in column["returns"]
            if "paper" in row["learner"]
        ]
        for column in table
    }
    assert paper["MPE"] == [("marl", 5.43), ("ma-irl", 5.12), ("gsiirl", 4.54), ("paper", 4.54)]
    assert paper["HRI"] == [("marl", -20.22), ("ma-irl", -20.63), ("gsiirl", -21.69), ("paper", -21.69)]
    assert paper["CS"] == [("marl", -16.96), ("gsiirl", -17.38)]
    page, markdown = files.page.read_text(), files.table_markdown.read_text()
    assert page.index("Table 1") < page.index("Human-robot interaction: crossing")
    for text in (page, markdown.replace("'", "&#39;")):
        for printed in ("5.12 ± 4.08", "\N{MINUS SIGN}20.37 ± 4.27", "\N{MINUS SIGN}13.16 ± 1.03", "6.76 ± 3.59"):
            assert printed in text
        for sentence in (column["sentence"] for column in table):
            assert sentence.replace("'", "&#39;") in text


def test_the_gap_to_marl_is_that_of_the_seeds(runs: dict[str, list[Path]], files: ReportFiles) -> None:
    (column,) = [column for column in table_of(files)["table_1"] if column["experiment"] == "deception"]
    (path,) = [path for path in runs["deception"] if path.name == "gsiirl"]
    run = ReportedRun.read(path)
    difference = run.final["deployed_return_learner"] - run.final["truth_return_learner"]
    gap = column["gap_to_marl"]
    assert gap["mean"] == pytest.approx(difference.mean())
    assert gap["high"] - gap["mean"] == pytest.approx(4.3027 * difference.std(ddof=1) / np.sqrt(3))
    assert (
        "3 seeds): neither better nor worse than MARL; the paper's GSIIRL ends 16 % below its MARL."
        in column["sentence"]
    )


def test_one_experiment_alone_has_no_table_1(runs: dict[str, list[Path]], tmp_path: Path) -> None:
    files = build_report([path for path in runs["crossing"] if path.name == "marl"], tmp_path / "out")
    assert "table_1" not in table_of(files)
    assert "(here a robot)" in files.page.read_text()


def test_of_two_games_table_1_shows_the_one_with_more_algorithms_and_says_so(
    runs: dict[str, list[Path]], tmp_path: Path
) -> None:
    marl, gsiirl = (path for path in runs["deception"] if path.name in ("marl", "gsiirl"))
    other = write_plane_run(tmp_path / "other", "deception", "marl", variant="separate_target")
    crossing = [path for path in runs["crossing"] if path.name == "marl"]
    files = build_report([other.path, marl, gsiirl, *crossing], tmp_path / "out")
    column, _ = table_of(files)["table_1"]
    assert column["variant"] == "mpe"
    assert "MPE shows physical deception, mpe: of the 2 games below" in files.page.read_text()


def test_a_failed_seed_is_named_and_left_out_everywhere(runs: dict[str, list[Path]], files: ReportFiles) -> None:
    crossing = table_of(files)["groups"][0]
    (quality,) = [row for row in crossing["quality"] if row["algorithm"] == "gsiirl"]
    assert quality["failed_seeds"] == [1]
    assert quality["human_goal_error"]["count"] == 2
    assert "Seed 1 of GSIIRL failed" in files.page.read_text()
    run = group_of(runs["crossing"]).runs["GSIIRL"]
    for metric in ("collision_rate", "goal_rate_robot", "deployed_return_learner"):
        curve = run.curve(metric)
        assert curve is not None
        kept = RunFolder.open(run.path).metrics().filter(polars.col("seed") != 1, polars.col("exploring") == 0)
        means = kept.group_by("iteration").agg(polars.col(metric).mean()).sort("iteration")[metric]
        np.testing.assert_allclose(curve.mean, means.to_numpy())


def test_new_metrics_stand_in_the_table_of_quality(files: ReportFiles) -> None:
    markdown = files.table_markdown.read_text()
    for heading in ("collisions", "robot arrives", "human arrives", "error of the human's goal", "target preference"):
        assert f"| {heading} |" in markdown
    for heading in ("feature gap of sampling alone", "exploitability, learner"):
        assert markdown.count(f"| {heading} |") == 2
    assert "7.0 ± 0.0 %" in markdown


def test_marl_by_another_solver_is_a_line_of_its_own(runs: dict[str, list[Path]]) -> None:
    group = group_of(runs["deception"])
    figure = draw_returns(group)
    assert figure is not None
    maddpg = group.runs["MARL (MADDPG)"].estimate("deployed_return_learner")
    assert maddpg is not None
    levels = [line for line in figure.axes[0].lines if len(np.ravel(line.get_xdata())) == 2]
    assert [np.ravel(line.get_ydata())[0] for line in levels[:2]] == [pytest.approx(8.9), pytest.approx(maddpg.mean)]
    assert {text.get_text() for text in figure.legends[0].texts} >= {"MARL, given both true rewards", "MARL (MADDPG)"}


def test_marl_solved_by_maddpg_is_known_by_its_solver(tmp_path: Path) -> None:
    run = RunFolder.create(
        tmp_path / "run", {"experiment": "deception", "algorithm": "marl", "solver": "maddpg"}, {"name": "g"}
    )
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    assert list(group_of([run.path]).runs) == ["MARL (MADDPG)"]


def test_rates_are_drawn_with_marls_level(runs: dict[str, list[Path]]) -> None:
    with figure_style():
        figure = draw_rates(group_of(runs["crossing"]))
    assert figure is not None
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "They collide",
        "The robot reaches its goal",
        "The human reaches its goal",
    ]
    for axes, level in zip(figure.axes, (0.01, 0.97, 0.99), strict=True):
        heights = [np.ravel(line.get_ydata()) for line in axes.lines]
        assert any(height[0] == height[-1] == pytest.approx(level) for height in heights if len(height) == 2)


def test_learned_weights_are_compared_by_direction(runs: dict[str, list[Path]]) -> None:
    group = group_of(runs["deception"])
    figure = draw_weights(group, {name: 5.0 * weight for name, weight in DECEPTION["truth"]["expert_reward"].items()})
    assert figure is not None
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == FEATURES
    for container, label in zip(axes.containers[1::2], ("MA-IRL", "GSIIRL", "GSIIRL, paper's preset"), strict=True):
        weights = group.runs[label].weights("expert_reward")
        assert weights is not None
        unit = weights / np.linalg.norm(weights, axis=1, keepdims=True)
        np.testing.assert_allclose([bar.get_width() for bar in container], unit.mean(axis=0))
    true = next(each for each in axes.collections if each.get_label() == "true")
    assert np.asarray(true.get_paths()[0].vertices)[0, 0] == pytest.approx(-1.0)


def test_deception_without_its_truth_or_paths_has_the_other_figures(tmp_path: Path) -> None:
    write_plane_run(tmp_path / "run", "deception", "gsiirl", variant="separate_target")
    game = tmp_path / "run" / "game.json"
    game.write_text(
        json.dumps({name: value for name, value in json.loads(game.read_text()).items() if name != "truth"})
    )
    (tmp_path / "run" / "paths.parquet").unlink()
    group = group_of([tmp_path / "run"])
    with figure_style():
        figures = [figure for figure in deception_figures(group, group.of("gsiirl"), None) if figure]
    assert [figure.name for figure in figures] == ["game-1-weights"]
    assert "true" not in figures[0].caption


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("game.json", '"safe_distance"', '"distance"'),
        ("game.json", '"goal_radius": 0.05', '"goal_radius": "wide"'),
        ("game.json", '"robot_goal": [', '"robot_goal": [0, '),
    ],
)
def test_a_damaged_game_is_named_in_one_line(tmp_path: Path, name: str, old: str, new: str) -> None:
    write_plane_run(tmp_path / "run", "crossing", "marl", seeds=1)
    path = tmp_path / "run" / name
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError, match=f"{name}: is damaged") as error:
        build_report([tmp_path / "run"], tmp_path / "out")
    assert "\n" not in str(error.value)
