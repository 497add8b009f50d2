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


def requirements(extra: str) -> list[str]:
    """Return what an extra asks for, with the extras of the package that it names; nothing where there is none."""
    texts = PROJECT["project"]["optional-dependencies"].get(extra, [])
    own = [re.fullmatch(r"proofmass\[(.+)\]", text) for text in texts]
    named = [name for match in own if match for name in match[1].split(",")]
    return [
        *(text for text, match in zip(texts, own, strict=True) if not match),
        *(text for name in named for text in requirements(name)),
    ]


def test_it_needs_what_the_package_needs_with_its_extra_all() -> None:
    """Conda has no extras, so its package is the whole one."""
    texts = [*PROJECT["project"]["dependencies"], *requirements("all")]
    needed = [package for text in texts for package in as_conda(text)]
    assert items("run")[0] == "python >=${{ python_min }}"
    assert sorted(items("run")[1:]) == sorted(needed)


def test_the_workers_of_a_study_are_bounded_alike() -> None:
    assert items("run_constraints") == [package for text in requirements("dask") for package in as_conda(text)]


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
