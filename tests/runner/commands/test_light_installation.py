"""A plain installation does the three jobs, and all else says which extra brings it."""

import ast
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import proofmass
from proofmass.blocks.declaration.libraries import LIBRARIES, MissingLibraryError, cure, installed, need, told
from proofmass.blocks.declaration.problem import ModelError

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DISTRIBUTIONS = {"flint": "python-flint", "h5py": "h5netcdf", "pandas": "xarray"}  # of libraries that have another name

WITHOUT = """
import contextlib, io, json, sys
from pathlib import Path
for library in {libraries!r}:
    sys.modules[library] = None  # as if it were not installed
from proofmass.runner.command_line import main
answers = {{}}
for words in {commands!r}:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(words)
    answers[" ".join(words)] = code, out.getvalue(), err.getvalue()
print(json.dumps(answers))
"""
BEHIND = ("write_figure", "_draw_vector", "_built")  # functions that another calls, which asks
LOOP = "library:closed_loop_accelerometer"
STUDY = "library:self_test_population"


def light(commands: list[list[str]], folder: Path) -> dict[str, tuple[int, str, str]]:
    """Exit code, output and errors of commands in a process without any of the libraries."""
    script = WITHOUT.format(libraries=sorted(LIBRARIES), commands=commands)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    answers: dict[str, tuple[int, str, str]] = json.loads(done.stdout)
    return answers


@pytest.mark.exhaustive
@pytest.mark.friendly(1, "without extras there are runs, studies and margins")
def test_it_declares_runs_studies_and_finds_margins(tmp_path: Path) -> None:
    commands = [
        ["new", "sensor.toml"],
        ["check", "sensor.toml"],
        ["check", "library:imu_3dof"],
        ["draw", LOOP, "-o", "loop.svg"],
        ["blocks", "MassSpringDamper"],
        ["run", "sensor.toml", "--samples", "300"],
        ["run", LOOP, "--samples", "300", "--engine", "compiled", "--out", "results", "--format", "csv"],
        ["run", "sensor.toml", "--out", "plain"],
        ["run", "library:recorded_motion", "--samples", "50"],
        ["margins", LOOP],
        ["montecarlo", STUDY, "--runs", "3"],
    ]
    for command, (code, _, err) in light(commands, tmp_path).items():
        assert code == 0, (command, err)
    assert (tmp_path / "plain" / "traces.csv").exists()
    names = {path.name for path in (tmp_path / "results").iterdir()}
    assert names == {"traces.csv", "plot.svg", "summary.json", "report.html"}


@pytest.mark.exhaustive
@pytest.mark.friendly(1, "what needs an extra names it before it runs")
def test_what_needs_more_says_which_extra_brings_it_before_it_runs(tmp_path: Path) -> None:
    cures = {
        ("run", LOOP, "--samples", "1000000000000", "--out", "a", "--format", "netcdf"): "netcdf",
        ("run", LOOP, "--samples", "1000000000000", "--out", "b", "--format", "parquet"): "parquet",
        ("montecarlo", STUDY, "--out", "c", "--format", "parquet"): "parquet",
    }
    answers = light([list(words) for words in cures], tmp_path)
    for words, extra in cures.items():
        code, _, err = answers[" ".join(words)]
        assert code == 1, (words, err)
        assert f'hint:     pip install "proofmass[{extra}]"' in err, words
        assert " is not installed: it makes " in err
    assert not (tmp_path / "a").exists()


@pytest.mark.exhaustive
def test_public_names_and_methods_say_it_too(monkeypatch: pytest.MonkeyPatch) -> None:
    script = (
        "import sys; sys.modules['h5netcdf'] = None\n"
        "try:\n    import proofmass.runner.output.export as export; export.need('h5netcdf')\n"
        "except ImportError as error:\n    print(type(error).__name__, error)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("MissingLibraryError h5netcdf is not installed: it makes netCDF files")
    assert 'pip install "proofmass[netcdf]"' in done.stdout
    graph = proofmass.Graph(name="one", rate=1000, blocks={"ramp": proofmass.blocks.Ramp()}, probes=["ramp.output"])
    result = proofmass.simulate(graph, samples=3)
    for library, ask in (("xarray", result.to_xarray), ("pandas", result.to_pandas)):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(MissingLibraryError) as caught:
            ask()
        assert isinstance(caught.value, ModelError)
        assert caught.value.problems[0].hint == cure(library)


def test_every_missing_library_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    for library in ("xarray", "h5netcdf"):
        monkeypatch.setitem(sys.modules, library, None)
    assert not installed("xarray")
    with pytest.raises(MissingLibraryError) as caught:
        need("numpy", "xarray", "h5netcdf")
    assert [problem.hint for problem in caught.value.problems] == [cure("xarray"), cure("h5netcdf")]


def test_an_import_that_fails_for_another_reason_stays_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(ModuleNotFoundError("no", name="elsewhere.inner")) is None
    assert told(ImportError("cannot import name", name="numpy")) is None
    monkeypatch.setitem(sys.modules, "xarray", None)
    found = told(ModuleNotFoundError("no", name="xarray.core"))
    assert found is not None
    assert found.problems[0].hint == 'pip install "proofmass[xarray]"'


def test_the_table_is_that_of_the_package() -> None:
    extras = PROJECT["optional-dependencies"]
    for library, (extra, _) in LIBRARIES.items():
        names = [re.split(r"[\[><=]", line)[0] for line in extras[extra]]
        assert DISTRIBUTIONS.get(library, library) in names, library
    needed = {re.split(r"[\[><=]", line)[0] for line in PROJECT["dependencies"]}
    analyses = {"control", "networkx", "python-flint", "scipy", "threadpoolctl"}
    assert needed == {"click", "llvmlite", "matplotlib", "numpy"} | analyses
    (every,) = extras["all"]
    assert set(re.split(r"[\[\],]", every)[1:-1]) == {extra for extra, _ in LIBRARIES.values()} - {"dask", "rtl"}


def test_whoever_imports_one_within_a_function_asks_for_it() -> None:
    forgotten = []
    for file in [path for room in ("graphs", "runner") for path in (ROOT / room).rglob("*.py")]:
        text = file.read_text(encoding="utf-8")
        if not any(name in text for name in LIBRARIES):
            continue
        for function in ast.walk(ast.parse(text)):
            if isinstance(function, ast.FunctionDef):
                wanted = set[str]()
                asked = "one that calls it" if function.name in BEHIND else ""
                for node in ast.walk(function):
                    if isinstance(node, ast.Import | ast.ImportFrom):
                        names = [a.name for a in node.names] if isinstance(node, ast.Import) else [node.module or ""]
                        wanted |= {name.partition(".")[0] for name in names} & (LIBRARIES.keys() - {"distributed"})
                    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "need":
                        asked += ast.unparse(node)
                if wanted and not asked:
                    forgotten.append(f"{file.relative_to(ROOT)}: {function.name}: {sorted(wanted)}")
    assert not forgotten
