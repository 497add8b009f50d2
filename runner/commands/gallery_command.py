"""The command `gallery`: the graphs that come along, a line each, or what one of them is."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any

from proofmass.graphs.files.gallery import PARTS, Exhibit, exhibit, exhibits
from proofmass.runner.commands.answers import DONE, print_answer
from proofmass.runner.commands.declarations.blocks import GalleryRequest
from proofmass.runner.output.text_table import text_table

WIDTH = 110  # of a description, in letters


def show_gallery(request: GalleryRequest) -> int:
    """List all exhibits, or show one, and return the exit code."""
    found = exhibits() if request.name is None else _found(request.name)
    if request.name is None or found:
        print_answer(request.as_json, lambda: [_facts(one) for one in found], _list(found))
    else:
        chosen = exhibit(request.name)
        print_answer(request.as_json, lambda: _facts(chosen), _about(chosen))
    return DONE


def _facts(item: Exhibit) -> dict[str, Any]:
    return {
        "name": item.name,
        "family": item.family,
        "title": item.title,
        "description": item.description,
        "path": str(item.path),
    }


def _found(words: str) -> tuple[Exhibit, ...]:
    """Return the exhibits that have all words in what they say; none if the words name one."""
    if any(words.removesuffix(".toml") == one.name for one in exhibits()):
        return ()
    wanted = words.lower().replace("_", " ").split()
    texts = {one: f"{one.name} {one.family} {one.title} {one.description}".lower() for one in exhibits()}
    return tuple(one for one, text in texts.items() if all(word in text for word in wanted))


def _list(items: Sequence[Exhibit]) -> Iterator[str]:
    """Exhibits under the headings of their families."""
    width = max(len(one.name) for one in items)
    for family, members in groupby(items, key=lambda one: one.family):
        yield f"{family}, for graphs of your own:" if family == PARTS else f"{family.replace('_', ' ')}:"
        yield from text_table([(f"  {one.name.ljust(width)}", one.title) for one in members], left=(0, 1))
        yield ""
    yield "copy one to start from: proofmass new sensor.toml --from NAME"


def _about(item: Exhibit) -> Iterator[str]:
    yield f"{item.name}: {item.title}"
    yield ""
    yield from wrap(item.description, WIDTH)
    if item.description:
        yield ""
    yield f"file    {item.path}"
    if item.family == PARTS:
        yield f'use     [blocks.NAME] with graph = "library:{item.path.name}"'
    yield f"start   proofmass new sensor.toml --from {item.name}"
