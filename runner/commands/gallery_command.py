"""The command `gallery`: the graphs that come along, a line each, or what one of them is."""

from collections.abc import Iterator
from itertools import groupby
from textwrap import wrap
from typing import Any

from proofmass.graphs.files.gallery import PARTS, Exhibit, exhibit, exhibits
from proofmass.runner.commands.answers import print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.output.text_table import text_table

WIDTH = 110  # of a description, in letters


def show_gallery(name: str | None, as_json: bool) -> int:
    """List all exhibits, or show one, and return the exit code."""
    if name is not None:
        one = exhibit(name)
        if as_json:
            print_json(_facts(one))
        else:
            print_text(_about(one))
    elif as_json:
        print_json([_facts(one) for one in exhibits()])
    else:
        print_text(_list())
    return DONE


def _facts(one: Exhibit) -> dict[str, Any]:
    return {
        "name": one.name,
        "family": one.family,
        "title": one.title,
        "description": one.description,
        "path": str(one.path),
    }


def _list() -> Iterator[str]:
    """The exhibits under the headings of their families."""
    width = max(len(one.name) for one in exhibits())
    for family, members in groupby(exhibits(), key=lambda one: one.family):
        yield f"{family}, for graphs of your own:" if family == PARTS else f"{family.replace('_', ' ')}:"
        yield from text_table([(f"  {one.name.ljust(width)}", one.title) for one in members], left=(0, 1))
        yield ""
    yield "copy one to start from: proofmass new sensor.toml --from NAME"


def _about(one: Exhibit) -> Iterator[str]:
    yield f"{one.name}: {one.title}"
    yield ""
    yield from wrap(one.description, WIDTH)
    if one.description:
        yield ""
    yield f"file    {one.path}"
    if one.family == PARTS:
        yield f'use     [blocks.NAME] with graph = "library:{one.path.name}"'
    yield f"start   proofmass new sensor.toml --from {one.name}"
