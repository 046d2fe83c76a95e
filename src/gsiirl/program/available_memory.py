"""How much memory this process can still have."""

import os
from collections.abc import Iterator
from pathlib import Path


def available_memory(root: Path = Path("/")) -> int | None:
    """Bytes that the system and the control groups of this process leave it; None where nothing tells.

    `root` is where the system's files are.
    """
    left = [*_of_system(root), *_of_groups(root)]
    return max(0, min(left)) if left else None


def _of_system(root: Path) -> Iterator[int]:
    try:
        lines = (root / "proc" / "meminfo").read_text().splitlines()
        yield next(1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, ValueError, IndexError, StopIteration):
        try:
            # Where only the whole memory is known.
            yield os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        except (AttributeError, OSError, ValueError):
            return


def _of_groups(root: Path) -> Iterator[int]:
    """What each control group with a limit leaves, of the second version (which names no controllers) and the first."""
    try:
        lines = (root / "proc" / "self" / "cgroup").read_text().splitlines()
    except OSError:
        return
    for line in lines:
        controllers, _, path = line.partition(":")[2].partition(":")
        if controllers == "":
            folder, limit, used = root / "sys/fs/cgroup", "memory.max", "memory.current"
        elif "memory" in controllers.split(","):
            folder, limit, used = root / "sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        else:
            continue
        group = Path(path.lstrip("/"))
        for each in (group, *group.parents):
            try:
                left = int((folder / each / limit).read_text()) - int((folder / each / used).read_text())
                yield left + _given_back(folder / each / "memory.stat")
            except (OSError, ValueError):
                # No such group here, or one without a limit.
                continue


def _given_back(statistics: Path) -> int:
    """Bytes of files kept in memory that the system drops when a process wants them."""
    numbers = dict(line.split()[:2] for line in statistics.read_text().splitlines())
    return int(numbers.get("total_inactive_file", numbers.get("inactive_file", 0)))
