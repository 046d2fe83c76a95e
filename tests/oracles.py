"""Slow reference implementations for dense tabular two-player finite-horizon Markov games.

Plain numpy and scipy, written from the formulas and sharing nothing with the package, so that agreement has meaning.

Array orders, everywhere: transition[s, a_l, a_e, s'], rewards[s, a_l, a_e], initial[s], policies[t, s, a] and
occupancies[t, s, a_l, a_e]; l is the learner, e the expert, t = 0..T-1. Rewards and policies of one side stand alone;
pairs are (learner, expert).
"""

from collections.abc import Callable, Iterator
from itertools import product
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import log_softmax, logsumexp, softmax, xlogy

Array = NDArray[np.float64]


class Game(NamedTuple):
    """A dense tabular game; `learner_reward` is all that the learner receives, both of its parts."""

    transition: Array
    learner_reward: Array
    expert_reward: Array
    initial: Array


def random_game(seed: int, states: int, learner_actions: int, expert_actions: int) -> Game:
    """Draw a game: Dirichlet(1) transitions and start, rewards uniform in [-1, 1]."""
    random = np.random.default_rng(seed)
    shape = (states, learner_actions, expert_actions)
    return Game(
        transition=random.dirichlet(np.ones(states), size=shape),
        learner_reward=random.uniform(-1.0, 1.0, size=shape),
        expert_reward=random.uniform(-1.0, 1.0, size=shape),
        initial=random.dirichlet(np.ones(states)),
    )


def random_policy(seed: int, horizon: int, states: int, actions: int) -> Array:
    """Draw a policy[t, s, a] with Dirichlet(1) rows."""
    return np.random.default_rng(seed).dirichlet(np.ones(actions), size=(horizon, states))


def uniform_policy(horizon: int, states: int, actions: int) -> Array:
    """Give the policy[t, s, a] = 1 / A."""
    return np.full((horizon, states, actions), 1.0 / actions)


# --- one policy pair -------------------------------------------------------------------------------------------------


class Path(NamedTuple):
    """One path s_0, a_0, ..., s_{T-1}, a_{T-1} (no final state) and its probability; steps are (s, a_l, a_e)."""

    probability: float
    steps: tuple[tuple[int, int, int], ...]


def paths(transition: Array, initial: Array, learner_policy: Array, expert_policy: Array) -> Iterator[Path]:
    """Enumerate every path of (state, learner action, expert action); there are (S A_l A_e)^T of them.

    P(path) = P0(s_0) prod_t pi_l(a_l|s_t,t) pi_e(a_e|s_t,t) prod_{t<T-1} P(s_{t+1}|s_t,a_t)
    """
    horizon = learner_policy.shape[0]
    states, learner_actions, expert_actions, _ = transition.shape
    cells = list(product(range(states), range(learner_actions), range(expert_actions)))
    for steps in product(cells, repeat=horizon):
        probability = float(initial[steps[0][0]])
        for time, (state, learner_action, expert_action) in enumerate(steps):
            probability *= learner_policy[time, state, learner_action] * expert_policy[time, state, expert_action]
            if time + 1 < horizon:
                probability *= transition[state, learner_action, expert_action, steps[time + 1][0]]
        yield Path(float(probability), steps)


def path_value(
    transition: Array, initial: Array, reward: Array, learner_policy: Array, expert_policy: Array, discount: float
) -> float:
    """Return sum over all paths of P(path) sum_t gamma^t r(s_t, a_t)."""
    total = 0.0
    for path in paths(transition, initial, learner_policy, expert_policy):
        total += path.probability * sum(discount**time * reward[step] for time, step in enumerate(path.steps))
    return float(total)


def policy_value(
    transition: Array, initial: Array, reward: Array, learner_policy: Array, expert_policy: Array, discount: float
) -> float:
    """Return sum_s P0(s) V_0(s), with V_T = 0 and

    V_t(s) = sum_{a_l, a_e} pi_l(a_l|s,t) pi_e(a_e|s,t) (r(s,a) + gamma sum_s' P(s'|s,a) V_{t+1}(s'))
    """
    value = np.zeros(transition.shape[0])
    for time in reversed(range(learner_policy.shape[0])):
        action_value = reward + discount * transition @ value
        value = np.einsum("sl,se,sle->s", learner_policy[time], expert_policy[time], action_value)
    return float(initial @ value)


