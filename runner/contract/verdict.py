"""Verdict of a check on a block."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from proofmass.blocks.declaration.problem import Problem

Status = Literal["passed", "FAILED", "not run"]


@dataclass(frozen=True)
class ContractVerdict:
    """One check of one block: what was looked at, or what is wrong."""

    check: str
    status: Status
    detail: str
    problems: tuple[Problem, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """The verdict as plain data, for `--json`."""
        problems = [problem.as_data() for problem in self.problems]
        return {"check": self.check, "status": self.status, "detail": self.detail, "problems": problems}


def verdict(check: str, problems: Iterator[Problem] | list[Problem], detail: str) -> ContractVerdict:
    """Return the verdict of a check that was run: it fails if there are problems."""
    found = tuple(problems)
    if not found:
        return ContractVerdict(check, "passed", detail)
    return ContractVerdict(check, "FAILED", f"{len(found)} problem{'s' if len(found) > 1 else ''}", found)
