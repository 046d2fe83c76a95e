"""Learned rewards in changed games: what every experiment that has them shares."""
