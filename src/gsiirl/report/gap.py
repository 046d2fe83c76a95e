"""How far a learner ends from MARL, which is given both true rewards."""

from dataclasses import dataclass

from gsiirl.report.estimate import Estimate
from gsiirl.report.group import GameGroup
from gsiirl.report.run import ReportedRun


@dataclass(frozen=True)
class Gap:
    """The deployed learner's return less MARL's, over seeds."""

    difference: Estimate

    @classmethod
    def of(cls, group: GameGroup, run: ReportedRun) -> "Gap | None":
        """From MARL's own run, seed by seed, where there is one of the same seeds; else from what the run says of MARL.

        None where either return is not known.
        """
        deployed, truth = (run.final.get(f"{kind}_return_learner") for kind in ("deployed", "truth"))
        marl = group.of("marl")
        if marl is not None and marl.kept_seeds == run.kept_seeds:
            # In a continuous game MARL ends elsewhere with every seed, and a run holds but one of its ends.
            truth = marl.final.get("truth_return_learner", truth)
        if truth is None:
            truth = group.reference("truth_return_learner")
        if deployed is None or truth is None or not len(deployed):
            return None
        return cls(Estimate.over(deployed - truth))

    @classmethod
    def to_deployed(cls, group: GameGroup, run: ReportedRun) -> "Gap | None":
        """From what MARL's own learner earns once the real expert has answered it; None where that is not known."""
        marl, deployed = group.of("marl"), run.final.get("deployed_return_learner")
        met = None if marl is None else marl.final.get("deployed_return_learner")
        if marl is None or met is None or deployed is None or not len(met) or not len(deployed):
            return None
        return cls(Estimate.over(deployed - (met if marl.kept_seeds == run.kept_seeds else met.mean())))

    @property
    def verdict(self) -> str:
        """`better`, `worse` or `neither better nor worse`, decided by the 95 % interval."""
        if self.is_open:
            return "neither better nor worse"
        return "better" if self.difference.mean > 0 else "worse"

    @property
    def is_open(self) -> bool:
        """Whether the seeds do not decide it."""
        return self.difference.count > 1 and self.difference.low <= 0 <= self.difference.high
