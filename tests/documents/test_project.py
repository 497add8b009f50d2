"""What the project says about itself agrees: version, licence, authors."""

import re
import tomllib
from pathlib import Path

from proofmass.runner.host.versions import PROOFMASS

ROOT = Path(__file__).parents[2]


def test_the_citation_agrees_with_the_package() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    facts = dict(re.findall(r"^(\w[\w-]*): (.+)$", citation, re.MULTILINE))
    assert facts["version"] == PROOFMASS
    assert facts["license"] == project["license"]
    assert re.findall(r"^  - name: \"(.+)\"$", citation, re.MULTILINE) == [x["name"] for x in project["authors"]]


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
