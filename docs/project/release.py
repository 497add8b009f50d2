"""Try a release: `python -m docs.project.release` builds the wheel and follows the tutorial on each installed Python.

Each Python gets an environment with nothing but the wheel and what pip installs with it, and an empty folder. There the
files of the tutorial are written and its commands typed, one process each. The table has the seconds that pip took, the
seconds from then on to the first report of one's own sensor, and how many commands answered as their page says.
Further interpreters are named as arguments.
"""

import contextlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from docs.site.pictures import STEPS
from docs.site.play import missing_lines, play

ROOT = Path(__file__).parents[2]
NEXT = "3.15"  # tried if it is there, though pyproject.toml does not name it yet
REPORT = Path("results", "report.html")


class Trial(NamedTuple):
    """What one Python did with the wheel; times in seconds."""

    version: str
    install: float
    report: float
    commands: int
    failures: tuple[str, ...]


def versions() -> list[str]:
    """Return the versions of Python that the package names, and the next one."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [re.search(r":: (3\.\d+)$", line) for line in project["classifiers"]]
    return [*(version[1] for version in named if version), NEXT]


def interpreters() -> Iterator[tuple[str, str]]:
    """Yield version and command of each of these Pythons that starts; an empty command where none does."""
    for version in versions():
        command = shutil.which(f"python{version}")
        works = command and not subprocess.run([command, "-c", ""], capture_output=True, check=False).returncode
        yield version, command if command and works else ""


def numbered(python: str) -> str:
    """Return the version of an interpreter, such as 3.12."""
    ask = [python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
    return subprocess.run(ask, check=True, capture_output=True, text=True).stdout.strip()


def build(folder: Path) -> Path:
    """Build the wheel and the archive of the source, check them, and return the wheel."""
    subprocess.run([sys.executable, "-m", "build", "--outdir", str(folder), str(ROOT)], check=True, capture_output=True)
    check = [sys.executable, "-m", "twine", "check", "--strict", *map(str, folder.iterdir())]
    done = subprocess.run(check, capture_output=True, text=True, check=False)
    print(done.stdout or "twine is not installed: descriptions are not checked")
    return next(folder.glob("*.whl"))


def try_wheel(version: str, python: str, wheel: Path, folder: Path) -> Trial:
    """Install a wheel into an environment of its own and follow the tutorial in an empty folder."""
    environment, work = folder / "environment", folder / "work"
    begin = time.perf_counter()
    subprocess.run([python, "-m", "venv", str(environment)], check=True, env=clean())
    subprocess.run(
        [environment / "bin" / "python", "-m", "pip", "install", "--quiet", f"{wheel}[all]"],
        check=True,
        env=clean(),
        stderr=subprocess.DEVNULL,
    )
    installed = time.perf_counter()
    work.mkdir()
    report, count, failures = 0.0, 0, []
    with contextlib.chdir(work):
        for step in STEPS:
            for command in play(step, partial(typed, environment / "bin")):
                count += 1
                if not report and REPORT.exists():
                    report = time.perf_counter() - installed
                if command.status != command.expected_status or missing_lines(command.output, command.promised):
                    failures.append(f"{step.name}: {command.text}\n{command.output}")
    return Trial(version, installed - begin, report, count, tuple(failures))


def typed(programs: Path, words: list[str]) -> tuple[int, str]:
    """Run the command `proofmass` of an environment; return exit code and output."""
    environment = clean() | {
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PROOFMASS_CACHE": str(programs / "cache"),
    }
    command = [str(programs / "proofmass"), *words]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    done = subprocess.run(command, env=environment, text=True, check=False, **streams)  # type: ignore[call-overload]
    return done.returncode, done.stdout


def clean() -> dict[str, str]:
    """Return the environment without the modules of the one who asks: nothing but the wheel may answer."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def main() -> int:
    """Print a row for each Python; return 1 if a command failed."""
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        wheel = build(Path(folder))
        print("Python  install  report  commands")
        for version, python in [*interpreters(), *((numbered(path), path) for path in sys.argv[1:])]:
            if not python:
                print(f"{version:7} not installed")
                continue
            with tempfile.TemporaryDirectory() as own:
                trial = try_wheel(version, python, wheel, Path(own))
            right = trial.commands - len(trial.failures)
            print(f"{version:7} {trial.install:6.1f}s {trial.report:6.1f}s  {right} of {trial.commands}", flush=True)
            print(*trial.failures, sep="\n", end="")
            failed |= bool(trial.failures)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
