from pathlib import Path

import numpy as np
import pytest
import scipy.stats
from report.made_up import made_up_run

from gsiirl.errors import InputError
from gsiirl.report import swept_table
from gsiirl.report.tables.swept import DASH
from gsiirl.runs import RunFolder, summarise

RANDOM = np.random.default_rng(0)


def rows(text: str) -> list[list[str]]:
    """The cells of every row of Markdown tables, headings included."""
    return [
        [cell.strip().replace("\N{MINUS SIGN}", "-") for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("|") and not line.startswith("|---")
    ]


def run(tmp_path: Path, name: str, values: list[float], algorithm: str, first_seed: int = 0, **config: object) -> Path:
    config = {"seeds": len(values), "first_seed": first_seed, **config}
    return made_up_run(tmp_path / name, algorithm, values, first_seed=first_seed, config=config)


def test_means_and_intervals_are_those_of_scipy(tmp_path):
    values = RANDOM.normal(-5.0, 1.0, 6)
    paths = [
        run(tmp_path, "a", values.tolist(), "gsiirl"),
        run(tmp_path, "b", (values - 0.3 + RANDOM.normal(0, 0.1, 6)).tolist(), "marl"),
    ]
    heading, first, _, _, pair = rows(swept_table(paths, None, "deployed_return_learner")[0])
    assert heading == ["algorithm", "mean", "95 % interval", "standard deviation", "seeds"]
    assert first[0] == "gsiirl"
    assert first[4] == "6"
    low, high = scipy.stats.t.interval(0.95, 5, values.mean(), values.std(ddof=1) / 6**0.5)
    assert [float(first[1]), *map(float, first[2].split(" to "))] == pytest.approx(
        [values.mean(), low, high], abs=0.006
    )
    assert float(first[3]) == pytest.approx(values.std(ddof=1), abs=0.006)
    assert pair[:2] == ["algorithm gsiirl", "algorithm marl"]
    assert pair[3] == "higher"


def test_pooled_settings_are_compared_seed_by_seed_with_their_like(tmp_path):
    # The temperature moves returns by far more than the algorithm: only pairs of one temperature show the difference.
    paths = [
        run(tmp_path, f"{algorithm}-{temperature}", [10 * temperature + shift + 0.01 * s for s in range(3)], algorithm,
            temperature=temperature)
        for algorithm, shift in (("gsiirl", 0.1), ("marl", 0.0))
        for temperature in (1.0, 5.0)
    ]  # fmt: skip
    text, _ = swept_table(paths, ["algorithm"], "deployed_return_learner")
    *_, pair = rows(text)
    assert pair == ["algorithm gsiirl", "algorithm marl", "+0.10 (0.10 to 0.10)", "higher"]
    assert "Each row is a mean over temperature as well." in text


def test_runs_of_other_seeds_are_one_group(tmp_path):
    paths = [
        run(tmp_path, "a", [1.0, 2.0], "gsiirl"),
        run(tmp_path, "b", [3.0, 4.0], "gsiirl", first_seed=2),
        run(tmp_path, "c", [0.0] * 4, "marl"),
    ]
    _, first, second, *_ = rows(swept_table(paths, None, "deployed_return_learner")[0])
    assert (first[0], float(first[1]), first[-1]) == ("gsiirl", 2.5, "4")
    assert second[-1] == "4"


def test_two_groups_are_compared_where_they_differ_in_one_setting(tmp_path):
    paths = [
        run(tmp_path, f"{a}-{t}", [1.0 + t, 2.0 + t], a, temperature=t) for a in ("gsiirl", "marl") for t in (1, 2)
    ]
    pairs = rows(swept_table(paths, None, "deployed_return_learner")[0])[6:]
    assert [pair[:2] for pair in pairs] == [
        ["temperature 1, algorithm gsiirl", "temperature 2, algorithm gsiirl"],
        ["algorithm gsiirl, temperature 1", "algorithm marl, temperature 1"],
        ["algorithm gsiirl, temperature 2", "algorithm marl, temperature 2"],
        ["temperature 1, algorithm marl", "temperature 2, algorithm marl"],
    ]
    assert [pair[3] for pair in pairs] == ["lower", "the same", "the same", "lower"]


def test_failed_seeds_count_and_are_told(tmp_path):
    # Random play earns -9.6 in made-up runs.
    _, first, _ = rows(
        swept_table(
            [run(tmp_path, "a", [-5.0, -20.0], "gsiirl"), run(tmp_path, "b", [-5.0, -6.0], "gsiirl", k=1)],
            ["k"],
            "deployed_return_learner",
        )[0]
    )[:3]
    assert float(first[1]) == -12.5
    assert first[-1] == "2 (1 failed)"


def test_a_seed_without_a_number_leaves_no_mean(tmp_path):
    path = run(tmp_path, "a", [-5.0, float("nan")], "gsiirl")
    *_, row = rows(swept_table([path, run(tmp_path, "b", [1.0, 1.0], "marl")], None, "deployed_return_learner")[0])[:2]
    assert row[1:] == ["1 without a number", DASH, DASH, "2 (1 failed)"]


def test_what_has_not_ended_is_left_out_and_named(tmp_path):
    whole = run(tmp_path, "a", [1.0, 2.0], "gsiirl")
    begun = RunFolder.create(tmp_path / "b", {"experiment": "security", "algorithm": "marl"}, {"name": "g"}).path
    text, unfinished = swept_table([whole, begun], None, "deployed_return_learner")
    assert unfinished == [begun]
    assert "marl" not in text
    with pytest.raises(InputError, match="DIR: holds no finished run"):
        swept_table([begun], None, "deployed_return_learner")


@pytest.mark.parametrize(
    ("by", "metric", "message"),
    [
        (["algoritm"], "deployed_return_learner", "--by: algoritm is no setting of these runs; choose from algorithm"),
        (None, "deployed", "--metric: deployed is no metric of these runs; choose from deployed_return_learner, "),
    ],
)
def test_names_that_no_run_has_are_refused(tmp_path, by, metric: str, message: str):
    paths = [run(tmp_path, name, [1.0, 2.0], name) for name in ("gsiirl", "marl")]
    with pytest.raises(InputError, match=message):
        swept_table(paths, by, metric)


def test_the_same_seed_twice_is_refused(tmp_path):
    paths = [run(tmp_path, name, [1.0, 2.0], "gsiirl") for name in ("a", "b")]
    with pytest.raises(InputError, match="holds the same seeds of one setting twice"):
        swept_table(paths, None, "deployed_return_learner")


def test_experiments_are_not_pooled(tmp_path):
    paths = [
        made_up_run(tmp_path / name, "gsiirl", [1.0, 2.0], name, config={"seeds": 2})
        for name in ("security", "crossing")
    ]
    with pytest.raises(InputError, match="--by: would pool different experiments; add experiment"):
        swept_table(paths, ["algorithm"], "deployed_return_learner")
    assert rows(swept_table(paths, None, "deployed_return_learner")[0])[0][0] == "experiment"


def test_it_is_the_last_iteration_that_counts(tmp_path):
    folder = RunFolder.create(tmp_path / "a", {"experiment": "security", "algorithm": "gsiirl"}, {"name": "g"})
    columns = {"seed": [0, 1, 0, 1], "iteration": [0, 0, 1, 1], "deployed_return_learner": [7.0, 8.0, 1.0, 2.0]}
    folder.append_metrics(0, {name: np.array(values) for name, values in columns.items()})
    folder.write_summary(summarise(folder.config, folder.metrics(), completed=True))
    _, row = rows(swept_table([folder.path], [], "deployed_return_learner")[0])
    assert float(row[-4]) == 1.5
