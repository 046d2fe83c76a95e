"""The oracles against one another, against closed forms and against recorded pygambit solutions."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import expit, softmax

from tests.oracles import (
    Demonstrations,
    Game,
    attack_graph_dense,
    best_response,
    epic_canonical,
    epic_distance,
    feature_expectation,
    lemma_1_gradient,
    logit_residual,
    markov_logit,
    nash_gap,
    negative_log_likelihood,
    occupancy,
    path_occupancy,
    path_value,
    paths,
    policy_value,
    random_game,
    random_policy,
    return_gradient_by_differences,
    soft_best_response,
    soft_nash_gap,
    soft_policy_value,
    stage_logit,
    swapped,
    trace_logit_branch,
    uniform_policy,
)

HORIZON, DISCOUNT, TEMPERATURE = 3, 0.9, 0.3
Pair = tuple[np.ndarray, np.ndarray]
RECORDED = np.load(Path(__file__).parent / "data" / "pygambit_logit.npz")


@pytest.fixture(scope="module")
def game() -> Game:
    return random_game(0, states=2, learner_actions=2, expert_actions=3)


@pytest.fixture(scope="module")
def pair() -> Pair:
    return random_policy(1, HORIZON, 2, 2), random_policy(2, HORIZON, 2, 3)


# --- one policy pair


def test_path_probabilities_sum_to_one(game: Game, pair: Pair):
    assert sum(path.probability for path in paths(game.transition, game.initial, *pair)) == pytest.approx(
        1.0, abs=1e-12
    )


@pytest.mark.parametrize("discount", [1.0, 0.9, 0.0])
def test_recursion_and_path_enumeration_give_the_same_value(game: Game, pair: Pair, discount: float):
    enumerated = path_value(game.transition, game.initial, game.expert_reward, *pair, discount)
    assert policy_value(game.transition, game.initial, game.expert_reward, *pair, discount) == pytest.approx(
        enumerated, abs=1e-12
    )


def test_recursion_and_path_enumeration_give_the_same_occupancy(game: Game, pair: Pair):
    forward = occupancy(game.transition, game.initial, *pair)
    np.testing.assert_allclose(forward, path_occupancy(game.transition, game.initial, *pair), atol=1e-14)
    np.testing.assert_allclose(forward.sum(axis=(1, 2, 3)), 1.0, atol=1e-14)


def test_value_is_the_discounted_reward_under_the_occupancy(game: Game, pair: Pair):
    occupancies = occupancy(game.transition, game.initial, *pair)
    (value,) = feature_expectation(occupancies, game.learner_reward[..., None], DISCOUNT)
    assert value == pytest.approx(
        policy_value(game.transition, game.initial, game.learner_reward, *pair, DISCOUNT), abs=1e-12
    )


# --- the logit equilibrium of one stage game


def test_matching_pennies_is_solved_by_the_uniform_pair():
    payoff = np.array([[1.0, -1.0], [-1.0, 1.0]])
    solution = stage_logit(payoff, -payoff, temperature=0.02)
    np.testing.assert_allclose(solution.learner, 0.5, atol=1e-12)
    np.testing.assert_allclose(solution.expert, 0.5, atol=1e-12)
    assert not solution.folded


def test_separate_decisions_are_solved_by_softmax():
    learner_utility, expert_utility = np.array([1.0, 0.2, -3.0]), np.array([0.0, 5.0])
    learner_payoff = np.repeat(learner_utility[:, None], 2, axis=1)
    expert_payoff = np.repeat(expert_utility[None, :], 3, axis=0)
    solution = stage_logit(learner_payoff, expert_payoff, temperature=0.1)
    np.testing.assert_allclose(solution.learner, softmax(learner_utility / 0.1), rtol=1e-12)
    np.testing.assert_allclose(solution.expert, softmax(expert_utility / 0.1), rtol=1e-12)


def test_constant_payoffs_are_solved_by_the_uniform_pair():
    solution = stage_logit(np.full((3, 2), 7.0), np.full((3, 2), -1.0), temperature=0.1)
    np.testing.assert_array_equal(solution.learner, np.full(3, 1 / 3))
    assert solution.residual <= 1e-12


@pytest.mark.parametrize("seed", range(8))
def test_two_by_two_games_agree_with_a_scan_for_roots(seed):
    """A 2x2 logit equilibrium is a root of one equation in p alone."""
    random = np.random.default_rng(seed)
    learner_payoff, expert_payoff = random.uniform(-1, 1, (2, 2, 2))
    rationality = 4.0

    def gap(p: float) -> float:
        q = expit(rationality * (np.array([p, 1 - p]) @ (expert_payoff[:, 0] - expert_payoff[:, 1])))
        return p - expit(rationality * ((learner_payoff[0] - learner_payoff[1]) @ np.array([q, 1 - q])))

    grid = np.linspace(0.0, 1.0, 20_001)
    signs = np.sign([gap(p) for p in grid])
    brackets = np.nonzero(signs[:-1] != signs[1:])[0]
    roots = [float(brentq(gap, grid[index], grid[index + 1], xtol=1e-15)) for index in brackets]  # pyright: ignore[reportArgumentType]
    solution = stage_logit(learner_payoff, expert_payoff, 1.0 / rationality)
    assert min(abs(root - solution.learner[0]) for root in roots) < 1e-12


@pytest.mark.parametrize("rationality", [0.5, 1.5])
def test_fixed_point_iteration_agrees_where_it_contracts(rationality):
    random = np.random.default_rng(3)
    learner_payoff, expert_payoff = random.random((2, 6, 4))
    expert = np.full(4, 0.25)
    learner = np.full(6, 1 / 6)
    for _ in range(200):
        learner = softmax(rationality * learner_payoff @ expert)
        expert = softmax(rationality * expert_payoff.T @ learner)
    solution = stage_logit(learner_payoff, expert_payoff, 1.0 / rationality)
    np.testing.assert_allclose(solution.learner, learner, atol=1e-13)
    np.testing.assert_allclose(solution.expert, expert, atol=1e-13)


def test_policies_do_not_change_under_scaling_and_strategically_neutral_shifts():
    random = np.random.default_rng(4)
    learner_payoff, expert_payoff = random.random((2, 5, 5))
    base = stage_logit(learner_payoff, expert_payoff, 0.05)
    scaled = stage_logit(100 * learner_payoff + random.random((1, 5)), 100 * expert_payoff + random.random((5, 1)), 5.0)
    np.testing.assert_allclose(scaled.learner, base.learner, atol=1e-12)
    np.testing.assert_allclose(scaled.expert, base.expert, atol=1e-12)


def test_sharp_equilibria_keep_a_tight_residual():
    random = np.random.default_rng(5)
    learner_payoff, expert_payoff = random.uniform(-10, 10, (2, 6, 6))
    solution = stage_logit(learner_payoff, expert_payoff, temperature=0.05)
    assert min(solution.learner.min(), solution.expert.min()) < 1e-20
    assert solution.residual < 1e-9


def test_every_point_of_a_folding_branch_is_an_equilibrium_and_the_turns_are_singular():
    number = int(RECORDED["folding_game"][1])
    learner_payoff, expert_payoff = RECORDED["learner_payoff"][number], RECORDED["expert_payoff"][number]
    branch = trace_logit_branch(learner_payoff, expert_payoff, 20.0)
    count = len(learner_payoff)
    for point in branch.points:
        learner, expert = np.exp(point[:count]), np.exp(point[count:-1])
        assert logit_residual(learner_payoff, expert_payoff, learner, expert, point[-1]) < 1e-11
    rationalities = branch.points[:, -1]
    turns = branch.turning_rationalities
    assert len(turns) == 2
    assert rationalities.max() < 20.0
    rising_until = int(np.argmax(np.diff(rationalities) < 0))
    assert rationalities[rising_until] <= turns[0] == pytest.approx(rationalities[rising_until], rel=1e-3)
    falling = rationalities[rising_until + 1 :]
    assert falling.min() == pytest.approx(turns[1], rel=1e-3)


FOLDING = RECORDED["folding_game"].tolist()


@pytest.mark.parametrize("number", [FOLDING[0], *(pytest.param(each, marks=pytest.mark.slow) for each in FOLDING[1:])])
def test_short_steps_follow_the_same_branch(number):
    payoffs = RECORDED["learner_payoff"][number], RECORDED["expert_payoff"][number]
    long, short = trace_logit_branch(*payoffs, 40.0), trace_logit_branch(*payoffs, 40.0, largest_step=0.08)
    assert long.turning_rationalities == pytest.approx(short.turning_rationalities, rel=1e-12)
    np.testing.assert_allclose(long.crossing, short.crossing, atol=1e-11)


@pytest.mark.parametrize("below", [1e-3, 1e-7])
def test_a_target_just_below_the_first_turn_is_not_stepped_over(below):
    number = int(RECORDED["folding_game"][2])
    payoffs = RECORDED["learner_payoff"][number], RECORDED["expert_payoff"][number]
    turn = trace_logit_branch(*payoffs, 30.0).turning_rationalities[0]
    before, after = stage_logit(*payoffs, 1.0 / (turn - below)), stage_logit(*payoffs, 1.0 / (turn + below))
    assert (before.folded, after.folded) == (False, True)
    assert before.residual < 1e-12
    assert np.abs(before.learner - after.learner).max() > 0.1


def test_a_near_bifurcation_is_followed_and_a_true_one_refused():
    """Coordination: with equal payoffs the branch meets a pitchfork at lambda = 2; an edge for one side decides it."""
    equal = np.eye(2)
    with pytest.raises(ArithmeticError, match="bifurcation"):
        stage_logit(equal, equal, temperature=0.2)
    for tilt in (1e-3, 1e-6):
        tilted = stage_logit(equal + np.diag([tilt, 0.0]), equal, temperature=0.2)
        assert tilted.learner[0] > 0.9
        other = stage_logit(equal + np.diag([0.0, tilt]), equal, temperature=0.2)
        np.testing.assert_allclose(other.learner, tilted.learner[::-1], atol=1e-12)


# --- pygambit


@pytest.mark.parametrize("column", [0, *(pytest.param(each, marks=pytest.mark.slow) for each in (1, 2))])
def test_stage_solutions_are_pygambits(column):
    rationality = RECORDED["rationality"][column]
    for number, (learner_payoff, expert_payoff) in enumerate(
        zip(RECORDED["learner_payoff"], RECORDED["expert_payoff"], strict=True)
    ):
        solution = stage_logit(learner_payoff, expert_payoff, 1.0 / rationality)
        assert not solution.folded
        assert solution.residual < 1e-13
        np.testing.assert_allclose(solution.learner, RECORDED["learner"][number, column], atol=1e-9)
        np.testing.assert_allclose(solution.expert, RECORDED["expert"][number, column], atol=1e-9)
        reached = stage_logit(learner_payoff, expert_payoff, 1.0 / RECORDED["reached"][number, column])
        np.testing.assert_allclose(reached.learner, RECORDED["learner"][number, column], atol=1e-13)
        np.testing.assert_allclose(reached.expert, RECORDED["expert"][number, column], atol=1e-13)


def test_stage_solutions_beyond_a_fold_are_pygambits():
    folded = []
    for row, number in enumerate(RECORDED["folding_game"]):
        for column, reached in enumerate(RECORDED["folding_reached"][row]):
            solution = stage_logit(RECORDED["learner_payoff"][number], RECORDED["expert_payoff"][number], 1.0 / reached)
            np.testing.assert_allclose(solution.learner, RECORDED["folding_learner"][row, column], atol=1e-12)
            np.testing.assert_allclose(solution.expert, RECORDED["folding_expert"][row, column], atol=1e-12)
            folded.append(solution.folded)
    # The last game turns at 25.5 only, so at 20 it is on the way out, although two more equilibria exist there.
    assert folded == [True, True, True, True, False, True]


def test_turning_points_are_pygambits():
    last = RECORDED["folding_rationality"][-1]
    for row, number in enumerate(RECORDED["folding_game"]):
        branch = trace_logit_branch(RECORDED["learner_payoff"][number], RECORDED["expert_payoff"][number], last)
        recorded = RECORDED["folding_turns"][row]
        assert branch.turning_rationalities == pytest.approx(recorded[~np.isnan(recorded)], rel=2e-6)


def test_pygambits_trace_of_a_folding_game_runs_along_the_branch():
    number = int(RECORDED["folding_game"][-1])
    payoffs = RECORDED["learner_payoff"][number], RECORDED["expert_payoff"][number]
    branch = trace_logit_branch(*payoffs, RECORDED["folding_rationality"][-1])
    for rationality, learner, expert in zip(
        RECORDED["trace_rationality"], RECORDED["trace_learner"], RECORDED["trace_expert"], strict=True
    ):
        assert logit_residual(*payoffs, learner, expert, rationality) < 1e-9
        point = np.concatenate([np.log(learner), np.log(expert)])
        distances = np.linalg.norm(branch.points[:, :-1] - point, axis=1)
        assert rationality > 40.0 or distances.min() < 0.25


def test_recorded_residuals_are_those_of_the_recorded_policies():
    assert RECORDED["residual"].max() <= 1e-9
    for number, column in np.ndindex(RECORDED["residual"].shape):
        residual = logit_residual(
            RECORDED["learner_payoff"][number],
            RECORDED["expert_payoff"][number],
            RECORDED["learner"][number, column],
            RECORDED["expert"][number, column],
            RECORDED["rationality"][column],
        )
        assert residual == pytest.approx(RECORDED["residual"][number, column], abs=1e-13)


# --- games over time


@pytest.fixture(scope="module")
def solved() -> tuple[Game, float]:
    return random_game(7, states=3, learner_actions=3, expert_actions=2), 0.15


@pytest.mark.parametrize("discount", [1.0, 0.8])
def test_markov_logit_has_no_regularised_nash_gap(solved, discount):
    game, temperature = solved
    solution = markov_logit(game, 4, discount, temperature)
    assert solution.residual.max() < 1e-12
    policies = solution.learner_policy, solution.expert_policy
    assert abs(soft_nash_gap(game, *policies, discount, temperature)) < 1e-12
    assert nash_gap(game, *policies, discount) > 1e-3


def test_markov_logit_is_the_soft_best_response_to_itself(solved):
    game, temperature = solved
    solution = markov_logit(game, 4, DISCOUNT, temperature)
    for sides, opponent, policy, value in (
        (game, solution.learner_policy, solution.expert_policy, solution.expert_value),
        (swapped(game), solution.expert_policy, solution.learner_policy, solution.learner_value),
    ):
        response = soft_best_response(sides.transition, sides.expert_reward, opponent, DISCOUNT, temperature)
        np.testing.assert_allclose(response.policy, policy, atol=1e-12)
        np.testing.assert_allclose(response.value, value, atol=1e-12)


def test_soft_values_are_return_plus_entropy_along_paths(game: Game, pair: Pair):
    """J_e = E^pi sum_t gamma^t (r_e - tau ln pi_e), which the soft response's V_0 is as well."""
    learner_policy, expert_policy = pair
    response = soft_best_response(game.transition, game.expert_reward, learner_policy, DISCOUNT, TEMPERATURE)
    for policy in (expert_policy, response.policy):
        total = 0.0
        for path in paths(game.transition, game.initial, learner_policy, policy):
            for time, (state, learner_action, expert_action) in enumerate(path.steps):
                reward = game.expert_reward[state, learner_action, expert_action]
                surprise = -np.log(policy[time, state, expert_action])
                total += path.probability * DISCOUNT**time * (reward + TEMPERATURE * surprise)
        assert _soft_value(game, learner_policy, policy) == pytest.approx(total, abs=1e-12)
    assert game.initial @ response.value[0] == pytest.approx(total, abs=1e-12)


