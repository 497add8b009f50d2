"""The line on skipped tests: alone at the end, with and without processes beside each other."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.skips import skips_told

ROOT = Path(__file__).parents[1]
TESTS = """\
import pytest

@pytest.mark.skipif(True, reason="Icarus Verilog is not installed")
@pytest.mark.parametrize("number", range(3))
def test_simulated(number): ...

def test_what_is_there(): ...

def test_of_a_part(): pytest.skip("this processor could not fuse")
"""
WHOLE = 'import pytest\npytest.importorskip("slycot_that_is_not_there")\ndef test_nothing(): ...\n'


@pytest.mark.exhaustive("2")
@pytest.mark.parametrize("processes", [0, 2])
def test_the_last_line_says_what_was_skipped_and_how_to_have_it(processes: int, tmp_path: Path) -> None:
    (tmp_path / "test_some.py").write_text(TESTS)
    (tmp_path / "test_whole.py").write_text(WHOLE)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    environment = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # or each process imports every plugin
    options = [
        "-p",
        "xdist.plugin",
        "-p",
        "tests.skips",
        "-p",
        "no:cacheprovider",
        *(["-n", str(processes)] if processes else []),
    ]
    command = [sys.executable, "-m", "pytest", *options, "--rootdir", str(tmp_path), "-c", str(tmp_path / "pytest.ini")]
    ran = subprocess.run(
        [*command, str(tmp_path)], cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.splitlines()[-1] == (
        "skipped: 3 for want of Icarus Verilog (apt-get install iverilog), "
        "1 because this processor could not fuse, 1 for want of slycot (pip install slycot)"
    )


def test_nothing_is_said_where_nothing_was_skipped() -> None:
    assert skips_told([]) == ""
