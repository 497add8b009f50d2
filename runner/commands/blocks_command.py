"""The command `blocks`: all kinds by family, those that words describe, or one with its equation and an example."""

import re
from collections.abc import Iterable, Iterator, Mapping

import click

from proofmass.blocks.declaration.catalog import all_blocks, facts, family_about, family_of, find
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.other_names import kind_hint
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_answer, print_json, print_text
from proofmass.runner.commands.declarations.blocks import BlocksRequest
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.output.describe import block_text
from proofmass.runner.output.text_table import text_table


def show_blocks(request: BlocksRequest) -> int:
    """List all kinds of blocks, or show one, and return the exit code."""
    own = own_blocks(request.own)
    if request.kind is not None:
        return _show_one(request, own)
    if request.example:
        raise click.UsageError("--example needs a kind of block: proofmass blocks PID --example")
    kinds = all_blocks(own)
    if request.words is not None:
        kinds = found_by(kinds, request.words)
    if request.as_json:
        print_json([facts(block) for block in kinds.values()])
    else:
        print_text(_list(kinds) if kinds else _nothing(request.words or "", all_blocks(own)))
    return DONE if kinds else WRONG_MODEL


def _show_one(request: BlocksRequest, own: Mapping[str, type[Block]] | None) -> int:
    kind = str(request.kind)
    block = find(kind, own)
    if block is None and not request.example:
        words = [re.compile(rf"\b{re.escape(word)}") for word in kind.lower().split()]
        found = {name: of for name, of in all_blocks(own).items() if all(word.search(_said(of)) for word in words)}
        if found:
            print_answer(request.as_json, lambda: [facts(one) for one in found.values()], _list(found))
            return DONE
    if block is None:
        hint = kind_hint(kind, all_blocks(own), bool(own))
        raise Problem(message="there is no such kind of block", key=kind, hint=hint).error
    if request.example:
        # start-up time: building graphs takes longer than listing kinds
        from proofmass.graphs.files.toml_writer import write_graph
        from proofmass.graphs.model.example import example_of

        print_text([write_graph(example_of(block)).rstrip()])
    elif request.as_json:
        print_json(facts(block))
    else:
        print_text([block_text(block)])
    return DONE


def found_by(kinds: Mapping[str, type[Block]], words: str) -> dict[str, type[Block]]:
    """Return the kinds that all words describe: first those whose name has one, then by what they say of themselves."""
    wanted = words.lower().split()
    matching = {name: kind for name, kind in kinds.items() if all(word in _said(kind) for word in wanted)}
    ranked = sorted(matching, key=lambda name: (not any(word in name.lower() for word in wanted), name))
    return {name: matching[name] for name in ranked}


def _said(kind: type[Block]) -> str:
    """Everything that a kind says of itself, in lower case."""
    known = facts(kind)
    ports = (fact["doc"] for group in ("parameters", "inputs", "outputs") for fact in known[group].values())
    names = (*known["parameters"], *known["inputs"], *known["outputs"])
    words = (known["kind"], known["doc"], known["equation"], known["family"], *known["elsewhere"], *names, *ports)
    return " ".join(words).lower()


def _list(kinds: Mapping[str, type[Block]]) -> Iterator[str]:
    """The kinds under the headings of their families: name and first line of the documentation."""
    width = max(map(len, kinds))
    families = sorted({family_of(kind) for kind in kinds.values()})
    for number, family in enumerate(families):
        if number:
            yield ""
        yield f"{family}: {family_about(family)}"
        docs = {name: (of.__doc__ or "").strip() for name, of in kinds.items() if family_of(of) == family}
        rows = [(f"  {name.ljust(width)}", doc.splitlines()[0]) for name, doc in docs.items()]
        yield from text_table(rows, left=(0, 1))


def _nothing(words: str, kinds: Iterable[str]) -> list[str]:
    return [f"no block is described by: {words}", f"  hint:     {kind_hint(words, kinds, own=True)}"]
