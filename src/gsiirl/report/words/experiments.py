"""Names of the experiments, their sides and their games."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SideName:
    """The name of one side, with the grammar of sentences about it."""

    name: str
    plural: bool = False

    def __str__(self) -> str:
        return self.name

    @property
    def possessive(self) -> str:
        """The genitive: `robot's`, `good agents'`."""
        return self.name + ("'" if self.plural else "'s")

    def verb(self, singular: str, plural: str) -> str:
        """The one of two verb forms that fits."""
        return plural if self.plural else singular


@dataclass(frozen=True)
class ExperimentWords:
    """An experiment in words."""

    title: str
    learner: SideName
    expert: SideName
    here: tuple[str, str] | None = None
    """Who learner and expert are, for readers who do not know the experiment."""
    reference: tuple[str, str] = ("plays at random", "play at random")
    """What the learner of random play does, in the singular and in the plural."""
    trained: bool = False
    """Whether policies are trained networks, MARL's too, which end elsewhere with every seed, and no best is known."""


UNTRAINED = ("has learned nothing", "have learned nothing")

EXPERIMENTS = {
    "deception": ExperimentWords(
        "Multi-agent particles",
        SideName("good agents", plural=True),
        SideName("adversary"),
        ("two agents that hide their target", "an adversary that looks for it"),
        UNTRAINED,
        trained=True,
    ),
    "crossing": ExperimentWords(
        "Human-robot interaction",
        SideName("robot"),
        SideName("human"),
        ("a robot", "a human whose way it crosses"),
        UNTRAINED,
        trained=True,
    ),
    "security": ExperimentWords(
        "Security",
        SideName("defender"),
        SideName("attacker"),
        ("the defender of a network", "its attacker"),
    ),
}
"""By experiment, in the order of the paper."""

VARIANTS = {
    "general_sum": "General-sum: what the defender loses need not be what the attacker gains",
    "zero_sum": "The paper's variant: the defender's dependent reward is minus the attacker's reward",
    "default": "Both move at once: each wants to be at its goal soon, and the robot wants the human at ease as well",
    "mpe": "As in MPE: both sides are after the same landmark, and the adversary does not know which of the two it is",
    "separate_target": "General-sum: the adversary is after the other landmark, not after that of the good agents",
}
"""The variants of games, in words."""

HANDED = {
    "zero_sum": "r_ld = \N{MINUS SIGN}r_e here: the losses that the defender reads hand it the attacker's reward.",
    "mpe": "r_ld = \N{MINUS SIGN}r_e here: what the good agents read of their own reward hands them the adversary's.",
}
"""The variants in which the learner's own reward tells it the expert's, in one line."""


def experiment_words(experiment: str) -> ExperimentWords:
    """The words of an experiment; one that is not listed has a learner and an expert."""
    unlisted = ExperimentWords(experiment.capitalize(), SideName("learner"), SideName("expert"))
    return EXPERIMENTS.get(experiment, unlisted)
