"""What the two games in the plane share: recorded episodes and how they are drawn."""
