"""Write the attack networks of NASim's benchmark scenarios, which the package holds, from NASim's own files.

    .venv/bin/python scripts/write_nasim_networks.py

NASim's simulator is not imported: importing it needs Tk, and sets Matplotlib's window backend for the whole process.
"""

import importlib.util
import json
from pathlib import Path

from gsiirl.scenarios.nasim import FOLDER
from gsiirl.scenarios.nasim_file import read_nasim


def benchmark_files() -> list[Path]:
    """The scenario files of the installed NASim."""
    package = importlib.util.find_spec("nasim")
    assert package is not None, "NASim is not installed: make setup"
    assert package.submodule_search_locations, "NASim has no folder"
    return sorted(Path(package.submodule_search_locations[0], "scenarios", "benchmark").glob("*.yaml"))


def text_of(file: Path) -> str:
    """A scenario's attack network as JSON, a line for each node and edge."""
    content = read_nasim(file).to_json_dict()
    lists = {
        name: "[\n    " + ",\n    ".join(json.dumps(each) for each in content[name]) + "\n  ]"
        for name in ("nodes", "edges")
    }
    fields = [f"{json.dumps(name)}: {lists.get(name, json.dumps(value))}" for name, value in content.items()]
    return "{\n  " + ",\n  ".join(fields) + "\n}\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for file in benchmark_files():
        (FOLDER / f"{file.stem}.json").write_text(text_of(file), encoding="utf-8")
        print(FOLDER / f"{file.stem}.json")
