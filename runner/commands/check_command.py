"""The command `check`: everything that is wrong with a file, and whether what it says is ready to run."""

import json
from pathlib import Path

import click

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.studies.check_file import check_file
from proofmass.runner.commands.failures import DONE, WRONG_MODEL, count
from proofmass.runner.commands.run_command import own_blocks


def check_graph(graph: Path, own: Path | None, as_json: bool) -> int:
    """Everything that `proofmass check` does; returns the exit code."""
    read, problems, study = check_file(graph, own_blocks(own))
    alone = read is not None and not _wrong(problems) and runs_alone(flatten(read))
    if read is not None and alone:
        from proofmass.runner.studies.whole.ready import unready

        problems += unready(read, study)
        if not _wrong(problems) and any(loop.requirements for loop in flatten(read).loops.values()):
            from proofmass.runner.commands.margins_command import missed_margins

            problems += missed_margins(read)
    wrong = _wrong(problems)
    if as_json:
        click.echo(json.dumps([problem.as_data() for problem in problems], indent=2))
    else:
        for problem in problems:
            click.echo(str(problem), err=not problem.note)
        if read is not None and not wrong:
            ready = "ready to run" if alone else "ready to be a part of other graphs"
            click.echo(f"{graph}: {read.size.blocks} blocks, {read.size.wires} wires, {ready}")
        else:
            click.echo(f"{count(len(wrong), 'problem')} in {graph}", err=True)
    return WRONG_MODEL if wrong else DONE


def _wrong(problems: list[Problem]) -> list[Problem]:
    return [problem for problem in problems if not problem.note]
