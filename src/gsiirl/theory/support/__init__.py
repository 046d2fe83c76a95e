"""What several checks share: games, models, closed forms, and ways to measure."""
