"""The processor cores that this process may use."""

import os


def cores() -> list[int]:
    """Their numbers where the system tells them, which may be fewer than the machine has."""
    return sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [*range(os.cpu_count() or 1)]
