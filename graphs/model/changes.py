"""A graph changed into another: parameters anywhere inside it, and files named from another folder."""

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean, shown
from proofmass.graphs.model.graph import Given, split


def with_parameters(graph: Given, changes: Mapping[str, object]) -> Given:
    """The graph with parameters changed, each named by its path or as it is exported."""
    blocks, parts = dict(graph.blocks), dict(graph.subgraphs)
    problems: list[Problem] = []
    by_block: dict[str, dict[str, object]] = {}
    for key, value in changes.items():
        signal = graph.exports.get(key, key)
        block, parameter = split(signal)
        if block not in blocks:
            block, _, parameter = signal.partition(".")
        if block not in blocks and block not in parts:
            hint = did_you_mean(block, [*blocks, *parts], "the blocks")
            problems.append(Problem(message="there is no such block", key=key, got=shown(block), hint=hint))
        else:
            by_block.setdefault(block, {})[parameter] = value
    for name, values in by_block.items():
        try:
            if name in parts:
                parts[name] = change_part(parts[name], values)
            else:
                blocks[name] = _changed(blocks[name], values)
        except ModelError as error:
            problems += [dataclasses.replace(p, key=f"{name}.{_key(p)}", path=()) for p in error.problems]
    if problems:
        raise ModelError(problems)
    return graph.changed(blocks=blocks, subgraphs=parts)


def changed_blocks(blocks: Mapping[str, Block], values: Mapping[str, object]) -> dict[str, Block]:
    """The blocks of a flat graph that have these parameters, by `block.parameter`; raises `ModelError`."""
    changes: dict[str, dict[str, object]] = {}
    for signal, value in values.items():
        name, parameter = split(signal)
        changes.setdefault(name, {})[parameter] = value
    return {name: _changed(blocks[name], changed) for name, changed in changes.items()}


def change_part(part: Given, values: Mapping[str, object]) -> Given:
    """As `with_parameters`, for a subgraph: a name without a dot is one that it exports."""
    unknown = [name for name in values if "." not in name and name not in part.exports]
    if unknown:
        names = [*part.exports, *part.blocks, *part.subgraphs]
        hints = (did_you_mean(name, names, "exports and blocks inside") for name in unknown)
        message = "the subgraph exports no such parameter"
        raise ModelError([Problem(message=message, key=n, got=n, hint=h) for n, h in zip(unknown, hints, strict=True)])
    return with_parameters(part, values)


def _changed(block: Block, values: dict[str, object]) -> Block:
    return type(block)(**({name: getattr(block, name) for name in type(block).parameters} | values))


def _key(problem: Problem) -> str:
    return problem.path[0] if problem.path else problem.key


def moved(graph: Given, folder: str) -> Given:
    """The graph with the recordings that it plays named from another folder."""
    return with_recordings(
        graph, folder, lambda here, file: file if here == folder else _from(Path(folder), Path(here) / file)
    )


def with_recordings(graph: Given, folder: str, named: Callable[[str, str], str]) -> Given:
    """The graph with other names, from a folder, of the recordings that it plays: `named` gets folder and name."""
    parts = {name: with_recordings(part, folder, named) for name, part in graph.subgraphs.items()}
    played: dict[str, Block] = {}
    for name, block in graph.blocks.items():
        file = getattr(block, "file", "")
        if file and any(buffer.recorded for buffer in type(block).buffers.values()):
            other = named(graph.place.folder, file)
            if other != file:
                played[name] = _changed(block, {"file": other})
    if not played and all(part is graph.subgraphs[name] for name, part in parts.items()):
        return graph
    place = dataclasses.replace(graph.place, folder=folder)
    return graph.changed(blocks={**graph.blocks, **played}, subgraphs=parts, place=place)


def _from(folder: Path, file: Path) -> str:
    """The file as named from the folder: relative where it lies inside."""
    absolute, inside = file.resolve(), folder.resolve()
    if file.is_absolute() and not absolute.is_relative_to(inside):
        return str(file)
    return str(absolute.relative_to(inside) if absolute.is_relative_to(inside) else absolute)
