"""The command line: runs a command, turns errors into messages and exit codes."""

import gc
import os
import sys
from importlib import import_module
from typing import Any

import click

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.commands.answers import DONE, INTERRUPTED, USAGE
from proofmass.runner.commands.declarations import analysis, blocks, comparison, design, fit, graphs
from proofmass.runner.commands.declarations.options import Request
from proofmass.runner.commands.failures import explain
from proofmass.runner.host.versions import PROOFMASS

__all__ = ["REQUESTS", "cli", "main"]

_COLLECTED = 50_000  # new objects between two collections: most objects of a command live on
REQUESTS: tuple[type[Request], ...] = tuple(
    kind
    for subject in (analysis, blocks, comparison, design, fit, graphs)
    for kind in vars(subject).values()
    if isinstance(kind, type) and issubclass(kind, Request) and kind.does
)


class Commands(click.Group):
    """Commands with "did you mean"."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError:
            # start-up time: few words are wrong
            from proofmass.runner.commands.misused import meant

            known = [*self.commands, "--help", "--version"]
            raise click.UsageError(
                f"no such command: {args[0]}; {meant(args[0], known, 'the commands')}", ctx
            ) from None


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120})
@click.version_option(PROOFMASS, prog_name="proofmass")
@click.option("--traceback", is_flag=True, help="Show Python's traceback of an error; allowed after the command too.")
def cli(traceback: bool) -> None:
    """Simulate inertial sensors and the loops around them, declared as block diagrams.

    \b
    proofmass new sensor.toml                 write a commented graph to start from
    proofmass check sensor.toml               list everything that is wrong with it
    proofmass run sensor.toml --out results   simulate it, write traces, plot and report

    Exit codes: 0 done, 1 the model is wrong, 2 wrong usage, 3 the run failed, 130 interrupted.
    """


def command_of(kind: type[Request]) -> click.Command:
    """Return the command of a request; what it does is imported when it is called."""

    def call(**options: Any) -> int:
        module, _, function = kind.does.partition(".")
        answer = getattr(import_module(f"proofmass.runner.commands.{module}"), function)
        try:
            return int(answer(kind(**options)))
        except ModelError as error:
            # start-up time: few values are wrong
            from proofmass.runner.commands.misused import under_options

            raise ModelError(under_options(error.problems, options, command)) from error

    parameters = [row.of_click(name) for name, row in kind.rows()]
    command = click.Command(kind.command_name(), callback=call, params=parameters, help=kind.__doc__)
    return command


for kind in REQUESTS:
    cli.add_command(command_of(kind))


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code; tracebacks only with `--traceback`."""
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
        return DONE  # so click says that the reader is gone, as in `proofmass blocks | head -1`
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more
        return DONE
    except click.Abort:
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.UsageError as error:
        # start-up time: few words are wrong
        from proofmass.runner.commands.misused import answered

        answered(error, plain).show()
        return USAGE
    except Exception as error:
        if plain != words:
            raise
        return explain(error)
