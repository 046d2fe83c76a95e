"""Run folders as the report reads them: runs, groups of runs of one game, estimates over seeds."""
