"""The command `new`: a graph to start from, a template or one of the gallery."""

from collections.abc import Mapping
from pathlib import Path

import click

from proofmass.graphs.files.gallery import PARTS, TEMPLATE, Exhibit, exhibit
from proofmass.graphs.files.library import FOLDER, library_file
from proofmass.runner.commands.answers import DONE
from proofmass.runner.commands.declarations.blocks import NewRequest
from proofmass.runner.commands.schema_command import write_schema_file
from proofmass.runner.host.named_files import named

PYTHON_TEMPLATE = FOLDER / "template.py"


def write_new_graph(request: NewRequest) -> int:
    """Write a graph, and what it names beside it, to files that do not exist yet, and return the exit code.

    The first line of a graph names its schema, which is written too where there is none.
    """
    path, copied = request.file, exhibit(request.name) if request.name is not None else None
    if path.suffix == ".py":
        _copy({path: PYTHON_TEMPLATE})
        click.echo(f"wrote {path}; run it with: python {path}")
        return DONE
    beside = {path.parent / file: library_file(file) for file in copied.beside} if copied else {}
    sources = {path: copied.path if copied else library_file(TEMPLATE)} | beside
    _copy(sources)
    graphs = (source.read_text(encoding="utf-8") for source in sources.values() if source.suffix == ".toml")
    names = dict.fromkeys(text.partition("\n")[0].removeprefix("#:schema ") for text in graphs)
    schemas = [schema for name in names if not (schema := path.parent / name).exists()]  # perhaps with own blocks
    for schema in schemas:
        write_schema_file(schema)
    written = map(str, (path, *beside, *schemas))
    click.echo(f"wrote {', '.join(written)}; {_next(path, copied)}")
    return DONE


def _copy(sources: Mapping[Path, Path]) -> None:
    """Copy the file of each target, none of which may exist."""
    existing = [str(target) for target in sources if target.exists() or target.is_symlink()]
    if existing:
        raise click.UsageError(f"{', '.join(existing)} exists already; nothing was written")
    for target, source in sources.items():
        with named(target), target.open("x", encoding="utf-8") as file:
            file.write(source.read_text(encoding="utf-8"))


def _next(path: Path, copied: Exhibit | None) -> str:
    if copied is not None and copied.family == PARTS:
        return f'use it in a graph beside it: graph = "{path.name}"'
    return f"run it with: proofmass {'montecarlo' if copied is not None and copied.study else 'run'} {path}"
