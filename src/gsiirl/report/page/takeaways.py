"""The three sentences on a game that a reader should take away, computed from the numbers that its tables show."""

from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.tables.rivals import Gain, Rivals
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.numbers import format_number, format_share
from gsiirl.report.words.sentences import enumeration

PAPER = algorithm_style("paper").name


def takeaways(group: GameGroup, rivals: Rivals | None) -> list[str]:
    """How much of what could be gained was reached; better and worse than whom; how right the reward is."""
    if rivals is None:
        return []
    run = group.runs[rivals.subject.label]
    sentences = [_reached(group, rivals), _compared(rivals), _learned(group, rivals.subject.label, run)]
    return [sentence for sentence in sentences if sentence]


def _reached(group: GameGroup, rivals: Rivals) -> str:
    ours, gain, learner = rivals.subject, rivals.gain, group.sides[0]
    run = group.runs[ours.label]
    whose, count = f"{ours.label}'s {learner}", len(run.seeds)
    if ours.overall is None:
        overall = f"over all {count} seeds there is no mean, since a seed has no number"
    else:
        share = "" if ours.overall_share is None else f" ({format_share(ours.overall_share)})"
        overall = f"over all {count} seeds {_it_earns(group)} {ours.overall}{share}"
    if ours.returns is None:
        return f"All {count} seeds of {whose} failed: {overall}.{_random(rivals)}"
    failed, others = "", ""
    if run.failed_seeds:
        failed = f"In {len(run.kept_seeds)} of {count} seeds ({len(run.failed_seeds)} failed) "
        others = f" {overall[0].upper()}{overall[1:]}."
    if gain is None:
        earns = f"{learner.verb('earns', 'earn')} {ours.earned} an encounter"
        return f"{failed}{whose}, deployed, {earns}.{others}{_random(rivals)}"
    if ours.share is None:
        return (
            f"Nothing can be gained here: random play and {_best(group, gain)} earn the same, "
            f"{format_number(gain.best)}. {failed}{whose} {learner.verb('earns', 'earn')} {ours.earned}.{others}"
        )
    marks = f"random play (0 %) {format_number(gain.random)}, {_best(group, gain)} (100 %) {format_number(gain.best)}"
    of = "what could be gained" if gain.is_ceiling else "what MARL gains, which is given both rewards"
    earns = f"{_it_earns(group)} {ours.earned} an encounter"
    return f"{failed}{whose} reached {format_share(ours.share)} of {of}: {earns}, {marks}.{others}"


def _it_earns(group: GameGroup) -> str:
    return group.sides[0].verb("it earns", "they earn")


def _best(group: GameGroup, gain: Gain) -> str:
    return "the best way found with both rewards known" if gain.is_ceiling else f"MARL's {group.sides[0]}, deployed too"


def _random(rivals: Rivals) -> str:
    random = rivals.of("random")
    return "" if random is None else f" Random play earns {random.earned}."


def _compared(rivals: Rivals) -> str:
    """Better, worse, the same: of whom each is said."""
    said: dict[str, list[str]] = {}
    for row in rivals.rows:
        if row.verdict is not None:
            said.setdefault(row.verdict.words(), []).append(row.label.replace(PAPER, "the paper's preset"))
    parts = [
        f"{kind} {enumeration(said.pop(key))}"
        for key, kind in (("better", "better than"), ("worse", "worse than"), ("the same", "the same as"))
        if key in said
    ]
    unsaid = [f"against {enumeration(names)} one {words}" for words, names in said.items()]
    ours = f"{rivals.subject.label} does " + enumeration(parts) if parts else ""
    text = "; ".join([*([ours] if ours else []), *unsaid])
    return f"{text[0].upper()}{text[1:]}." if text else ""


def _learned(group: GameGroup, label: str, run: ReportedRun) -> str:
    expert = group.sides[1]
    wants = f"What the {expert} {expert.verb('wants', 'want')}"
    if "expert_reward_pearson" in run.undefined:
        return (
            f"{wants} cannot be compared with the truth: one of the two rewards is the same whatever happens, so that "
            "a correlation is not defined."
        )
    pearson, asked = run.estimate("expert_reward_pearson"), run.estimate("expert_trajectories")
    if pearson is None:
        return ""
    cost = "" if asked is None else f", from {asked.mean:,.0f} observed encounters a seed"
    everyone = ""
    if pearson.with_failed is not None:
        everyone = f"; over all {pearson.with_failed.count} seeds {format_number(pearson.with_failed.mean, 3)}"
    correlation = f"a correlation of {format_number(pearson.mean, 3)} with the truth (1 is perfect{everyone})"
    return f"{wants}, {label} learned to {correlation}{cost}."


def gain_note(group: GameGroup, rivals: Rivals | None) -> str:
    """What shares of the gain are measured by."""
    if rivals is None or rivals.gain is None:
        return "What could be gained is not known here."
    begin = f"The gain is measured from random play (0 %) to {_best(group, rivals.gain)} (100 %)"
    if not rivals.gain.is_ceiling:
        return f"{begin}: no best is known in a game of this kind, and 100 % can be passed."
    regret = group.runs[rivals.subject.label].estimate("regret")
    text = f"{begin}, the best by discounted returns, so that 100 % can be passed by a little."
    if regret is None:
        return text
    missed = f"{rivals.subject.label} misses {format_number(100 * regret.mean, 2)} % (its regret)"
    return f"{text} Of what lies between the worst and the best way, discounted, {missed}."
