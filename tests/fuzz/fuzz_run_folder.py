"""Damaged run folders by the thousand: every reader takes them or refuses them in one line, and lets no NaN pass.

    python tests/fuzz/fuzz_run_folder.py json --inputs 100000
    python tests/fuzz/fuzz_run_folder.py binary --inputs 10000
    python tests/fuzz/fuzz_run_folder.py earlier --inputs 1000

Checksums are made right again after most damages, so that what stands behind them is met; where they are not, nothing
but a refusal is right. Parquet is the exception: at some damaged bytes its reader ends the process, which is why files
without a checksum are read by a process of their own (`earlier`, about 1 s each), and why those with a right one are
damaged as tables, not as bytes.
"""

import argparse
import copy
import io
import json
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import polars
import safetensors.numpy

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from report.synthetic import SyntheticGame, write_run
from report.synthetic_plane import write_plane_run
from report.synthetic_theory import all_findings
from resealing import CARRIED, resealed

from gsiirl.errors import InputError
from gsiirl.experiments.config import config_from_dict, config_to_dict
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.deception.mpe2_evaluation import PlayedRun
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.game.file import OwnGame
from gsiirl.experiments.loading import load
from gsiirl.front_door.result import Result
from gsiirl.games import TabularGame
from gsiirl.problems.problem import Problem
from gsiirl.report.crossing.encounter_figure import smallest_distance
from gsiirl.report.crossing.recorded_crossing import RecordedCrossing
from gsiirl.report.crossing.reward_map import RewardMap
from gsiirl.report.deception.recorded_episode import BODIES, advantage, true_weights
from gsiirl.report.page.game_figures import network_of
from gsiirl.report.page.out_folder import refuse_foreign_files
from gsiirl.report.page.report import Report, Section
from gsiirl.report.plane.episode import pick_episode
from gsiirl.report.read.group import group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.report.security.sample_path import pick_sample_path
from gsiirl.report.tables.comparison import compare
from gsiirl.report.tables.quality import judge
from gsiirl.report.tables.rivals import rivals_of
from gsiirl.runs import Ablation, AblationVariant, Findings, RunFolder, summarise
from gsiirl.runs.files.checksum import NAME, PLACE
from gsiirl.runs.files.json_file import encode_json
from gsiirl.runs.files.numbers import is_sound

PATIENCE, GROWTH = 5, 500 * 1024
"""Seconds that an input may take, and KiB by which the process may grow."""
RESEALED = 0.9
"""Share of inputs whose checksum is made right again."""
TINY = {"nodes": ["a", "b"], "footholds": ["a"], "edges": [("a", "b", 0.5)]}
WEIGHTS = {"learner.table": np.full((2, 3, 2, 2), 0.5), "expert.table": np.full((2, 3, 2, 2), 0.5)}
VALUES: list[Any] = [
    None, True, False, 0, -1, 1, 2**63, 10**40, 0.5, -1e99, 1e308, "", "1", "nan", "\ud800", "x" * 1000, "../x",
    [], {}, [[]], [None], [0, 0], {"": 0}, "gsiirl-sha256:" + "0" * 64,
]  # fmt: skip
TEXTS = [
    b"1e999",
    b"NaN",
    b"-Infinity",
    b"[" * 3000,
    b'{"a":' * 3000,
    b"1" * 5000,
    b'"\\ud800"',
    b"\xff",
    b"\x00",
    b"//",
]


