"""A gardener and a deer: the game of the first tutorial (docs/tutorials/first-reward.md)."""

import numpy as np

import gsiirl

forest, fence, garden = 0, 1, 2  # where the deer is
wait, chase = 0, 1  # what you may do
stay, come = 0, 1  # what the deer may do

move = np.zeros((3, 2, 2, 3))  # [place, yours, the deer's, next place]
for place in (forest, fence, garden):
    move[place, :, stay, place] = 1.0  # it stays
    move[place, :, come, min(place + 1, garden)] = 1.0  # or comes a place nearer
for place in (fence, garden):
    move[place, chase] = 0.0
    move[place, chase, :, forest] = 0.8  # whom you chase flees, four times in five
    move[place, chase, :, place] = 0.2

earned = np.zeros((3, 2, 2))  # [place, yours, the deer's]
earned[garden] -= 1.0  # it eats your lettuce
earned[:, chase] -= 0.4  # chasing tires you

matters = np.zeros((3, 2, 2, 2))  # [place, yours, the deer's, feature]
matters[garden, :, :, 0] = 1.0  # feature 0: it eats
matters[[fence, garden], chase, :, 1] = 1.0  # feature 1: it is chased

game = gsiirl.games.TabularGame.from_arrays(move, initial=[1, 0, 0], horizon=6)
problem = gsiirl.Problem(
    game,
    dependent_value=earned,
    temperature=0.3,
    expert_features=matters,
    expert_names=["eating", "being chased"],
)
wishes = matters @ [1.0, -1.5]  # hidden from you
deer = gsiirl.RespondingExpert(game, wishes, temperature=0.3, discount=0.95)


def encounter():
    """The two sides, for `gsiirl run game examples/deer.py:encounter`."""
    return problem, deer
