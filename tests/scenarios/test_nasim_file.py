"""A user's scenarios in NASim's YAML format."""

import warnings
from pathlib import Path

import pytest

from gsiirl.errors import InputError, NetworkWarning
from gsiirl.scenarios import load_network
from gsiirl.scenarios.nasim_file import read_nasim

CLINIC = Path(__file__).parents[1] / "data" / "nasim" / "clinic.yaml"


def changed(folder: Path, before: str, after: str) -> Path:
    """The clinic with one place of its file changed."""
    text = CLINIC.read_text()
    assert before in text
    path = folder / "clinic.yaml"
    path.write_text(text.replace(before, after, 1))
    return path


def test_a_scenario_becomes_its_hosts_and_the_exploits_that_pass():
    network = load_network(str(CLINIC))
    assert network.name == "clinic"
    assert network.node_names == ("host (1, 0)", "host (2, 0)", "host (2, 1)", "host (3, 0)")
    # Values over the largest, 40; costs likewise.
    assert network.value.tolist() == [0, 0.1, 0.5, 1]
    edges = dict(
        zip(network.edge_names, zip(network.success_probability, network.attack_cost, strict=True), strict=True)
    )
    assert edges == {
        "outside -> host (1, 0)": (0.7, 2 / 40),
        # Of rdp and smb, equally likely, the cheaper.
        "host (1, 0) -> host (2, 0)": (0.5, 1 / 40),
        # Its own firewall denies smb to (1, 0), but not to its neighbour.
        "host (2, 0) -> host (2, 1)": (0.5, 3 / 40),
        "host (2, 1) -> host (2, 0)": (0.5, 1 / 40),
        # smb needs windows; http works under any system.
        "host (2, 0) -> host (3, 0)": (0.7, 2 / 40),
        "host (2, 1) -> host (3, 0)": (0.7, 2 / 40),
    }
    assert network.block_cost.tolist() == [1 / 40] * 6
    # Half of it the value, half the out-degree over the largest one, 2.
    assert network.criticality.tolist() == [0.25, 0.55, 0.75, 0.5]


def test_zero_sum_takes_the_values_for_criticalities():
    assert load_network(str(CLINIC), "zero_sum").criticality.tolist() == [0, 0.1, 0.5, 1]


@pytest.mark.parametrize("system", ["none", "None", "~"])
def test_an_exploit_without_a_system_works_under_any(tmp_path: Path, system: str):
    path = changed(tmp_path, "os: None", f"os: {system}")
    assert read_nasim(path).edge_names == read_nasim(CLINIC).edge_names


def test_an_exploit_that_never_succeeds_is_none(tmp_path: Path):
    names = read_nasim(changed(tmp_path, "prob: 0.5\n    cost: 3", "prob: 0\n    cost: 3")).edge_names
    assert "host (2, 0) -> host (2, 1)" not in names


