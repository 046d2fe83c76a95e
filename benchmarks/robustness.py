"""Experts that are not what the learner takes them for: what is lost, and whether the check names it.

Every run is a random Markov game (Dirichlet transitions) whose expert's reward is linear in random features, lived
through as by default. The expert answers as `EXPERTS` says; these are written in NumPy here and share no code with the
package. A row a violation:

* `pearson`: correlation of the learned reward with the true one, over (s, a_l, a_e), after the part that depends on
  (s, a_l) alone was taken out (mean over runs, and the least);
* `regret`: how much less the policy earns against this very expert than the best policy found by looking at the truth
  (a search from many starts with the expert as it is), in per cent of what lies between that and random play;
* `named`: in how many runs `result.check()` named each model.

    python benchmarks/robustness.py --runs 20
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import scipy.optimize

import gsiirl
from gsiirl.games import TabularGame
from gsiirl.types import Sides, Trajectories

STATES, LEARNER, EXPERT, HORIZON, DISCOUNT, FEATURES = 4, 2, 3, 4, 0.95, 6
TEMPERATURE = 0.5


@dataclass
class World:
    """A random game with its rewards, as arrays."""

    transitions: np.ndarray
    expert: np.ndarray
    """φ (S, A_l, A_e, features)."""
    weights: np.ndarray
    learner: np.ndarray
    """r_l (S, A_l, A_e)."""

    @classmethod
    def random(cls, seed: int) -> "World":
        source = np.random.default_rng(seed)
        joint = (STATES, LEARNER, EXPERT)
        return cls(
            source.dirichlet(np.ones(STATES), joint),
            source.normal(size=(*joint, FEATURES)),
            source.normal(size=FEATURES),
            source.normal(size=joint),
        )

    @property
    def reward(self) -> np.ndarray:
        """The true r_e (S, A_l, A_e)."""
        return self.expert @ self.weights


Answer = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""π_e (T, S, A_e) from π_l (T, S, A_l) and the policy that was played before."""


def values(
    world: World, policy: np.ndarray, temperature: float, hard: bool = False, ahead: int = HORIZON
) -> np.ndarray:
    """Q_e (T, S, A_e): soft, or of choosing best later; looking `ahead` so many steps."""
    found = np.zeros((HORIZON, STATES, EXPERT))
    # Who looks to the end computes all times in one pass.
    for start in range(HORIZON) if ahead < HORIZON else [0]:
        after = np.zeros(STATES)
        for time in range(min(start + ahead, HORIZON) - 1, start - 1, -1):
            onward = world.reward + DISCOUNT * world.transitions @ after
            action_values = np.einsum("sa,sae->se", policy[time], onward)
            most = action_values.max(axis=1)
            soft = most + temperature * np.log(np.exp((action_values - most[:, None]) / temperature).sum(axis=1))
            after = most if hard else soft
            if time == start or ahead >= HORIZON:
                found[time] = action_values
    return found


def softmax(scores: np.ndarray) -> np.ndarray:
    raised = np.exp(scores - scores.max(axis=-1, keepdims=True))
    return raised / raised.sum(axis=-1, keepdims=True)


def soft(world: World, temperature: float = TEMPERATURE, ahead: int = HORIZON) -> Answer:
    return lambda policy, before: softmax(values(world, policy, temperature, ahead=ahead) / temperature)


def random_at_times(world: World, chance: float) -> Answer:
    answer = soft(world)
    return lambda policy, before: (1 - chance) * answer(policy, before) + chance / EXPERT


def boltzmann(world: World) -> Answer:
    return lambda policy, before: softmax(values(world, policy, TEMPERATURE, hard=True) / TEMPERATURE)


def late(world: World) -> Answer:
    answer = soft(world)
    return lambda policy, before: answer(before, before)


def best_and_second(world: World) -> Answer:
    def answer(policy: np.ndarray, before: np.ndarray) -> np.ndarray:
        order = np.argsort(-values(world, policy, TEMPERATURE, hard=True), axis=-1)
        chances = np.zeros(order.shape)
        np.put_along_axis(chances, order[..., :1], 0.6, axis=-1)
        np.put_along_axis(chances, order[..., 1:2], 0.4, axis=-1)
        return chances

    return answer


EXPERTS: dict[str, Callable[[World], Answer]] = {
    "none": soft,
    "temperature twice": lambda world: soft(world, 2 * TEMPERATURE),
    "temperature half": lambda world: soft(world, TEMPERATURE / 2),
    "temperature unknown": soft,
    "best 60 %, second best 40 %": best_and_second,
    "random in 5 %": lambda world: random_at_times(world, 0.05),
    "random in 20 %": lambda world: random_at_times(world, 0.2),
    "looks 1 step ahead": lambda world: soft(world, ahead=1),
    "looks 2 steps ahead": lambda world: soft(world, ahead=2),
    "answers the policy before": late,
    "Boltzmann in Q*": boltzmann,
    "novice (temperature 2)": lambda world: soft(world, 2.0),
    "experienced (temperature 0.3)": lambda world: soft(world, 0.3),
    "expert (temperature 0.1)": lambda world: soft(world, 0.1),
    "a feature is missing": soft,
    "learner reads values at visits only": soft,
    "values misread by 0.2": soft,
    "values misread by 0.5": soft,
}
MISREAD = {"values misread by 0.2": 0.2, "values misread by 0.5": 0.5}
"""Standard deviation of the error with which a value of r_ld is read."""


