"""The command `blocks`: all kinds of blocks, or one with its equation, parameters and ports."""

import json

import click

from proofmass.blocks.declaration.catalog import Own, all_blocks, facts, find
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.runner.output.describe import block_text


def show_blocks(kind: str | None, own: Own | None, as_json: bool) -> int:
    """Everything that `proofmass blocks` does; returns the exit code."""
    if kind is None:
        found = all_blocks(own)
        if as_json:
            click.echo(json.dumps([facts(block) for block in found.values()], indent=2))
        else:
            width = max(map(len, found))
            for name, block in found.items():
                click.echo(f"{name:<{width}}  {(block.__doc__ or '').strip().splitlines()[0]}")
        return 0
    shown = find(kind, own)
    if shown is None:
        hint = did_you_mean(kind, all_blocks(own), "the kinds")
        raise ModelError([Problem(message="there is no such kind of block", key=kind, hint=hint)])
    click.echo(json.dumps(facts(shown), indent=2) if as_json else block_text(shown))
    return 0
