"""Arguments and options that several commands share."""

from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, Protocol, TypeVar

import click

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.graphs.files.library import LIBRARY, file_of, library_files
from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.runner.commands.completion import graphs, outputs, parameters
from proofmass.runner.run.engine_table import engine_choices

_Function = TypeVar("_Function", bound=Callable[..., Any])


class Decorator(Protocol):
    """Adds an argument or option to a command."""

    def __call__(self, function: _Function, /) -> _Function: ...


class LibraryFile(click.Path):
    """A file, or one of the packaged library by its name: `library:NAME`, whose `.toml` may be left out."""

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[Any]:
        """Return what a shell may write."""
        return graphs(incomplete)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path of the file."""
        if not str(value).startswith(LIBRARY):
            return super().convert(value, param, ctx)
        path = file_of(value)
        if path == Path(value):
            name, stems = str(value).removeprefix(LIBRARY), [Path(file).stem for file in library_files()]
            self.fail(f"there is no such graph: {name}; {did_you_mean(name, stems, 'the library')}", param, ctx)
        return path


class Whole(click.IntRange):
    """A whole number within bounds, as digits or as 1e6."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        try:
            number = Decimal(str(value))
        except InvalidOperation:
            number = Decimal("NaN")
        if not number.is_finite() or abs(number) >= _LARGEST_DECIMAL or number != number.to_integral_value():
            self.fail(f"{value!r} is not a whole number, such as 1000000 or 1e6", param, ctx)
        return super().convert(int(number), param, ctx)


class PictureFile(click.Path):
    """A file for a picture, whose ending says its kind."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path of the file; refused before anything is computed."""
        path = Path(str(super().convert(value, param, ctx)))
        if path.suffix.lower() not in PICTURES:
            self.fail(f"{path.name} ends in none of {', '.join(PICTURES)}", param, ctx)
        return path


_LARGEST_DECIMAL = Decimal(10) ** 80
PICTURES = (".svg", ".png", ".pdf")
_FILE = click.Path(dir_okay=False, path_type=Path)
_FOLDER = click.Path(file_okay=False, path_type=Path)

graph_argument = click.argument("graph", type=LibraryFile(dir_okay=False, path_type=Path))
at_option = click.option(
    "--at",
    default="auto",
    show_default=True,
    metavar="TIME",
    help='Linearise at this time, where it has "settled", about a "periodic" orbit, or where there is an answer.',
)

blocks_option = click.option(
    "--blocks",
    "own",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Use the blocks of this Python file, which is run.",
)
set_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="NAME=VALUE",
    shell_complete=parameters,
    help="Change a parameter or a named value, for example adc.bits=16 or mass=60ug; repeatable.",
)
probe_option = click.option(
    "--probe",
    "probes",
    multiple=True,
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Record one more signal; repeatable.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
quiet_option = click.option("--quiet", is_flag=True, help="Show no progress bar.")
duration_option = click.option(
    "--duration", metavar="TIME", help='Run the graph this long, for example "2 s" (default: as the graph says).'
)


def seed_option(source: str) -> Decorator:
    """Return the option for a seed, which `source` says otherwise."""
    return click.option(
        "--seed", type=Whole(0, LARGEST_SEED), help=f"Seed all random numbers (default: as {source} says)."
    )


def engine_option(studies: bool = False) -> Decorator:
    """Return the option for an engine, among those that run studies if `studies`."""
    return click.option(
        "--engine",
        type=click.Choice(engine_choices(studies)),
        default="auto",
        show_default=True,
        help="Choose an engine; all give the same bits. auto begins in plain Python and goes on in machine code.",
    )


def out_option(help_text: str, required: bool = False) -> Decorator:
    """Return the option for the folder to write to."""
    names = ("-o", "--out", "--output", "out")
    return click.option(*names, type=_FOLDER, metavar="FOLDER", required=required, help=help_text)


def output_option(default: str) -> Decorator:
    """Return the option for the one file that a command writes."""
    names = ("-o", "--out", "--output", "output")
    return click.option(*names, type=_FILE, metavar="FILE", help=f"Write to this file (default: {default}).")


def plot_option(name: str, help_text: str) -> Decorator:
    """Return the option for a picture."""
    kind = PictureFile(dir_okay=False, path_type=Path)
    return click.option("--plot", name, type=kind, metavar="FILE", help=f"{help_text}: .svg, .png or .pdf.")


def file_argument(name: str, library: bool = False) -> Decorator:
    """Return an argument that is a file, or one of the library."""
    return click.argument(name, type=LibraryFile(dir_okay=False, path_type=Path) if library else _FILE)
