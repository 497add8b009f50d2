"""The built wheel: only `proofmass/` inside, and it works in a fresh environment where nothing else is in reach."""

import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from fnmatch import fnmatch
from pathlib import Path

import pytest

from tests.documents.test_readme import GRAPH, PYTHON

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    keep_out = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info", "__pycache__", "demo")
    shutil.copytree(ROOT, folder / "source", symlinks=True, ignore=keep_out)
    source = str(folder / "source")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), source]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    return next(folder.glob("*.whl"))


ROOMS = ("blocks", "graphs", "runner")
NOT_SHIPPED = {"tsconfig.json", "vendored.d.ts"}  # types of scripts, for those who change them


def test_each_file_is_among_what_a_wheel_packs() -> None:
    """What the wheel has, from the words of its description alone: to make one takes ten seconds."""
    described = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    assert described["package-dir"] == {"": "src"}
    assert described["packages"] == {"find": {"where": ["src"]}}
    assert [path.name for path in (ROOT / "src").iterdir() if not path.name.endswith(".egg-info")] == ["proofmass"]
    files = [path for room in ROOMS for path in (ROOT / room).rglob("*") if path.is_file()]
    files = [path.relative_to(ROOT) for path in files if path.parent.name != "__pycache__"]
    assert all(part.isidentifier() for file in files for part in file.parts[:-1]), "a folder that is no package"
    patterns = ("*.py", *described["package-data"]["*"])
    left = {file.name for file in files if not any(fnmatch(file.name, pattern) for pattern in patterns)}
    assert left == NOT_SHIPPED


@pytest.mark.exhaustive
def test_wheel_holds_only_proofmass(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info/" not in name} == {"proofmass"}
    for expected in ("blocks/signals/gain.py", "graphs/model/graph.py", "runner/run/simulate.py", "py.typed"):
        assert f"proofmass/{expected}" in names
    library = sorted(path.name for path in (ROOT / "graphs" / "library").rglob("*") if path.suffix in (".toml", ".csv"))
    assert sorted(name.split("/")[-1] for name in names if "/library/" in name and not name.endswith(".py")) == library


@pytest.mark.exhaustive
def test_every_python_file_is_in_the_wheel(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    files = [path.relative_to(ROOT) for top in ("blocks", "graphs", "runner") for path in (ROOT / top).rglob("*.py")]
    assert {f"proofmass/{file}" for file in files} <= names
    assert {"proofmass/__init__.pyi", "proofmass/blocks/__init__.pyi"} <= names


@pytest.mark.parametrize("name", ROOMS)
def test_links_for_type_checkers_point_at_the_folders(name: str) -> None:
    link = ROOT / "src" / "proofmass" / name
    assert link.is_symlink()
    assert link.resolve() == ROOT / name


@pytest.mark.exhaustive
@pytest.mark.friendly(1, "a wheel in an empty environment runs the README")
def test_a_fresh_environment_runs_the_readme(wheel: Path, tmp_path: Path) -> None:
    """Only the dependencies come from this environment; a file `runner.py` and a folder `graphs` are in the way."""
    venv.create(tmp_path / "environment", symlinks=True)
    python = tmp_path / "environment" / "bin" / "python"
    install = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(python),
        "install",
        "--quiet",
        "--no-compile",
        "--no-deps",
        str(wheel),
    ]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run(install, check=True, timeout=300, env=environment)
    packages = next((tmp_path / "environment" / "lib").glob("python*/site-packages"))
    (packages / "dependencies.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
    work = tmp_path / "work"
    (work / "graphs").mkdir(parents=True)
    (work / "runner.py").write_text("raise SystemExit('the wrong runner')\n")
    (work / "accelerometer.toml").write_text(GRAPH)
    (work / "example.py").write_text(PYTHON[0] + "\nimport proofmass\nprint(proofmass.__file__)\n")
    done = subprocess.run(
        [python, "example.py"], cwd=work, env=environment, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].startswith(str(packages))
    command = [tmp_path / "environment" / "bin" / "proofmass", "run", "accelerometer.toml", "--out", "results"]
    done = subprocess.run(command, cwd=work, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert (work / "results" / "report.html").exists()
