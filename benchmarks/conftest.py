"""Benchmarks run without the type checks and the strictness of the tests: as users run the library."""