def make_folders(folder: Path) -> dict[str, Path]:
    """A sound folder of each kind."""
    for each in ("security", "crossing", "deception"):
        path = folder / each
        if each == "security":
            run = write_run(path, "gsiirl", SyntheticGame(TINY), seeds=2, iterations=2)
        else:
            run = write_plane_run(path, each, "gsiirl", seeds=2, iterations=2)
        run.save_policies(WEIGHTS)
        run.save_checkpoint({"state": np.zeros(3), "key": np.zeros((2, 2), np.uint32)}, iteration=2, chunks=1)
        summary = run.summary()
        assert summary is not None
        run.write_summary(summary)
    write_run(folder / "interrupted", "gsiirl", SyntheticGame(TINY), seeds=2, iterations=2, completed=False)
    shutil.copytree(folder / "security", folder / "earlier")
    for path in (folder / "earlier").rglob("*.*"):
        path.write_bytes(CARRIED.sub(len(PLACE) * b"-", path.read_bytes().replace(b'"checksum"', b'"unlisted"')))
    make_game(folder)
    make_played(folder / "played")
    all_findings().write(folder / "theory")
    Ablation(["graph-0"], [AblationVariant("paper", "the paper's"), AblationVariant("b", "")]).write(
        folder / "ablation"
    )
    (folder / "report").mkdir()
    (folder / "report" / "table.json").write_bytes(
        encode_json("table.json", {"generator": "gsiirl report", "files": ["a.png", "table.json"]})
    )
    return {path.name: path for path in folder.iterdir()}


def make_game(folder: Path) -> None:
    """A run of one's own game, and a result of it that was saved."""
    game = TabularGame.from_arrays(np.full((2, 2, 2, 2), 0.5), initial=np.array([1.0, 0.0]), horizon=3)
    zero = np.zeros((2, 2, 2))
    problem = Problem(game, own_reward=zero, dependent_value=zero, discount=0.9, temperature=1.0)
    names = {"expert_reward": list(problem.expert_names), "dependent_reward": list(problem.dependent_names)}
    Result.learned(
        problem=problem,
        seed=0,
        trajectories=5,
        policy=WEIGHTS["learner.table"][0],
        expert_policy=WEIGHTS["expert.table"][0],
        expert_weights=np.zeros(len(names["expert_reward"])),
        dependent_weights=np.zeros(len(names["dependent_reward"])),
        draws=np.zeros((3, len(names["expert_reward"]))),
        history=polars.DataFrame({"iteration": [0, 1], "fit_decrement": [0.1, 0.2]}),
        played=np.zeros((2, 3, 2, 2)),
        answers=np.zeros((2, 3, 2, 2)),
        effective_draws=3.0,
        sampled=False,
    ).save(folder / "saved")
    config = GameConfig(file="mine.npz", seeds=2, iterations=1).resolved()
    own = OwnGame("mine", problem, np.zeros((2, 2, 2)), 1.0)
    run = RunFolder.create(folder / "game", config_to_dict(config), own.to_json_dict())
    run.append_metrics(0, {"seed": np.array([0, 0, 1, 1]), "iteration": np.array([0, 1, 0, 1]), "regret": np.zeros(4)})
    run.save_learned(
        {name: np.zeros((2, len(each))) for name, each in names.items()}, dict.fromkeys(names, 1.0), names, [0, 1]
    )
    run.save_policies(WEIGHTS | {"expert_reward.draws": np.zeros((2, 3, len(names["expert_reward"])))})
    run.write_summary(summarise(run.config, run.metrics(), completed=True))


def make_played(path: Path) -> None:
    """A run of deception that mpe2 can play."""
    run = RunFolder.create(path, config_to_dict(DeceptionConfig(seeds=2).resolved()), {"kind": "deception"})
    weights = {}
    for name, inputs, actions in (("learner", 20, 4), ("expert", 8, 2), ("response", 8, 2)):
        for layer, (before, after) in enumerate(((inputs + 1, 3), (3, 3), (3, actions))):
            weights[f"{name}.layers.{layer}.weight"] = np.zeros((2, after, before), np.float32)
            weights[f"{name}.layers.{layer}.bias"] = np.zeros((2, after), np.float32)
    run.save_policies(weights)
    returns = {f"{pair}_return_{side}": np.zeros(2) for pair in ("deployed", "model") for side in ("learner", "expert")}
    run.append_metrics(0, {"seed": np.array([0, 1]), "iteration": np.array([0, 0]), **returns})
    run.write_summary(summarise(run.config, run.metrics(), completed=True))


