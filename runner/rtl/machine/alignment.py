"""Stages of the blocks of a machine: by how many ticks each is late, after blocks whose outputs come late.

A block whose inputs come at different stages takes all of them at the latest stage, and its
registers wait as long after a reset. So the machine does the same as the graph, later. In a loop of
blocks that is impossible.
"""

from collections.abc import Mapping
from itertools import pairwise

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.rtl.machine.modules import Module


def block_stages(modules: Mapping[str, Module], drivers: Mapping[Endpoint, Endpoint]) -> dict[str, int]:
    """Stages by path; `drivers` are the outputs behind inputs. Raises `ModelError` for a cut in a loop of blocks."""
    before: dict[str, set[str]] = {path: set() for path in modules}
    for target, source in drivers.items():
        if source[0] in modules:
            before[target[0]].add(source[0])
    stages = dict.fromkeys(modules, 0)
    late = {path: module.pipeline.latency for path, module in modules.items() if module.pipeline.latency}
    for path in late:
        loop = _loop(path, before)
        if loop:
            raise _refused(path, loop, drivers).error
    moved = bool(late)
    while moved:
        moved = False
        for path, sources in before.items():
            stage = max((stages[each] + late.get(each, 0) for each in sources), default=0)
            moved |= stage > stages[path]
            stages[path] = max(stage, stages[path])
    return stages


def _loop(path: str, before: Mapping[str, set[str]]) -> list[str]:
    """A shortest path from a block back to itself, against the wires; empty if there is none."""
    ways = [[path]]
    reached: set[str] = set()
    for way in ways:
        for follower in sorted(before[way[-1]]):
            if follower == path:
                return [*way, path]
            if follower not in reached:
                reached.add(follower)
                ways.append([*way, follower])
    return []


def _refused(path: str, loop: list[str], drivers: Mapping[Endpoint, Endpoint]) -> Problem:
    wires = []
    for after, block in pairwise(loop):
        target, source = min((t, s) for t, s in drivers.items() if (t[0], s[0]) == (after, block))
        wires.append(f"{'.'.join(source)} -> {'.'.join(target)}")
    return Problem(
        message="a pipeline cut in a loop of blocks: each round would take longer than in the simulation",
        got=", ".join(wires[::-1]),
        expected="cuts in blocks whose outputs do not come back to them",
        hint="leave out the cut, or keep the stages in the state of the block, so that the simulation has them too",
        path=("blocks", path),
    )
