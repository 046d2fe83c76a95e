"""A run on one's own finite game."""
