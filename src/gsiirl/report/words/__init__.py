"""Names of algorithms and experiments, and numbers and formulas as text."""