def test_windows_line_ends_a_byte_order_mark_and_utf_16_are_read(tmp_path: Path):
    text = CLINIC.read_text()
    for number, content in enumerate(
        [text.replace("\n", "\r\n").encode(), b"\xef\xbb\xbf" + text.encode(), text.encode("utf-16")]
    ):
        path = tmp_path / f"{number}.yml"
        path.write_bytes(content)
        assert read_nasim(path).value.tolist() == read_nasim(CLINIC).value.tolist()


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("prob: 0.7", "prob: high", "exploits.e_http.prob: cannot be high; it should be a valid number"),
        ("prob: 0.7", "prob: 1.7", "exploits.e_http.prob: cannot be 1.7; it should be less than or equal to 1"),
        ("prob: 0.7", "prob: .nan", "exploits.e_http.prob: cannot be nan; it should be a finite number"),
        ("cost: 2", "cost: -2", "exploits.e_http.cost: cannot be -2; it should be greater than or equal to 0"),
        ("cost: 2", "costs: 2", "exploits.e_http.cost: is missing; add it"),
        ("service: http", "service: htp", "exploits.e_http.service: names htp, which services does not list; correct"),
        ("os: windows\n    prob", "os: dos\n    prob", "exploits.e_smb.os: names dos, which os does not list; correct"),
        (
            "os: linux\n    services: [http]",
            "os: bsd\n    services: [http]",
            "host_configurations.(1, 0).os: names bsd",
        ),
        (
            "services: [rdp, smb]",
            "services: [rdp, ftp]",
            "host_configurations.(2, 0).services: names ftp, which servic",
        ),
        (
            "services: [rdp, smb]",
            "services: rdp",
            "host_configurations.(2, 0).services: cannot be rdp; it should be a ",
        ),
        ("(1, 0): [smb]", "(1, 0): [sbm]", "host_configurations.(2, 1).firewall.(1, 0): names sbm, which services "),
        (
            "(1, 0): [smb]",
            "(1, 9): [smb]",
            "host_configurations.(2, 1).firewall: names the host (1, 9), which subnets ",
        ),
        (
            "(1, 2): [smb, rdp]",
            "(1, 2): [smb, rpd]",
            "firewall.(1, 2): names rpd, which services does not list; correct",
        ),
        ("  (2, 3): [http, smb]\n", "", "firewall: lacks (2, 3), which topology connects; list the services that pass"),
        ("(0, 1): [http]", "(0, 1): []", "firewall: no exploit passes from the internet to any host; let the service"),
        ("(2, 1): 20", "(2, 7): 20", "sensitive_hosts: names the host (2, 7), which subnets has not; correct one of"),
        ("(2, 1): 20", "2.1: 20", "sensitive_hosts.2.1: cannot be 2.1; it should be a pair such as (1, 0)"),
        ("(2, 1): 20", "(3,  0): 20", "file: is not YAML ((3, 0) is there twice in line 9); mend the file"),
        (
            "subnets: [1, 2, 1]",
            "subnets: [1, 1, 1]",
            "host_configurations: names the host (2, 1), which subnets has not",
        ),
        ("subnets: [1, 2, 1]", "subnets: [1, 3, 1]", "host_configurations: lacks the host (2, 2) of subnets; add it"),
        ("subnets: [1, 2, 1]", "subnets: [1, 2-5, 1]", "subnets.1: cannot be 2-5; it should be a valid integer"),
        (
            "subnets: [1, 2, 1]",
            "subnets: [1, 2, 1, 1]",
            "topology: is not of 4 subnets; give 5 rows of 5: the internet",
        ),
        ("subnets: [1, 2, 1]", "subnets: [1, 2, 9999]", "subnets: are of 10002 hosts; give at most 1000"),
        ("[1, 1, 1, 0]", "[1, 1, 2, 0]", "topology.1.2: cannot be 2; it should be 0 or 1"),
        ("step_limit: 500", "exploits: {}", "file: is not YAML (exploits is there twice in line 70); mend the file"),
        ("subnets:", "subnet:", "subnets: is missing; add it"),
        ("step_limit: 500", "step_limit: *there", "file: is not YAML (found undefined alias"),
        ("step_limit: 500", "step_limit: !!python/object:os.system x", "file: is not YAML (could not determine a"),
        ("step_limit: 500", "step_limit: 2025-99-99", "file: is not YAML that can be read; mend the file"),
    ],
)
def test_a_malformed_scenario_is_refused_in_one_line_that_names_the_field(
    tmp_path: Path, before: str, after: str, message: str
):
    path = changed(tmp_path, before, after)
    with pytest.raises(InputError) as caught:
        read_nasim(path)
    assert str(caught.value).startswith(f"{path}: {message}")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"- 1\n",
        b"\xff\x00\xff",
        b"[" * 5000,
        b"9" * 5000,
        b"a: !!bool x",
        b"a: !!timestamp x",
        b"a: &a {<<: *a}",
        b"exploits: {" + b"x" * 5000 + b": 1}",
        b"#" * 2_000_000,
    ],
)
def test_what_is_no_scenario_is_refused_in_a_short_line(tmp_path: Path, content: bytes):
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_nasim(path)
    assert len(str(caught.value)) < 300 + len(str(path))


def test_a_missing_file_is_told(tmp_path: Path):
    with pytest.raises(InputError, match=r"x\.yaml: cannot be read \(No such file"):
        load_network(str(tmp_path / "x.yaml"))


def test_what_nasim_does_not_know_is_told(tmp_path: Path):
    path = changed(tmp_path, "access: user", "credentials_needed: 1")
    with pytest.warns(NetworkWarning, match="NASim's format has no credentials_needed; what they say is not looked"):
        read_nasim(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_nasim(CLINIC)