def test_no_policy_beats_the_soft_best_response(game: Game, pair: Pair):
    learner_policy, _ = pair
    response = soft_best_response(game.transition, game.expert_reward, learner_policy, DISCOUNT, TEMPERATURE)
    best = _soft_value(game, learner_policy, response.policy)
    for seed in range(5):
        nearby = 0.9 * response.policy + 0.1 * random_policy(seed, HORIZON, 2, 3)
        assert _soft_value(game, learner_policy, nearby) < best


def _soft_value(game: Game, learner_policy: np.ndarray, expert_policy: np.ndarray) -> float:
    return soft_policy_value(
        game.transition, game.initial, game.expert_reward, learner_policy, expert_policy, DISCOUNT, TEMPERATURE
    )


def test_soft_best_response_sharpens_to_the_best_response(game: Game, pair: Pair):
    learner_policy, _ = pair
    soft = soft_best_response(game.transition, game.expert_reward, learner_policy, DISCOUNT, 1e-4)
    hard = best_response(game.transition, game.expert_reward, learner_policy, DISCOUNT)
    np.testing.assert_allclose(soft.policy, hard.policy, atol=1e-9)
    np.testing.assert_allclose(soft.value, hard.value, atol=1e-3)


def test_best_response_is_the_best_of_all_pure_policies(game: Game, pair: Pair):
    learner_policy = pair[0][:2]
    best = game.initial @ best_response(game.transition, game.expert_reward, learner_policy, DISCOUNT).value[0]
    values = []
    for choice in np.ndindex(3, 3, 3, 3):
        policy = np.eye(3)[np.reshape(choice, (2, 2))]
        values.append(policy_value(game.transition, game.initial, game.expert_reward, learner_policy, policy, DISCOUNT))
    assert best == pytest.approx(max(values), abs=1e-12)


