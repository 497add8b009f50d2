"""The workflow that others see runs what `.ci/run` runs, on every Python that the package claims."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
WORKFLOW = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")


def test_it_runs_the_commands_of_ci_run() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert re.findall(r"^ *- run: (make .+)$", WORKFLOW, re.MULTILINE) == re.findall(r"^make .+$", script, re.MULTILINE)


def test_it_runs_on_every_python_that_the_package_names() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    claimed = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', project)
    matrix = re.search(r"^ *python: \[(.+)\]$", WORKFLOW, re.MULTILINE)
    assert matrix is not None
    assert re.findall(r"3\.\d+", matrix[1]) == claimed