def read_run(folder: Path) -> None:
    """All that a report reads of a run, and says of it; no NaN may be in what it takes for a result."""
    run = ReportedRun.read(folder)
    (group,) = group_runs([run])
    RunFolder.open(folder).load_policies()
    RunFolder.open(folder).load_checkpoint()
    report = Report([Section(group, rivals_of(group), compare(group), judge(group), [], network_of(group))], [])
    encode_json("table.json", report.json([]))
    report.markdown().encode()
    kind = group.game.get("kind")
    if kind == "attack_graph":
        graph = RecordedGraph.read(group.game, folder)
        assert is_sound(graph.expert_truth).all()
        assert is_sound(graph.dependent_truth).all()
        pick_sample_path(graph, run)
    elif kind == "crossing":
        RecordedCrossing.read(group.game, folder)
        pick_episode(run, ("robot", "human"), smallest_distance)
        RewardMap.of(run)
    elif kind == "deception":
        true_weights(group.game, folder)
        pick_episode(run, BODIES, advantage)
    for values in run.final.values():
        assert is_sound(values).all()
        assert len(values) == len(run.kept_seeds)
    for name in [] if run.learned is None else run.learned.arrays:
        weights = run.weights(name)
        assert weights is None or is_sound(weights).all()
    assert run.wall_seconds is None or is_sound(np.array(run.wall_seconds))


def read_config(folder: Path) -> None:
    """What `resume` asks of a configuration."""
    config_from_dict(RunFolder.open(folder).config, folder / "config.json")


def read_theory(folder: Path) -> None:
    """What a report asks of findings."""
    for finding in Findings.read(folder).findings:
        assert "/" not in finding.key


def read_table(folder: Path) -> None:
    """What a report asks of an earlier one."""
    refuse_foreign_files(folder, ["table.json", "a.png"])


def read_result(folder: Path) -> None:
    """What `gsiirl.load` asks of a saved result, or of a run."""
    result = load(folder)
    for values in (result.policy, result.expert_policy, result.expert_reward.weights, result.dependent_reward.weights):
        assert is_sound(values).all()


def read_played(folder: Path) -> None:
    """What `gsiirl evaluate` asks of a run."""
    run = PlayedRun.open(folder)
    for name, inputs, actions in (("learner", 20, 4), ("response", 8, 2)):
        for place in range(len(run.seeds)):
            action = run.policy(name, place, inputs, actions)(np.zeros(inputs, np.float32), 0.5)
            assert np.isfinite(action).all()
    assert is_sound(run.in_port("deployed")).all()


Reader = Callable[[Path], object]
TARGETS: dict[str, list[tuple[str, str, Reader]]] = {
    "json": [
        *((kind, name, read_run) for kind in ("security", "crossing", "deception")
          for name in ("summary.json", "game.json", "learned.json", "environment.json", "config.json")
          if (kind, name) != ("crossing", "learned.json")),
        ("security", "config.json", read_config),
        ("interrupted", "game.json", read_run),
        ("interrupted", "config.json", read_run),
        *(("game", name, read_result) for name in ("game.json", "config.json", "summary.json", "learned.json")),
        ("saved", "result.json", read_result),
        *(("played", name, read_played) for name in ("summary.json", "config.json")),
        ("theory", "theory.json", read_theory),
        ("ablation", "ablation.json", Ablation.read),
        ("report", "table.json", read_table),
    ],
    "binary": [
        *((kind, name, read_run) for kind, names in {
            "security": ("metrics/chunk-00000.parquet", "paths.parquet", "learned.safetensors", "policies.safetensors",
                         "checkpoint/state.safetensors"),
            "crossing": ("metrics/chunk-00000.parquet", "paths.parquet", "reward_map.parquet"),
            "deception": ("paths.parquet", "learned.safetensors"),
            "interrupted": ("metrics/chunk-00000.parquet", "paths.parquet", "learned.safetensors"),
        }.items() for name in names),
        ("played", "policies.safetensors", read_played),
        *(("game", name, read_result) for name in ("policies.safetensors", "learned.safetensors")),
        *(("saved", name, read_result) for name in ("history.parquet", "result.safetensors")),
    ],
    "earlier": [("earlier", name, read_run) for name in ("metrics/chunk-00000.parquet", "paths.parquet")],
}  # fmt: skip
"""Kind of folder, file to damage, reader."""