def test_nash_gap_of_known_games():
    """Matching pennies twice: 0 at uniform, 2 + 2 gamma for a pure pair; prisoner's dilemma: 2 for (C, C)."""
    transition, initial = np.ones((1, 2, 2, 1)), np.ones(1)
    payoff = np.array([[[1.0, -1.0], [-1.0, 1.0]]])
    pennies = Game(transition, payoff, -payoff, initial)
    uniform = uniform_policy(2, 1, 2)
    pure = np.tile([1.0, 0.0], (2, 1, 1))
    assert nash_gap(pennies, uniform, uniform, 0.5) == pytest.approx(0.0, abs=1e-15)
    assert nash_gap(pennies, pure, pure, 0.5) == pytest.approx(3.0)
    assert soft_nash_gap(pennies, uniform, uniform, 0.5, 0.3) == pytest.approx(0.0, abs=1e-15)
    prisoner = np.array([[[3.0, 0.0], [4.0, 1.0]]])
    dilemma = Game(transition, prisoner, prisoner.swapaxes(1, 2), initial)
    assert nash_gap(dilemma, pure[:1], pure[:1], 1.0) == pytest.approx(2.0)
    assert nash_gap(dilemma, pure[:1, :, ::-1], pure[:1, :, ::-1], 1.0) == pytest.approx(0.0)


