"""The experts that a learner meets."""
