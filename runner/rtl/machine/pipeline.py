"""Stages of a pipeline: by how many ticks each value is late, so that operands of an operation are equally late.

A cut is one tick later than what it cuts. A register is as late as what it takes; where that depends on the register
itself through a cut, no stage is late enough, and the cut is refused.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from proofmass.runner.fixed.integer_ir import Node, TraceError


@dataclass(frozen=True)
class Pipeline:
    """Stages of operations and of registers, in ticks; constants have none. Outputs are all `latency` late.

    `delays` says how many registers follow an operation, for those that take it later than it is there.
    """

    stages: Mapping[Node, int]
    registers: Mapping[str, int]
    latency: int
    delays: Mapping[Node, int]

    @property
    def waits(self) -> int:
        """Ticks after a reset until every register may move."""
        return max(self.registers.values(), default=0)


@dataclass(frozen=True)
class Flow:
    """What depends on what in a module: `operands` of each operation, and by the names of the ports and registers what
    outputs give (`results`) and registers take (`following`); `registers` are the names of registers by their texts.
    """

    operands: Mapping[Node, tuple[Node, ...]]
    results: Mapping[str, Node]
    following: Mapping[str, Node]
    registers: Mapping[str, str]


def pipelined(flow: Flow, name: str) -> Pipeline:
    """The stages of a module; raises `TraceError` for a cut in a feedback."""
    order = sorted(flow.operands, key=lambda node: node.number)
    for node in order:
        if node.operation == "pipe":
            _refuse_feedback(flow, node, name)
    held = dict.fromkeys(flow.following, 0)
    stages = _stages(flow, order, held)
    while late := {r: stages[n] for r, n in flow.following.items() if n in stages and stages[n] > held[r]}:
        held |= late
        stages = _stages(flow, order, held)
    latency = max((stages[node] for node in flow.results.values() if node in stages), default=0)
    taken = [(each, stages[node] - (node.operation == "pipe")) for node in stages for each in flow.operands[node]]
    taken += [(node, latency) for node in flow.results.values()]
    taken += [(node, held[register]) for register, node in flow.following.items()]
    delays: dict[Node, int] = {}
    for node, stage in taken:
        if node in stages and stage > stages[node]:
            delays[node] = max(delays.get(node, 0), stage - stages[node])
    return Pipeline(stages, held, latency, delays)


def _stages(flow: Flow, order: Iterable[Node], held: Mapping[str, int]) -> dict[Node, int]:
    stages: dict[Node, int] = {}
    for node in order:
        if node.operation == "input":
            stages[node] = held.get(flow.registers.get(node.name, ""), 0)
        elif node.operation != "constant":
            before = max((stages[each] for each in flow.operands[node] if each in stages), default=0)
            stages[node] = before + (node.operation == "pipe")
    return stages


def _refuse_feedback(flow: Flow, cut: Node, name: str) -> None:
    """Refuse a cut that depends on itself, by way of registers."""
    below = _below(flow, flow.operands[cut])
    if cut in below:
        texts = [node.name for node in below if node.operation == "input" and node.name in flow.registers]
        inside = [text for text in texts if cut in _below(flow, [flow.following[flow.registers[text]]])]
        hint = "cut what does not come back to it, or keep the stages in the state and let the loop be longer"
        raise TraceError(
            f"a pipeline cut in the feedback of {' and '.join(sorted(inside))}",
            cut.place,
            got="a register that would compute with its own value of a tick before",
            expected="cuts in paths that do not come back to the register that they start from",
            hint=hint,
            key=name,
        )


def _below(flow: Flow, nodes: Iterable[Node]) -> set[Node]:
    """What the nodes depend on, themselves included, by way of registers too."""
    found: set[Node] = set()
    todo = list(nodes)
    while todo:
        node = todo.pop()
        if node not in found:
            found.add(node)
            todo += flow.operands.get(node, ())
            if node.operation == "input" and node.name in flow.registers:
                todo.append(flow.following[flow.registers[node.name]])
    return found
