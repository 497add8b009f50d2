"""The command `new`: a commented graph to start from."""

from pathlib import Path

import click

from proofmass.graphs.files.library import library_file
from proofmass.runner.commands.exit_codes import DONE


def write_new_graph(path: Path) -> int:
    """Write the template to a file that does not exist yet, and return the exit code."""
    text = library_file("template.toml").read_text(encoding="utf-8")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise click.UsageError(f"{path} exists already; nothing was written") from None
    click.echo(f"wrote {path}; run it with: proofmass run {path}")
    return DONE
