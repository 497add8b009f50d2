"""The command `new`: a commented graph to start from."""

from importlib.resources import files
from pathlib import Path

import click

from proofmass.runner.commands.exit_codes import DONE


def write_new_graph(path: Path) -> int:
    """Write the template to a file that does not exist yet, and return the exit code."""
    text = (files("proofmass.graphs") / "library" / "template.toml").read_text(encoding="utf-8")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise click.UsageError(f"{path} exists already; nothing was written") from None
    click.echo(f"wrote {path}; run it with: proofmass run {path}")
    return DONE
