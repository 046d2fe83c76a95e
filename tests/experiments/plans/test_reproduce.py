from pathlib import Path

from gsiirl.experiments.config import config_to_dict
from gsiirl.experiments.plans.reproduce import plan

OUT = Path("out")


def test_every_algorithm_runs_on_every_game_as_often_as_the_papers_figures_show():
    runs = {str(folder.relative_to(OUT)): config for folder, config in plan(OUT, seeds=10, quick=False, maddpg=False)}
    games = ("security-zero-sum", "security-general-sum", "crossing", "deception")
    of_all, of_finite = ("gsiirl", "paper", "ma-irl", "marl"), ("lin2019",)
    finite = {game: of_finite if game.startswith("security") else () for game in games}
    assert list(runs) == [f"{game}/{name}" for game in games for name in of_all + finite[game]]
    assert {config.seeds for config in runs.values()} == {10}
    assert [runs[f"{game}/gsiirl"].iterations for game in games] == [50, 50, 100, 50]
    assert all(path.endswith("/" + config.algorithm) for path, config in runs.items())
    assert all(path.startswith(config.experiment) for path, config in runs.items())
    assert len({config.resolved() for config in runs.values()}) == len(runs)


def test_quick_runs_are_the_papers_games_with_fewer_iterations():
    full, quick = (dict(plan(OUT, 2, quick=each, maddpg=False)) for each in (False, True))
    assert quick.keys() < full.keys()
    assert {folder.parts[1] for folder in quick} == {"security-zero-sum", "crossing", "deception"}
    assert all(config.iterations < full[folder].iterations for folder, config in quick.items())
    for folder, config in quick.items():
        for name, value in config_to_dict(config).items():
            if isinstance(value, int):
                assert value <= config_to_dict(full[folder])[name], (folder, name)


def test_maddpg_is_a_second_marl_where_it_can_be():
    runs = dict(plan(OUT, 2, quick=True, maddpg=True))
    added = runs.keys() - dict(plan(OUT, 2, quick=True, maddpg=False)).keys()
    assert added == {OUT / "crossing" / "marl-maddpg", OUT / "deception" / "marl-maddpg"}
    fields = [config_to_dict(config.resolved()) for folder, config in runs.items() if folder in added]
    assert {(each["algorithm"], each["solver"]) for each in fields} == {("marl", "maddpg")}
