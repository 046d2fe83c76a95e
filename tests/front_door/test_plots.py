import html
import importlib.util
import io
from html.parser import HTMLParser
from typing import Any

import numpy as np
import polars
import pytest
import rich.console

import gsiirl
from gsiirl.front_door import plots
from gsiirl.front_door.result import Result, Results
from gsiirl.program import progress

RANDOM = np.random.default_rng(0)
STATES, LEARNER, EXPERT, HORIZON = 2, 2, 3, 2
WEIGHTS = STATES * LEARNER * EXPERT


def made_up(draws: int = 50) -> Result:
    """A result of a game that always begins in state 0, and goes to state 1 when the learner plays action 1."""
    transitions = np.zeros((STATES, LEARNER, EXPERT, STATES))
    transitions[:, 0, :, 0] = transitions[:, 1, :, 1] = 1.0
    game = gsiirl.games.TabularGame.from_arrays(transitions, initial=[1.0, 0.0], horizon=HORIZON)
    own = RANDOM.normal(size=(STATES, LEARNER))
    value = RANDOM.normal(size=(STATES, LEARNER, EXPERT))
    problem = gsiirl.Problem(game, own_reward=own, dependent_value=value, temperature=0.5, discount=0.9)
    policy = RANDOM.dirichlet(np.ones(LEARNER), (HORIZON, STATES))
    weights = np.arange(WEIGHTS) - 4.5
    spread = np.where(np.arange(WEIGHTS) % 2, 0.1, 2.0)
    return Result.learned(
        problem=problem,
        seed=3,
        trajectories=20,
        policy=policy,
        expert_policy=RANDOM.dirichlet(np.ones(EXPERT), (HORIZON, STATES)),
        expert_weights=weights,
        dependent_weights=RANDOM.normal(size=WEIGHTS),
        draws=weights + spread * RANDOM.normal(size=(draws, WEIGHTS)),
        history=polars.DataFrame({"iteration": [1, 2], "prior_deviation": [1.0, 1.0]}),
        played=RANDOM.dirichlet(np.ones(LEARNER), (2, HORIZON, STATES)),
        answers=np.zeros((0, HORIZON, STATES, EXPERT)),
        effective_draws=40.0,
        sampled=False,
    )


def returns_of(result: Result, policy: np.ndarray) -> float:
    """The learner's discounted return against a soft best response to the learned weights: backward induction."""
    problem, reward = result.problem, result.expert_reward.weights.reshape(STATES, LEARNER, EXPERT)
    expert, learner = np.zeros(STATES), np.zeros(STATES)
    tau, own = 0.5, np.asarray((problem.own_reward + problem.dependent_value).dense())
    for step in reversed(range(HORIZON)):
        after = [np.stack([values] * STATES)[:, :, None] for values in (expert, learner)]
        joint = policy[step][:, :, None]
        values = (joint * (reward + problem.discount * after[0])).sum(1) / tau
        answer = np.exp(values - values.max(1, keepdims=True))
        answer /= answer.sum(1, keepdims=True)
        expert = tau * (np.log(np.exp(values - values.max(1, keepdims=True)).sum(1)) + values.max(1))
        learner = (joint * answer[:, None, :] * (own + problem.discount * after[1])).sum((1, 2))
    return float(learner[0])


def test_a_plot_shows_weights_returns_and_the_commitment() -> None:
    result = made_up()
    wanted, earned, committed = result.plot().axes
    titles = [axes.get_title(loc="left").splitlines()[0] for axes in (wanted, earned, committed)]
    assert titles == ["What the expert wants", "What the learner earns", "The commitment"]
    names = [label.get_text() for label in wanted.get_yticklabels()]
    assert names == list(result.expert_reward.names)[::-1]
    points = [line for line in wanted.lines if line.get_marker() == "o"]
    drawn = {round(float(np.ravel(line.get_ydata())[0])): float(np.ravel(line.get_xdata())[0]) for line in points}
    assert [drawn[place] for place in range(WEIGHTS)] == pytest.approx(result.expert_reward.weights[::-1])
    # Those that the draws leave open are grey.
    grey = [line.get_color() == plots.UNDETERMINED for line in points]
    assert grey == [not known for known in result.expert_reward.determined[::-1]]
    assert 0 < sum(grey) < WEIGHTS
    played = np.ravel(earned.lines[0].get_ydata())
    assert list(played) == pytest.approx([returns_of(result, each) for each in result.played])
    assert np.ravel(earned.lines[1].get_ydata())[0] == pytest.approx(returns_of(result, result.policy))
    # The game begins in state 0 alone.
    assert [label.get_text() for label in committed.get_yticklabels()] == [
        "step 0, state 0",
        "step 1, state 0",
        "step 1, state 1",
    ]
    shown = np.asarray(committed.images[0].get_array())
    assert shown == pytest.approx(np.stack([result.policy[0, 0], result.policy[1, 0], result.policy[1, 1]]))


