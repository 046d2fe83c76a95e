"""The checks, one file a statement of the paper: each measures it and says what was found."""