def occupancy(transition: Array, initial: Array, learner_policy: Array, expert_policy: Array) -> Array:
    """Return d[t, s, a_l, a_e], the (undiscounted) probability of the state and joint action at each time.

    P_0 = P0;  d_t(s,a) = P_t(s) pi_l(a_l|s,t) pi_e(a_e|s,t);  P_{t+1}(s') = sum_{s,a} d_t(s,a) P(s'|s,a)
    """
    states, learner_actions, expert_actions, _ = transition.shape
    horizon = learner_policy.shape[0]
    result = np.zeros((horizon, states, learner_actions, expert_actions))
    marginal = initial
    for time in range(horizon):
        result[time] = np.einsum("s,sl,se->sle", marginal, learner_policy[time], expert_policy[time])
        marginal = np.einsum("sle,slen->n", result[time], transition)
    return result


def path_occupancy(transition: Array, initial: Array, learner_policy: Array, expert_policy: Array) -> Array:
    """Return d[t, s, a_l, a_e] by adding up the probabilities of all paths through each cell."""
    result = np.zeros((learner_policy.shape[0], *transition.shape[:3]))
    for path in paths(transition, initial, learner_policy, expert_policy):
        for time, step in enumerate(path.steps):
            result[time][step] += path.probability
    return result


def feature_expectation(occupancies: Array, features: Array, discount: float) -> Array:
    """Return mu[m] = sum_t gamma^t sum_{s,a} d_t(s,a) phi(s,a), for features[s, a_l, a_e, m]."""
    return sum(
        (discount**time * np.einsum("sle,slem->m", cells, features) for time, cells in enumerate(occupancies)),
        start=np.zeros(features.shape[-1]),
    )


# --- the logit equilibrium of one stage game -------------------------------------------------------------------------


class LogitBranch(NamedTuple):
    """The principal branch of a bimatrix game from lambda = 0 to the first crossing of a target.

    `points[k] = (ln p, ln q, lambda)` are the accepted points in order; `turning_rationalities` are the lambda at which
    the branch turned round on the way, in order (maxima and minima alternate); `crossing` is the point at the target.
    """

    points: Array
    turning_rationalities: tuple[float, ...]
    crossing: Array


Height = Callable[[Array, Array], float]


class StageSolution(NamedTuple):
    """A logit equilibrium; `folded`: the branch turned on the way to it.

    residual = max over both sides of |ln pi - log_softmax(E Q / tau)|
    """

    learner: Array
    expert: Array
    folded: bool
    residual: float


def logit_residual(
    learner_payoff: Array, expert_payoff: Array, learner: Array, expert: Array, rationality: float
) -> float:
    """Return max over both sides of |ln pi_i - log_softmax(lambda E_{pi_-i} u_i)|, payoffs[a_l, a_e]."""
    with np.errstate(divide="ignore"):
        log_learner, log_expert = np.log(learner), np.log(expert)
    learner_error = log_learner - log_softmax(rationality * learner_payoff @ expert)
    expert_error = log_expert - log_softmax(rationality * expert_payoff.T @ learner)
    return float(max(np.abs(learner_error).max(), np.abs(expert_error).max()))


def _logit_system(point: Array, learner_payoff: Array, expert_payoff: Array) -> tuple[Array, Array]:
    """Return F and its Jacobian by (ln p, ln q, lambda).

    F_l = ln p - log_softmax(lambda A q),  F_e = ln q - log_softmax(lambda B^T p)
    d log_softmax(x) = (I - 1 softmax(x)^T) dx
    """
    count, other = learner_payoff.shape
    learner, expert, rationality = np.exp(point[:count]), np.exp(point[count:-1]), point[-1]
    learner_utility, expert_utility = learner_payoff @ expert, expert_payoff.T @ learner
    value = np.concatenate(
        [
            point[:count] - log_softmax(rationality * learner_utility),
            point[count:-1] - log_softmax(rationality * expert_utility),
        ]
    )
    learner_centre = np.eye(count) - softmax(rationality * learner_utility)[None, :]
    expert_centre = np.eye(other) - softmax(rationality * expert_utility)[None, :]
    jacobian = np.zeros((count + other, count + other + 1))
    jacobian[:, :-1] = np.eye(count + other)
    jacobian[:count, count:-1] = -rationality * learner_centre @ (learner_payoff * expert[None, :])
    jacobian[count:, :count] = -rationality * expert_centre @ (expert_payoff.T * learner[None, :])
    jacobian[:count, -1] = -learner_centre @ learner_utility
    jacobian[count:, -1] = -expert_centre @ expert_utility
    return value, jacobian


