"""The command line: runs a command, turns errors into messages and exit codes."""

import gc
import os
import sys

import click

from proofmass.runner.commands.declarations.analysis import ANALYSES
from proofmass.runner.commands.declarations.blocks import BLOCKS
from proofmass.runner.commands.declarations.comparison import COMPARISONS
from proofmass.runner.commands.declarations.design import DESIGN
from proofmass.runner.commands.declarations.fit import fit
from proofmass.runner.commands.declarations.graphs import cli
from proofmass.runner.commands.declarations.live import live
from proofmass.runner.commands.exit_codes import DONE, INTERRUPTED, USAGE
from proofmass.runner.commands.failures import explain

__all__ = ["cli", "main"]

_COLLECTED = 50_000  # new objects between two collections: most of a command's objects live to its end

for command in (*ANALYSES, *BLOCKS, *COMPARISONS, fit, *DESIGN, live):
    cli.add_command(command)


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code; errors are messages, tracebacks only with `--traceback`."""
    if arguments is not None:
        return _answered(arguments)
    gc.set_threshold(_COLLECTED)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy is loaded: the matrices are small, threads wait
    try:
        return _answered(sys.argv[1:])
    finally:
        gc.freeze()  # the process ends: collecting its objects would take time in vain


def _answered(words: list[str]) -> int:
    plain = [word for word in words if word != "--traceback"]
    try:
        code = cli.main(plain, prog_name="proofmass", standalone_mode=False)
        sys.stdout.flush()
        return code or DONE
    except SystemExit:
        return DONE  # click raises so where the reader has gone away, as in `proofmass blocks | head -1`
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more at its end
        return DONE
    except click.Abort:
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.UsageError as error:
        error.show()
        return USAGE
    except Exception as error:
        if plain != words:
            raise
        return explain(error)
