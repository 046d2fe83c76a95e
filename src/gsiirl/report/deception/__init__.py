"""Figures of physical deception: an episode, and the weights of the adversary's reward."""
