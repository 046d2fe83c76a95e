"""The page of `gsiirl theory`: the findings and their figures."""
