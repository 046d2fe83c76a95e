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
        # Single weights have it beside them.
        facts += [("not determined", each) for each in reward.undetermined[int((~known).sum()) :][:SHOWN]]
        heads.append(f"{100 * LEVEL:.0f} % interval")
        for row, place in zip(rows, order, strict=True):
            row.append(f"{low[place]:.3g} to {high[place]:.3g}{'' if known[place] else ', not determined'}")
    left = len(weights) - len(order)
    table = _table(heads, rows) + (f"<p>and {left} smaller ones</p>" if left else "")
    return _framed(f"{type(result).__name__} of GSIIRL", facts, table)


def html_of_several(results: Any) -> str:
    """What the results of several seeds are of, and a table of the expert's largest weights: mean and spread."""
    first, mean, spread = results[0], results.mean, results.spread
    seeds = ", ".join(str(each.seed) for each in results)
    facts = [("game", repr(first.problem)), ("seeds", seeds), ("one of them", "results[0], with its plot and its save")]
    order = sorted(mean, key=lambda name: -abs(mean[name]))[:SHOWN]
    rows = [[name, f"{mean[name]:.3g}", f"{spread[name]:.2g}"] for name in order]
    table = _table(["what the expert weighs", "mean over seeds", "standard deviation"], rows)
    left = len(mean) - len(order)
    return _framed(
        f"{type(results).__name__} of GSIIRL", facts, table + (f"<p>and {left} smaller ones</p>" if left else "")
    )


def _framed(title: str, facts: list[tuple[str, str]], table: str) -> str:
    lines = "".join(f"<li>{escape(name)}: {escape(value)}</li>" for name, value in facts)
    return f"<div><strong>{title}</strong><ul>{lines}</ul>{table}</div>"


def _table(heads: list[str], rows: list[list[str]]) -> str:
    head = "".join(f'<th scope="col">{escape(each)}</th>' for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
