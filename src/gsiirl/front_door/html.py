"""A result as a notebook shows it."""

from html import escape
from typing import Any

import numpy as np

from gsiirl.front_door.learned_reward import LearnedReward, interval_of
from gsiirl.runs.learned import LEVEL

SHOWN = 8
"""Weights that are listed: the largest."""


def html_of(result: Any) -> str:
    """What the result is of, and a table of the expert's largest weights, with intervals where there is a posterior."""
    reward, rounds = result.expert_reward, f"{len(result.history)} iterations of {result.trajectories} episodes"
    facts = [("game", repr(result.problem)), ("learned from", f"{rounds}, seed {result.seed}")]
    names, weights = list(reward.names), reward.weights
    order = np.argsort(-np.abs(weights), kind="stable")[:SHOWN]
    heads = ["what the expert weighs", "weight"]
    rows = [[names[place], f"{weights[place]:.3g}"] for place in order]
    if isinstance(reward, LearnedReward) and len(reward.draws):
        (low, high), known = interval_of(reward.draws, LEVEL), reward.determined
        facts.append(("weights determined", f"{int(known.sum())} of {len(known)}"))
        heads.append(f"{100 * LEVEL:.0f} % interval")
        for row, place in zip(rows, order, strict=True):
            row.append(f"{low[place]:.3g} to {high[place]:.3g}{'' if known[place] else ', not determined'}")
    lines = "".join(f"<li>{escape(name)}: {escape(value)}</li>" for name, value in facts)
    head = "".join(f'<th scope="col">{escape(each)}</th>' for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    left = len(weights) - len(order)
    more = f"<p>and {left} smaller ones</p>" if left else ""
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f"<div><strong>{type(result).__name__} of GSIIRL</strong><ul>{lines}</ul>{table}{more}</div>"
