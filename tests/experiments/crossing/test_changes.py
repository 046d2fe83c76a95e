"""Changes of the crossing are what their texts say, and drawn ones can be given again."""

import math
from dataclasses import replace

import pytest

from gsiirl.errors import InputError
from gsiirl.experiments.crossing.changes import KINDS, Box, Layout, _is_a_crossing, boxes, changed, drawn
from gsiirl.games.crossing import HUMAN_START, ROBOT_START


@pytest.mark.parametrize(
    ("change", "field", "value"),
    [
        ("robot-goal=0.3:-0.25", "robot_goal", (0.3, -0.25)),
        ("robot-start=-0.1:0.2", "robot_start", (-0.1, 0.2)),
        ("human-start=1e-1:0", "human_start", (0.1, 0.0)),
        ("robot-speed=0.05", "robot_speed", 0.05),
        ("human-speed=0.2", "human_speed", 0.2),
    ],
)
def test_one_thing_is_moved_and_the_rest_stays(change: str, field: str, value: object):
    assert changed(Layout(), change) == replace(Layout(), **{field: value})
    assert changed(Layout(), change) != Layout()


def test_boxes_keep_their_size_around_another_middle():
    before, after = boxes(Layout()), boxes(Layout(robot_start=(0.3, 0.05), human_start=(-0.45, 1.0)))
    assert flat(before) == pytest.approx(flat((ROBOT_START, HUMAN_START)))
    assert flat(after) == pytest.approx([0.05, 0.55, 0.0, 0.1, -0.5, -0.4, 0.75, 1.25])


def flat(two: tuple[Box, Box]) -> list[float]:
    return [float(number) for box in two for axis in box for number in axis]


def test_drawn_changes_come_in_turn_and_can_be_given_again():
    changes = drawn(11, seed=3)
    assert [each.partition("=")[0] for each in changes] == [*KINDS, *KINDS, KINDS[0]]
    assert changes == drawn(11, seed=3)
    assert changes != drawn(11, seed=4)
    assert len({changed(Layout(), each) for each in changes}) == 11


@pytest.mark.parametrize(
    ("layout", "holds"),
    [
        (Layout(), True),
        (Layout(robot_goal=(0.0, -0.1)), False),
        (Layout(human_start=(0.0, -0.1)), False),
        # 0.42 apart, but the boxes touch: the robot's is 0.25 to either side, the human's 0.25 up and down.
        (Layout(human_start=(0.29, -0.15)), False),
        (Layout(human_start=(0.31, -0.15)), True),
    ],
)
def test_a_crossing_has_a_way_to_go_and_room_between_the_starts(layout: Layout, holds: bool):
    assert _is_a_crossing(layout) is holds


@pytest.mark.parametrize("seed", range(10))
def test_drawn_places_leave_a_way_to_go_and_nobody_starts_in_a_collision(seed: int):
    for change in drawn(10, seed):
        layout = changed(Layout(), change)
        robot, human = boxes(layout)
        assert math.dist(layout.robot_start, layout.robot_goal) > 0.399
        # Nearest points of both boxes: a gap along an axis, or apart along the diagonal.
        gaps = [max(0.0, low[0] - high[1], high[0] - low[1]) for low, high in zip(robot, human, strict=True)]
        assert math.hypot(*gaps) > 0.0
        assert min(layout.robot_speed, layout.human_speed) >= 0.05
        assert max(layout.robot_speed, layout.human_speed) <= 0.15


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("human-goal=0:0", "'human-goal=0:0' is no change of the crossing; give robot-goal=X:Y"),
        ("robot-goal=1", "robot-goal: '1' cannot be read; give robot-goal=0.3:0.5, say"),
        ("robot-goal=1:2:3", "robot-goal: '1:2:3' cannot be read"),
        ("robot-goal=1:nan", "robot-goal: '1:nan' cannot be read"),
        ("human-speed=fast", "human-speed: 'fast' cannot be read; give human-speed=0.05, say"),
        ("human-speed=0", "human-speed cannot be 0; give a number above 0, at most 1"),
        ("robot-speed=1.5", "robot-speed cannot be 1.5; give a number above 0, at most 1"),
        ("human-start=0:11", "human-start cannot be 0:11; give places from -10 to 10"),
        ("", "'' is no change of the crossing"),
    ],
)
def test_what_is_no_change_is_refused_in_one_line(change: str, line: str):
    with pytest.raises(InputError) as refused:
        changed(Layout(), change)
    assert str(refused.value).startswith(f"--change: {line}")