def trace_logit_branch(
    learner_payoff: Array, expert_payoff: Array, rationality: float, largest_step: float = 0.25
) -> LogitBranch:
    """Follow the solutions of F(ln p, ln q, lambda) = 0 from (uniform, uniform, 0) until lambda first reaches a target.

    Pseudo-arclength continuation: predict along the unit tangent, correct by Newton in the hyperplane across it. A step
    is accepted only if the correction is small, the tangent hardly turns and det [dF; tangent] keeps its sign; the last
    test tells the branch from a neighbour that runs parallel beyond a near-bifurcation. Where lambda turns round within
    a step the turning point is located, so a target just below it is not stepped over. Payoffs[a_l, a_e] are centred
    for each opponent's action and scaled to 1, which changes nothing but the meaning of lambda.

    Raises ArithmeticError at a true bifurcation (exactly symmetric games), where there is no such thing as the branch.
    """
    count, other = learner_payoff.shape
    learner_payoff = learner_payoff - learner_payoff.mean(axis=0, keepdims=True)
    expert_payoff = expert_payoff - expert_payoff.mean(axis=1, keepdims=True)
    scale = max(float(np.abs(learner_payoff).max()), float(np.abs(expert_payoff).max()))
    start = np.concatenate([np.full(count, -np.log(count)), np.full(other, -np.log(other)), [0.0]])
    if scale == 0.0:
        return LogitBranch(start[None], (), np.append(start[:-1], rationality))
    learner_payoff, expert_payoff, target = learner_payoff / scale, expert_payoff / scale, rationality * scale

    def tangent_at(point: Array, forward: Array) -> tuple[Array, float]:
        _, jacobian = _logit_system(point, learner_payoff, expert_payoff)
        tangent = np.linalg.solve(np.vstack([jacobian, forward]), np.eye(len(point))[-1])
        tangent /= np.linalg.norm(tangent)
        return tangent, float(np.linalg.slogdet(np.vstack([jacobian, tangent]))[0])

    def correct(predicted: Array, normal: Array) -> Array | None:
        """Newton in the hyperplane through `predicted` across `normal`; None if it does not settle."""
        point, best = predicted, np.inf
        for _ in range(12):
            value, jacobian = _logit_system(point, learner_payoff, expert_payoff)
            equations = np.append(value, normal @ (point - predicted))
            error = float(np.abs(equations).max())
            if error < 1e-11 * (1.0 + abs(point[-1])) and error >= 0.5 * best:
                return point
            if not error < 1e3:
                return None
            best = min(best, error)
            point = point - np.linalg.solve(np.vstack([jacobian, normal]), equations)
        return point if best < 1e-11 * (1.0 + abs(point[-1])) else None

    def advance(point: Array, tangent: Array, step: float) -> tuple[Array, Array, float] | None:
        corrected = correct(point + step * tangent, tangent)
        if corrected is None:
            return None
        return corrected, *tangent_at(corrected, tangent)

    def root(point: Array, tangent: Array, longest: float, height: Height) -> tuple[float, Array]:
        """Find the step in [0, longest] at which height(point, tangent) crosses zero, and the point there."""

        def at(step: float) -> tuple[Array, Array]:
            result = advance(point, tangent, step)
            if result is None:
                raise ArithmeticError("the corrector failed inside an accepted step")
            return result[0], result[1]

        step = float(brentq(lambda length: height(*at(length)), 0.0, longest, xtol=1e-14, rtol=1e-14))  # pyright: ignore[reportArgumentType]
        return step, at(step)[0]

    point, (tangent, _) = start, tangent_at(start, np.eye(len(start))[-1])
    points, turns, step = [point], [], 0.01
    last = np.eye(len(start))[-1]

    def finish(length: float) -> LogitBranch:
        _, crossing = root(point, tangent, length, lambda here, _: float(here[-1] - target))
        crossing[-1] = target
        polished = correct(crossing, last)
        crossing = crossing if polished is None else polished
        unscale = np.append(np.ones(count + other), 1.0 / scale)
        return LogitBranch(np.array(points) * unscale, tuple(turn / scale for turn in turns), crossing * unscale)

    while len(points) < 200_000:
        if step < 1e-9:
            raise ArithmeticError(f"no unique branch beyond lambda = {point[-1] / scale:.6g}: a bifurcation")
        result = advance(point, tangent, step)
        if result is None:
            step /= 2.0
            continue
        following, turned, orientation = result
        drift = float(np.linalg.norm(following - point - step * tangent)) / step
        alignment = float(turned @ tangent)
        if orientation <= 0 or drift > 0.1 or alignment < 0.99:
            step /= 2.0
            continue
        if turned[-1] * tangent[-1] < 0.0:
            length, turn = root(point, tangent, step, lambda _, direction: float(direction[-1]))
            if turn[-1] >= target:
                return finish(length)
            turns.append(float(turn[-1]))
        elif following[-1] >= target:
            return finish(step)
        if alignment > 0.999 and drift < 0.03:
            step = min(1.5 * step, largest_step)
        point, tangent = following, turned
        points.append(point)
    raise ArithmeticError("the branch did not reach the target within 200,000 points")


