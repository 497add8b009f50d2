"""A page for each family of blocks: picture, equation, parameters, ports and an example of every block."""

from collections import defaultdict
from collections.abc import Iterator
from importlib import import_module
from typing import Any

from docs.site.markdown import code, fence, plain, table
from docs.site.ports import ports_picture
from docs.site.responses import response_picture
from proofmass.blocks.declaration.catalog import all_blocks, facts, family_of
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.output.describe import block_text
from proofmass.runner.output.typeset import typeset


def families() -> dict[str, list[type[Block]]]:
    """Return the blocks of the library by family, both in alphabetical order."""
    by_family = defaultdict(list)
    for kind in all_blocks().values():
        by_family[family_of(kind)].append(kind)
    return dict(sorted(by_family.items()))


def block_pages(responses: bool = False) -> Iterator[tuple[str, str]]:
    """Yield the index of all blocks and the page of each family."""
    yield "reference/blocks/index.md", _index()
    for family, kinds in families().items():
        yield f"reference/blocks/{family}.md", _family_page(family, kinds, responses)


def _index() -> str:
    count = sum(map(len, families().values()))
    lines = ["# Blocks", "", f"All {count} kinds, by family. `proofmass blocks KIND` prints the same about one.", ""]
    lines += ["```{toctree}", ":hidden:", "", *families(), "```", ""]
    for family, kinds in families().items():
        lines += [f"## [{_title(family)}]({family}.md)", "", plain(_sentence(family)), ""]
        rows = [(f"[{kind.__name__}]({family}.md#{kind.__name__.lower()})", plain(_first(kind))) for kind in kinds]
        lines += table(("kind", ""), rows)
    return "\n".join(lines) + "\n"


def _family_page(family: str, kinds: list[type[Block]], responses: bool) -> str:
    lines = [f"# {_title(family)}", "", plain(_sentence(family)), ""]
    for kind in kinds:
        lines += _block(kind, responses)
    return "\n".join(lines) + "\n"


def _block(kind: type[Block], responses: bool) -> Iterator[str]:
    about = facts(kind)
    yield from (f"## {kind.__name__}", "", plain(about["doc"]), "")
    yield from ("```{raw} html", '<div class="ports-frame">', ports_picture(about), "</div>")
    yield from (f'<div class="equation">{typeset(about["equation"])}</div>', "```", "")
    if about["elsewhere"]:
        yield from (f"Elsewhere called: {plain(', '.join(about['elsewhere']))}.", "")
    if about["continuous"]:
        yield from ("Continuous: it is integrated between ticks.", "")
    response = response_picture(kind) if responses else ""
    if response:
        what = f"What the example of `proofmass blocks {kind.__name__} --example` gives:"
        yield from (what, "", "```{raw} html", f'<div class="ports-frame">{response}</div>', "```", "")
    parameters = [
        (code(name), plain(p["doc"]), code(_default(p["default"])), code(p["unit"]), _bounds(kind, name, p))
        for name, p in about["parameters"].items()
    ]
    yield from table(("parameter", "meaning", "default", "unit", "bounds"), parameters)
    inputs = [
        (code(name), plain(p["doc"]), p["type"], code(p["unit"]), "may stay unconnected" * ("default" in p))
        for name, p in about["inputs"].items()
    ]
    yield from table(("input", "meaning", "type", "unit", ""), inputs)
    outputs = [
        (code(name), plain(p["doc"]), p["type"], code(p["unit"]), ", ".join(map(code, p["feedthrough"])) or "nothing")
        for name, p in about["outputs"].items()
    ]
    yield from table(("output", "meaning", "type", "unit", "depends in the same tick on"), outputs)
    yield from fence("toml", _example(kind))


def _example(kind: type[Block]) -> str:
    """Return the lines of a graph file that `proofmass blocks` prints."""
    text = block_text(kind).partition("In a graph file:\n")[2]
    return "\n".join(line.removeprefix("    ") for line in text.splitlines())


def _bounds(kind: type[Block], name: str, parameter: dict[str, Any]) -> str:
    return plain(kind.parameters[name].bounds()) or ", ".join(map(code, parameter.get("choices", [])))


def _default(value: object) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _title(family: str) -> str:
    return family.replace("_", " ").capitalize()


def _sentence(family: str) -> str:
    return " ".join((import_module(f"proofmass.blocks.{family}").__doc__ or "").split())


def _first(kind: type[Block]) -> str:
    return (kind.__doc__ or "").strip().splitlines()[0]
