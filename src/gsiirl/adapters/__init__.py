"""Adapters: learned policies in other people's implementations of a game (no JAX)."""
