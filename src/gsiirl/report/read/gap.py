"""The difference between a learner's return and MARL's, which is given both true rewards."""

from dataclasses import dataclass

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun


@dataclass(frozen=True)
class Gap:
    """The deployed learner's return less MARL's, over seeds."""

    difference: Estimate

    @classmethod
    def of(cls, group: GameGroup, run: ReportedRun) -> "Gap | None":
        """The gap to the pair that MARL trained; None where either return is not known.

        It is taken seed by seed from MARL's own run where there is one of the same seeds, else from the run itself.
        """
        deployed, truth = (run.final.get(f"{kind}_return_learner") for kind in ("deployed", "truth"))
        marl = group.of("marl")
        if marl is not None and marl.kept_seeds == run.kept_seeds:
            # In a continuous game MARL ends elsewhere with every seed, and a run holds only one of its ends.
            truth = marl.final.get("truth_return_learner", truth)
        if truth is None:
            truth = group.reference("truth_return_learner")
        if deployed is None or truth is None or not len(deployed):
            return None
        return cls(Estimate.over(deployed - truth))

    @classmethod
    def to_deployed(cls, group: GameGroup, run: ReportedRun) -> "Gap | None":
        """The gap to MARL's learner deployed against the real expert; None where that is not known."""
        marl, deployed = group.of("marl"), run.final.get("deployed_return_learner")
        met = None if marl is None else marl.final.get("deployed_return_learner")
        if marl is None or met is None or deployed is None or not len(met) or not len(deployed):
            return None
        return cls(Estimate.over(deployed - (met if marl.kept_seeds == run.kept_seeds else met.mean())))

    @property
    def verdict(self) -> str:
        """`better` or `worse`; `neither better nor worse` where the 95 % interval holds 0."""
        if self.is_open:
            return "neither better nor worse"
        return "better" if self.difference.mean > 0 else "worse"

    @property
    def is_open(self) -> bool:
        """Whether the 95 % interval holds 0."""
        return self.difference.count > 1 and self.difference.low <= 0 <= self.difference.high