def damaged_json(content: bytes, chance: random.Random) -> bytes:
    """With one or a few values or keys changed, or as damaged bytes."""
    if chance.random() < 0.3:
        return damaged_bytes(content, chance)
    value = json.loads(content)
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        value = _changed(value, chance)
    text = json.dumps(value).encode()
    if chance.random() < 0.1:
        # Numbers that no writer of JSON would write.
        places = [place for place, byte in enumerate(text) if byte in b"0123456789"]
        if places:
            place = chance.choice(places)
            text = text[:place] + chance.choice(TEXTS) + text[place + 1 :]
    return text


def _changed(value: Any, chance: random.Random) -> Any:
    places = list(_places(value))
    if not places:
        return copy.deepcopy(chance.choice(VALUES))
    holder, key = chance.choice(places)
    what = chance.randrange(6)
    if what == 0:
        del holder[key]
    elif what == 1 and isinstance(holder, list):
        holder.append(holder[key])
    elif what == 2 and isinstance(holder, dict):
        holder[str(chance.choice(VALUES))[:20]] = holder.pop(key)
    elif what == 3:
        other, other_key = chance.choice(places)
        holder[key] = json.loads(
            json.dumps(other.get(other_key) if isinstance(other, dict) else other[other_key : other_key + 1])
        )
    elif what == 4 and isinstance(holder[key], int | float):
        holder[key] = holder[key] * chance.choice((-1, 2, 1e50, 1e308)) + chance.choice((0, 1, 0.5))
    else:
        holder[key] = copy.deepcopy(chance.choice(VALUES))
    return value


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from _places(value[key])


def damaged_binary(content: bytes, chance: random.Random) -> bytes:
    """With values, types, columns, rows or names changed, as damaged bytes, or both."""
    if content.startswith(b"PAR1"):
        return _changed_table(content, chance)
    if chance.random() < 0.4:
        return damaged_bytes(content, chance)
    content = _changed_arrays(content, chance)
    return damaged_bytes(content, chance) if chance.random() < 0.3 else content


def _changed_table(content: bytes, chance: random.Random) -> bytes:
    table = polars.read_parquet(content)
    name = chance.choice(table.columns)
    match chance.randrange(8):
        case 0:
            table = table.drop(name)
        case 1:
            kind = chance.choice(
                (polars.Float32, polars.Float64, polars.Int8, polars.String, polars.Boolean, polars.UInt64)
            )
            table = table.with_columns(polars.col(name).cast(kind, strict=False))
        case 2:
            table = table.filter(polars.int_range(polars.len()) != chance.randrange(len(table)))
        case 3:
            table = polars.concat([table, table.slice(chance.randrange(len(table)), 1)])
        case 4:
            table = table.rename({name: str(chance.choice(VALUES))[:20].encode(errors="replace").decode()})
        case 5:
            table = table.clear() if chance.random() < 0.3 else table.sample(fraction=1.0, shuffle=True, seed=1)
        case _:
            value = chance.choice((float("nan"), float("inf"), -1e99, 1e300, None, 0, -1, 10**9, 2**62))
            here = polars.int_range(polars.len()) == chance.randrange(len(table))
            changed = polars.when(here).then(polars.lit(value)).otherwise(polars.col(name))
            table = table.with_columns(changed.alias(name))
    stream = io.BytesIO()
    table.write_parquet(stream, metadata={NAME: PLACE}, compression=chance.choice(("zstd", "uncompressed")))
    return stream.getvalue()


def _changed_arrays(content: bytes, chance: random.Random) -> bytes:
    arrays, metadata = (
        safetensors.numpy.load(content),
        json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")]),
    )
    metadata = metadata["__metadata__"] | {NAME: PLACE}
    name = chance.choice(list(arrays))
    match chance.randrange(7):
        case 0:
            del arrays[name]
        case 1:
            arrays[name] = arrays[name].astype(chance.choice((np.float32, np.int64, np.bool_, np.float16, np.uint8)))
        case 2:
            arrays[name] = arrays[name][chance.choice((slice(1), slice(0), slice(1, None)))]
        case 3:
            arrays[name] = np.array(chance.choice((0.0, 1.0, float("nan"))))
        case 4:
            arrays[str(chance.choice(VALUES))[:20].encode(errors="replace").decode()] = arrays.pop(name)
        case 5:
            key = chance.choice([*metadata, "more"])
            metadata[key] = chance.choice(("", "-1", "1e3", "99999999999999", "\u0661", PLACE))
        case _:
            if arrays[name].size:
                values = arrays[name].astype(arrays[name].dtype, copy=True)
                place = chance.randrange(values.size)
                values.flat[place] = chance.choice((np.nan, np.inf, 1e30, -1.0)) if values.dtype.kind == "f" else 1
                arrays[name] = values
    return safetensors.numpy.save(arrays, metadata=metadata)