def test_how_often_states_are_met_is_what_the_policies_make_it() -> None:
    result = made_up()
    often = plots.visited(result.problem, result.policy, result.expert_policy)
    assert often == pytest.approx(np.array([[1.0, 0.0], result.policy[0, 0]]))


def test_without_a_posterior_there_are_no_intervals() -> None:
    wanted, earned, _ = made_up(draws=0).plot().axes
    assert all(line.get_marker() == "o" for line in wanted.lines[:-1])
    assert len(earned.patches) == 0


def test_a_notebook_gets_a_picture() -> None:
    figure: Any = made_up().plot()
    assert figure._repr_png_().startswith(b"\x89PNG")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg")
    assert buffer.getvalue()


class Cells(HTMLParser):
    """The text of every element, and whether every element that is opened is closed in its turn."""

    def __init__(self) -> None:
        super().__init__()
        self.open, self.texts = list[str](), list[str]()

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_html_names_the_largest_weights_and_what_is_open() -> None:
    result = made_up()
    parsed = Cells()
    parsed.feed(result._repr_html_())
    assert parsed.open == []
    assert "learned from: 2 iterations of 20 episodes, seed 3" in parsed.texts
    assert "weights determined: 6 of 12" in parsed.texts
    largest = list(result.expert_reward.names)[WEIGHTS - 1]
    place = parsed.texts.index(largest)
    assert parsed.texts[place + 1] == "6.5"
    assert "and 4 smaller ones" in parsed.texts
    assert sum("not determined" in text for text in parsed.texts) >= 1


def test_what_people_print_is_one_short_line() -> None:
    result = made_up()
    expert = gsiirl.RespondingExpert(result.problem.game, np.zeros((STATES, LEARNER, EXPERT)), 0.5, 0.9)
    security, attacker = gsiirl.problems.security("small-linear")
    crossing, human = gsiirl.problems.crossing()
    everything = [result, result.problem, result.problem.game, expert, result.expert_reward, gsiirl.GSIIRL(security)]
    everything += [security, security.game, attacker, crossing, crossing.game, human, gsiirl.GSIIRL(crossing)]
    assert [each for each in map(repr, everything) if "\n" in each or len(each) > 120] == []
    assert (
        repr(attacker)
        == "RespondingExpert(AttackGraph(30 states, 17 x 17 actions, 10 steps), temperature 0.05, discount 0.95)"
    )


@pytest.mark.parametrize(
    ("jupyter", "widgets", "terminal", "dumb", "drawn"),
    [
        (True, True, False, False, True),
        (True, False, True, False, False),
        (False, True, True, False, True),
        (False, True, True, True, False),
        (False, True, False, False, False),
    ],
)
def test_bars_are_drawn_on_terminals_and_in_notebooks_that_can(
    monkeypatch: pytest.MonkeyPatch, jupyter: bool, widgets: bool, terminal: bool, dumb: bool, drawn: bool
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object() if widgets else None)

    class Console(rich.console.Console):
        @property
        def is_terminal(self) -> bool:
            return terminal

        @property
        def is_dumb_terminal(self) -> bool:
            return dumb

    console = Console(force_jupyter=jupyter)
    assert progress.draws(console) is drawn


def test_html_of_several_seeds_has_means_and_spreads() -> None:
    one, other = made_up(), made_up()
    other.expert_reward.weights[WEIGHTS - 1] += 2.0
    parsed = Cells()
    parsed.feed(Results([one, other])._repr_html_())
    assert parsed.open == []
    place = parsed.texts.index(list(one.expert_reward.names)[WEIGHTS - 1])
    assert parsed.texts[place + 1 : place + 3] == ["7.5", "1.4"]
    assert "and 4 smaller ones" in parsed.texts


def test_html_names_what_is_open_only_together() -> None:
    result = made_up()
    shared = np.random.default_rng(0).normal(size=(len(result.expert_reward.draws), 1))
    result.expert_reward.draws[:, :2] = 0.6 * result.expert_reward.prior_deviation * shared
    result.expert_reward.draws[:, :2] *= np.array([0.7, 0.7])
    words = [each for each in result.expert_reward.undetermined if each.startswith("a c")]
    assert words
    assert all(f"not determined: {each}" in html.unescape(result._repr_html_()) for each in words)
