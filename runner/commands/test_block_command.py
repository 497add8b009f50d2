"""The command `test-block`: whether a user's own blocks keep the contract the library's keep."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_json, print_text
from proofmass.runner.commands.declarations.blocks import TestBlockRequest
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.contract.contract import Report, check_block
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table

_INDENT = "    "


def test_blocks(request: TestBlockRequest) -> int:
    """Check blocks of a file, print what each check says, and return the exit code."""
    reports = []
    for kind in _chosen(request.file, request.kind):
        reports.append(check_block(kind))
        if not request.as_json:
            print_text(_lines(reports[-1]))
    if request.as_json:
        print_json([report.as_data() for report in reports])
    else:
        print_text([_summary(reports)])
    return DONE if all(report.passed for report in reports) else WRONG_MODEL


def _chosen(file: Path, names: Sequence[str]) -> list[type[Block]]:
    """The blocks of the file that are named; all if none is."""
    own = own_blocks(file) or {}
    if not own:
        hint = "a block is a class: class MyBlock(Block): ..."
        raise Problem(message="there is no block in the file", file=str(file), hint=hint).error
    missing = [
        Problem(message="there is no such block", file=str(file), key=name, hint=did_you_mean(name, own, "its blocks"))
        for name in names
        if name not in own
    ]
    if missing:
        raise ModelError(missing)
    return [own[name] for name in names or own]


def _lines(report: Report) -> Iterator[str]:
    """A line for each check, and below it what is wrong."""
    table = text_table([("  " + v.check, v.status, v.detail) for v in report.verdicts], left=(0, 1, 2))
    yield report.kind
    for line, verdict in zip(table, report.verdicts, strict=True):
        yield line
        for problem in verdict.problems:
            yield from (f"{_INDENT}{part}" for part in str(problem).splitlines())


def _summary(reports: Sequence[Report]) -> str:
    failed = [report.kind for report in reports if not report.passed]
    if failed:
        return f"{len(failed)} of {count(len(reports), 'block')} failed: {', '.join(failed)}"
    return f"{count(len(reports), 'block')} passed every check that could be run"
