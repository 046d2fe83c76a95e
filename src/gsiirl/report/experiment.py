"""How the report names an experiment and its two sides."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SideName:
    """What one side is called, and how sentences go on after it."""

    name: str
    plural: bool = False

    def __str__(self) -> str:
        return self.name

    @property
    def possessive(self) -> str:
        """As in `the robot's return`."""
        return self.name + ("'" if self.plural else "'s")

    def verb(self, singular: str, plural: str) -> str:
        """The form that fits."""
        return plural if self.plural else singular


@dataclass(frozen=True)
class ExperimentWords:
    """An experiment in words."""

    title: str
    learner: SideName
    expert: SideName
    here: tuple[str, str] | None = None
    """Who learner and expert are, for who has not heard of the experiment."""
    reference: tuple[str, str] = ("plays at random", "play at random")
    """What the learner does that marks the lower end, of one and of several."""


UNTRAINED = ("has learned nothing", "have learned nothing")

EXPERIMENTS = {
    "deception": ExperimentWords(
        "Multi-agent particles",
        SideName("good agents", plural=True),
        SideName("adversary"),
        ("two agents that hide their target", "an adversary that looks for it"),
        UNTRAINED,
    ),
    "crossing": ExperimentWords(
        "Human-robot interaction",
        SideName("robot"),
        SideName("human"),
        ("a robot", "a human whose way it crosses"),
        UNTRAINED,
    ),
    "security": ExperimentWords(
        "Security",
        SideName("defender"),
        SideName("attacker"),
        ("the defender of a network", "its attacker"),
    ),
}
"""In the order of the paper."""

VARIANTS = {
    "general_sum": "general-sum: the defender's losses differ from the attacker's gains",
    "zero_sum": "the paper's variant: the defender's dependent reward is minus the attacker's reward",
    "default": "both move at once: each wants to be at its goal soon, and the robot wants the human at ease as well",
    "mpe": "as in MPE: both sides are after the same landmark, and the adversary does not know which of the two it is",
    "separate_target": "general-sum: the adversary is after the other landmark, not after that of the good agents",
}


def experiment_words(experiment: str) -> ExperimentWords:
    """The words of any experiment; one not known here has a learner and an expert."""
    return EXPERIMENTS.get(experiment) or ExperimentWords(
        experiment.capitalize(), SideName("learner"), SideName("expert")
    )
