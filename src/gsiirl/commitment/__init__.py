"""The upper level in finite games: which policy to commit to, given how the expert would answer it."""

from gsiirl.commitment.objective import Commitment as Commitment
from gsiirl.commitment.search import Search as Search
