"""Imports run one way, and what needs no JAX loads none."""

import ast
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

import gsiirl

PACKAGE = Path(gsiirl.__file__).parent
OFFICE = Path(__file__).parents[1] / "examples" / "office.json"

LEARNERS = {"interaction", "learners", "experts"}

LAYERS = [
    {"types", "arguments"},
    {"games", "rewards"},
    {"equilibria"},
    {"demonstrations", "irl", "misfit", "problems"},
    {"commitment"},
    LEARNERS,
    {"baselines", "evaluation"},
    {"front_door"},
    {"theory"},
    {"experiments"},
    {"finished"},
    {"pettingzoo"},
    {"cli"},
    {"__main__"},
]
"""Lowest first: a part imports its own layer and those below it."""

STANDALONE = {"hypergradients", "scenarios", "adapters", "runs", "report"}
"""Parts that import none of the layers."""

READERS = {
    "hypergradients": {"learners", "theory", "experiments"},
    "scenarios": {"games", "rewards", "theory", "experiments", "pettingzoo", "cli"},
    "adapters": {"experiments", "pettingzoo", "cli"},
    "runs": {"front_door", "report", "theory", "experiments", "pettingzoo", "finished", "cli"},
    "report": {"finished", "cli"},
}
"""Who may import a standalone part."""

COMMANDS = {
    "gsiirl.experiments.commands",
    "gsiirl.experiments.network_commands",
    "gsiirl.experiments.plans.commands",
    "gsiirl.theory.commands",
}
"""The command line's, wherever they stand: they may import what `cli` may."""

DOORS = {"gsiirl.problems"}
"""Names for users, which lead to where they are made when they are first used."""

SIBLINGS = [
    LEARNERS | {"front_door"},
    {"baselines"},
    {"evaluation"},
]
"""Learners, what they are compared with, and how they are judged: none of these imports another."""

FRONT_DOOR = {("front_door", "evaluation")}
"""A result is judged by `result.evaluate`, so that a user needs no other import."""

EVERYWHERE = {"compilation", "errors", "limits", "program", "program_cache", "_version"}

WITHOUT_JAX = {
    "program",
    "program_cache",
    "__init__",
    "__main__",
    "_version",
    "adapters",
    "cli",
    "errors",
    "finished",
    "limits",
    "report",
    "runs",
    "scenarios",
}
WITHOUT_JAX_MODULES = {
    "gsiirl.experiments",
    "gsiirl.experiments.plans.ablation",
    "gsiirl.experiments.commands",
    "gsiirl.experiments.config",
    "gsiirl.experiments.continuous.config",
    "gsiirl.experiments.crossing.config",
    "gsiirl.experiments.deception.config",
    "gsiirl.experiments.evaluate",
    "gsiirl.experiments.game.config",
    "gsiirl.experiments.network_commands",
    "gsiirl.experiments.deception.mpe2_evaluation",
    "gsiirl.experiments.plans",
    "gsiirl.experiments.plans.commands",
    "gsiirl.experiments.plans.plan",
    "gsiirl.experiments.plans.planned_run",
    "gsiirl.experiments.plans.reproduce",
    "gsiirl.experiments.plans.sweep",
    "gsiirl.experiments.security.changes",
    "gsiirl.experiments.security.config",
    "gsiirl.experiments.security.cost",
    "gsiirl.experiments.security.network_check",
    "gsiirl.experiments.transfer.commands",
    "gsiirl.theory",
    "gsiirl.theory.commands",
    "gsiirl.theory.folder",
}


