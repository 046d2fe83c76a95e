"""Solvers of the special cases, in NumPy and SciPy: they share nothing with the package.

`soft_minimax`      competition: the least soft value that any policy of the learner leaves the expert
`CausalEntropy`     only watching: maximum causal entropy inverse reinforcement learning from discounted occupancies
"""

import numpy as np
from commitment_oracle import FiniteGame, Floats
from scipy.optimize import minimize
from scipy.special import softmax


def logsumexp(values: Floats) -> Floats:
    """ln Σ exp over the last axis."""
    most = values.max(-1)
    return most + np.log(np.exp(values - most[..., None]).sum(-1))


def stage(payoff: Floats, temperature: float) -> tuple[float, Floats]:
    """min over π of τ ln Σ_e exp(π·Q(·, e)/τ), and the minimiser; `payoff` Q is (A_l, A_e).

    The function F is convex, so that π·∇F − min_l ∇F_l bounds what is missed: the least value that is left is proven.
    """

    def value(policy: Floats) -> float:
        return float(temperature * logsumexp(policy @ payoff / temperature))

    def slope(policy: Floats) -> Floats:
        return payoff @ softmax(policy @ payoff / temperature)

    actions = len(payoff)
    found = minimize(
        value,
        np.full(actions, 1.0 / actions),
        jac=slope,
        bounds=[(0.0, 1.0)] * actions,
        constraints=[{"type": "eq", "fun": lambda p: p.sum() - 1.0, "jac": lambda p: np.ones(actions)}],
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    policy = np.maximum(found.x, 0.0)
    policy /= policy.sum()
    for step in range(2000):  # exponentiated gradients, where the first method stopped early
        gradient = slope(policy)
        if policy @ gradient - gradient.min() <= 1e-8:
            break
        policy = policy * np.exp(-(gradient - gradient.min()) * 2.0 / (1.0 + 0.01 * step))
        policy /= policy.sum()
    assert policy @ slope(policy) - slope(policy).min() <= 1e-5
    return value(policy), policy


def soft_minimax(game: FiniteGame) -> tuple[float, Floats]:
    """V* = min over π_l of the expert's soft value, and a π_l (T, S, A_l) that reaches it; without masks.

    V*_T = 0 and V*_t(s) = min over π of τ ln Σ_e exp(Σ_l π(l) Q_t(s, l, e)/τ), Q_t = r_e + γ E V*_t+1. One state after
    the other, because the soft value rises with that of every state that follows.
    """
    values, policies = np.zeros(len(game.initial)), []
    over = np.zeros(len(values), bool) if game.terminal is None else game.terminal
    for _ in range(game.horizon):
        payoffs = game.expert + game.discount * game.transitions @ values
        solved = [stage(payoff, game.temperature) for payoff in payoffs]
        values = np.where(over, 0.0, [value for value, _ in solved])
        policies.append([policy for _, policy in solved])
    return float(game.initial @ values), np.array(policies[::-1])


class CausalEntropy:
    """Maximum causal entropy inverse reinforcement learning of a Markov decision process with finite horizon.

    P is (S, A, S). The reward is a table θ (S, A), in units of the temperature. To discounted occupancies ρ (S, A) it
    is the θ that minimises the dual E V_0 − θ·ρ + (λ/2)‖θ‖², whose gradient is the model's occupancies − ρ + λθ.
    """

    def __init__(self, transitions: Floats, initial: Floats, horizon: int, discount: float) -> None:
        self.transitions, self.initial, self.horizon, self.discount = transitions, initial, horizon, discount

    def solve(self, reward: Floats) -> tuple[float, Floats]:
        """E V_0 of soft value iteration, and its policy (T, S, A)."""
        value, policies = np.zeros(len(self.initial)), []
        for _ in range(self.horizon):
            action_values = reward + self.discount * self.transitions @ value
            value = logsumexp(action_values)
            policies.append(softmax(action_values, axis=-1))
        return float(self.initial @ value), np.array(policies[::-1])

    def occupancies(self, policy: Floats) -> Floats:
        """ρ(s, a) = Σ_t γ^t P(s_t = s, a_t = a)."""
        here, total = self.initial, np.zeros(self.transitions.shape[:2])
        for time, now in enumerate(policy):
            total += self.discount**time * here[:, None] * now
            here = np.einsum("s,sa,san->n", here, now, self.transitions)
        return total

    def fit(self, occupancies: Floats, regularisation: float) -> Floats:
        """The reward, by L-BFGS and then Newton's steps with differences of the gradient."""
        shape = occupancies.shape

        def loss(flat: Floats) -> tuple[float, Floats]:
            value, policy = self.solve(flat.reshape(shape))
            slope = (self.occupancies(policy) - occupancies).ravel() + regularisation * flat
            return float(value - flat @ occupancies.ravel() + 0.5 * regularisation * flat @ flat), slope

        flat = minimize(loss, np.zeros(occupancies.size), jac=True, method="L-BFGS-B").x
        for _ in range(8):
            steps = 1e-5 * np.eye(len(flat))
            rows = [(loss(flat + each)[1] - loss(flat - each)[1]) / 2e-5 for each in steps]
            flat = flat - np.linalg.solve(np.array(rows), loss(flat)[1])
        assert np.abs(loss(flat)[1]).max() <= 1e-10
        return flat.reshape(shape)
