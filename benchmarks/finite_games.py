"""How far from the best commitment the learner ends in finite games that nobody here chose.

The best commitment is that of an oracle of its own (tests/commitment_oracle.py: NumPy and SciPy). Rows are appended to
a JSON-lines file, one a game; games that are there already are not run again.

    python benchmarks/finite_games.py random --size 3 --temperature 0.1 --games 50 --out results.jsonl
    python benchmarks/finite_games.py markov --states 4 --size 3x3 --horizon 4 --temperature 0.1 --out results.jsonl
    python benchmarks/finite_games.py public --temperature 0.1 --out results.jsonl
    python benchmarks/finite_games.py random --learner reward --size 3 --temperature 0.4 --out earlier.jsonl
    python benchmarks/finite_games.py table results.jsonl
"""

import argparse
import json
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

import commitment_oracle as oracle
import equinox as eqx
import jax
import jax.numpy as jnp
import public_games
import small_games

import gsiirl
from gsiirl.equilibria.logit import Logit
from gsiirl.games import DensePayoff
from gsiirl.interaction import interact
from gsiirl.learners.bilevel import Bilevel
from gsiirl.learners.reward_learner import RewardGSIIRL
from gsiirl.rewards.linear import IndicatorFeatures, Linear

BOUND = 1.5
"""On every weight of the rewards that `--learner reward` learns; the games' rewards are within 1.3."""


def games(arguments: argparse.Namespace) -> Iterator[oracle.FiniteGame]:
    """The games that the command line names."""
    temperature = arguments.temperature
    if arguments.kind == "public":
        yield from public_games.public_games(temperature)
        return
    for seed in range(arguments.first, arguments.first + arguments.games):
        if arguments.kind == "random":
            yield oracle.random_one_shot(int(arguments.size), temperature, seed)
        else:
            learner, expert = map(int, arguments.size.split("x"))
            yield oracle.random_markov(arguments.states, learner, expert, arguments.horizon, temperature, seed)


def run(game: oracle.FiniteGame, iterations: int, trajectories: int, settings: dict) -> dict:
    """One game: what the learner earns beside the oracle's ceiling and floor, in percent of what is between them."""
    problem, expert = small_games.problem_of(game), small_games.expert_of(game)
    began = time.perf_counter()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        result = gsiirl.GSIIRL(problem, **settings).fit(expert, iterations, trajectories, seed=0, progress=False)
    seconds = time.perf_counter() - began
    own, history = result.evaluate(game.expert), result.history
    policies = [result.policy, own.ceiling_policy]
    began = time.perf_counter()
    ceiling, _, floor = oracle.extremes(game, policies=policies)
    oracle_seconds = time.perf_counter() - began
    earned = oracle.learner_return(game, result.policy)
    played = np.array([oracle.learner_return(game, policy) for policy in result.played])
    actions = game.own.shape[1]
    shape = (game.horizon, game.own.shape[0], actions)
    uniform = oracle.learner_return(game, np.full(shape, 1.0 / actions))
    pure = min(
        oracle.learner_return(game, np.broadcast_to(np.eye(actions)[action], shape).copy()) for action in range(actions)
    )
    span = max(ceiling - floor, 1e-12)

    def percent(value: float) -> float:
        return 100.0 * (ceiling - value) / span

    return {
        "game": game.name,
        "temperature": game.temperature,
        "loss": percent(earned),
        "own_ceiling": percent(own.ceiling),
        "own_floor": 100.0 * (own.floor - floor) / span,
        "played": percent(float(played[-10:].mean())),
        "best_played": percent(float(played.max())),
        "simple": percent(max(uniform, pure)),
        "marl": percent(own.marl),
        "sharp_marl": percent(own.sharp_marl),
        "effective_draws": result.effective_draws,
        "sampled": result.sampled,
        "converged": float(history["fit_converged"][-1]) if "fit_converged" in history.columns else np.nan,
        "warnings": len(said),
        "seconds": seconds,
        "oracle_seconds": oracle_seconds,
    }