def modules() -> Iterator[tuple[str, Path]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


def part_of(module: str) -> str:
    """`games` for `gsiirl.games.payoff`, `__init__` for the package itself."""
    return module.split(".")[1] if "." in module else "__init__"


def imports(tree: ast.AST, module_level_only: bool = False) -> Iterator[str]:
    """Full names of what a module imports; `from a import b` counts as `a.b`."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif module_level_only and (isinstance(node, ast.FunctionDef | ast.Lambda) or is_type_checking(node)):
            continue
        else:
            yield from imports(node, module_level_only)


def is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")


def level(part: str) -> int | None:
    return next((index for index, layer in enumerate(LAYERS) if part in layer), None)


def is_allowed(importer: str, imported: str) -> bool:
    if imported in EVERYWHERE or importer == imported or importer == "__init__":
        return True
    family = next((each for each in SIBLINGS if importer in each), None)
    if family is not None and any(imported in each for each in SIBLINGS if each is not family):
        return (importer, imported) in FRONT_DOOR
    if imported in STANDALONE:
        return importer in READERS[imported]
    lower, upper = level(imported), level(importer)
    return lower is not None and upper is not None and lower <= upper


def test_no_folder_holds_more_than_twelve_modules_and_no_module_has_more_than_400_lines():
    folders = Counter(path.parent for path in PACKAGE.rglob("*.py"))
    assert {folder.name: number for folder, number in folders.items() if number > 12} == {}
    lines = {path.name: len(path.read_text().splitlines()) for path in PACKAGE.rglob("*.py")}
    assert {name: number for name, number in lines.items() if number > 400} == {}


@pytest.mark.parametrize(("module", "path"), list(modules()))
def test_imports_run_one_way(module: str, path: Path):
    part = part_of(module)
    assert part in EVERYWHERE | STANDALONE | {"__init__"} or level(part) is not None, f"{part} has no layer yet"
    own = [name for name in imports(ast.parse(path.read_text())) if name.startswith("gsiirl.")]
    importer = "cli" if module in COMMANDS else "__init__" if module in DOORS else part
    assert [name for name in own if not is_allowed(importer, part_of(name))] == []


@pytest.mark.parametrize(
    ("module", "path"),
    [(module, path) for module, path in modules() if part_of(module) in WITHOUT_JAX or module in WITHOUT_JAX_MODULES],
)
def test_no_jax_at_module_level(module: str, path: Path):
    needs_jax = {"jax", "jaxlib", "equinox", "optax", "jaxtyping"}
    used = {name.split(".")[0] for name in imports(ast.parse(path.read_text()), module_level_only=True)}
    assert used & needs_jax == set()


def test_a_forbidden_import_is_seen():
    assert not is_allowed("games", "irl")
    assert not is_allowed("report", "games")
    assert not is_allowed("theory", "report")
    assert not is_allowed("evaluation", "learners")
    assert not is_allowed("baselines", "learners")
    assert not is_allowed("learners", "evaluation")
    assert not is_allowed("equilibria", "scenarios")
    assert not is_allowed("experiments", "pettingzoo")
    assert not is_allowed("learners", "adapters")
    assert list(imports(ast.parse("def f():\n    from gsiirl.irl import memory"))) == ["gsiirl.irl.memory"]


@pytest.mark.parametrize(
    "code",
    [
        "import gsiirl, gsiirl.cli, gsiirl.scenarios, gsiirl.runs, gsiirl.report, gsiirl.experiments.config",
        "from gsiirl.cli import main; main(['--help'])",
        "from gsiirl.cli import main; main(['run', 'security', '--help'])",
        "from gsiirl.cli import main; main(['run', 'crossing', '--help'])",
        "from gsiirl.cli import main; main(['reproduce', '--help'])",
        "from gsiirl.cli import main; main(['list'])",
        f"from gsiirl.cli import main; main(['network', 'check', {str(OFFICE)!r}])",
        "from gsiirl.cli import main; main(['theory', '--help'])",
        "import gsiirl.experiments.deception.mpe2_evaluation",
    ],
)
def test_jax_is_not_loaded(code: str):
    check = "import sys; sys.exit('jax' in sys.modules)"
    finished = subprocess.run([sys.executable, "-c", f"{code}; {check}"], capture_output=True, text=True, check=False)
    assert (finished.returncode, finished.stderr) == (0, "")


@pytest.mark.parametrize("command", [["--help"], ["theory", "--help"], ["evaluate", "--help"], ["transfer", "--help"]])
def test_help_loads_nothing_heavy(command: list[str]):
    assert loaded_by(command, {"pydantic", "polars", "matplotlib", "networkx", "numpy"}) == ""


def test_help_on_a_run_loads_what_checks_its_settings_alone():
    assert loaded_by(["run", "security", "--help"], {"polars", "matplotlib", "networkx", "numpy"}) == ""


def loaded_by(command: list[str], modules: set[str]) -> str:
    """Which of the modules a command loads."""
    check = f"import sys; sys.exit(', '.join({modules} & {{*sys.modules}}))"
    code = f"from gsiirl.cli import main; main({command}); {check}"
    finished = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    return finished.stderr.strip()
