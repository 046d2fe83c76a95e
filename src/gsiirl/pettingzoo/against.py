"""A two-player environment with one side played by somebody: one agent is left, and the environment is Gymnasium's."""

from typing import TYPE_CHECKING, Any

from gsiirl.errors import InputError
from gsiirl.pettingzoo.players import Player

if TYPE_CHECKING:
    import gymnasium
    from pettingzoo import ParallelEnv


def against(environment: "ParallelEnv[str, Any, Any]", agent: str, player: Player) -> "gymnasium.Env[Any, Any]":
    """The game as the other agent meets it while `player` plays `agent`, as a Gymnasium environment.

    Any library that trains a single agent can be given it. `player` may be one of this package, or any function
    `player(observation, random)` that returns an action. `reset(seed)` decides what the player draws, too.

    Raises:
        InputError: the environment has no such agent, or not two.
    """
    from gsiirl.pettingzoo.single_agent import SingleAgentEnv

    agents = environment.possible_agents
    if len(agents) != 2:
        raise InputError("environment", f"has agents {', '.join(agents)}", "give one of two agents")
    if agent not in agents:
        raise InputError("agent", f"cannot be {agent!r}", f"choose {' or '.join(agents)}")
    return SingleAgentEnv(environment, agent, player)
