"""Stages of a pipeline: by how many ticks each value is late, so that operands of an operation are equally late.

A cut is one tick later than its operand. A register is as late as its next value. If that depends
on the register itself through a cut, no stage is late enough, and the cut is refused.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from proofmass.graphs.model.digraph import with_following
from proofmass.runner.fixed.integer_ir import Operation, TraceError


@dataclass(frozen=True)
class Pipeline:
    """Stages of operations and of registers, in ticks; constants have none. Outputs are all `latency` late.

    `delays` gives the number of registers after an operation some readers take later than it comes.
    """

    stages: Mapping[Operation, int]
    registers: Mapping[str, int]
    latency: int
    delays: Mapping[Operation, int]

    @property
    def waits(self) -> int:
        """Ticks after a reset until every register may move."""
        return max(self.registers.values(), default=0)


@dataclass(frozen=True)
class Flow:
    """Dependencies in a module: `operands` of each operation; the operations of outputs (`results`)
    and the next values of registers (`following`), by name; `registers` has the names of registers
    by their texts.
    """

    operands: Mapping[Operation, tuple[Operation, ...]]
    results: Mapping[str, Operation]
    following: Mapping[str, Operation]
    registers: Mapping[str, str]


def pipelined(flow: Flow, name: str) -> Pipeline:
    """The stages of a module; raises `TraceError` for a cut in a feedback."""
    order = sorted(flow.operands, key=lambda operation: operation.number)
    for operation in order:
        if operation.kind == "pipe":
            _refuse_feedback(flow, operation, name)
    register_stages = dict.fromkeys(flow.following, 0)
    stages = _stages(flow, order, register_stages)
    while late := {r: stages[n] for r, n in flow.following.items() if n in stages and stages[n] > register_stages[r]}:
        register_stages |= late
        stages = _stages(flow, order, register_stages)
    latency = max((stages[operation] for operation in flow.results.values() if operation in stages), default=0)
    uses = [
        (each, stages[operation] - (operation.kind == "pipe"))
        for operation in stages
        for each in flow.operands[operation]
    ]
    uses += [(operation, latency) for operation in flow.results.values()]
    uses += [(operation, register_stages[register]) for register, operation in flow.following.items()]
    delays: dict[Operation, int] = {}
    for operation, stage in uses:
        if operation in stages and stage > stages[operation]:
            delays[operation] = max(delays.get(operation, 0), stage - stages[operation])
    return Pipeline(stages, register_stages, latency, delays)


def _stages(flow: Flow, order: Iterable[Operation], register_stages: Mapping[str, int]) -> dict[Operation, int]:
    stages: dict[Operation, int] = {}
    for operation in order:
        if operation.kind == "input":
            stages[operation] = register_stages.get(flow.registers.get(operation.name, ""), 0)
        elif operation.kind != "constant":
            before = max((stages[each] for each in flow.operands[operation] if each in stages), default=0)
            stages[operation] = before + (operation.kind == "pipe")
    return stages


def _refuse_feedback(flow: Flow, cut: Operation, name: str) -> None:
    """Refuse a cut that depends on itself, by way of registers."""
    below = _below(flow, flow.operands[cut])
    if cut in below:
        texts = [
            operation.name for operation in below if operation.kind == "input" and operation.name in flow.registers
        ]
        inside = [text for text in texts if cut in _below(flow, [flow.following[flow.registers[text]]])]
        raise TraceError(
            f"a pipeline cut in the feedback of {' and '.join(sorted(inside))}",
            cut.place,
            got="a register that would compute with its own value of a tick before",
            expected="cuts in paths that do not come back to the register that they start from",
            hint="cut what does not come back to it, or keep the stages in the state and let the loop be longer",
            key=name,
        )


def _below(flow: Flow, operations: Iterable[Operation]) -> set[Operation]:
    """Return all operations on which some depend, these included, also through registers."""

    def operands(operation: Operation) -> tuple[Operation, ...]:
        before = operation.kind == "input" and operation.name in flow.registers
        return (flow.following[flow.registers[operation.name]],) if before else flow.operands.get(operation, ())

    return with_following(operations, operands)