def stage_logit(learner_payoff: Array, expert_payoff: Array, temperature: float) -> StageSolution:
    """Solve one stage game on its principal branch, first crossing of lambda = 1/tau; payoffs[a_l, a_e].

    p = softmax(A q / tau),  q = softmax(B^T p / tau)
    """
    branch = trace_logit_branch(learner_payoff, expert_payoff, 1.0 / temperature)
    count = learner_payoff.shape[0]
    learner, expert = softmax(branch.crossing[:count]), softmax(branch.crossing[count:-1])
    residual = logit_residual(learner_payoff, expert_payoff, learner, expert, 1.0 / temperature)
    return StageSolution(learner, expert, len(branch.turning_rationalities) > 0, residual)


# --- games over time -------------------------------------------------------------------------------------------------


class LogitSolution(NamedTuple):
    """A Markov logit equilibrium: policies[t, s, a], values[t, s] for t = 0..T, folded[t, s] and residuals[t, s]."""

    learner_policy: Array
    expert_policy: Array
    learner_value: Array
    expert_value: Array
    folded: NDArray[np.bool_]
    residual: Array


def markov_logit(game: Game, horizon: int, discount: float, temperature: float) -> LogitSolution:
    """Solve the entropy-regularised Markov logit equilibrium backward in t, with V_{i,T} = 0:

    Q_{i,t}(s,a) = r_i(s,a) + gamma sum_s' P(s'|s,a) V_{i,t+1}(s')
    (pi_{l,t}(.|s), pi_{e,t}(.|s)) = the logit equilibrium of the stage game Q_{.,t}(s), principal branch
    V_{i,t}(s) = tau logsumexp_{a_i}(E_{pi_-i} Q_{i,t}(s,.) / tau)
    """
    states, learner_actions, expert_actions, _ = game.transition.shape
    learner_policy = np.zeros((horizon, states, learner_actions))
    expert_policy = np.zeros((horizon, states, expert_actions))
    learner_value, expert_value = np.zeros((horizon + 1, states)), np.zeros((horizon + 1, states))
    folded, residual = np.zeros((horizon, states), dtype=bool), np.zeros((horizon, states))
    for time in reversed(range(horizon)):
        for state in range(states):
            onward = discount * game.transition[state]
            learner_payoff = game.learner_reward[state] + onward @ learner_value[time + 1]
            expert_payoff = game.expert_reward[state] + onward @ expert_value[time + 1]
            stage = stage_logit(learner_payoff, expert_payoff, temperature)
            learner_policy[time, state], expert_policy[time, state] = stage.learner, stage.expert
            folded[time, state], residual[time, state] = stage.folded, stage.residual
            learner_value[time, state] = temperature * logsumexp(learner_payoff @ stage.expert / temperature)
            expert_value[time, state] = temperature * logsumexp(stage.learner @ expert_payoff / temperature)
    return LogitSolution(learner_policy, expert_policy, learner_value, expert_value, folded, residual)


