"""The learners of Algorithm 1: of finite and continuous games, and the paper's."""
