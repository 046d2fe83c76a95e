"""Single files of a run folder: written whole or not at all, and checked when they are read."""
