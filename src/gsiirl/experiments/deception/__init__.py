"""The deception experiment: two agents and an adversary."""
