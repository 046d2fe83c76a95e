"""What the experiments with continuous states share."""
