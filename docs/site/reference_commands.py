"""The page of the command line: the help of every command, as the command prints it."""

import click

from docs.site.markdown import fence
from proofmass.runner.command_line import cli

WIDTH = 84


def commands_page() -> str:
    """Return the page of all commands."""
    lines = ["# Command line", "", "`python -m proofmass` is the same as `proofmass`.", ""]
    lines += fence("text", help_text("proofmass", cli))
    for name, command in sorted(cli.commands.items()):
        lines += [f"## proofmass {name}", "", *fence("text", help_text(f"proofmass {name}", command))]
    return "\n".join(lines) + "\n"


def help_text(name: str, command: click.Command) -> str:
    """Return what `NAME --help` prints on a terminal of a fixed width."""
    settings = {"help_option_names": ["-h", "--help"]}
    context = click.Context(command, info_name=name, terminal_width=WIDTH, max_content_width=WIDTH, **settings)
    return command.get_help(context)
