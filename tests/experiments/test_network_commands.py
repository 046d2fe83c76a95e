"""`gsiirl network check` and `build` as they are typed."""

import json
from pathlib import Path

import pytest

from gsiirl.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"
PLAIN, TABLE = str(EXAMPLES / "clinic.graphml"), str(EXAMPLES / "clinic.csv")


def build(out: Path, *more: str) -> int:
    start = ["--foothold", "Reception PC"]
    return main(["network", "build", PLAIN, "--vulnerabilities", TABLE, *start, "--out", str(out), *more])


def test_the_exit_status_says_whether_a_run_can_begin(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["network", "check", PLAIN]) == 1
    assert main(["network", "check", str(EXAMPLES / "office.json")]) == 0
    assert capsys.readouterr().err == ""
    assert main(["network", "check", str(tmp_path / "none.json")]) == 2
    assert "cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize("file", [PLAIN, str(EXAMPLES / "office.json")])
def test_json_is_all_that_is_printed(file: str, capsys: pytest.CaptureFixture[str]):
    main(["network", "check", file, "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert printed["game"] == (file != PLAIN)
    assert printed["hosts"] in (4, 11)


def test_what_is_built_is_a_game(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "new folder" / "clinic.json"
    assert build(out) == 0
    assert "11 hosts, 10 edges" in capsys.readouterr().out
    assert main(["network", "check", str(out)]) == 0


def test_one_edge_is_one_edge(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    plain, table = tmp_path / "plain.json", tmp_path / "table.csv"
    plain.write_text(
        '{"directed": true, "nodes": [{"id": "a"}, {"id": "b"}], "edges": [{"source": "a", "target": "b"}]}'
    )
    table.write_text("host,name,probability,value\nb,hole,0.5,1\n")
    words = [str(plain), "--vulnerabilities", str(table), "--foothold", "a", "--out", str(tmp_path / "x.json")]
    assert main(["network", "build", *words]) == 0
    assert "2 hosts, 1 edge;" in capsys.readouterr().out


def test_a_file_that_is_there_is_not_touched(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "clinic.json"
    out.write_text("mine")
    assert build(out) == 2
    assert "is there already" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert build(tmp_path / "clinic.graphml") == 2
    assert "does not end in .json" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert build(tmp_path / "file" / "x.json") == 2
    assert "cannot be written" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clinic.json", "file"]


def test_another_rule_for_scores_may_be_given(tmp_path: Path):
    assert build(tmp_path / "x.json", "--probability-of-cvss", "0.2,0.4,0.6,0.8") == 0
    edges = json.loads((tmp_path / "x.json").read_text())["edges"]
    assert {edge["success_probability"] for edge in edges} == {0.4, 0.6, 0.8, 0.25}