# --- the lower level


@pytest.mark.parametrize("discount", [1.0, 0.7])
def test_lemma_1_is_the_gradient_of_the_likelihood(discount):
    game = random_game(11, states=4, learner_actions=2, expert_actions=3)
    random = np.random.default_rng(12)
    features = random.normal(size=(4, 2, 3, 5))
    learner_policy, expert_policy = random_policy(13, 5, 4, 2), random_policy(14, 5, 4, 3)
    demonstrations = Demonstrations(
        occupancy(game.transition, game.initial, learner_policy, expert_policy), learner_policy
    )
    parameters = random.normal(size=5) / 3
    settings = (discount, 0.4, 0.1)
    lemma = lemma_1_gradient(parameters, features, game.transition, game.initial, demonstrations, *settings)
    differences = return_gradient_by_differences(
        lambda theta: negative_log_likelihood(theta, features, game.transition, demonstrations, *settings), parameters
    )
    np.testing.assert_allclose(lemma, differences, atol=1e-7)
    assert np.abs(lemma).max() > 0.1


def test_lemma_1_vanishes_at_the_truth():
    game = random_game(15, states=3, learner_actions=2, expert_actions=2)
    features = np.random.default_rng(16).normal(size=(3, 2, 2, 4))
    truth = np.array([0.3, -0.5, 0.2, 0.4])
    learner_policy = random_policy(17, 4, 3, 2)
    expert = soft_best_response(game.transition, features @ truth, learner_policy, DISCOUNT, TEMPERATURE)
    demonstrations = Demonstrations(
        occupancy(game.transition, game.initial, learner_policy, expert.policy), learner_policy
    )
    gradient = lemma_1_gradient(
        truth, features, game.transition, game.initial, demonstrations, DISCOUNT, TEMPERATURE, 0.0
    )
    np.testing.assert_allclose(gradient, 0.0, atol=1e-12)


