"""What `against` returns."""

from typing import Any

import gymnasium
from pettingzoo import ParallelEnv

from gsiirl.pettingzoo.players import Player


class SingleAgentEnv(gymnasium.Env[Any, Any]):
    """A two-player environment as one agent meets it; see `against`."""

    def __init__(self, environment: ParallelEnv[str, Any, Any], agent: str, player: Player) -> None:
        self.environment, self.player, self.other = environment, player, agent
        [self.agent] = [each for each in environment.possible_agents if each != agent]
        self.observation_space = environment.observation_space(self.agent)
        self.action_space = environment.action_space(self.agent)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self._seen, infos = self.environment.reset(seed=seed, options=options)
        return self._seen[self.agent], infos[self.agent]

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        answer = self.player(self._seen[self.other], self.np_random)
        actions = {self.agent: action, self.other: answer}
        self._seen, rewards, terminations, truncations, infos = self.environment.step(actions)
        own = self.agent
        return self._seen[own], rewards[own], terminations[own], truncations[own], infos[own]
