"""The conda recipe says what pyproject.toml says: version, Python, dependencies, command, licence."""

import re
import tomllib
from pathlib import Path

from proofmass.runner.host.versions import PROOFMASS

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
RECIPE = (ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8")
CONDA_NAMES = {"matplotlib": "matplotlib-base"}  # where conda-forge has another name for a package of PyPI


def items(key: str) -> list[str]:
    """Return the entries of the list below a key that stands alone in its line."""
    lists = re.findall(rf"^( *){key}:\n((?:\1  [-#] .+\n)+)", RECIPE, re.MULTILINE)
    assert len(lists) == 1, key
    return re.findall(r"^ *- (.+)", lists[0][1], re.MULTILINE)


def as_conda(requirement: str) -> list[str]:
    """Return what a requirement of PyPI is called in conda: a package, and one for each extra."""
    name, extra, bound = re.fullmatch(r"([\w-]+)(?:\[([\w-]+)\])?(>=[\w.]+)?", requirement).groups()  # type: ignore[union-attr]
    return [f"{CONDA_NAMES.get(name, name)} {bound}", *([extra] if extra else [])]


def test_it_needs_what_the_package_needs() -> None:
    """And what its extra `all` does: conda has no extras."""
    extras = PROJECT["project"]["optional-dependencies"]
    names = re.split(r"[\[\],]", extras["all"][0])[1:-1]
    requirements = [*PROJECT["project"]["dependencies"], *(each for name in names for each in extras[name])]
    needed = [package for requirement in requirements for package in as_conda(requirement)]
    assert items("run") == ["python >=${{ python_min }}", *needed]


def test_the_workers_of_a_study_are_bounded_alike() -> None:
    extra = PROJECT["project"]["optional-dependencies"]["dask"]
    assert items("run_constraints") == [package for requirement in extra for package in as_conda(requirement)]


def test_it_is_built_by_what_the_package_is_built_by() -> None:
    tools = [package for requirement in PROJECT["build-system"]["requires"] for package in as_conda(requirement)]
    assert items("host") == ["python ${{ python_min }}.*", "pip", *tools]


def test_version_python_licence_and_command_are_those_of_the_package() -> None:
    facts = dict(re.findall(r"^ *(version|python_min|license|license_file): \"?([^\"$\n]+)\"?$", RECIPE, re.MULTILINE))
    project = PROJECT["project"]
    assert facts["version"] == PROOFMASS
    assert f">={facts['python_min']}" == project["requires-python"]
    assert facts["license"] == project["license"]
    assert [facts["license_file"]] == project["license-files"]
    assert items("entry_points") == [f"{name} = {target}" for name, target in project["scripts"].items()]
