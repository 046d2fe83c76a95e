"""The security, crossing and deception games as PettingZoo environments, and who can play in them.

docs/how-to/pettingzoo.md shows how.
"""

from gsiirl.pettingzoo.against import against as against
from gsiirl.pettingzoo.environments import parallel_env as parallel_env
from gsiirl.pettingzoo.environments import run_env as run_env
from gsiirl.pettingzoo.players import Player as Player
from gsiirl.pettingzoo.responding_player import responding_player as responding_player
from gsiirl.pettingzoo.run_players import expert_player as expert_player
from gsiirl.pettingzoo.run_players import learned_player as learned_player