def test_central_differences_are_exact_for_quadratics():
    matrix = np.array([[2.0, -1.0], [0.5, 3.0]])
    parameters = np.array([0.7, -1.1])
    gradient = return_gradient_by_differences(lambda theta: float(theta @ matrix @ theta), parameters, step=0.1)
    np.testing.assert_allclose(gradient, (matrix + matrix.T) @ parameters, atol=1e-12)


# --- comparing rewards


def test_epic_is_zero_up_to_scale_constant_and_potential_shaping():
    random = np.random.default_rng(20)
    reward = random.normal(size=(5, 6, 5))
    potential = random.normal(size=5)
    shaped = 3.0 * reward + 0.9 * potential[None, None, :] - potential[:, None, None] + 2.0
    assert epic_distance(reward, shaped, 0.9) == pytest.approx(0.0, abs=1e-7)
    assert epic_distance(reward, -reward, 0.9) == pytest.approx(1.0)
    assert epic_distance(reward, shaped, 0.5) > 0.05
    other = random.normal(size=(5, 6, 5))
    assert epic_distance(reward, other, 0.9) == pytest.approx(epic_distance(shaped, other, 0.9), abs=1e-12)
    assert 0.4 < epic_distance(reward, other, 0.9) < 0.9


def test_epic_canonical_form_is_the_expectation_over_independent_samples():
    random = np.random.default_rng(21)
    reward = random.normal(size=(3, 2, 3))
    state, action, following = 2, 1, 0
    total = 0.0
    for first, taken, second in np.ndindex(3, 2, 3):
        total += 0.9 * (reward[following, taken, second] - reward[first, taken, second]) - reward[state, taken, second]
    assert epic_canonical(reward, 0.9)[state, action, following] == pytest.approx(
        reward[state, action, following] + total / 18, abs=1e-12
    )


