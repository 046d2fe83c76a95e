"""Games other people published, as finite two-sided games with the payoffs of both sides scaled into [-1, 1].

Each game divides all its payoffs by its one largest absolute payoff, so the balance between the two sides is kept.
The learner takes the row player's (or the leader's, or the defender's) part. A temperature is in units of the scaled
payoffs. Two games are not copied from a table but drawn with a fixed seed, and say so: the security game, whose
numbers come from the ranges of a known benchmark, and the Garnet game, which is random by its definition.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from commitment_oracle import FiniteGame, Floats, one_shot

# Selten and Chmura, "Stationary concepts for experimental 2x2 games", American Economic Review 98(3), 2008, Figure 1.
# Rows are up and down, columns left and right; each entry is (row player, column player). Games 1 to 6 are constant
# sum; games 7 to 12 add a constant to the row player's right column and to the column player's upper row, so game
# k + 6 has the equilibrium of game k.
SELTEN_CHMURA = (
    (((10, 8), (0, 18)), ((9, 9), (10, 8))),
    (((9, 4), (0, 13)), ((6, 7), (8, 5))),
    (((8, 6), (0, 14)), ((7, 7), (10, 4))),
    (((7, 4), (0, 11)), ((5, 6), (9, 2))),
    (((7, 2), (0, 9)), ((4, 5), (8, 1))),
    (((7, 1), (1, 7)), ((3, 5), (8, 0))),
    (((10, 12), (4, 22)), ((9, 9), (14, 8))),
    (((9, 7), (3, 16)), ((6, 7), (11, 5))),
    (((8, 9), (3, 17)), ((7, 7), (13, 4))),
    (((7, 6), (2, 13)), ((5, 6), (11, 2))),
    (((7, 4), (2, 11)), ((4, 5), (10, 1))),
    (((7, 3), (3, 9)), ((3, 5), (10, 0))),
)


def _scaled(name: str, learner: Floats, expert: Floats, temperature: float) -> FiniteGame:
    """A one-shot game with both payoff matrices divided by the largest absolute payoff."""
    largest = max(np.abs(learner).max(), np.abs(expert).max())
    return one_shot(name, learner / largest, expert / largest, temperature)


def _markov(
    name: str,
    transitions: Floats,
    initial: Floats,
    horizon: int,
    learner: Floats,
    expert: Floats,
    discount: float,
    temperature: float,
) -> FiniteGame:
    """A Markov game with both reward tables divided by the largest absolute reward."""
    largest = max(np.abs(learner).max(), np.abs(expert).max())
    return FiniteGame(
        name=name,
        transitions=transitions,
        initial=initial,
        horizon=horizon,
        own=np.zeros(learner.shape[:2]),
        dependent=learner / largest,
        expert=expert / largest,
        discount=discount,
        temperature=temperature,
    )


def shapley(temperature: float) -> FiniteGame:
    """Shapley's 3x3 game, in which fictitious play cycles.

    L. S. Shapley, "Some topics in two-person games", 1964; the matrices are those of Shoham and Leyton-Brown,
    Multiagent Systems, 2009, chapter 7 (and of OpenSpiel's ``matrix_shapleys_game``).
    """
    learner = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    expert = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    return _scaled("Shapley", learner, expert, temperature)


def selten_chmura(number: int, temperature: float) -> FiniteGame:
    """Game 1 to 12 of Selten and Chmura (2008); the learner is the row player."""
    table = np.array(SELTEN_CHMURA[number - 1], float)
    return _scaled(f"Selten-Chmura {number}", table[..., 0], table[..., 1], temperature)


def biased_rock_paper_scissors(temperature: float) -> FiniteGame:
    """Zero-sum rock, paper, scissors with unequal stakes, whose equilibrium is (1/16, 10/16, 5/16).

    Bošanský, Lisý, Lanctot, Čermák and Winands, "Algorithms for computing strategies in two-player simultaneous
    move games", Artificial Intelligence 237, 2016, Figure 7 (OpenSpiel's ``matrix_brps``).
    """
    learner = np.array([[0.0, -25.0, 50.0], [25.0, 0.0, -5.0], [-50.0, 5.0, 0.0]])
    return _scaled("biased rock-paper-scissors", learner, -learner, temperature)


def iterated_prisoners_dilemma(temperature: float) -> FiniteGame:
    """The iterated prisoner's dilemma with memory one: ten rounds, payoffs 3, 0, 5, 1 and a discount of 0.95.

    Five states: the start, then the last joint action CC, CD, DC, DD with the learner's action first, as in Foerster
    et al., "Learning with opponent-learning awareness", 2018. Payoffs are those of Axelrod's tournaments (1984), also
    used by Press and Dyson (2012).
    """
    learner = np.array([[3.0, 0.0], [5.0, 1.0]])
    transitions = np.zeros((5, 2, 2, 5))
    for mine in range(2):
        for yours in range(2):
            transitions[:, mine, yours, 1 + 2 * mine + yours] = 1.0
    return _markov(
        "iterated prisoner's dilemma",
        transitions,
        np.eye(5)[0],
        10,
        np.tile(learner, (5, 1, 1)),
        np.tile(learner.T, (5, 1, 1)),
        0.95,
        temperature,
    )


def security_game(temperature: float, targets: int = 5, seed: int = 2011) -> FiniteGame:
    """A Stackelberg security game: one resource and five targets, and either side may also do nothing.

    The form is that of Kiekintveld et al., "Computing optimal randomized resource allocations for massive security
    games", 2009: an attack on a covered target pays the defender a reward and the attacker a penalty, on an uncovered
    one the other way round. The payoffs are not copied from a paper: they are integers drawn with a fixed seed,
    rewards from 1 to 10 and penalties from -10 to -1, the ranges customary since Yang et al., "Improving resource
    allocation strategy against human adversaries in security games", 2011. No attack pays both sides nothing.
    """
    rng = np.random.default_rng(seed)
    saved, caught, lost, loot = (rng.integers(1, 11, size=targets) for _ in range(4))
    learner = np.zeros((targets + 1, targets + 1))  # the last action of either side is to do nothing
    expert = np.zeros((targets + 1, targets + 1))
    learner[:, :targets] = -lost
    expert[:, :targets] = loot
    covered = np.arange(targets)
    learner[covered, covered] = saved
    expert[covered, covered] = -caught
    return _scaled("security game", learner, expert, temperature)


def garnet(
    temperature: float, states: int = 12, actions: int = 3, horizon: int = 8, branching: int = 3, seed: int = 1995
) -> FiniteGame:
    """A Garnet: a random sparse Markov game with twelve states, three successors and normal rewards.

    After Archibald, McKinnon and Thomas, "On the generation of Markov decision processes", 1995, and Bhatnagar et
    al., "Natural actor-critic algorithms", 2009: every state and joint action has ``branching`` successors, whose
    probabilities are the gaps between uniform cuts of [0, 1]. The draw is ours and has a fixed seed.
    """
    rng = np.random.default_rng(seed)
    transitions = np.zeros((states, actions, actions, states))
    for index in np.ndindex(states, actions, actions):
        successors = rng.choice(states, size=branching, replace=False)
        cuts = np.concatenate([[0.0], np.sort(rng.random(branching - 1)), [1.0]])
        transitions[index][successors] = np.diff(cuts)
    learner = rng.normal(size=(states, actions, actions))
    expert = rng.normal(size=(states, actions, actions))
    initial = np.full(states, 1.0 / states)
    return _markov(f"Garnet {states} states", transitions, initial, horizon, learner, expert, 0.95, temperature)


def boltzmann_toy(temperature: float, bonus: float = 1.0, horizon: int = 10) -> FiniteGame:
    """The three-state toy Markov game of "BC-HG", with two leader and three follower actions.

    Kudo, Tanabe, Wachi and Akimoto, "Sample-efficient hypergradient estimation for decentralized bi-level
    reinforcement learning", arXiv 2603.14867, 2026; the tables are those of ``DiscreteToy4`` in the authors'
    repository akimotolab/BC-HG, where the bonus is 1 (R1) or 2 (R2) and the discount 0.99. The leader's action
    matters in state A alone. The authors run episodes of 150 steps against a stationary follower at temperature 0.05
    in unscaled rewards; here the horizon is shortened.
    """
    start, left, right = 0, 1, 2  # called S, A and B by the authors; the follower's actions are s, a and b
    successor = np.tile(np.arange(3)[:, None, None], (1, 2, 3))  # any move not named below stays
    successor[start, :, 1] = left
    successor[start, :, 2] = right
    successor[left, 0, 0] = start
    successor[left, 0, 2] = right
    successor[left, 1, :] = start
    successor[right, :, 0] = start
    expert = np.zeros((3, 2, 3))
    expert[start, :, 1:] = 1.0
    expert[left, 1, :] = -1.0
    expert[left, 0, 2] = bonus
    learner = np.zeros((3, 2, 3))
    learner[start, :, 1] = 1.0
    name = f"BC-HG toy R{bonus:g}"
    return _markov(name, np.eye(3)[successor], np.eye(3)[start], horizon, learner, expert, 0.99, temperature)


def public_games(temperature: float) -> list[FiniteGame]:
    """All the published games at one temperature, one-shot games first."""
    one_shots: Sequence[FiniteGame] = [
        shapley(temperature),
        *(selten_chmura(number, temperature) for number in range(1, 13)),
        biased_rock_paper_scissors(temperature),
        security_game(temperature),
    ]
    return [
        *one_shots,
        iterated_prisoners_dilemma(temperature),
        boltzmann_toy(temperature, bonus=1.0),
        boltzmann_toy(temperature, bonus=2.0),
        garnet(temperature),
    ]
