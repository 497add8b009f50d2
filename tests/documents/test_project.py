"""What the project says about itself agrees: version, licence, authors."""

import re
import tomllib
from pathlib import Path

import pytest

from proofmass.graphs.model.build import Graph
from proofmass.runner.host.versions import PROOFMASS
from proofmass.runner.run.provenance import provenance

ROOT = Path(__file__).parents[2]
KINDS_OF_CHANGE = ["Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"]  # in the order of Keep a Changelog


def test_the_citation_agrees_with_the_package() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    facts = dict(re.findall(r"^(\w[\w-]*): (.+)$", citation, re.MULTILINE))
    assert facts["version"] == PROOFMASS
    assert facts["license"] == project["license"]
    assert re.findall(r"^  - name: \"(.+)\"$", citation, re.MULTILINE) == [x["name"] for x in project["authors"]]


def test_the_changelog_names_this_version_and_each_kind_of_change_once() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## (\d+\.\d+\.\d+), (?:unreleased|\d{4}-\d\d-\d\d)$", text, re.MULTILINE)
    assert versions[0] == PROOFMASS
    assert len(versions) == len(re.findall(r"^## ", text, re.MULTILINE))
    for entry in text.split("\n## ")[1:]:
        kinds = re.findall(r"^### (.+)$", entry, re.MULTILINE)
        assert kinds == [kind for kind in KINDS_OF_CHANGE if kind in kinds]


@pytest.mark.friendly(26, "the version of the code stands in a result")
def test_a_result_states_the_version_of_the_code_that_ran() -> None:
    assert provenance(Graph(name="empty", rate="1 Hz", blocks={}), "python")["proofmass"] == PROOFMASS


def test_every_extra_says_what_each_dependency_is_for() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    section = text.partition("[project.optional-dependencies]\n")[2].partition("\n[")[0]
    lines = [line for line in section.splitlines() if line.startswith('    "') and "proofmass[" not in line]
    assert lines
    assert [line for line in lines if "# " not in line] == []


def test_issue_templates_ask_for_what_is_needed() -> None:
    folder = ROOT / ".github" / "ISSUE_TEMPLATE"
    for template in folder.glob("*.md"):
        assert re.match(r"---\nname: .+\nabout: .+\nlabels: \w+\n---\n", template.read_text(encoding="utf-8")), template
