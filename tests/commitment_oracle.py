"""A second opinion on the learner's best commitment, found by brute search instead of by the library.

A learner commits to a time-indexed stochastic policy; an expert answers it with the entropy-regularised soft best
response. The *ceiling* of a game is the largest return a commitment can earn, its *floor* the smallest. This module
finds both with NumPy and SciPy alone and shares no code with the package it is used to check.

How far to trust the search. It proves nothing; it was compared with a search from ten times as many starts, a miss
being a ceiling that the longer search raises by more than 0.05 % of the distance from floor to ceiling.

- One-shot games of size 3 to 5, 30 of each temperature 1, 0.4, 0.1 and 0.02: no miss, no rise above 0.00005 %. Nor
  did 300,000 sampled commitments, of which some 150 were polished, find anything better in these 120 games.
- Markov games of 4 states, 3x3 actions and 4 steps (``starts`` ten times as large, hence also ten times the rounds of
  improvement): no miss in 30 games at temperature 0.02 (largest rise 0.009 %), none in 15 at 0.1 and none in 6 at
  0.4 (no rise above 0.00005 %). At temperature 1 only an earlier, weaker version was compared: no miss in 6.
- A larger game is searched less surely: four seeds on the 12-state, 8-step Garnet of ``public_games`` disagreed by
  up to 0.03 % at temperatures 0.1 and 0.02, with half as many rounds again as now.

The floor only sets the scale and gets half the starts. A one-shot game takes 0.2 to 0.5 s on one core, such a Markov
game 3 to 5 s, the ten-step games of ``public_games`` 5 to 10 s and the Garnet roughly a minute.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog, minimize

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

MARGINS = (0.0, 1.0, 2.0, 4.0, 8.0)


@dataclass(frozen=True)
class FiniteGame:
    """A finite-horizon two-sided Markov game whose expert answers a committed learner policy softly.

    The learner earns ``own[s, a_l] + dependent[s, a_l, a_e]``, the expert ``expert[s, a_l, a_e]``. Masks name the
    allowed actions; a terminal state ends the episode and pays nothing.
    """

    name: str
    transitions: Floats  # (S, A_l, A_e, S)
    initial: Floats  # (S,)
    horizon: int
    own: Floats  # (S, A_l)
    dependent: Floats  # (S, A_l, A_e)
    expert: Floats  # (S, A_l, A_e)
    discount: float
    temperature: float
    learner_actions: Booleans | None = None  # (S, A_l)
    expert_actions: Booleans | None = None  # (S, A_e)
    terminal: Booleans | None = None  # (S,)


# --- The definition, spelled out -------------------------------------------------------------------------------------


def response(game: FiniteGame, learner_policy: Floats) -> Floats:
    """The expert's soft best response (T, S, A_e) to a learner policy (T, S, A_l).

    In a terminal state, where nothing depends on it, the answer is uniform over the allowed actions.
    """
    states, _, expert_actions = game.expert.shape
    answer = np.zeros((game.horizon, states, expert_actions))
    value = np.zeros(states)
    for t in reversed(range(game.horizon)):
        new_value = np.zeros(states)
        for s in range(states):
            allowed = np.ones(expert_actions, bool) if game.expert_actions is None else game.expert_actions[s]
            if game.terminal is not None and game.terminal[s]:
                allowed = allowed if allowed.any() else np.ones(expert_actions, bool)
                answer[t, s] = allowed / allowed.sum()
                continue
            pair = game.expert[s] + game.discount * game.transitions[s] @ value  # (A_l, A_e)
            scaled = np.where(allowed, learner_policy[t, s] @ pair / game.temperature, -np.inf)
            peak = scaled.max()
            weights = np.exp(scaled - peak)
            answer[t, s] = weights / weights.sum()
            new_value[s] = game.temperature * (peak + np.log(weights.sum()))
        value = new_value
    return answer


def learner_return(game: FiniteGame, learner_policy: Floats, discount: float | None = None) -> float:
    """The learner's exact expected return against the expert's response to its policy.

    ``discount`` replaces the discount of the learner's sum only; the expert still answers under the game's own.
    """
    factor = game.discount if discount is None else discount
    answer = response(game, learner_policy)
    alive = np.ones(len(game.initial)) if game.terminal is None else 1.0 - game.terminal
    payoff = game.own[:, :, None] + game.dependent
    here = game.initial * alive
    total = 0.0
    for t in range(game.horizon):
        joint = here[:, None, None] * learner_policy[t][:, :, None] * answer[t][:, None, :]
        total += factor**t * float((joint * payoff).sum())
        here = np.einsum("sab,sabn->n", joint, game.transitions) * alive
    return total


# --- The same return for a batch of policies, with its gradient ------------------------------------------------------


def _largest(values: Floats) -> Floats:
    """The maximum along the short last axis, several times faster than ``max`` on it."""
    peak = values[..., 0].copy()
    for column in range(1, values.shape[-1]):
        np.maximum(peak, values[..., column], out=peak)
    return peak[..., None]


def _total(values: Floats) -> Floats:
    """The sum along the short last axis, several times faster than ``sum`` on it."""
    total = values[..., 0].copy()
    for column in range(1, values.shape[-1]):
        total += values[..., column]
    return total[..., None]


class Batch:
    """Returns and gradients of many learner policies of one game at once, by a hand-written adjoint recursion."""

    def __init__(self, game: FiniteGame, sign: float = 1.0) -> None:
        self.game = game
        self.states, self.actions, self.answers = game.expert.shape
        self.horizon = game.horizon
        self.shape = (self.horizon, self.states, self.actions)
        alive = np.ones(self.states, bool) if game.terminal is None else ~np.asarray(game.terminal, bool)
        self.alive = alive
        here = alive.astype(float)[:, None, None]
        self.payoff = sign * here * (game.own[:, :, None] + game.dependent)
        self.expert = here * game.expert
        # Leaving a terminal state leads nowhere, and arriving in one is worth nothing.
        flow = game.transitions * here[..., None] * alive
        self.flow = np.ascontiguousarray(flow.reshape(-1, self.states))
        self.initial = game.initial * alive
        self.discount = game.discount
        allowed = np.ones((self.states, self.actions), bool)
        if game.learner_actions is not None:
            allowed = np.asarray(game.learner_actions, bool).copy()
            allowed[~allowed.any(1)] = True
        self.allowed = allowed
        answers = np.ones((self.states, self.answers), bool)
        if game.expert_actions is not None:
            answers = np.asarray(game.expert_actions, bool).copy()
            answers[~answers.any(1)] = True
        self.forbidden_answer = np.where(answers, 0.0, -np.inf)
        # Blocks (t, s) that can be reached and where the learner's choice makes a difference.
        tables = np.concatenate([self.payoff[..., None], self.expert[..., None], flow], -1)
        free = np.array([np.ptp(tables[s][allowed[s]], axis=0).max() > 0 for s in range(self.states)])
        reached, step = self.initial > 0, flow.max((1, 2)) > 0
        self.blocks = []
        for t in range(self.horizon):
            self.blocks += [(t, s) for s in range(self.states) if free[s] and reached[s]]
            reached = (reached[:, None] & step).any(0)

    def _expect(self, value: Floats) -> Floats:
        """Discounted expected next value of every state and joint action (B, S, A_l, A_e)."""
        count = len(value)
        return (self.discount * (value @ self.flow.T)).reshape(count, self.states, self.actions, self.answers)

    def _backward(self, policies: Floats, temperature: float) -> tuple[list[tuple[Floats, ...]], Floats]:
        count = len(policies)
        expert_value = np.zeros((count, self.states))
        learner_value = np.zeros((count, self.states))
        record: list[tuple[Floats, ...]] = []
        for t in reversed(range(self.horizon)):
            policy = policies[:, t, :, None, :]
            if t == self.horizon - 1:
                pair, gain = np.broadcast_to(self.expert, (count, *self.expert.shape)), self.payoff[None]
            else:
                pair = self.expert + self._expect(expert_value)
                gain = self.payoff + self._expect(learner_value)
            scaled = (policy @ pair)[:, :, 0] / temperature + self.forbidden_answer
            peak = _largest(scaled)
            weights = np.exp(scaled - peak)
            total = _total(weights)
            answer = weights / total
            merit = (policy @ gain)[:, :, 0]  # what each answer is worth to the learner
            expert_value = temperature * (peak + np.log(total))[..., 0] * self.alive
            learner_value = _total(merit * answer)[..., 0]
            record.append((pair, gain, answer, merit, learner_value))
        record.reverse()
        return record, learner_value @ self.initial

    def values(self, policies: Floats, temperature: float | None = None) -> Floats:
        """The return of each policy of a batch (B, T, S, A_l)."""
        tau = self.game.temperature if temperature is None else temperature
        pieces = np.array_split(policies, max(1, len(policies) // 2000))
        return np.concatenate([self._backward(piece, tau)[1] for piece in pieces])

    def gradients(self, policies: Floats, temperature: float | None = None) -> tuple[Floats, Floats]:
        """The return of each policy of a batch and its derivative by every probability."""
        tau = self.game.temperature if temperature is None else temperature
        count = len(policies)
        record, returns = self._backward(policies, tau)
        slopes = np.zeros_like(policies)
        visits = np.broadcast_to(self.initial, (count, self.states))  # adjoint of the learner's value
        pull = np.zeros((count, self.states))  # adjoint of the expert's value
        for t, (pair, gain, answer, merit, learner_value) in enumerate(record):
            visits_here = visits[..., None]
            reach = visits_here * answer
            push = pull[..., None] * answer + reach * (merit - learner_value[..., None]) / tau
            slopes[:, t] = (gain @ reach[..., None] + pair @ push[..., None])[..., 0]
            if t + 1 < self.horizon:
                policy = policies[:, t, :, :, None]
                spread = np.concatenate([policy * reach[:, :, None, :], policy * push[:, :, None, :]])
                moved = self.discount * (spread.reshape(2 * count, -1) @ self.flow)
                visits, pull = moved[:count], moved[count:]
        return returns, slopes

    # --- Moving in the space of policies ---

    def from_logits(self, logits: Floats) -> Floats:
        """Softmax over the allowed actions."""
        masked = np.where(self.allowed, logits, -np.inf)
        weights = np.exp(masked - _largest(masked))
        return weights / _total(weights)

    def tidy(self, policies: Floats) -> Floats:
        """Puts no weight on forbidden actions and makes every row sum to one."""
        kept = np.where(self.allowed, np.maximum(policies, 0.0), 0.0)
        total = kept.sum(-1, keepdims=True)
        uniform = self.allowed / self.allowed.sum(-1, keepdims=True)
        return np.where(total > 1e-12, kept / np.maximum(total, 1e-300), uniform)

    def ascend(self, policies: Floats, temperatures: Floats, rate: float = 0.2) -> Floats:
        """Batched Adam on the logits, one step per temperature with a shrinking step size."""
        logits = np.log(np.maximum(policies, 1e-4))
        first = np.zeros_like(logits)
        second = np.zeros_like(logits)
        steps = len(temperatures)
        for step, temperature in enumerate(temperatures):
            current = self.from_logits(logits)
            _, slopes = self.gradients(current, temperature)
            slopes = current * (slopes - _total(current * slopes))
            first = 0.8 * first + 0.2 * slopes
            second = 0.95 * second + 0.05 * slopes**2
            size = rate * (1.0 - step / steps) ** 1.5 + 0.002
            unbias = np.sqrt(1 - 0.95 ** (step + 1)) / (1 - 0.8 ** (step + 1))
            logits = logits + size * unbias * first / (np.sqrt(second) + 1e-12)
            logits = np.clip(logits - _largest(logits), -16.0, 0.0)
        return self.from_logits(logits)

    def polish(self, policy: Floats, iterations: int = 150) -> Floats:
        """L-BFGS-B on unnormalised weights in [0, 1], so that it can reach and leave the boundary."""
        start = self.tidy(policy)
        mask = np.broadcast_to(self.allowed, self.shape)

        def loss(flat: Floats) -> tuple[float, Floats]:
            weights = np.zeros(self.shape)
            weights[mask] = flat
            total = weights.sum(-1, keepdims=True) + 1e-12
            current = weights / total
            returns, slopes = self.gradients(current[None])
            slopes = (slopes[0] - (current * slopes[0]).sum(-1, keepdims=True)) / total
            return -float(returns[0]), -slopes[mask]

        options = {"maxiter": iterations, "ftol": 1e-12, "gtol": 1e-9}
        result = minimize(
            loss, start[mask], jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * int(mask.sum()), options=options
        )
        weights = np.zeros(self.shape)
        weights[mask] = result.x
        better = self.tidy(weights)
        both = np.stack([start, better])
        return both[int(np.argmax(self.values(both)))]


def _random_policies(batch: Batch, count: int, rng: np.random.Generator) -> Floats:
    """Diverse random policies: nearly uniform, spread out, sparse and pure."""
    if count <= 0:
        return np.zeros((0, *batch.shape))
    concentration = rng.choice([0.1, 0.3, 1.0, 5.0], size=(count, 1, 1, 1))
    draws = rng.gamma(np.broadcast_to(concentration, (count, *batch.shape))) + 1e-12
    steady = rng.random(count) < 0.25  # some starts play the same way at every step
    draws[steady] = draws[steady][:, :1]
    return batch.tidy(draws)


def _grid(actions: int, rng: np.random.Generator) -> Floats:
    """Points spread over the simplex of one decision: a grid where that is small, random points otherwise."""
    if actions <= 4:
        parts = {1: 1, 2: 40, 3: 10, 4: 6}[actions]
        points = [p for p in itertools.product(range(parts + 1), repeat=actions) if sum(p) == parts]
        return np.array(points, float) / parts
    corners = np.eye(actions)
    edges = np.array([0.5 * (corners[i] + corners[j]) for i in range(actions) for j in range(i)])
    return np.concatenate([corners, edges, rng.dirichlet(np.full(actions, 0.7), size=60)])


def _top_distinct(policies: Floats, values: Floats, count: int, gap: float = 1e-3) -> Floats:
    """The best few policies that differ from each other."""
    chosen: list[Floats] = []
    for index in np.argsort(-values):
        if len(chosen) == count:
            break
        if all(np.abs(policies[index] - other).max() > gap for other in chosen):
            chosen.append(policies[index])
    return np.array(chosen)


# --- One-shot games --------------------------------------------------------------------------------------------------


def _stackelberg(batch: Batch, margins: Sequence[float]) -> Floats:
    """Strong Stackelberg commitments, one linear program per answer and margin (Conitzer and Sandholm 2006)."""
    found = []
    payoff, expert = batch.payoff[0], batch.expert[0]
    answers = [j for j in range(batch.answers) if np.isfinite(batch.forbidden_answer[0, j])]
    bounds = [(0.0, 1.0 if ok else 0.0) for ok in batch.allowed[0]]
    for wanted, margin in itertools.product(answers, margins):
        rivals = [j for j in answers if j != wanted]
        limits = (expert[:, rivals] - expert[:, [wanted]]).T if rivals else None
        slack = np.full(len(rivals), -margin * batch.game.temperature) if rivals else None
        ones = np.ones((1, batch.actions))
        result = linprog(-payoff[:, wanted], A_ub=limits, b_ub=slack, A_eq=ones, b_eq=[1.0], bounds=bounds)
        if result.status == 0:
            found.append(result.x)
    return np.array(found).reshape(-1, 1, 1, batch.actions)


def _search_one_shot(batch: Batch, rng: np.random.Generator, starts: int, extra: Floats) -> tuple[float, Floats]:
    """The best commitment of a one-shot game: a broad sample, linear programs, then local ascent."""
    actions = batch.actions
    corners = np.eye(actions)
    mixtures = [
        w * corners[i] + (1 - w) * corners[j]
        for i in range(actions)
        for j in range(i)
        for w in np.linspace(0.02, 0.98, 49)
    ]
    sample = [corners, np.full((1, actions), 1.0 / actions), np.array(mixtures).reshape(-1, actions)]
    sample += [rng.dirichlet(np.full(actions, c), size=10 * starts) for c in (0.2, 0.5, 1.0)]
    if actions == 2:
        left = np.linspace(0.0, 1.0, 4001)
        sample.append(np.stack([left, 1 - left], 1))
    points = batch.tidy(np.concatenate(sample)[:, None, None, :])
    programs = batch.tidy(_stackelberg(batch, MARGINS))
    pool = np.concatenate([points, programs, extra])
    values = batch.values(pool)
    best = [_top_distinct(pool, values, 8)]
    # Ascend from the best of the sample and from a random part of it, with and without annealing.
    leaders = np.concatenate(
        [pool[np.argsort(-values)[: starts // 2]], programs, extra, pool[rng.choice(len(pool), starts // 2)]]
    )
    tau = batch.game.temperature
    for hot in sorted({max(tau, 0.5), tau}):
        climbed = batch.ascend(leaders, _schedule(hot, tau, 100))
        best.append(_top_distinct(climbed, batch.values(climbed), 4, 1e-2))
    finalists = np.concatenate([*best, extra])
    polished = np.array([batch.polish(p, 100) for p in finalists])
    everything = np.concatenate([polished, pool])
    values = batch.values(everything)
    index = int(np.argmax(values))
    return float(values[index]), everything[index]


# --- Markov games ----------------------------------------------------------------------------------------------------


def _schedule(hot: float, cold: float, steps: int) -> Floats:
    """Temperatures that fall geometrically during the first 60 % of the steps and then stay."""
    falling = int(0.6 * steps)
    return np.concatenate([np.geomspace(max(hot, cold), cold, falling), np.full(steps - falling, cold)])


def _block_moves(batch: Batch, policy: Floats, width: int, rng: np.random.Generator) -> Floats:
    """Promising copies of a policy that play differently at one time and state, or at several."""
    grid = _grid(batch.actions, rng)
    size = len(grid)
    moved = np.repeat(policy[None], len(batch.blocks) * size, 0)
    for k, (t, s) in enumerate(batch.blocks):
        moved[k * size : (k + 1) * size, t, s] = grid
    moved = batch.tidy(moved)
    merit = batch.values(moved)
    # The best change of every block for each answer of the expert it can bring about.
    record, _ = batch._backward(policy[None], batch.game.temperature)
    leaders = []
    for k, (t, s) in enumerate(batch.blocks):
        rows = slice(k * size, (k + 1) * size)
        answers = (moved[rows, t, s] @ record[t][0][0, s] + batch.forbidden_answer[s]).argmax(1)
        scores = merit[rows]
        for answer in np.unique(answers):
            leaders.append(k * size + int(np.argmax(np.where(answers == answer, scores, -np.inf))))
    ranked = np.array(leaders)[np.argsort(-merit[leaders])]
    picked = np.concatenate([ranked[: width // 2], rng.permutation(ranked[width // 2 : 5 * width])[: width // 2]])
    # The best change of every block, several of them at once.
    winners = merit.reshape(-1, size).argmax(1) + size * np.arange(len(batch.blocks))
    gains = merit[winners] - batch.values(policy[None])[0]
    joint = np.repeat(policy[None], 8, 0)
    for copy, bar in zip(joint, np.linspace(1.0, -0.2, 8), strict=True):
        for (t, s), winner, gain in zip(batch.blocks, winners, gains, strict=True):
            if gain > bar * gains.max() and rng.random() < 0.7:
                copy[t, s] = moved[winner, t, s]
    return np.concatenate([moved[picked], joint])


def _shaken(batch: Batch, policy: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Copies of a policy with a few blocks replaced by random ones."""
    fresh = _random_policies(batch, count, rng)
    blocks = max(1, len(batch.blocks))
    rate = rng.choice([1.5, 3.0, 6.0, 0.3 * blocks], size=(count, 1, 1, 1)) / blocks
    swap = rng.random((count, *batch.shape[:2], 1)) < rate
    return np.where(swap, fresh, policy)