class Response(NamedTuple):
    """One side's answer to the other side's fixed policy: policy[t, s, a] and value[t, s] for t = 0..T."""

    policy: Array
    value: Array


def _expected_over_learner(learner_policy: Array, action_value: Array) -> Array:
    """Return q[s, a_e] = sum_{a_l} pi_l(a_l|s) Q(s, a_l, a_e)."""
    return np.einsum("sl,sle->se", learner_policy, action_value)


def soft_best_response(
    transition: Array, expert_reward: Array, learner_policy: Array, discount: float, temperature: float
) -> Response:
    """Return the expert's entropy-regularised best response to a fixed learner policy, with V_T = 0:

    q_t(s,a_e) = sum_{a_l} pi_l(a_l|s,t) (r_e(s,a) + gamma sum_s' P(s'|s,a) V_{t+1}(s'))
    pi_e(.|s,t) = softmax(q_t(s,.) / tau),  V_t(s) = tau logsumexp_{a_e}(q_t(s,a_e) / tau)
    """
    horizon, states, _ = learner_policy.shape
    policy, value = np.zeros((horizon, states, transition.shape[2])), np.zeros((horizon + 1, states))
    for time in reversed(range(horizon)):
        expected = _expected_over_learner(learner_policy[time], expert_reward + discount * transition @ value[time + 1])
        policy[time] = softmax(expected / temperature, axis=1)
        value[time] = temperature * logsumexp(expected / temperature, axis=1)
    return Response(policy, value)


def best_response(transition: Array, expert_reward: Array, learner_policy: Array, discount: float) -> Response:
    """Return the expert's best response to a fixed learner policy: `soft_best_response` with max for tau logsumexp."""
    horizon, states, _ = learner_policy.shape
    policy, value = np.zeros((horizon, states, transition.shape[2])), np.zeros((horizon + 1, states))
    for time in reversed(range(horizon)):
        expected = _expected_over_learner(learner_policy[time], expert_reward + discount * transition @ value[time + 1])
        policy[time, np.arange(states), expected.argmax(axis=1)] = 1.0
        value[time] = expected.max(axis=1)
    return Response(policy, value)


def swapped(game: Game) -> Game:
    """Exchange the two sides: the learner becomes the expert and the other way round."""
    return Game(
        np.swapaxes(game.transition, 1, 2),
        np.swapaxes(game.expert_reward, 1, 2),
        np.swapaxes(game.learner_reward, 1, 2),
        game.initial,
    )


def nash_gap(game: Game, learner_policy: Array, expert_policy: Array, discount: float) -> float:
    """Return NashConv = sum over both sides of (best-response value - own value), discounted, from P0."""
    gap = 0.0
    for sides, opponent, own in (
        (game, learner_policy, expert_policy),
        (swapped(game), expert_policy, learner_policy),
    ):
        best = sides.initial @ best_response(sides.transition, sides.expert_reward, opponent, discount).value[0]
        gap += best - policy_value(sides.transition, sides.initial, sides.expert_reward, opponent, own, discount)
    return float(gap)


def soft_policy_value(
    transition: Array,
    initial: Array,
    expert_reward: Array,
    learner_policy: Array,
    expert_policy: Array,
    discount: float,
    temperature: float,
) -> float:
    """Return the expert's J_e(pi) = E^pi[sum_t gamma^t (r_e(s_t,a_t) + tau H(pi_e(.|s_t,t)))]."""
    total = policy_value(transition, initial, expert_reward, learner_policy, expert_policy, discount)
    for time, cells in enumerate(occupancy(transition, initial, learner_policy, expert_policy)):
        entropy = -xlogy(expert_policy[time], expert_policy[time]).sum(axis=1)
        total += discount**time * temperature * float(cells.sum(axis=(1, 2)) @ entropy)
    return total