@eqx.filter_jit
def by_reward(
    expert: gsiirl.RespondingExpert,
    rewards: tuple[jax.Array, jax.Array],
    iterations: int,
    trajectories: int,
) -> jax.Array:
    """The policy that a commitment to a reward ends with, given r_li and r_ld and the expert's discount and τ."""
    own, dependent = map(DensePayoff, rewards)
    discount, temperature = expert.discount, expert.temperature
    states, actions, answers = rewards[1].shape
    indicators = IndicatorFeatures(shape=(states, actions, answers))
    reward = Linear(indicators, BOUND * indicators.number**0.5)
    bilevel = Bilevel(expert.game, own, dependent, reward, reward, Logit(temperature), temperature, discount)
    learner = RewardGSIIRL.create(bilevel)
    start, key = jax.random.split(jax.random.key(0))
    (state, _), _ = interact(
        learner, expert, (learner.init(start), None), key, 0, iterations, trajectories, lambda _: {}
    )
    return learner.forward(state).policies.learner


def run_earlier(game: oracle.FiniteGame, iterations: int, trajectories: int) -> dict:
    """One game by the earlier default, a commitment to a reward; it is told how large rewards can be."""
    own = np.broadcast_to(game.own[:, :, None], game.dependent.shape)
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        rewards = jnp.asarray(own), jnp.asarray(game.dependent)
        expert = jax.tree.map(jnp.asarray, small_games.expert_of(game))
        began = time.perf_counter()
        policy = np.asarray(by_reward(expert, rewards, iterations, trajectories))
        seconds = time.perf_counter() - began
    ceiling, _, floor = oracle.extremes(game, policies=[policy])
    loss = 100.0 * (ceiling - oracle.learner_return(game, policy)) / max(ceiling - floor, 1e-12)
    return {"game": game.name, "temperature": game.temperature, "loss": loss, "seconds": seconds}


def table(rows: list[dict]) -> str:
    """Median, 90 % and worst of the losses, by kind of game and temperature."""
    groups: dict[tuple[str, float], list[dict]] = {}
    for row in rows:
        groups.setdefault((row["kind"], row["temperature"]), []).append(row)
    lines = [f"{'games':<16}{'tau':>6}{'n':>4}  {'deployed':>20}  {'played':>20}  {'MARL sharp':>12}{'s/game':>8}"]
    for (kind, temperature), each in sorted(groups.items()):
        columns = []
        for name in ("loss", "played"):
            values = [row.get(name, np.nan) for row in each]
            columns.append("/".join(f"{np.quantile(values, q):.2f}" for q in (0.5, 0.9, 1.0)))
        sharp = np.median([row.get("sharp_marl", np.nan) for row in each])
        seconds = np.median([row["seconds"] for row in each])
        bad = [
            row["game"]
            for row in each
            if "simple" in row and row["loss"] > min(row["simple"], row["best_played"] + 1.0) + 1e-9
        ]
        lines.append(
            f"{kind:<16}{temperature:>6}{len(each):>4}  {columns[0]:>20}  {columns[1]:>20}  "
            f"{sharp:>12.1f}{seconds:>8.2f}"
            + (f"  below what is simple or was played: {', '.join(bad)}" if bad else "")
        )
    return "\n".join(lines)


def main() -> None:
    """Run what the command line names, or print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=("random", "markov", "public", "table"))
    parser.add_argument("file", nargs="?", type=Path)
    parser.add_argument("--size", default="3")
    parser.add_argument("--states", type=int, default=3)
    parser.add_argument("--horizon", type=int, default=3)
    parser.add_argument("--temperature", type=float, default=0.1)
    parser.add_argument("--games", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--iterations", type=int, default=50)
    parser.add_argument("--trajectories", type=int, default=100)
    parser.add_argument("--learner", choices=("policy", "reward"), default="policy")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    if arguments.kind == "table":
        print(table([json.loads(line) for line in arguments.file.read_text().splitlines()]))
        return
    words = {"True": True, "False": False}
    settings = {name: words.get(value, value) for name, value in (each.split("=") for each in arguments.set)}
    kind = arguments.kind if arguments.kind == "public" else f"{arguments.kind} {arguments.size}"
    if arguments.kind == "markov":
        kind = f"markov {arguments.states} {arguments.size} {arguments.horizon}"
    done = set()
    if arguments.out.exists():
        done = {(row["game"], row["temperature"]) for row in map(json.loads, arguments.out.read_text().splitlines())}
    for game in games(arguments):
        if (game.name, game.temperature) in done:
            continue
        if arguments.learner == "reward":
            row = {"kind": kind, **run_earlier(game, arguments.iterations, arguments.trajectories)}
        else:
            row = {"kind": kind, **run(game, arguments.iterations, arguments.trajectories, settings)}
        with arguments.out.open("a") as stream:
            stream.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
