"""Learned weights are compared by their direction."""

from pathlib import Path

import numpy as np
import pytest
from report.synthetic import group_of
from report.synthetic_plane import DECEPTION, FEATURES

from gsiirl.report.deception.weights_figure import draw_weights


def test_learned_weights_are_compared_by_direction(plane_runs: dict[str, list[Path]]) -> None:
    group = group_of(plane_runs["deception"])
    figure = draw_weights(group, {name: 5.0 * weight for name, weight in DECEPTION["truth"]["expert_reward"].items()})
    assert figure is not None
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == FEATURES
    for container, label in zip(axes.containers[1::2], ("MA-IRL", "GSIIRL", "GSIIRL, paper's preset"), strict=True):
        weights = group.runs[label].weights("expert_reward")
        assert weights is not None
        unit = weights / np.linalg.norm(weights, axis=1, keepdims=True)
        np.testing.assert_allclose([bar.get_width() for bar in container], unit.mean(axis=0))
    true = next(each for each in axes.collections if each.get_label() == "true")
    assert np.asarray(true.get_paths()[0].vertices)[0, 0] == pytest.approx(-1.0)
