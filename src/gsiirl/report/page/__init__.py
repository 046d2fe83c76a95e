"""The page of `gsiirl report`: from the run folders to the written files."""
