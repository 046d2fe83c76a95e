"""The logit equilibrium of one stage game."""
