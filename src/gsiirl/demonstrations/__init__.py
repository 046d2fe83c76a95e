"""What somebody's own expert demonstrates: does it fit the game, and the policy that was asked for?"""
