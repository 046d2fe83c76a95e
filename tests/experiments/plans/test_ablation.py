import dataclasses
from pathlib import Path

import pytest
from problems import tiny_config

from gsiirl.errors import InputError
from gsiirl.experiments import runner
from gsiirl.experiments.config import config_to_dict, load_config
from gsiirl.experiments.plans.ablation import CHANGES, run_ablation, variants
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.runs import Ablation, RunFolder

BASE = {"nodes": 4, "edges": 5, "horizon": 3, "seeds": 2, "iterations": 10, "trajectories": 5}


def test_the_ladder_climbs_from_the_papers_preset_to_the_default_one_change_at_a_time():
    ladder = [load_config(SecurityConfig, fields).resolved() for _, fields in variants()]
    assert ladder[0] == load_config(SecurityConfig, {"algorithm": "paper"}).resolved()
    # Nothing but the name and SPSA's own settings, which the exact gradient does not use, is left of the paper's.
    spsa = {"perturbation": None, "perturbation_decay": None}
    default = dataclasses.replace(load_config(SecurityConfig, {}).resolved(), algorithm="paper", **spsa)
    assert dataclasses.replace(ladder[-1], **spsa) == default
    budget = {"draws"}
    for below, above, change in zip(ladder, ladder[1:], CHANGES, strict=False):
        before, after = config_to_dict(below), config_to_dict(above)
        assert {name for name in before if before[name] != after[name]} - budget == set(change.fields)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Folders run, in order; each gets what makes it a run folder."""
    folders: list[Path] = []

    def note(config, folder: Path, _: object) -> None:
        folders.append(folder)
        RunFolder.create(folder, config_to_dict(config.resolved()), {"name": "none"})

    monkeypatch.setattr(runner, "run", note)
    monkeypatch.setattr(runner, "resume", lambda folder, _: folders.append(folder))
    return folders


def test_every_variant_runs_on_every_graph_and_again_is_gone_on_with(run, tmp_path):
    run_ablation(BASE, [1, 4], tmp_path)
    plan = Ablation.read(tmp_path)
    expected = [tmp_path / graph / each.name for graph in ("graph-1", "graph-4") for each in plan.variants]
    assert run == expected
    assert RunFolder.open(tmp_path / "graph-4" / "played").config["graph_seed"] == 4
    run_ablation(BASE, [1, 4], tmp_path)
    assert run == expected * 2


def test_a_folder_with_other_settings_is_refused_and_nothing_runs(run, tmp_path):
    other = tiny_config(graph_seed=1, seeds=3, algorithm="paper").resolved()
    RunFolder.create(tmp_path / "graph-1" / "paper", config_to_dict(other), {"name": "none"})
    with pytest.raises(InputError, match="holds a run with other settings"):
        run_ablation(BASE, [1], tmp_path)
    assert run == []
    assert not (tmp_path / "ablation.json").exists()
