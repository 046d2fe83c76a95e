"""Templates and the writing of files."""
