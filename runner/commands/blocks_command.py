"""The command `blocks`: all kinds of blocks, or one with its equation, parameters and ports."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from proofmass.blocks.declaration.catalog import all_blocks, facts, find
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.other_names import kind_hint
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.commands.answers import print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.output.describe import block_text
from proofmass.runner.output.text_table import text_table


def show_blocks(kind: str | None, own_file: Path | None, as_json: bool) -> int:
    """List all kinds of blocks, or show one, and return the exit code."""
    own = own_blocks(own_file)
    if kind is None:
        kinds = all_blocks(own)
        if as_json:
            print_json([facts(block) for block in kinds.values()])
        else:
            print_text(_list(kinds))
        return DONE
    block = find(kind, own)
    if block is None:
        hint = kind_hint(kind, all_blocks(own), bool(own))
        raise ModelError([Problem(message="there is no such kind of block", key=kind, hint=hint)])
    if as_json:
        print_json(facts(block))
    else:
        print_text([block_text(block)])
    return DONE


def _list(kinds: Mapping[str, type[Block]]) -> Iterator[str]:
    """A line for each kind: its name and the first line of its documentation."""
    rows = [(name, (block.__doc__ or "").strip().splitlines()[0]) for name, block in kinds.items()]
    yield from text_table(rows, left=(0, 1))
