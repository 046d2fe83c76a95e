"""Tables of vulnerabilities."""

from pathlib import Path

import pytest

from gsiirl.errors import InputError
from gsiirl.scenarios.vulnerabilities import CvssRule, Vulnerability, read_vulnerabilities


def read(folder: Path, content: str | bytes) -> tuple[list[Vulnerability], list[str]]:
    path = folder / "table.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    table = read_vulnerabilities(path, CvssRule())
    return table.rows, table.notes


def test_columns_come_in_any_order_and_case_and_cells_are_trimmed(tmp_path: Path):
    text = (
        '\ufeffName , Attack Cost,HOST,Probability,Source,value\r\n"a, b\nc",0.1, mail  server ,0.5,,1\r\n'
        "\r\n,,x,1,y,\r\n"
    )
    rows, notes = read(tmp_path, text)
    assert rows == [
        Vulnerability(2, "mail server", "a, b c", 0.5, False, None, 0.1, 1.0),
        Vulnerability(5, "x", "", 1.0, False, "y", 0.0, None),
    ]
    assert notes == []


def test_an_empty_column_without_a_name_is_not_worth_a_word(tmp_path: Path):
    assert read(tmp_path, "host,name,probability,\nx,y,0.5,\n")[1] == []


def test_only_what_is_missing_may_have_been_meant(tmp_path: Path):
    with pytest.raises(InputError) as caught:
        read(tmp_path, "host,name,score\nx,y,5\n")
    assert str(caught.value).endswith("columns are missing: probability or cvss; add them, or rename 'score'")


def test_other_columns_are_named_with_what_may_have_been_meant(tmp_path: Path):
    _, notes = read(tmp_path, "host,name,cvss,atack_cost,owner\nx,y,5,1,z\n")
    assert notes[0] == "columns that are not read: 'atack_cost' (did you mean attack_cost?), 'owner'"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is empty"),
        ("host,name,cvss\n", "has no row below its header"),
        ("host;name;cvss\nx;y;5\n", "line 1: separates columns by ';'; save it with commas"),
        ("host\tname\tcvss\nx\ty\t5\n", "line 1: separates columns by tabs"),
        ("hots,name\nx,y\n", "columns are missing: host, probability or cvss; add them, or rename 'hots'"),
        ("hots,name\nx,y\n", "'hots' (did you mean host?)"),
        ("host,name,csvs\nx,y,5\n", "rename 'csvs' (did you mean cvss?)"),
        ("host,name,cvss,cvss\nx,y,5,5\n", "column cvss: is there twice"),
        ("host,name,cvss\n\nx,y\n", "line 3: has 2 cells for 3 columns"),
        ('host,name,cvss\nx,"y,5\n', "line 2: is not CSV"),
        ("host,name,cvss\n,y,5\n", "line 2, host: is empty"),
        ("host,name,cvss,probability\nx,y,,\n", "line 2, probability and cvss: is empty"),
        ("host,name,cvss\nx,y,11\n", "line 2, cvss: is '11'; give a base score from 0 to 10"),
        ("host,name,cvss\nx,y,CVSS:3.1/AV:N\n", "give a base score"),
        ('host,name,cvss\nx,y,"7,5"\n', "with a decimal point: 7.5"),
        ("host,name,probability\nx,y,0\n", "line 2, probability: is '0'; give a number above 0 and at most 1"),
        ("host,name,probability\nx,y,nan\n", "is 'nan'"),
        ("host,name,probability\nx,y,0_1\n", "is '0_1'"),
        ("host,name,probability,attack_cost\nx,y,1,-1\n", "line 2, attack_cost: is '-1'; give 0 or more"),
        ("host,name,probability,value\nx,y,1,inf\n", "line 2, value: is 'inf'; give a finite number"),
        (b"host,name,cvss\nx,y,5\nx,\xe9,5\n", "line 3: is not UTF-8 text; save it as 'CSV UTF-8'"),
        ("host,name,cvss\nx,y,5\n".encode("utf-16"), "is not UTF-8 text"),
    ],
)
def test_what_cannot_be_is_refused_by_line_and_column(tmp_path: Path, content: str | bytes, message: str):
    with pytest.raises(InputError) as caught:
        read(tmp_path, content)
    assert str(tmp_path / "table.csv") in str(caught.value)
    assert message in str(caught.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="cannot be read"):
        read_vulnerabilities(tmp_path / "none.csv", CvssRule())


@pytest.mark.parametrize(("score", "probability"), [(0.1, 0.05), (4.9, 0.49), (7.5, 0.75), (10, 0.95)])
def test_by_default_a_probability_is_a_tenth_of_the_score_and_never_sure(score: float, probability: float):
    assert CvssRule.of("score")(score) == probability


@pytest.mark.parametrize(("score", "probability"), [(3.9, 0.1), (4, 0.2), (6.9, 0.2), (7, 0.3), (9, 0.4), (10, 0.4)])
def test_four_numbers_are_those_of_the_severities(score: float, probability: float):
    assert CvssRule.of("0.1, 0.2,0.3,0.4")(score) == probability


@pytest.mark.parametrize("text", ["", "0.1", "0,0.2,0.3,0.4", "a,b,c,d", "0.1,0.2,0.3,1.1", "0.1,0.2,0.3,nan"])
def test_other_rules_are_refused(text: str):
    with pytest.raises(InputError, match="probability-of-cvss"):
        CvssRule.of(text)
