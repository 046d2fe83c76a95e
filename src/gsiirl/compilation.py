"""How programs are compiled."""

QUICKLY = {"xla_backend_optimization_level": 1}
"""In two thirds of the time; the programs run as fast."""
OF_A_RUN = {"cpu": {**QUICKLY, "xla_cpu_prefer_vector_width": 512}, "gpu": {}}
"""The programs of a run, by device. On a CPU they run as fast or faster."""
