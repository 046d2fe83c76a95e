"""What can be done with finished runs: reports, tables, files for other programs."""