def soft_nash_gap(
    game: Game, learner_policy: Array, expert_policy: Array, discount: float, temperature: float
) -> float:
    """Return the entropy-regularised NashConv, from P0: sum over sides i of max_{pi_i'} J_i(pi_i', pi_-i) - J_i(pi).

    J_i(pi) = E^pi[sum_t gamma^t (r_i(s_t,a_t) + tau H(pi_i(.|s_t,t)))], each side with its own entropy only
    """
    gap = 0.0
    for sides, opponent, own in (
        (game, learner_policy, expert_policy),
        (swapped(game), expert_policy, learner_policy),
    ):
        response = soft_best_response(sides.transition, sides.expert_reward, opponent, discount, temperature)
        gap += sides.initial @ response.value[0] - soft_policy_value(
            sides.transition, sides.initial, sides.expert_reward, opponent, own, discount, temperature
        )
    return float(gap)


# --- the lower level -------------------------------------------------------------------------------------------------


class Demonstrations(NamedTuple):
    """Exact demonstrations: occupancies[t, s, a_l, a_e] of the true pair, and the learner policy played in them."""

    occupancies: Array
    learner_policy: Array


def negative_log_likelihood(
    parameters: Array,
    features: Array,
    transition: Array,
    demonstrations: Demonstrations,
    discount: float,
    temperature: float,
    regularisation: float,
) -> float:
    """Return L(theta) for r_e = phi . theta, features[s, a_l, a_e, m]; pi_e is the soft response to the played policy.

    L(theta) = -sum_t gamma^t sum_{s,a} d_t(s,a) ln pi_e^theta(a_e|s,t) + (lambda/2) |theta|^2
    """
    response = soft_best_response(
        transition, features @ parameters, demonstrations.learner_policy, discount, temperature
    )
    total = 0.0
    for time, cells in enumerate(demonstrations.occupancies):
        total -= discount**time * float((cells.sum(axis=1) * np.log(response.policy[time])).sum())
    return total + 0.5 * regularisation * float(parameters @ parameters)


def lemma_1_gradient(
    parameters: Array,
    features: Array,
    transition: Array,
    initial: Array,
    demonstrations: Demonstrations,
    discount: float,
    temperature: float,
    regularisation: float,
) -> Array:
    """Return (mu_e(pi^theta) - mu_hat_e) / tau + lambda theta, with pi^theta = (played pi_l, soft response to it)."""
    response = soft_best_response(
        transition, features @ parameters, demonstrations.learner_policy, discount, temperature
    )
    modelled = occupancy(transition, initial, demonstrations.learner_policy, response.policy)
    difference = feature_expectation(modelled, features, discount) - feature_expectation(
        demonstrations.occupancies, features, discount
    )
    return difference / temperature + regularisation * parameters


def return_gradient_by_differences(function: Callable[[Array], float], parameters: Array, step: float = 1e-5) -> Array:
    """Return the gradient (f(theta + h e_k) - f(theta - h e_k)) / 2h, coordinate by coordinate; error O(h^2)."""
    gradient = np.zeros_like(parameters, dtype=np.float64)
    for index in np.ndindex(parameters.shape):
        shift = np.zeros_like(gradient)
        shift[index] = step
        gradient[index] = (function(parameters + shift) - function(parameters - shift)) / (2.0 * step)
    return gradient


# --- comparing rewards -----------------------------------------------------------------------------------------------


def epic_canonical(reward: Array, discount: float) -> Array:
    """Return the canonically shaped reward, reward[s, a, s'], with S, S' and A independent and uniform:

    C(R)(s,a,s') = R(s,a,s') + E[gamma R(s',A,S') - R(s,A,S') - gamma R(S,A,S')]
    """
    states = reward.shape[0]
    onward = np.array([reward[state].mean() for state in range(states)])
    result = np.empty_like(reward)
    for state, action, following in np.ndindex(reward.shape):
        shaping = discount * onward[following] - onward[state] - discount * onward.mean()
        result[state, action, following] = reward[state, action, following] + shaping
    return result


