"""How much memory is free, by the files of a system made up for it."""

from pathlib import Path

import pytest

from gsiirl.program.available_memory import available_memory

GIGABYTE = 10**9


def system(root: Path, files: dict[str, str]) -> Path:
    """A root folder with these files."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


def of_version_2(group: str, limit: str) -> dict[str, str]:
    folder = f"sys/fs/cgroup{group}"
    return {
        "proc/meminfo": "MemTotal: 16000000 kB\nMemAvailable:    8000000 kB\n",
        "proc/self/cgroup": "0::/jobs/run\n",
        f"{folder}/memory.max": limit,
        f"{folder}/memory.current": f"{3 * GIGABYTE}\n",
        f"{folder}/memory.stat": f"anon 5\ninactive_file {GIGABYTE}\n",
    }


def test_without_limits_it_is_what_the_system_has_available(tmp_path: Path):
    files = {"proc/meminfo": "MemTotal:       16000000 kB\nMemAvailable:    8000000 kB\n"}
    assert available_memory(system(tmp_path, files)) == 8_192_000_000


@pytest.mark.parametrize("group", ["/jobs/run", "/jobs", ""])
def test_a_limit_of_the_process_s_group_or_of_one_above_it_counts(tmp_path: Path, group: str):
    # Of 5 GB 3 are used, of which 1 is files that the system can drop.
    root = system(tmp_path, of_version_2(group, f"{5 * GIGABYTE}\n"))
    assert available_memory(root) == 3 * GIGABYTE


def test_a_group_without_a_limit_does_not_count(tmp_path: Path):
    assert available_memory(system(tmp_path, of_version_2("/jobs/run", "max\n"))) == 8_192_000_000


def test_groups_of_the_first_version_count_too(tmp_path: Path):
    files = {
        "proc/meminfo": "MemAvailable:    8000000 kB\n",
        "proc/self/cgroup": "5:cpu,cpuacct:/x\n4:memory:/docker/0815\n0::/\n",
        # Inside a container its own group is the root.
        "sys/fs/cgroup/memory/memory.limit_in_bytes": f"{4 * GIGABYTE}\n",
        "sys/fs/cgroup/memory/memory.usage_in_bytes": f"{2 * GIGABYTE}\n",
        "sys/fs/cgroup/memory/memory.stat": "cache 7\ntotal_inactive_file 500\n",
    }
    assert available_memory(system(tmp_path, files)) == 2 * GIGABYTE + 500


def test_more_in_use_than_the_limit_leaves_nothing(tmp_path: Path):
    assert available_memory(system(tmp_path, of_version_2("/jobs/run", "1000"))) == 0
