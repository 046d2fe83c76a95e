"""The paper's lemmas and theorems, measured (`gsiirl theory`, docs/theory.md)."""
