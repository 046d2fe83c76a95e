"""Experiments: a configuration, and how a run is built from it."""
