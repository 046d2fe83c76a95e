"""A short run of the fuzzers, without Atheris."""

import pytest
from fuzz import graphml_network, json_network, nasim_scenario, vulnerabilities
from fuzz.driver import LARGEST, Target, changed_samples, check, grown

from gsiirl.errors import InputError

TARGETS = {
    "json": json_network.TARGET,
    "graphml": graphml_network.TARGET,
    "csv": vulnerabilities.TARGET,
    "nasim": nasim_scenario.TARGET,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", TARGETS)
def test_changed_samples_are_read_or_refused(name: str):
    before = grown()
    accepted = [check(TARGETS[name], content) for content in changed_samples(TARGETS[name], 2000, seed=0)]
    assert 100 < sum(accepted) < 1900
    assert grown() - before < LARGEST


def raising(error: Exception) -> Target:
    def read(content: bytes) -> None:
        if b"NaN" in content:
            raise error

    return Target(read, samples=[b"abc"], words=[], package="")


@pytest.mark.parametrize("error", [KeyError("x"), RecursionError(), InputError("x", "y" * 1000, "z")])
def test_a_fault_is_found(error: Exception):
    target = raising(error)
    inputs = changed_samples(target, 200, seed=0)
    with pytest.raises((KeyError, RecursionError, AssertionError)):
        all(check(target, content) for content in inputs)


def test_the_same_seed_gives_the_same_inputs():
    target = json_network.TARGET
    first, second, other = (list(changed_samples(target, 20, seed)) for seed in (0, 0, 1))
    assert first == second != other