def _crossed(batch: Batch, policy: Floats, others: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Copies of a policy that take some states, some times or some blocks from another policy."""
    donors = others[rng.integers(len(others), size=count)]
    rate = rng.choice([0.15, 0.5], size=(count, 1, 1, 1))
    by_block = rng.random((count, *batch.shape[:2], 1)) < rate
    by_state = rng.random((count, 1, batch.states, 1)) < rate
    late = np.arange(batch.horizon)[:, None, None] >= rng.integers(1, batch.horizon + 1, size=(count, 1, 1, 1))
    kind = rng.integers(4, size=(count, 1, 1, 1))
    return np.where(np.select([kind == 0, kind == 1, kind == 2], [by_block, by_state, late], ~late), donors, policy)


def _coordinates(batch: Batch, policy: Floats, width: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """The policy after block moves until none helps, and the promising moves that were left."""
    value = batch.values(policy[None])[0]
    moves = policy[None]
    for _ in range(12):
        moves = _block_moves(batch, policy, width, rng)
        values = batch.values(moves)
        index = int(np.argmax(values))
        if values[index] < value + 1e-5:
            break
        policy, value = moves[index], values[index]
    return policy, moves


def _search_markov(batch: Batch, rng: np.random.Generator, starts: int, extra: Floats) -> tuple[float, Floats]:
    """The best commitment of a Markov game: annealed ascent from many starts, then block moves and shakes."""
    tau = batch.game.temperature

    def scout(count: int, given: Floats) -> Floats:
        """Policies climbed to from random starts, most of them with annealing."""
        begin = np.concatenate([_random_policies(batch, count, rng), given])
        cold = batch.ascend(begin[: len(begin) // 3], np.full(150, tau))
        return np.concatenate([cold, batch.ascend(begin[len(begin) // 3 :], _schedule(max(tau, 0.5), tau, 150))])

    size = max(6, starts // 32)
    uniform = batch.tidy(np.ones((1, *batch.shape)))
    extra = np.concatenate([extra, *(batch.polish(p)[None] for p in extra)])
    pool = np.concatenate([scout(starts, np.concatenate([uniform, extra])), extra])
    elite = np.array([batch.polish(p) for p in _top_distinct(pool, batch.values(pool), size, 5e-2)])
    values = batch.values(elite)
    rounds = int(max(6.0, starts / 16) * max(1.0, len(batch.blocks) / 48)) if batch.blocks else 0
    width = 48
    idle = np.zeros(len(elite), int)
    for _ in range(rounds):
        if (idle >= 3).all():  # keep the best two and look elsewhere
            pool = scout(2 * width, elite[:0])
            fresh = _top_distinct(pool, batch.values(pool), size - 2, 5e-2)
            elite = np.concatenate([elite[np.argsort(-values)[:2]], fresh])
            values, idle = batch.values(elite), np.zeros(len(elite), int)
        index = int(np.argmax(np.where(idle < 3, values, -np.inf)))  # the best that has not been tried in vain
        policy, moves = _coordinates(batch, elite[index], width, rng)
        tried = [policy[None], moves, _shaken(batch, policy, width // 2, rng)]
        tried += [_crossed(batch, policy, elite, width // 2, rng)]
        climbed = batch.ascend(np.concatenate(tried), np.full(60, tau), 0.15)
        gains = batch.values(climbed)
        challenger = batch.polish(climbed[int(np.argmax(gains))])
        value = float(batch.values(challenger[None])[0])
        if value <= values[index] + 1e-7:
            idle[index] += 1
        elif np.abs(np.delete(values, index) - value).min(initial=np.inf) < 1e-7:  # met another of the elite
            values[index], idle[index] = -np.inf, 3
        else:
            elite[index], values[index], idle[index] = challenger, value, 0
    pool = np.concatenate([elite, extra, pool])
    values = batch.values(pool)
    index = int(np.argmax(values))
    return float(values[index]), pool[index]


def extremes(
    game: FiniteGame, seed: int = 0, starts: int = 192, policies: Sequence[Floats] = ()
) -> tuple[float, Floats, float]:
    """The ceiling of a game, a policy that reaches it, and the floor, by global search.

    ``policies`` are further starting points: each is evaluated and improved, so the ceiling is never below any.
    """
    one_shot = game.horizon == 1 and len(game.initial) == 1
    search: Callable[..., tuple[float, Floats]] = _search_one_shot if one_shot else _search_markov
    rng = np.random.default_rng(seed)
    upper, lower = Batch(game), Batch(game, sign=-1.0)
    extra = np.array([np.asarray(p, float).reshape(upper.shape) for p in policies]).reshape(-1, *upper.shape)
    ceiling, best = search(upper, rng, starts, extra)
    floor, _ = search(lower, rng, max(16, starts // 2), extra)
    return ceiling, best, -floor


# --- Games -----------------------------------------------------------------------------------------------------------


def one_shot(name: str, dependent: Floats, expert: Floats, temperature: float, own: Floats | None = None) -> FiniteGame:
    """A game of one state and one step, from payoff matrices with the learner's actions as rows."""
    dependent, expert = np.asarray(dependent, float), np.asarray(expert, float)
    rows, columns = dependent.shape
    return FiniteGame(
        name=name,
        transitions=np.ones((1, rows, columns, 1)),
        initial=np.ones(1),
        horizon=1,
        own=np.zeros((1, rows)) if own is None else np.asarray(own, float).reshape(1, rows),
        dependent=dependent[None],
        expert=expert[None],
        discount=1.0,
        temperature=temperature,
    )


def random_one_shot(size: int, temperature: float, seed: int) -> FiniteGame:
    """A random square one-shot game."""
    rng = np.random.default_rng(seed)
    expert = rng.uniform(-1, 1, (size, size))
    dependent = rng.uniform(-1, 1, (size, size))
    own = rng.uniform(-0.3, 0.3, size)
    return one_shot(f"random {size}x{size} game, seed {seed}", dependent, expert, temperature, own)


def random_markov(
    states: int, learner_actions: int, expert_actions: int, horizon: int, temperature: float, seed: int
) -> FiniteGame:
    """A random Markov game with dense transitions and a discount of 0.95."""
    rng = np.random.default_rng(seed)
    joint = (states, learner_actions, expert_actions)
    return FiniteGame(
        name=f"random Markov game {states}s {learner_actions}x{expert_actions} T={horizon}, seed {seed}",
        transitions=rng.dirichlet(np.ones(states), size=joint),
        initial=rng.dirichlet(np.ones(states)),
        horizon=horizon,
        own=rng.uniform(-0.3, 0.3, joint[:2]),
        dependent=rng.uniform(-1, 1, joint),
        expert=rng.uniform(-1, 1, joint),
        discount=0.95,
        temperature=temperature,
    )


def textbook(temperature: float) -> FiniteGame:
    """The textbook game in which committing beats every equilibrium (after Conitzer and Sandholm 2006).

    The best commitment earns 2.974, 3.267 and 3.437 at temperatures 0.3, 0.1 and 0.02.
    """
    return one_shot("textbook", np.array([[2.0, 4.0], [1.0, 3.0]]), np.eye(2), temperature)
