"""The difference between a learner's return and MARL's, which is given both true rewards."""

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun

VERDICTS = {1: "better", 0: "neither better nor worse", -1: "worse"}
"""By the sign of the difference."""


def gap_to_marl(group: GameGroup, run: ReportedRun) -> Estimate | None:
    """The deployed return less that of the pair that MARL trained; None where either is not known.

    It is taken seed by seed from MARL's own run where there is one of the same seeds, else from the run itself.
    """
    deployed, truth = (run.final.get(f"{kind}_return_learner") for kind in ("deployed", "truth"))
    marl = group.of("marl")
    if marl is not None and marl.kept_seeds == run.kept_seeds:
        # In a continuous game MARL ends elsewhere with every seed, and a run holds only one of its ends.
        truth = marl.final.get("truth_return_learner", truth)
    if truth is None:
        truth = group.reference("truth_return_learner")
    return None if deployed is None or truth is None or not len(deployed) else Estimate.over(deployed - truth)


def gap_to_deployed_marl(group: GameGroup, run: ReportedRun) -> Estimate | None:
    """The deployed return less that of MARL's learner against the real expert; None where either is not known."""
    marl, deployed = group.of("marl"), run.final.get("deployed_return_learner")
    met = None if marl is None else marl.final.get("deployed_return_learner")
    if marl is None or met is None or deployed is None or not len(met) or not len(deployed):
        return None
    return Estimate.over(deployed - (met if marl.kept_seeds == run.kept_seeds else met.mean()))
