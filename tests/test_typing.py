"""A type checker sees the library's classes as what they are."""

import json
import re
import subprocess
import sys
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"
SHOWN = """
reveal_type(gsiirl.GSIIRL)
reveal_type(gsiirl.RewardGSIIRL)
reveal_type(gsiirl.SimulatedExpert)
reveal_type(gsiirl.Bilevel)
reveal_type(gsiirl.load)
reveal_type(problem)
reveal_type(expert)
reveal_type(result)
reveal_type(result.policy)
reveal_type(told)
"""


def test_a_users_program_is_fully_typed(tmp_path: Path) -> None:
    [program] = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "program.py").write_text(program + SHOWN)
    command = [sys.executable, "-m", "basedpyright", "--outputjson", "--pythonpath", sys.executable, "program.py"]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    said = json.loads(ended.stdout)["generalDiagnostics"]
    assert [each["message"] for each in said if each["severity"] == "error"] == []
    types = [each["message"] for each in said if each["severity"] == "information"]
    assert len(types) == len(SHOWN.split())
    assert [each for each in types if re.search(r'is "(type\[)?(Any|Unknown)\b', each)] == []
