"""Commands as rows: a field of a request is an argument or option, from which click, its help and the call derive."""

import re
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal, InvalidOperation
from inspect import signature
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeVar, dataclass_transform

import click

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.graphs.files.library import LIBRARY, file_of, library_files
from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.runner.commands.declarations.completion import graphs, outputs, parameters
from proofmass.runner.run.engine_table import engine_choices

Returned = TypeVar("Returned")


class Row(NamedTuple):
    """An argument, which has no names, or an option of a command; a field of a request has it for its default."""

    names: tuple[str, ...] | None
    settings: Mapping[str, Any]

    def of_click(self, field: str) -> click.Parameter:
        """Return it as click's; an option without names is named by its field."""
        if self.names is None:
            return click.Argument([field], **self.settings)
        return click.Option([*(self.names or (f"--{field.replace('_', '-')}",)), field], **self.settings)


@dataclass_transform()
class Request:
    """A call of a command: its docstring is the help, `does` the function that takes it."""

    does: ClassVar[str] = ""

    def __init_subclass__(cls, does: str = "") -> None:
        cls.does = does

    def __init__(self, **values: Any) -> None:
        vars(self).update(values)
        self.check()

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a request is frozen: {name}")

    def check(self) -> None:
        """Raise `click.UsageError` where options do not go together."""

    def call(self, function: Callable[..., Returned], *first: object, **others: object) -> Returned:
        """Call a function with every field that is named as a parameter of it; `first` and `others` come before."""
        names = list(signature(function).parameters)[len(first) :]
        return function(*first, **{name: vars(self)[name] for name in names if name in vars(self)} | others)

    @classmethod
    def rows(cls) -> Iterator[tuple[str, Row]]:
        """Yield the fields with their rows: its own first, those that it shares behind them."""
        for kind in cls.__mro__:
            yield from ((name, row) for name, row in vars(kind).items() if isinstance(row, Row))

    @classmethod
    def command_name(cls) -> str:
        """Return the name of the command: `noise-model` of `NoiseModelRequest`."""
        return re.sub("(?<=.)([A-Z])", r"-\1", cls.__name__.removesuffix("Request")).lower()


def option(help_text: str, *names: str, **settings: Any) -> Any:
    """Return the row of an option; its help shows a default that is not empty."""
    return Row(names, {"help": help_text, "show_default": settings.get("default", "") != "", **settings})


def flag(help_text: str, *names: str) -> Any:
    """Return the row of an option without a value."""
    return option(help_text, *names, is_flag=True)


def several(help_text: str, *names: str, **settings: Any) -> Any:
    """Return the row of an option that may be repeated."""
    return option(help_text, *names, multiple=True, **settings)


def argument(**settings: Any) -> Any:
    """Return the row of an argument."""
    return Row(None, settings)


class LibraryFile(click.Path):
    """A file, or one of the packaged library: `library:NAME`, without or with `.toml`."""

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[Any]:
        """Return what a shell may write."""
        return graphs(incomplete)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path of the file."""
        if not str(value).startswith(LIBRARY):
            if not self.dir_okay and Path(value).is_dir():
                self.fail(_is_a_folder(Path(value)), param, ctx)
            return super().convert(value, param, ctx)
        path = file_of(value)
        if path == Path(value):
            name, stems = str(value).removeprefix(LIBRARY), [Path(file).stem for file in library_files()]
            self.fail(f"there is no such graph: {name}; {did_you_mean(name, stems, 'the library')}", param, ctx)
        return path


class Folder(click.Path):
    """A folder to write to."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path of the folder."""
        if Path(value).is_file():
            self.fail(f"{value} is a file; name a folder", param, ctx)
        return super().convert(value, param, ctx)


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
_FOLDER = Folder(file_okay=False, path_type=Path)
PORT: Mapping[str, Any] = {"metavar": "BLOCK.PORT", "shell_complete": outputs}
AT: Any = option(
    'Linearise at this time, where it has "settled", about a "periodic" orbit, or where there is an answer.',
    default="auto",
    metavar="TIME",
)
OWN: Any = option(
    "Use the blocks of this Python file, which is run.",
    "--blocks",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
)
SET: Any = several(
    "Change a parameter or a named value, for example adc.bits=16 or mass=60ug; repeatable.",
    "--set",
    metavar="NAME=VALUE",
    shell_complete=parameters,
)
PROBES: Any = several("Record one more signal; repeatable.", "--probe", **PORT)
DURATION: Any = option('Run the graph this long, for example "2 s" (default: as the graph says).', metavar="TIME")
QUIET: Any = flag("Show no progress bar.")
JSON: Any = flag("Print the answer as JSON.", "--json")


def _is_a_folder(path: Path) -> str:
    """Return what to say of a folder that stands where a graph belongs."""
    inside = sorted(file for file in path.glob("*.toml") if file.is_file())[:3]
    typed = [f"./{file}" if file.parent == Path() else str(file) for file in inside]
    hint = f"did you mean {' or '.join(typed)}?" if typed else "name a file in it"
    return f"{path} is a folder; {hint}"


def file_argument(library: bool = False) -> Any:
    """Return an argument that is a file, or one of the library."""
    return argument(type=LibraryFile(dir_okay=False, path_type=Path) if library else _FILE)


def band_option(help_text: str) -> Any:
    """Return the option for a band of frequency."""
    return option(help_text, nargs=2, metavar="FROM TO")


def seed_option(source: str, what: str = "all random numbers") -> Any:
    """Return the option for a seed, which `source` says otherwise."""
    return option(f"Seed {what} (default: {source}).", type=Whole(0, LARGEST_SEED))


def engine_option(studies: bool = False) -> Any:
    """Return the option for an engine, among those that run studies if `studies`."""
    text = "Choose an engine; all give the same bits. auto begins in plain Python and goes on in machine code."
    return option(text, type=click.Choice(engine_choices(studies)), default="auto")


def out_option(help_text: str, required: bool = False) -> Any:
    """Return the option for the folder to write to."""
    return option(help_text, "-o", "--out", "--output", type=_FOLDER, metavar="FOLDER", required=required)


def file_option(help_text: str, *names: str) -> Any:
    """Return an option that is a file."""
    return option(help_text, *names, type=_FILE, metavar="FILE")


def output_option(default: str) -> Any:
    """Return the option for the one file that a command writes."""
    return file_option(f"Write to this file (default: {default}).", "-o", "--out", "--output")


def plot_option(help_text: str) -> Any:
    """Return the option for a picture."""
    kind = PictureFile(dir_okay=False, path_type=Path)
    return option(f"{help_text}: .svg, .png or .pdf.", "--plot", type=kind, metavar="FILE")


class Answered(Request):
    """A command that knows own blocks, and answers as text or JSON."""

    own: Path | None = OWN
    as_json: bool = JSON


class Changed(Answered):
    """A command of a graph whose parameters may be changed."""

    changes: tuple[str, ...] = SET
