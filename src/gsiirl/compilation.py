"""Options of the compiler (XLA)."""

import os


def silence() -> None:
    """Keep XLA's own log off the screen, before JAX is imported; its errors are raised in Python all the same.

    It takes a program that compiles for minutes for a fault, and says so in words that are of no use here.
    """
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")


QUICKLY = {"xla_backend_optimization_level": 1}
"""With these a program compiles in about two thirds of the time, and runs as fast."""
OF_A_RUN = {"cpu": {**QUICKLY, "xla_cpu_prefer_vector_width": 512}, "gpu": {}}
"""Options for the programs of a run, per device. On a CPU they make a run as fast or faster."""
