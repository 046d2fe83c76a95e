"""What stands at a path is known, or it is an error that it cannot be."""

import errno
from pathlib import Path

import pytest

from gsiirl.program.presence import is_file, is_folder, is_there


def test_files_folders_and_nothing_are_told_apart(tmp_path: Path) -> None:
    file, loop = tmp_path / "file", tmp_path / "loop"
    file.write_text("")
    loop.symlink_to(loop)
    for path, expected in (
        (file, (True, False, True)),
        (tmp_path, (True, True, False)),
        (tmp_path / "none", (False, False, False)),
        (file / "below", (False, False, False)),
        (loop, (False, False, False)),
        (Path("a\0b"), (False, False, False)),
    ):
        assert (is_there(path), is_folder(path), is_file(path)) == expected


@pytest.mark.parametrize("asked", [is_there, is_folder, is_file])
def test_a_name_that_cannot_be_looked_up_is_an_error(asked) -> None:
    with pytest.raises(OSError, match="too long") as refused:
        asked(Path("x" * 300))
    assert refused.value.errno == errno.ENAMETOOLONG