def damaged_bytes(content: bytes, chance: random.Random) -> bytes:
    """With bytes flipped, cut out, doubled or put in; often near the end, where Parquet has its description."""
    data = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 8, 40))):
        place = chance.randrange(len(data) + 1)
        if chance.random() < 0.5:
            place = (
                max(0, len(data) - chance.randrange(600))
                if chance.random() < 0.5
                else min(len(data), chance.randrange(600))
            )
        length = chance.choice((1, 1, 4, 8, 100))
        what = chance.randrange(5)
        if what == 0:
            del data[place : place + length]
        elif what == 1:
            data[place:place] = data[place : place + length]
        elif what == 2:
            data[place : place + length] = chance.randbytes(length)
        elif what == 3:
            data[place : place + 8] = chance.choice(
                (b"\xff" * 8, b"\x00" * 8, b"\x00" * 6 + b"\xf8\x7f", b"\xff" * 7 + b"\x7f")
            )
        elif place < len(data):
            data[place] ^= 1 << chance.randrange(8)
    return bytes(data)


DAMAGES = {"json": damaged_json, "binary": damaged_binary, "earlier": damaged_bytes}


@contextmanager
def _in_time() -> Iterator[None]:
    def late(*_: object) -> None:
        raise AssertionError(f"took more than {PATIENCE} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def fuzz(kind: str, inputs: int, seed: int, folder: Path) -> Counter[str]:
    """Try damaged files of a kind, as `TARGETS` names them; returns how many of each were refused, and taken.

    Raises:
        AssertionError: one was taken though its checksum is wrong, or held NaN, or took long or much; or whatever it
            raised that is no `InputError`. The file is left in `folder`.
    """
    folders, counts = make_folders(folder), Counter[str]()
    sound = {each: (folders[each[0]] / each[1]).read_bytes() for each in ((a, b) for a, b, _ in TARGETS[kind])}
    for which, _, reader in TARGETS[kind]:
        reader(folders[which])
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for number in range(inputs):
        chance = random.Random(f"{seed} {number}")
        which, name, reader = chance.choice(TARGETS[kind])
        content = sound[which, name]
        damaged = DAMAGES[kind](content, chance)
        again = chance.random() < RESEALED
        damaged = resealed(damaged) if again else damaged
        path, tried = folders[which] / name, f"input {number} of seed {seed}, {which}/{name}"
        path.write_bytes(damaged)
        refusal, told = None, list[warnings.WarningMessage]()
        try:
            with warnings.catch_warnings(record=True) as told, _in_time():
                warnings.simplefilter("always")
                reader(folders[which])
        except InputError as error:
            refusal = str(error)
        except BaseException as error:
            raise AssertionError(f"{tried}: {error!r}") from error
        assert refusal is None or (refusal.isprintable() and len(refusal) < 1500), f"{tried}: {refusal}"
        # Without any checksum it is a folder of an earlier version, which is said.
        seen = again or damaged == content or b"gsiirl-sha256:" not in content or told
        assert refusal is not None or seen, f"{tried}: taken with a wrong checksum"
        counts[f"{which}/{name} {'taken' if refusal is None else 'refused'}"] += 1
        path.write_bytes(content)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - grown
    assert most < GROWTH, f"grew by {most} KiB"
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=list(TARGETS))
    parser.add_argument("--inputs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        counts = fuzz(given.kind, given.inputs, given.seed, Path(folder))
    for name, number in sorted(counts.items()):
        print(f"{number:8d} {name}")
    print(f"{given.inputs} inputs in {time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    main()
