"""What of a continuous game's return is lost by the learned rewards, and what by the search for policies?

A run is lived as by `gsiirl run`. From the pair that it ends with, the forward model then settles four times, with the
true rewards or the learned ones in the place of the expert's reward and of the learner's dependent reward. Each line
has the learner's return when a real expert has answered, per seed and on average.

    python benchmarks/settling.py deception --seeds 20,21,22,23
"""

import argparse
from typing import Any

import jax
import jax.numpy as jnp
from continuous_games import GAMES, experiment_of

from gsiirl.compilation import OF_A_RUN
from gsiirl.equilibria.pathwise import TRAINED_RATE, policies_of
from gsiirl.experiments.continuous.experiment import front_door_of
from gsiirl.experiments.continuous.judge import Judge
from gsiirl.experiments.continuous.run import learner_of, prepare_continuous
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides

AT_A_TIME = 2
"""Seeds that are computed together."""


def main() -> None:
    """Print a line for each of the four pairs of rewards."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("game", choices=GAMES)
    parser.add_argument("--seeds", default="20,21,22,23")
    parser.add_argument("--steps", type=int, help="steps to settle for; default those of a run, or of marl")
    arguments = parser.parse_args()
    config, experiment = experiment_of(arguments.game)
    learner = learner_of(config, experiment.problem)
    true = Judge(config, experiment).true
    steps = arguments.steps or config.settling_steps or config.training_steps
    trainer = front_door_of(config, experiment.problem).solver(steps, TRAINED_RATE)

    run = prepare_continuous(config, experiment).algorithm

    def live(key: jax.Array) -> Any:
        start_key, run_key = jax.random.split(key)
        return run.advance(run.init(start_key), run_key, jnp.asarray(0), config.iterations)[0]

    def settled(carry: Any, key: jax.Array, expert_learned: jax.Array, own_learned: jax.Array) -> jax.Array:
        state, habits = carry
        learned, known = learner.rewards(state.commitment, state.expert_parameters), experiment.true_rewards

        def one_of(which: jax.Array, one: TransitionReward, other: TransitionReward) -> TransitionReward:
            return lambda seen: jnp.where(which, one(seen), other(seen))

        rewards = Sides(
            one_of(own_learned, learned.learner, known.learner), one_of(expert_learned, learned.expert, known.expert)
        )
        settle_key, response_key = jax.random.split(key)
        model = trainer.settle(policies_of(state.solution), rewards, settle_key, steps)
        answer = true.best_response(model.learner, (habits.policy, model.expert), response_key)
        return true.returns(true.episodes(Sides(model.learner, answer))).learner

    seeds = [int(each) for each in arguments.seeds.split(",")]
    options = OF_A_RUN["cpu"]
    begun = jax.jit(jax.vmap(live), compiler_options=options)
    ended = jax.jit(jax.vmap(settled, (0, 0, None, None)), compiler_options=options)
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
