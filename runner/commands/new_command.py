"""The command `new`: a graph to start from, the template or one of the gallery."""

from pathlib import Path

import click

from proofmass.graphs.files.gallery import PARTS, TEMPLATE, Exhibit, exhibit
from proofmass.graphs.files.library import library_file
from proofmass.runner.commands.exit_codes import DONE


def write_new_graph(path: Path, name: str | None) -> int:
    """Write a graph, and what it names beside it, to files that do not exist yet, and return the exit code."""
    copied = exhibit(name) if name is not None else None
    beside = {path.parent / file: library_file(file) for file in copied.beside} if copied else {}
    sources = {path: copied.path if copied else library_file(TEMPLATE)} | beside
    existing = [str(target) for target in sources if target.exists() or target.is_symlink()]
    if existing:
        raise click.UsageError(f"{', '.join(existing)} exists already; nothing was written")
    for target, source in sources.items():
        with target.open("x", encoding="utf-8") as file:
            file.write(source.read_text(encoding="utf-8"))
    also = f" and {', '.join(map(str, beside))}" if beside else ""
    click.echo(f"wrote {path}{also}; {_next(path, copied)}")
    return DONE


def _next(path: Path, copied: Exhibit | None) -> str:
    if copied is not None and copied.family == PARTS:
        return f'use it in a graph beside it: graph = "{path.name}"'
    return f"run it with: proofmass {'montecarlo' if copied is not None and copied.study else 'run'} {path}"
