"""Options of the compiler (XLA)."""

QUICKLY = {"xla_backend_optimization_level": 1}
"""With these a program compiles in about two thirds of the time, and runs as fast."""
OF_A_RUN = {"cpu": {**QUICKLY, "xla_cpu_prefer_vector_width": 512}, "gpu": {}}
"""Options for the programs of a run, per device. On a CPU they make a run as fast or faster."""
