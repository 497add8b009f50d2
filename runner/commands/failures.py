"""What the shell is told of an error: a message and an exit code.

Exit codes: 0 done, 1 the model is wrong, 2 usage, 3 the run failed, 130 interrupted.
"""

import click

DONE, WRONG_MODEL, USAGE, FAILED, INTERRUPTED = 0, 1, 2, 3, 130


def explain(error: Exception) -> int:
    """Print an error in the words of the user; returns the exit code."""
    from proofmass.blocks.declaration.problem import ModelError

    if isinstance(error, ModelError):
        for problem in error.problems:
            click.echo(str(problem), err=True)
        click.echo(count(len(error.problems), "problem"), err=True)
        return WRONG_MODEL
    name = type(error).__name__
    if isinstance(error, OSError):
        click.echo(f"cannot write or read {error.filename or 'a file'}: {error.strerror or error}", err=True)
    elif isinstance(error, MemoryError):
        click.echo("out of memory\n  hint:     fewer samples, or thin a probe: every = 1000", err=True)
    elif name == "RunError":
        click.echo(f"the run failed\n{error}", err=True)
    else:
        click.echo(f"an error inside proofmass: {name}: {error}\n  hint:     --traceback shows where", err=True)
    return FAILED


def count(number: int, noun: str) -> str:
    """`"1 problem"`, `"2 problems"`."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"
