"""What a learner is told: a game, its own reward, and what it may find out of the rest."""
