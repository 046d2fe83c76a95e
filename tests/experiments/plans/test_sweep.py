import itertools
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsiirl.errors import InputError
from gsiirl.experiments.plans.planned_run import PlannedRun
from gsiirl.experiments.plans.sweep import part_of, read_sweep
from gsiirl.experiments.security.config import SecurityConfig

OUT = Path("out")


def swept(tmp_path: Path, text: str) -> dict[str, PlannedRun]:
    file = tmp_path / "sweep.toml"
    file.write_text(text)
    return {each.folder.name: each for each in read_sweep(file, OUT)}


def test_every_combination_of_listed_values_is_a_run(tmp_path):
    runs = swept(
        tmp_path,
        """
        experiment = "security"
        graph = "small-linear"
        algorithm = ["gsiirl", "marl"]
        temperature = [0.4, 0.1]
        honest_start = false
        commitment = "reward"
        seeds = 3
        """,
    )
    assert list(runs) == [
        f"algorithm={algorithm},temperature={temperature}"
        for algorithm, temperature in itertools.product(("gsiirl", "marl"), (0.4, 0.1))
    ]
    assert all(run.folder == OUT / name for name, run in runs.items())
    config = runs["algorithm=marl,temperature=0.1"].config
    assert isinstance(config, SecurityConfig)
    assert (config.algorithm, config.temperature, config.graph, config.seeds) == ("marl", 0.1, "small-linear", 3)


def test_a_list_of_one_value_names_the_folder_too_so_that_a_second_value_renames_nothing(tmp_path):
    one = swept(tmp_path, 'experiment = "security"\nalgorithm = ["marl"]')
    two = swept(tmp_path, 'experiment = "security"\nalgorithm = ["marl", "paper"]')
    assert list(one) == ["algorithm=marl"]
    assert list(two) == ["algorithm=marl", "algorithm=paper"]


def test_tables_share_what_stands_above_them_and_their_differences_name_the_folders(tmp_path):
    runs = swept(
        tmp_path,
        """
        seeds = 2
        [[grid]]
        experiment = ["security", "game"]
        algorithm = "marl"
        [[grid]]
        experiment = "crossing"
        algorithm = "gsiirl"
        iterations = [5, 10]
        """,
    )
    assert list(runs) == [
        "experiment=security,algorithm=marl",
        "experiment=game,algorithm=marl",
        "experiment=crossing,algorithm=gsiirl,iterations=5",
        "experiment=crossing,algorithm=gsiirl,iterations=10",
    ]
    assert {run.config.seeds for run in runs.values()} == {2}


def test_a_path_gives_its_last_part_to_the_name_and_nothing_a_shell_minds(tmp_path):
    runs = swept(tmp_path, 'experiment = "security"\ngraph = ["nets/my net.json", "nets/b.json"]')
    assert list(runs) == ["graph=my_net.json", "graph=b.json"]


def test_one_run_is_named_after_its_experiment(tmp_path):
    assert list(swept(tmp_path, 'experiment = "deception"')) == ["deception"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("algorithm = 'marl'", "experiment in .*: is missing; choose from security"),
        ("experiment = 'chess'", "experiment in .*: cannot be 'chess'; choose from security"),
        ("experiment = 'security'\nalgoritm = ['marl']", "algoritm in .*: is no field .*did you mean algorithm"),
        ("experiment = 'security'\nalgorithm = ['marl', 'x']", "algorithm in .*: cannot be x; choose gsiirl"),
        ("experiment = 'security'\nalgorithm = []", r"algorithm in .*: cannot be \[\]; give a value"),
        ("experiment = 'security'\n[algorithm]\na = 1", "algorithm in .*: cannot be .*; give a value"),
        ("experiment = 'security'\nseeds = [2, 2]", "has two runs seeds=2; give every run another value"),
        ("experiment = 'security'\ngraph = ['a/n.json', 'b/n.json']", "has two runs graph=n.json"),
        ("grid = 3", r"grid in .*: is no list of tables; write \[\[grid\]\]"),
        ("experiment = ", "is not TOML"),
        (
            "experiment = 'security'\ngraph_seed = ["
            + ",".join(map(str, range(400)))
            + "]\nfirst_seed = ["
            + ",".join(map(str, range(30)))
            + "]",
            "has more than 10,000 runs; give fewer values",
        ),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused_in_one_line(tmp_path, text: str, message: str):
    with pytest.raises(InputError, match=message) as refused:
        swept(tmp_path, text)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: cannot be read \(No such file"):
        read_sweep(tmp_path / "none.toml", OUT)


@given(st.integers(0, 40), st.integers(1, 12))
def test_the_parts_of_a_plan_are_all_of_it_once_and_of_about_one_size(number: int, parts: int):
    plan = [PlannedRun(Path(str(place)), None) for place in range(number)]  # type: ignore[arg-type]
    shares = [part_of(plan, f"{part}/{parts}") for part in range(1, parts + 1)]
    assert sorted(itertools.chain(*shares), key=plan.index) == plan
    assert max(map(len, shares)) - min(map(len, shares)) <= 1


@pytest.mark.parametrize("part", ["", "0/3", "4/3", "1", "a/b", "1/2/3", "-1/3", "1 / 2"])
def test_what_is_no_part_is_refused(part: str):
    with pytest.raises(InputError, match=r"--part: cannot be .*; give it as K/N"):
        part_of([], part)