def epic_distance(first: Array, second: Array, discount: float, states: NDArray[np.intp] | None = None) -> float:
    """Return sqrt((1 - rho) / 2), rho = Pearson of the canonical rewards over uniform (s, a, s'); rewards[s, a, s'].

    `states` restricts s and s' (coverage and expectations alike), for instance to the reachable ones; None is all.
    Raises ValueError if a canonical reward is constant: a reward equivalent to zero has no distance.
    """
    if states is not None:
        part = np.ix_(states, np.arange(first.shape[1]), states)
        first, second = first[part], second[part]
    canonical = [epic_canonical(reward, discount).ravel() for reward in (first, second)]
    if any(np.ptp(values) <= 1e-12 * (1.0 + np.abs(values).max()) for values in canonical):
        raise ValueError("a canonical reward is constant")
    centred = [values - values.mean() for values in canonical]
    correlation = float(centred[0] @ centred[1] / np.sqrt((centred[0] @ centred[0]) * (centred[1] @ centred[1])))
    return float(np.sqrt(max(0.0, (1.0 - correlation) / 2.0)))


# --- the attack graph ------------------------------------------------------------------------------------------------


class Network(Protocol):
    """What `attack_graph_dense` reads of an attack network; edge_source -1 is an entry edge."""

    @property
    def value(self) -> Array: ...
    @property
    def criticality(self) -> Array: ...
    @property
    def edge_source(self) -> NDArray[np.intp]: ...
    @property
    def edge_target(self) -> NDArray[np.intp]: ...
    @property
    def success_probability(self) -> Array: ...
    @property
    def attack_cost(self) -> Array: ...
    @property
    def block_cost(self) -> Array: ...
    @property
    def footholds(self) -> tuple[int, ...]: ...
    @property
    def variant(self) -> str: ...


class AttackGraph(NamedTuple):
    """The dense game over all 2^N states (bit j of s: node j is compromised); rewards are expected, r(s, a_l, a_e)."""

    transition: Array
    own_reward: Array
    dependent_reward: Array
    expert_reward: Array
    initial: Array

    def game(self) -> Game:
        """Return the game with r_l = r_li + r_ld."""
        return Game(self.transition, self.own_reward + self.dependent_reward, self.expert_reward, self.initial)


def attack_graph_dense(network: Network, no_op: bool = False) -> AttackGraph:
    """Build the attack graph; a_l is the edge blocked, a_e the edge i -> j attacked (the learner defends).

    It succeeds with the edge's probability if i is compromised (or it is an entry edge), j is clean and a_l != a_e.
    r_e = P(success) value[j] - attack_cost[a_e],  r_li = -block_cost[a_l],
    r_ld = -P(success) criticality[j] (general_sum) or -r_e (zero_sum).
    `no_op` gives both sides one more, last action that does and costs nothing.
    """
    states, edges = 2 ** len(network.value), len(network.edge_source)
    actions = edges + 1 if no_op else edges
    transition = np.zeros((states, actions, actions, states))
    own_reward, dependent_reward, expert_reward = (np.zeros((states, actions, actions)) for _ in range(3))
    for state in range(states):
        for blocked in range(actions):
            for attacked in range(actions):
                cell = (state, blocked, attacked)
                if blocked < edges:
                    own_reward[cell] = -network.block_cost[blocked]
                if attacked == edges:
                    transition[state, blocked, attacked, state] = 1.0
                    continue
                source, target = int(network.edge_source[attacked]), int(network.edge_target[attacked])
                source_held = source == -1 or (state >> source) & 1 == 1
                target_clean = (state >> target) & 1 == 0
                possible = source_held and target_clean and blocked != attacked
                success = float(network.success_probability[attacked]) if possible else 0.0
                transition[state, blocked, attacked, state | (1 << target)] += success
                transition[state, blocked, attacked, state] += 1.0 - success
                expert_reward[cell] = success * network.value[target] - network.attack_cost[attacked]
                if network.variant == "zero_sum":
                    dependent_reward[cell] = -expert_reward[cell]
                else:
                    dependent_reward[cell] = -success * network.criticality[target]
    initial = np.zeros(states)
    initial[sum(1 << node for node in network.footholds)] = 1.0
    return AttackGraph(transition, own_reward, dependent_reward, expert_reward, initial)