def test_epic_over_some_states_is_epic_of_the_smaller_game():
    random = np.random.default_rng(22)
    first, second = random.normal(size=(2, 5, 4, 5))
    chosen = np.array([0, 2, 3])
    part = np.ix_(chosen, np.arange(4), chosen)
    assert epic_distance(first, second, 0.9, chosen) == pytest.approx(epic_distance(first[part], second[part], 0.9))


def test_epic_refuses_a_reward_that_is_shaping_only():
    potential = np.arange(3.0)
    shaping = np.broadcast_to(0.9 * potential[None, None, :] - potential[:, None, None], (3, 2, 3))
    with pytest.raises(ValueError, match="constant"):
        epic_distance(shaping, np.random.default_rng(0).normal(size=(3, 2, 3)), 0.9)


# --- the attack graph


class SmallNetwork(NamedTuple):
    """outside -> 0, 0 -> 1, 1 -> 2, 0 -> 2; nothing is held at the start."""

    variant: str = "general_sum"
    footholds: tuple[int, ...] = ()
    value: np.ndarray = np.array([1.0, 2.0, 4.0])
    criticality: np.ndarray = np.array([3.0, 1.0, 5.0])
    edge_source: np.ndarray = np.array([-1, 0, 1, 0])
    edge_target: np.ndarray = np.array([0, 1, 2, 2])
    success_probability: np.ndarray = np.array([0.5, 0.8, 1.0, 0.25])
    attack_cost: np.ndarray = np.array([0.1, 0.2, 0.3, 0.4])
    block_cost: np.ndarray = np.array([1.0, 1.1, 1.2, 1.3])