class Expert:
    """Plays episodes by an answer; remembers the policy it met before."""

    def __init__(self, world: World, answer: Answer) -> None:
        self.world, self.answer, self.before = world, answer, None

    def demonstrate(self, learner_policy: Any, number: int, key: Any) -> Trajectories:
        played = np.asarray(learner_policy)
        source = np.random.default_rng(np.asarray(jax.random.key_data(key)).ravel().tolist())
        chances = self.answer(played, played if self.before is None else self.before)
        self.before = played
        states, learner, expert = (np.zeros((number, HORIZON), int) for _ in range(3))
        here = source.integers(STATES, size=number)

        def drawn(table: np.ndarray) -> np.ndarray:
            return (table.cumsum(axis=1) < source.random((number, 1))).sum(axis=1).clip(max=table.shape[1] - 1)

        for time in range(HORIZON):
            states[:, time] = here
            learner[:, time], expert[:, time] = drawn(played[time][here]), drawn(chances[time][here])
            here = drawn(self.world.transitions[here, learner[:, time], expert[:, time]])
        arrays = map(jnp.asarray, (states, learner, expert, np.ones((number, HORIZON), bool)))
        states, learner, expert, mask = arrays
        return Trajectories(states, Sides(learner, expert), mask)


def earned(world: World, policy: np.ndarray, answer: Answer) -> float:
    """f(π_l) against an expert who has had time to answer this policy."""
    chances = answer(policy, policy)
    after = np.zeros(STATES)
    for time in range(HORIZON - 1, -1, -1):
        onward = world.learner + DISCOUNT * world.transitions @ after
        after = np.einsum("sa,se,sae->s", policy[time], chances[time], onward)
    return float(after.mean())


def best(world: World, answer: Answer, starts: list[np.ndarray], seed: int) -> float:
    """The most that a search over policies finds, from `starts` and random ones."""
    source = np.random.default_rng(seed)
    size = HORIZON * STATES

    def lost(logits: np.ndarray) -> float:
        return -earned(world, softmax(logits.reshape(HORIZON, STATES, LEARNER)), answer)

    begun = [np.log(np.maximum(each, 1e-3)).ravel() for each in starts]
    begun += [source.normal(0, 2, size * LEARNER) for _ in range(4)]
    found = [-scipy.optimize.minimize(lost, each, method="L-BFGS-B", options={"maxiter": 60}).fun for each in begun]
    pure = [earned(world, each, answer) for each in starts]
    return max(*found, *pure)


def one(world: World, violation: str, seed: int, iterations: int, trajectories: int) -> dict[str, Any]:
    """One run."""
    answer = EXPERTS[violation](world)
    # Every value of r_ld is read wrong by a number of its own, once and for all; r_ld has a deviation of 1.
    read = world.learner + MISREAD.get(violation, 0.0) * np.random.default_rng(seed + 10_000).normal(
        size=world.learner.shape
    )
    features = world.expert[..., :-1] if violation == "a feature is missing" else world.expert
    game = TabularGame.from_arrays(world.transitions, initial=np.full(STATES, 1 / STATES), horizon=HORIZON)
    problem = gsiirl.Problem(
        game,
        own_reward=np.zeros((STATES, LEARNER)),
        dependent_value=read,
        discount=DISCOUNT,
        temperature=None if violation == "temperature unknown" else TEMPERATURE,
        expert_features={f"feature {place}": features[..., place] for place in range(features.shape[-1])},
    )
    feedback: Any = "visited" if violation == "learner reads values at visits only" else "model"
    result = gsiirl.GSIIRL(problem, feedback=feedback).fit(
        Expert(world, answer), iterations=iterations, trajectories=trajectories, seed=seed, progress=False
    )
    told = result.check()
    # What depends on (s, a_l) alone moves no choice in the last step.
    true, learned = (each - each.mean(axis=2, keepdims=True) for each in (world.reward, result.expert_reward.table))
    uniform = np.full_like(result.policy, 1 / LEARNER)
    ceiling = best(world, answer, [result.policy, uniform], seed)
    floor = earned(world, uniform, answer)
    return {
        "pearson": float(np.corrcoef(true.ravel(), learned.ravel())[0, 1]),
        "regret": 100 * (ceiling - earned(world, result.policy, answer)) / max(ceiling - floor, 1e-9),
        "named": told.named or "nothing",
        "p": told.p_value,
    }


def main() -> None:
    """A line of JSON a violation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--iterations", type=int, default=20)
    parser.add_argument("--trajectories", type=int, default=100)
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    for violation in EXPERTS:
        if asked.only not in violation:
            continue
        rows = []
        for seed in range(asked.runs):
            rows.append(one(World.random(seed), violation, seed, asked.iterations, asked.trajectories))
            print(violation, seed, rows[-1], file=sys.stderr, flush=True)
        pearson, regret = (np.array([row[name] for row in rows]) for name in ("pearson", "regret"))
        table = {
            "violation": violation,
            "pearson": [round(float(pearson.mean()), 4), round(float(pearson.min()), 4)],
            "regret": [
                round(float(np.median(regret)), 2),
                round(float(regret.mean()), 2),
                round(float(regret.max()), 2),
            ],
            "named": dict(Counter(row["named"] for row in rows).most_common()),
            "p": round(float(np.median([row["p"] for row in rows])), 3),
        }
        print(json.dumps(table), flush=True)


if __name__ == "__main__":
    main()
