"""Changes of the crossing that `gsiirl transfer` takes a learner through: a goal, a start or a speed moved.

A change is a text:

    robot-goal=X:Y      the robot heads for (X, Y)
    robot-start=X:Y     the robot starts around (X, Y), in a box as large as before
    human-start=X:Y     the human does
    robot-speed=V       the robot moves by up to V along an axis in a step
    human-speed=V       the human does

Where the human heads for stays: it is what was learned.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gsiirl.errors import InputError
from gsiirl.games.crossing import HUMAN_START, LARGEST_STEP, ROBOT_START
from gsiirl.rewards.crossing import ROBOT_GOAL
from gsiirl.scenarios.network import shown

Place = tuple[float, float]
Box = tuple[Place, Place]
FIELD = "--change"
FORMS = "give robot-goal=X:Y, robot-start=X:Y, human-start=X:Y, robot-speed=V or human-speed=V"
KINDS = ("robot-goal", "human-start", "robot-start", "human-speed", "robot-speed")
FURTHEST, FASTEST = 10.0, 1.0
"""Bounds on what may be given: places along an axis, and speeds."""
ARENA, SPEEDS = 0.6, (0.05, 0.15)
"""Ranges that changes are drawn from."""
APART = 0.4
"""The robot starts at least this far from its goal, and from the human, where places are drawn."""
DIGITS = 3
"""Decimals of what is drawn, so that its text says all of it."""


@dataclass(frozen=True)
class Layout:
    """Where the robot heads for, the middles of the boxes that both start in, and how fast both are."""

    robot_goal: Place = ROBOT_GOAL
    robot_start: Place = (0.0, -0.45)
    human_start: Place = (0.45, 0.0)
    robot_speed: float = LARGEST_STEP
    human_speed: float = LARGEST_STEP


def changed(layout: Layout, change: str) -> Layout:
    """The layout after a change.

    Raises:
        InputError: the text is none, or its numbers are out of range.
    """
    kind, _, what = change.partition("=")
    if kind not in KINDS:
        raise InputError(FIELD, f"'{shown(change)}' is no change of the crossing", FORMS)
    number = 1 if kind.endswith("speed") else 2
    values = _numbers(kind, what, number)
    if number == 1 and not 0 < values[0] <= FASTEST:
        raise InputError(FIELD, f"{kind} cannot be {shown(what)}", f"give a number above 0, at most {FASTEST:g}")
    if max(map(abs, values)) > FURTHEST:
        raise InputError(FIELD, f"{kind} cannot be {shown(what)}", f"give places from {-FURTHEST:g} to {FURTHEST:g}")
    value: Any = values[0] if number == 1 else tuple(values)
    return replace(layout, **{kind.replace("-", "_"): value})


def drawn(number: int, seed: int) -> list[str]:
    """`number` changes in turn, a goal, two starts, two speeds; the same seed gives the same ones."""
    generator = np.random.default_rng(seed)
    changes: list[str] = []
    for place in range(number):
        kind = KINDS[place % len(KINDS)]
        change = _draw(generator, kind)
        while not _is_a_crossing(changed(Layout(), change)):
            change = _draw(generator, kind)
        changes.append(change)
    return changes


def _draw(generator: np.random.Generator, kind: str) -> str:
    speed = kind.endswith("speed")
    values = generator.uniform(*SPEEDS, 1) if speed else generator.uniform(-ARENA, ARENA, 2)
    return f"{kind}={':'.join(f'{value:.{DIGITS}f}' for value in values)}"


def _is_a_crossing(layout: Layout) -> bool:
    """Whether the robot has a way to go, and both start apart."""
    gaps = [max(one[0] - other[1], other[0] - one[1]) for one, other in zip(*boxes(layout), strict=True)]
    others = (layout.robot_goal, layout.human_start)
    return max(gaps) > 0.0 and all(math.dist(layout.robot_start, other) >= APART for other in others)


def boxes(layout: Layout) -> tuple[Box, Box]:
    """Where the robot and the human start: the boxes of the crossing, moved."""
    return _moved(ROBOT_START, layout.robot_start), _moved(HUMAN_START, layout.human_start)


def _moved(box: Box, middle: Place) -> Box:
    (left, right), (low, high) = box
    wide, tall = 0.5 * (right - left), 0.5 * (high - low)
    return (middle[0] - wide, middle[0] + wide), (middle[1] - tall, middle[1] + tall)


def _numbers(kind: str, text: str, number: int) -> list[float]:
    try:
        values = [float(each) for each in text.split(":")]
    except ValueError:
        values = []
    if len(values) != number or not all(map(math.isfinite, values)):
        example = "0.05" if number == 1 else "0.3:0.5"
        raise InputError(FIELD, f"{kind}: '{shown(text)}' cannot be read", f"give {kind}={example}, say")
    return values
