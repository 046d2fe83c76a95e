"""The same stage games solved one by one in NumPy: what the batched solver is compared with."""

import numpy as np

from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.payoff import MatchingPayoff
from gsiirl.types import Sides


def log_softmax(values: np.ndarray) -> np.ndarray:
    shifted = values - values.max()
    return shifted - np.log(np.exp(shifted).sum())


def solve_stage(
    learner: np.ndarray, expert: np.ndarray, temperature: float, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Log-policies of the stage game with matrices Q_l, Q_e (A_l, A_e): damped Newton on dense matrices.

    Along a few temperatures down to the target, each from the solution before: a plain, careful program of its kind.
    """
    actions_l, actions_e = learner.shape
    u, v = np.full(actions_l, -np.log(actions_l)), np.full(actions_e, -np.log(actions_e))
    spread = max(np.ptp(learner), np.ptp(expert), temperature)
    for tau in np.geomspace(spread, temperature, max(2, int(np.ceil(np.log2(spread / temperature))) + 1)):
        for _ in range(50):
            p, q = np.exp(u), np.exp(v)
            x, y = learner @ q / tau, expert.T @ p / tau
            residual = np.concatenate([u - log_softmax(x), v - log_softmax(y)])
            size = np.abs(residual).max()
            if size <= tolerance:
                break
            best_l, best_e = np.exp(log_softmax(x)), np.exp(log_softmax(y))
            to_l = (learner - best_l @ learner) * q / tau
            to_e = (expert.T - best_e @ expert.T) * p / tau
            jacobian = np.block([[np.eye(actions_l), -to_l], [-to_e, np.eye(actions_e)]])
            step = np.linalg.solve(jacobian, -residual)
            u_new, v_new = u, v
            for length in 0.5 ** np.arange(14):
                u_new, v_new = u + length * step[:actions_l], v + length * step[actions_l:]
                p, q = np.exp(u_new), np.exp(v_new)
                moved = [u_new - log_softmax(learner @ q / tau), v_new - log_softmax(expert.T @ p / tau)]
                if np.abs(np.concatenate(moved)).max() < size:
                    break
            u, v = u_new, v_new
    return u, v


def solve(
    game: AttackGraph, rewards: Sides[MatchingPayoff], discount: float, temperature: float, tolerance: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Policies (T, S, A) of both sides by backward induction, and the largest residual."""
    learner_reward, expert_reward = np.asarray(rewards.learner.dense()), np.asarray(rewards.expert.dense())
    states, edges = game.success.shape
    success, successors = np.asarray(game.success), np.asarray(game.successors)
    values_l, values_e = np.zeros(states), np.zeros(states)
    policies = np.zeros((game.horizon, states, edges)), np.zeros((game.horizon, states, edges))
    worst = 0.0
    for time in reversed(range(game.horizon)):
        next_l, next_e = np.zeros(states), np.zeros(states)
        for state in range(states):
            onward = []
            for values in (values_l, values_e):
                gain = success[state] * (values[successors[state]] - values[state])
                onward.append(values[state] + gain[None, :] * (1.0 - np.eye(edges)))
            q_l = learner_reward[state] + discount * onward[0]
            q_e = expert_reward[state] + discount * onward[1]
            u, v = solve_stage(q_l, q_e, temperature, tolerance)
            x, y = q_l @ np.exp(v) / temperature, q_e.T @ np.exp(u) / temperature
            worst = max(worst, np.abs(u - log_softmax(x)).max(), np.abs(v - log_softmax(y)).max())
            policies[0][time, state], policies[1][time, state] = np.exp(u), np.exp(v)
            next_l[state] = temperature * (x.max() + np.log(np.exp(x - x.max()).sum()))
            next_e[state] = temperature * (y.max() + np.log(np.exp(y - y.max()).sum()))
        values_l, values_e = next_l, next_e
    return *policies, worst
