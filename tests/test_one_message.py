"""One message per test of a process of xdist: nothing that went wrong is lost."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
TESTS = """\
import pytest

@pytest.fixture
def broken(): raise ValueError("set-up")

@pytest.fixture
def broken_at_its_end():
    yield
    raise ValueError("end")

@pytest.fixture
def absent(): pytest.skip("absent")

def test_well(): ...
def test_wrong(): assert False
def test_not_set_up(broken): ...
def test_ends_badly(broken_at_its_end): ...
def test_wrong_and_ends_badly(broken_at_its_end): assert False
def test_without(absent): ...
"""


def test_what_went_wrong_is_told(tmp_path: Path) -> None:
    (tmp_path / "test_some.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    environment = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # or each process imports every plugin
    plugins = ["-p", "xdist.plugin", "-p", "tests.one_message", "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *plugins, "-n", "1", "-c", str(tmp_path / "pytest.ini"), str(tmp_path)]
    ran = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    *_, last = ran.stdout.splitlines()
    told = re.findall(r"^(FAILED|ERROR) \S+::(\w+)", ran.stdout, re.MULTILINE)
    assert sorted(told) == [
        ("ERROR", "test_ends_badly"),
        ("ERROR", "test_not_set_up"),
        ("ERROR", "test_wrong_and_ends_badly"),
        ("FAILED", "test_wrong"),
        ("FAILED", "test_wrong_and_ends_badly"),
    ]
    assert "2 failed, 2 passed, 1 skipped, 3 errors" in last