def test_attack_graph_follows_the_rules_of_an_attack():
    graph = attack_graph_dense(SmallNetwork())
    assert graph.transition.shape == (8, 4, 4, 8)
    np.testing.assert_allclose(graph.transition.sum(axis=3), 1.0, atol=1e-15)
    assert graph.initial[0] == 1.0
    # All clean: the entry edge works, an edge from a clean node does not, and a block stops the entry.
    assert graph.transition[0, 1, 0, 0b001] == graph.transition[0, 1, 0, 0] == 0.5
    assert graph.transition[0, 0, 1, 0] == graph.transition[0, 0, 0, 0] == 1.0
    # Node 0 held: node 2 by the direct edge; node 0 cannot be taken again.
    assert graph.transition[0b001, 0, 3, 0b101] == 0.25
    assert graph.transition[0b001, 1, 0, 0b001] == 1.0
    assert graph.expert_reward[0b001, 0, 3] == pytest.approx(0.25 * 4.0 - 0.4)
    assert graph.dependent_reward[0b001, 0, 3] == pytest.approx(-0.25 * 5.0)
    assert graph.expert_reward[0b001, 3, 3] == pytest.approx(-0.4)
    assert graph.dependent_reward[0b001, 3, 3] == 0.0
    assert graph.own_reward[0b001, 3, 0] == -1.3


def test_compromise_is_permanent_and_pays_at_most_once():
    graph = attack_graph_dense(SmallNetwork())
    for before, after in np.ndindex(8, 8):
        if before & ~after:
            assert graph.transition[before, :, :, after].max() == 0.0
    np.testing.assert_allclose(graph.expert_reward[0b111], np.tile([-0.1, -0.2, -0.3, -0.4], (4, 1)))
    assert not graph.dependent_reward[0b111].any()


def test_zero_sum_variant_returns_the_attackers_reward_to_the_defender():
    graph = attack_graph_dense(SmallNetwork("zero_sum"))
    np.testing.assert_array_equal(graph.dependent_reward, -graph.expert_reward)
    np.testing.assert_array_equal(graph.game().learner_reward, graph.own_reward - graph.expert_reward)


def test_no_op_adds_an_action_that_does_and_costs_nothing():
    plain, with_no_op = (attack_graph_dense(SmallNetwork(), no_op=choice) for choice in (False, True))
    assert with_no_op.transition.shape == (8, 5, 5, 8)
    for small, large in zip(plain[:4], with_no_op[:4], strict=True):
        np.testing.assert_array_equal(large[:, :4, :4], small)
    np.testing.assert_array_equal(with_no_op.transition[:, 2, 4], np.eye(8))
    assert not with_no_op.expert_reward[:, :, 4].any()
    assert not with_no_op.own_reward[:, 4].any()
    assert with_no_op.transition[0, 4, 0, 0b001] == 0.5


def test_footholds_are_the_initial_state():
    assert np.flatnonzero(attack_graph_dense(SmallNetwork(footholds=(0, 2))).initial).tolist() == [0b101]


def test_the_attack_graph_can_be_solved():
    game = attack_graph_dense(SmallNetwork()).game()
    solution = markov_logit(game, 3, 1.0, 0.4)
    assert solution.residual.max() < 1e-12
    assert abs(soft_nash_gap(game, solution.learner_policy, solution.expert_policy, 1.0, 0.4)) < 1e-12
