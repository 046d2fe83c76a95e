"""What a user calls: a learner of a problem, and what comes out of it."""
