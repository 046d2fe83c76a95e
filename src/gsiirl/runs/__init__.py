"""Run folders: what one experiment writes, and how it is read back (no JAX)."""

from gsiirl.runs.ablation import Ablation as Ablation
from gsiirl.runs.ablation import AblationVariant as AblationVariant
from gsiirl.runs.checkpoint import Checkpoint as Checkpoint
from gsiirl.runs.environment import Environment as Environment
from gsiirl.runs.findings import Curve as Curve
from gsiirl.runs.findings import Finding as Finding
from gsiirl.runs.findings import Findings as Findings
from gsiirl.runs.findings import Measurement as Measurement
from gsiirl.runs.findings import Panel as Panel
from gsiirl.runs.folder import RunFolder as RunFolder
from gsiirl.runs.folder import refuse_used as refuse_used
from gsiirl.runs.learned import LearnedParameters as LearnedParameters
from gsiirl.runs.lock import clear_lock as clear_lock
from gsiirl.runs.lock import locked as locked
from gsiirl.runs.summary import GIVEN_THE_REWARDS as GIVEN_THE_REWARDS
from gsiirl.runs.summary import Statistics as Statistics
from gsiirl.runs.summary import Summary as Summary
from gsiirl.runs.summary import summarise as summarise
