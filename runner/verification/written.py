"""Findings as a table for the terminal, as JUnit XML, and as one HTML file."""

import math
from collections.abc import Sequence
from html import escape
from pathlib import Path
from xml.etree import ElementTree

from proofmass.runner.output.counts import count
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.page import save_page, table
from proofmass.runner.output.text_table import text_table
from proofmass.runner.verification.verify import Finding

HEADS = ("", "id", "quantity", "value", "required", "unit", "text")
_NUMBERS = (3, 4)
_LONGEST = 60  # characters of a text in a terminal


def findings_text(findings: Sequence[Finding]) -> list[str]:
    """Return a line for each finding, and one that counts them."""
    rows = [_row(finding) for finding in findings]
    short = [(*row[:-1], row[-1] if len(row[-1]) <= _LONGEST else row[-1][: _LONGEST - 4] + " ...") for row in rows]
    lines = text_table([HEADS, *short], left=(0, 1, 2, 5, 6)) if rows else []
    return [*lines, "" if rows else "the graph has no requirements", *_reasons(findings), summary(findings)]


def summary(findings: Sequence[Finding]) -> str:
    """Return how many requirements are met."""
    missed = sum(not finding.met for finding in findings)
    return f"{count(len(findings), 'requirement')}, {missed} missed"


def save_junit(path: Path, name: str, findings: Sequence[Finding]) -> Path:
    """Write a test suite with a case for each finding."""
    missed = sum(not finding.met for finding in findings)
    suite = ElementTree.Element(
        "testsuite", name=_clean(name), tests=str(len(findings)), failures=str(missed), errors="0", skipped="0"
    )
    for finding in findings:
        case = ElementTree.SubElement(suite, "testcase", classname=_clean(finding.quantity), name=_clean(finding.id))
        if not finding.met:
            message = f"{finding.quantity} is {_number(finding)} {finding.unit}, required {_required(finding)}"
            message += f": {finding.reason}" if finding.reason else ""
            ElementTree.SubElement(case, "failure", message=_clean(message)).text = _clean(finding.text)
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    return write_whole(path, ElementTree.tostring(suites, encoding="utf-8", xml_declaration=True))


def save_findings_page(path: Path, name: str, findings: Sequence[Finding]) -> Path:
    """Write the findings as a page."""
    rows = map(_row, findings)
    opening = "".join(f"<p>{escape(line)}</p>" for line in (summary(findings), *_reasons(findings)))
    return save_page(path, name or "Requirements", opening, [("Requirements", table(HEADS, rows, _NUMBERS))], "")


def _reasons(findings: Sequence[Finding]) -> list[str]:
    told = [(f"{f.id} has no value" if math.isnan(f.value) else f.id, f.reason) for f in findings if f.reason]
    return [f"{subject}: {reason}" for subject, reason in told]


def _row(finding: Finding) -> tuple[str, ...]:
    mark = "met" if finding.met else "MISSED"
    return mark, finding.id, finding.quantity, _number(finding), _required(finding), finding.unit, finding.text


def _number(finding: Finding) -> str:
    return "no value" if math.isnan(finding.value) else f"{finding.value:.9g}"


def _required(finding: Finding) -> str:
    low, high = finding.at_least, finding.at_most
    if math.isinf(low) and low < 0.0:
        return f"<= {high:.9g}"
    return f">= {low:.9g}" if math.isinf(high) and low != high else f"{low:.9g} to {high:.9g}"


def _clean(text: str) -> str:
    """Text without the control characters that XML has no way to write."""
    return "".join(c if c.isprintable() else " " for c in text)
