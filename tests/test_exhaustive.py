"""Exhaustive tests: left out unless they are asked for, and counted in the last line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TESTS = """\
import pytest

@pytest.mark.exhaustive
@pytest.mark.parametrize("number", range(3))
def test_every_vector(number): ...

@pytest.mark.parametrize("number", [1, pytest.param(2, marks=pytest.mark.exhaustive)])
def test_a_sample(number): ...

@pytest.mark.exhaustive("noise", "worst")
@pytest.mark.parametrize("command", ["noise-1", "noise-2", "run"])
def test_by_their_names(command): ...

@pytest.mark.exhaustive(but=2)
@pytest.mark.parametrize("letter", ["a", "b", "c", "d"])
def test_evenly_spaced(letter): ...
"""


@pytest.mark.exhaustive(
    "options1-1-left out: 4 exhaustive (make test-all)",
    "options1-4-left out: 8 exhaustive (make test-all)",
    "options0-4-left out: 8 exhaustive (make test-all)",
)
@pytest.mark.parametrize(
    ("options", "passed", "last"),
    [
        ([], 4, "left out: 8 exhaustive (make test-all)"),
        (["-n", "2"], 4, "left out: 8 exhaustive (make test-all)"),
        (["--exhaustive"], 12, "12 passed"),
        (["--exhaustive", "-m", "exhaustive"], 11, "11 passed"),
    ],
)
def test_they_run_where_they_are_asked_for(options: list[str], passed: int, last: str, tmp_path: Path) -> None:
    (tmp_path / "test_some.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = exhaustive\n")
    plugins = ["-p", "xdist.plugin", "-p", "tests.exhaustive", "-p", "no:cacheprovider"]
    environment = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # or each process imports every plugin
    command = [sys.executable, "-m", "pytest", *plugins, *options, "-c", str(tmp_path / "pytest.ini"), str(tmp_path)]
    ran = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert f"{passed} passed" in ran.stdout
    assert last in ran.stdout.splitlines()[-1]
