"""Errors in the words of the user: a message on standard error and an exit code."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from proofmass.runner.commands.answers import FAILED, WRONG_MODEL, print_problem
from proofmass.runner.output.counts import count

if TYPE_CHECKING:
    from proofmass.blocks.declaration.problem import Problem


def explain(error: Exception) -> int:
    """Print an error and return its exit code."""
    # start-up time: `proofmass --help` refuses nothing
    from proofmass.blocks.declaration.libraries import told
    from proofmass.blocks.declaration.problem import ModelError, Problem
    from proofmass.runner.commands.own_blocks import raised_by_own_block

    error = raised_by_own_block(error) or error
    if isinstance(error, ImportError):
        error = told(error) or error
    if isinstance(error, ModelError):
        for problem in error.problems:
            print_problem(problem)
        print_codes(error.problems)
        click.echo(count(len(error.problems), "problem"), err=True)
        return WRONG_MODEL
    click.echo(_message(error), err=True)
    if isinstance(failed := getattr(error, "problem", None), Problem):
        print_codes([failed])
    return FAILED


def print_codes(problems: "Sequence[Problem]") -> None:
    """Say by which codes the problems are explained."""
    codes = sorted({problem.code for problem in problems if problem.code})
    if codes:
        click.echo(f"more: proofmass explain {' '.join(codes)}", err=True)


def _message(error: Exception) -> str:
    from proofmass.runner.run.faults import RunError  # `--help` needs no NumPy

    if isinstance(error, RunError):
        return f"the run failed\n{error}"
    folder = Path(str(getattr(error, "filename", None) or ".")).parent
    if isinstance(error, FileNotFoundError) and not folder.is_dir():
        return f"cannot write {error.filename}\n  hint:     there is no folder {folder}: make it"
    if isinstance(error, OSError):
        return f"cannot write or read {error.filename or 'standard output or a file'}: {error.strerror or error}"
    if isinstance(error, MemoryError):
        return "out of memory\n  hint:     run fewer samples, or thin a probe: every = 1000"
    return f"an error inside proofmass: {type(error).__name__}: {error}\n  hint:     --traceback shows where"
