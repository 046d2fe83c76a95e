"""Every machine and attack stands in a table, with its whole name."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from report.synthetic import SyntheticGame, write_run

from gsiirl.report.figures import fonts
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.host_names import with_short_names
from gsiirl.report.security.network_table import NetworkTable, network_table, untested_hosts
from gsiirl.report.security.recorded_graph import RecordedGraph

OFFICE: dict[str, Any] = {
    "nodes": ["desk", "files", "vault", "attic"],
    "footholds": ["desk"],
    "edges": [("desk", "files", 0.5), ("files", "vault", 0.5), ("attic", "vault", 0.5), (None, "files", 0.5)],
}


def read(folder: Path, graph: dict[str, Any], algorithm: str = "gsiirl") -> tuple[RecordedGraph, ReportedRun]:
    run = write_run(folder / "run", algorithm, SyntheticGame(graph), iterations=1)
    return RecordedGraph.read(run.game, run.path), ReportedRun.read(run.path)


def table(folder: Path, algorithm: str = "gsiirl") -> NetworkTable:
    return network_table(*read(folder, OFFICE, algorithm))


def test_each_machine_has_its_values_and_what_put_it_to_the_test(tmp_path: Path) -> None:
    desk, files, vault, attic = table(tmp_path).hosts
    assert [row.name for row in (desk, files, vault, attic)] == OFFICE["nodes"]
    assert (desk.learned, desk.tested) == ("\N{EN DASH}", "held from the start: its value has no effect")
    assert (attic.learned, attic.tested) == ("\N{EN DASH}", "cannot be reached: its value has no effect")
    # The made-up run saw 0, 10, 20 and 30 attacks along the four edges, half of them with a chance.
    assert (files.tested, vault.tested) == ("15 attacks with a chance", "15 attacks with a chance")
    assert float(files.learned) == pytest.approx(float(files.true), abs=0.2)


def test_each_attack_has_its_cost_and_says_where_it_can_never_succeed(tmp_path: Path) -> None:
    found = table(tmp_path)
    assert [(row.name, row.tested, row.sure) for row in found.edges] == [
        ("desk → files", "never", False),
        ("files → vault", "10 attacks, 5 with a chance", True),
        ("attic → vault", "20 attacks; it can never succeed", True),
        ("outside → files", "30 attacks, 15 with a chance", True),
    ]
    assert found.only_differences


def test_a_run_that_counted_nothing_says_so(tmp_path: Path) -> None:
    found = table(tmp_path, "ma-irl")
    assert {row.tested for row in found.hosts[1:3]} == {"not recorded"}
    assert found.edges[0].tested == "not recorded"
    assert found.learner == "MA-IRL"


def test_machines_that_no_attack_with_a_chance_was_seen_at_are_told(tmp_path: Path) -> None:
    graph, run = read(tmp_path, {**OFFICE, "edges": [("desk", "vault", 0.5), ("desk", "files", 0.5)]})
    assert untested_hosts(graph, run) == [2]
    assert not network_table(graph, run).hosts[2].sure


def test_what_lies_too_far_for_an_episode_cannot_be_reached(tmp_path: Path) -> None:
    graph, run = read(tmp_path, OFFICE)
    assert network_table(replace(graph, horizon=1), run).hosts[2].tested.startswith("cannot be reached")
    assert graph.can_fall(2)


LONG = ["prod-eu-west-1-webserver-01", "prod-eu-west-1-webserver-02"]


def test_long_names_are_numbered_in_figures_and_whole_in_the_table(tmp_path: Path) -> None:
    graph, run = read(tmp_path, {"nodes": LONG, "footholds": LONG[:1], "edges": [(LONG[0], LONG[1], 0.5)]})
    assert with_short_names(graph).nodes == ["1 prod-eu-west…", "2 prod-eu-west…"]
    found = network_table(graph, run)
    assert [(row.number, row.name) for row in found.hosts] == [("1", LONG[0]), ("2", LONG[1])]
    assert [(row.number, row.name) for row in found.edges] == [("1 → 2", f"{LONG[0]} → {LONG[1]}")]


def test_short_names_stay_as_they_are(tmp_path: Path) -> None:
    graph, _ = read(tmp_path, OFFICE)
    assert with_short_names(graph).nodes == OFFICE["nodes"]


def test_names_that_no_font_can_draw_are_numbers_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fonts, "_characters", lambda: frozenset(map(ord, "abcdefghijklmnopqrstuvwxyz ")))
    nodes = ["データベース", "web"]
    graph, _ = read(tmp_path, {"nodes": nodes, "footholds": ["web"], "edges": [("web", nodes[0], 0.5)]})
    assert with_short_names(graph).nodes == ["1", "2 web"]


def test_east_asian_letters_are_twice_as_wide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = "データベースサーバー"
    monkeypatch.setattr(fonts, "_characters", lambda: frozenset(map(ord, name + "web")))
    graph, _ = read(tmp_path, {"nodes": [name, "web"], "footholds": ["web"], "edges": [("web", name, 0.5)]})
    assert with_short_names(graph).nodes == ["1 データベース…", "2 web"]


def test_costs_of_which_only_differences_can_be_learned_are_shifted_to_the_mean_of_the_true_ones(
    tmp_path: Path,
) -> None:
    graph, run = read(tmp_path, OFFICE)
    count = len(graph.nodes)
    learned = run.weights("expert_reward")
    assert learned is not None
    raw = learned.mean(axis=0)[count:]
    shown = [float(row.learned.replace("\N{MINUS SIGN}", "-")) for row in network_table(graph, run).edges]
    truth = graph.expert_truth[count:]
    assert shown == pytest.approx(list(raw - raw.mean() + truth.mean()), abs=0.006)
    assert shown != pytest.approx(list(raw), abs=0.006)
    waits = [float(row.learned) for row in network_table(replace(graph, expert_no_op=True), run).edges]
    assert waits == pytest.approx(list(raw), abs=0.006)
