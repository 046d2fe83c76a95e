"""The version, alone, so that `gsiirl --version` imports nothing else."""

__version__ = "0.1.0"
