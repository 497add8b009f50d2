"""Files of own blocks that are none."""

from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks


def test_a_file_without_the_ending_of_python_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "own.txt"
    file.write_text("")
    with pytest.raises(ImportError, match=r"own\.txt is not a Python file"):
        load_own_blocks(file)
