"""What of a continuous game's return is lost by the learned rewards, and what by the search for policies?

A run is lived as by `gsiirl run`. From the pair that it ends with, the forward model then settles four times: with the
true rewards or the learned ones in the place of the expert's and of the learner's dependent reward. Each line has the
learner's return, per seed and on average, when a real expert has answered.

    python benchmarks/settling.py deception --seeds 20,21,22,23
"""

import argparse
from typing import Any

import jax
import jax.numpy as jnp

from gsiirl.equilibria.pathwise import TransitionReward, policies_of
from gsiirl.experiments import crossing_problem, deception_problem
from gsiirl.experiments.continuous_judge import Judge
from gsiirl.experiments.continuous_run import expert_of, learner_of
from gsiirl.experiments.continuous_solvers import TRAINED_RATE, solver_of
from gsiirl.experiments.crossing import CrossingConfig
from gsiirl.experiments.deception import DeceptionConfig
from gsiirl.types import Sides

AT_A_TIME = 2
"""Seeds that are computed together."""


def main() -> None:
    """Print a line for each of the four pairs of rewards."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("game", choices=("deception", "separate_target", "crossing"))
    parser.add_argument("--seeds", default="20,21,22,23")
    arguments = parser.parse_args()
    if arguments.game == "crossing":
        config = CrossingConfig().resolved()
        problem = crossing_problem.build(config)
    else:
        config = DeceptionConfig(variant="mpe" if arguments.game == "deception" else arguments.game).resolved()
        problem = deception_problem.build(config)
    learner, expert, judge = learner_of(config, problem), expert_of(config, problem), Judge(config, problem)
    steps = config.settling_steps or config.training_steps
    trainer = solver_of(config, problem, steps, TRAINED_RATE)

    def live(key: jax.Array) -> Any:
        learner_key, expert_key, run_key = jax.random.split(key, 3)
        state = learner.init(learner_key)
        habits = expert.init(expert_key, learner.propose(state))

        def one_iteration(carry: Any, key: jax.Array) -> Any:
            state, habits = carry
            demonstration_key, update_key = jax.random.split(key)
            played = learner.propose(state)
            habits, seen = expert.demonstrate(habits, played, config.trajectories, demonstration_key)
            return (learner.update(state, played, seen, update_key), habits), None

        keys = jax.random.split(run_key, config.iterations)
        return jax.lax.scan(one_iteration, (state, habits), keys)[0]

    def settled(carry: Any, key: jax.Array, expert_learned: jax.Array, own_learned: jax.Array) -> jax.Array:
        state, habits = carry
        learned, true = learner.rewards(state.commitment, state.expert_parameters), problem.true_rewards

        def one_of(which: jax.Array, one: TransitionReward, other: TransitionReward) -> TransitionReward:
            return lambda seen: jnp.where(which, one(seen), other(seen))

        rewards = Sides(
            one_of(own_learned, learned.learner, true.learner), one_of(expert_learned, learned.expert, true.expert)
        )
        settle_key, response_key = jax.random.split(key)
        model = trainer.settle(policies_of(state.solution), rewards, settle_key, steps)
        answer = judge.best_response(model.learner, (habits.policy, model.expert), response_key)
        return judge.returns(judge.episodes(Sides(model.learner, answer))).learner

    seeds = [int(each) for each in arguments.seeds.split(",")]
    begun, ended = jax.jit(jax.vmap(live)), jax.jit(jax.vmap(settled, (0, 0, None, None)))
    found: dict[tuple[bool, bool], list[float]] = {}
    for first in range(0, len(seeds), AT_A_TIME):
        keys = jax.vmap(jax.random.key)(jnp.asarray(seeds[first : first + AT_A_TIME]))
        carry = begun(keys)
        for learned in ((False, False), (False, True), (True, False), (True, True)):
            returns = ended(carry, keys, *jnp.asarray(learned))
            found.setdefault(learned, []).extend(float(each) for each in returns)
    for (expert_learned, own_learned), returns in found.items():
        names = f"r_e {'learned' if expert_learned else 'true':>7}, r_ld {'fitted' if own_learned else 'true':>6}"
        each = " ".join(f"{value:6.2f}" for value in returns)
        print(f"{arguments.game} {names}: mean {sum(returns) / len(returns):6.2f}, seeds {each}", flush=True)


if __name__ == "__main__":
    main()
