"""What the pages under docs/how-to print is what their programs print."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[1] / "docs" / "how-to" / "own-continuous-game.md"


@pytest.mark.slow
def test_the_program_of_a_continuous_game_of_ones_own_finds_what_the_cat_wants():
    [program] = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    printed = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    assert "the cat likes best to be at (0.50, 0.50)" in printed
    [real, known] = re.findall(r"robot (-?\d+\.\d+), cat (-?\d+\.\d+)", printed)
    assert float(real[0]) == pytest.approx(float(known[0]), rel=0.05)
