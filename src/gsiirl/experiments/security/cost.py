"""What a run of the security experiment takes, estimated before anything is compiled: memory, and roughly the time.

The counts of numbers below are those of the compiled programs, by XLA's own analysis of stars and of NASim's medium,
rounded up.
"""

from collections.abc import Callable
from typing import NamedTuple

from gsiirl.errors import InputError
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.limits import DENSE, remembered
from gsiirl.program.available_memory import available_memory
from gsiirl.scenarios import AttackNetwork
from gsiirl.scenarios.reachable import TooManyStatesError, reachable_states, starting_state

TOGETHER = 2
"""Seeds that are computed at a time."""
YARDSTICKS = 200
"""Policies that the search for the best commitment holds."""
STEP = 64
"""Bytes of a step of a demonstration."""
LONG = 1.0
"""Hours that are not worth a word."""
NUMBER = 8
"""Bytes of any other number."""
WATCHERS = ("ma-irl", "lin2019")
"""Algorithms that see all their demonstrations at once."""
COMPILATION = 70.0
"""Seconds, where no compiled programs are kept from an earlier run."""


class Held(NamedTuple):
    """What a seed keeps between iterations, and works on within one, in numbers of one policy (T, S, A)."""

    kept: float
    working: float


def warning_of(config: SecurityConfig) -> str | None:
    """What is to be said of the time that a run of a resolved configuration takes, if anything.

    Raises:
        InputError: see `check_memory`.
    """
    network = config.network()
    hours = seconds_needed(config, network, check_memory(config, network)) / 3600
    return f"this run takes about {hours:,.0f} hours of a processor" if hours > LONG else None


def check_memory(config: SecurityConfig, network: AttackNetwork) -> int:
    """The number of states that the game of a resolved configuration can reach.

    Raises:
        InputError: the run would take more than half of the memory that is free, or its game has too many states.
    """
    available = available_memory()
    half = float("inf") if available is None else available / 2

    def fits(states: int, seeds: int) -> bool:
        return memory_needed(config, network, states, seeds) <= half

    # What is free may be endless, but not the patience to count.
    most = _largest(lambda states: fits(states, 1), 2**24)
    try:
        states = reachable_states(network, [starting_state(network)], most).size
        if fits(states, config.seeds):
            return states
        seeds, or_more = config.seeds, ""
        mend = f"use at most --seeds {_largest(lambda seeds: fits(states, seeds), seeds)}"
    except TooManyStatesError:
        states, seeds, or_more = most + 1, 1, " or more"
        mend = "use a smaller network or a shorter horizon"
    needed = memory_needed(config, network, states, seeds)
    raise InputError(
        "nodes" if config.graph is None else "graph",
        f"a game of {states:,}{or_more} states and {len(network.edge_names)} edges takes {needed / 1e9:,.1f} "
        f"GB{or_more} of memory, and half of what is free is {half / 1e9:,.1f} GB",
        mend,
    )


def memory_needed(config: SecurityConfig, network: AttackNetwork, states: int, seeds: int) -> float:
    """Bytes that a run takes at most, besides what the program itself does."""
    edges, nodes = len(network.edge_names), len(network.node_names)
    actions = edges + max(config.learner_no_op, config.expert_no_op)
    policy = config.horizon * states * actions
    held, together = _held(config, policy, nodes + edges), min(seeds, TOGETHER)
    policies = max(
        # An iteration begins with the old states of all seeds and ends with the new ones.
        3 * seeds * held.kept + together * held.working,
        # A checkpoint is copied as it is written.
        4 * seeds * held.kept,
        YARDSTICKS,
    )
    # Every feature of every joint action, of one state at a time.
    features = 4 * actions**2 * (nodes + 2 * edges)
    episodes = config.trajectories * (max(config.iterations, 1) if config.algorithm in WATCHERS else 1)
    first_state = 2 * NUMBER * states
    if config.algorithm == "lin2019":
        # What every joint action adds to either side, by weight: made, copied to the program, and cut down there.
        features += 3 * together * config.horizon * states * actions**2 * (2 * nodes + 3 * edges)
    demonstrations = episodes * (3 if config.response == "measured" else 1) * (config.horizon * STEP + first_state)
    return NUMBER * (policies * policy + features) + together * demonstrations


def seconds_needed(config: SecurityConfig, network: AttackNetwork, states: int) -> float:
    """Roughly the processor time of a run that commits to a policy; of others less is said than they take.

    Measured in microseconds for each number of a policy, with 16 to 41 weights of the attacker's reward; twice or half
    as long is no surprise.
    """
    edges, nodes = len(network.edge_names), len(network.node_names)
    policy = config.horizon * states * edges
    held = config.remembered or remembered(2 * policy, config.iterations)
    by_policy = config.algorithm == "gsiirl" and config.commitment == "policy"
    iteration, end, yardsticks = 15 + 0.6 * (nodes + edges) + 0.25 * held, 500, 500
    learning = config.seeds * (config.iterations * iteration + end) if by_policy else 0
    return COMPILATION + 1e-6 * policy * (learning + yardsticks)


def _held(config: SecurityConfig, policy: int, weights: int) -> Held:
    """Of the learner, and of what it hands back in the end."""
    if config.algorithm in ("marl", *WATCHERS):
        return Held(0.0, 30.0)
    if config.commitment == "reward":
        kept = config.remembered or 1
        return Held(kept, 2 * kept + 50 + 20 * config.draws)
    number = config.remembered or remembered(2 * policy, config.iterations)
    if config.lower_level == "matching":
        kept, fit = number + 5, 0.0
    else:
        # The derivative of every action value by every weight, and products of it.
        kept, fit = 2 * number + 5, 4.2 * weights if weights <= DENSE else 50.0
    return Held(kept, max(2.5 * kept + fit + 100, 0.8 * kept + 230))


def _largest(fits: Callable[[int], bool], most: int) -> int:
    """The largest number up to `most` that fits; 0 where 1 does not. What fits does so for all smaller numbers."""
    low, high = 0, most
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if fits(middle) else (low, middle - 1)
    return low
