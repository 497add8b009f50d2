"""A digital block as a module: its functions as integer operations, its ports and registers with their ranges.

Constants and parameters are numbers of this graph, folded into the operations. Outputs and update
are traced into one program, so that they share common operations.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.declare import Port as BlockPort
from proofmass.blocks.declaration.instance import unit_of
from proofmass.runner.fixed.block_formats import function_formats, port_formats, state_formats
from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation, TraceError
from proofmass.runner.fixed.step_formats import Format, SteadyValue, Within, bounds, leaves, mantissas
from proofmass.runner.fixed.trace import Traced, trace
from proofmass.runner.rtl.machine.low_bits import operands_of
from proofmass.runner.rtl.machine.pipeline import Flow, Pipeline, pipelined
from proofmass.runner.rtl.machine.ranges import register_ranges
from proofmass.runner.rtl.machine.words import Register, VerilogNames, VerilogPort, Word

CLOCKING = ("clock", "reset", "enable")  # ports of a module with registers


@dataclass(frozen=True)
class Module:
    """A block with its numbers: what becomes one Verilog module.

    `steps` has each output function and "update" by name, all in one program. At a clock with
    `enable` the registers take the operations in `following`; with `reset`, their starts. Outputs
    come `pipeline.latency` ticks late.
    """

    name: str
    block: Block
    constants: Any  # first argument of the functions
    inputs: tuple[VerilogPort, ...]
    outputs: tuple[VerilogPort, ...]
    registers: tuple[Register, ...]
    steps: Mapping[str, Traced]
    results: Mapping[str, Operation]  # by the name of the output
    following: Mapping[str, Operation]  # by the name of the register

    @property
    def program(self) -> IntegerProgram:
        """The operations of all functions."""
        return next(iter(self.steps.values())).program

    @cached_property
    def live(self) -> list[Operation]:
        """The operations that outputs and registers depend on, operands first."""
        return self.program.live([*self.results.values(), *self.following.values()])

    @cached_property
    def needed(self) -> list[Operation]:
        """The live operations that are written; the steps of a wrap are not: it is low bits of its operand."""
        needed = {*self.results.values(), *self.following.values()}
        for operation in reversed(self.live):
            if operation in needed:
                needed.update(operands_of(operation))
        return sorted((n for n in needed if n.kind != "constant"), key=lambda operation: operation.number)

    @cached_property
    def pipeline(self) -> Pipeline:
        """Stages of the operations; raises `TraceError` for a cut in a feedback."""
        operands = {operation: operands_of(operation) for operation in self.needed}
        registers = {register.text: register.name for register in self.registers}
        return pipelined(Flow(operands, self.results, self.following, registers), self.name)

    @property
    def clocked(self) -> bool:
        """Return whether it has the ports clock, reset and enable."""
        return bool(self.registers or self.pipeline.latency)

    @cached_property
    def sources(self) -> Mapping[str, VerilogPort | Register]:
        """Port or register behind each input of the program, by its name there."""
        sources: list[VerilogPort | Register] = [*self.inputs, *self.registers]
        return {each.text: each for each in sources}


def make_module(
    name: str,
    block: Block,
    constants: Any,
    start: Any,
    buffers: Mapping[str, Sequence[int]],
    ranges: Mapping[str, Word],
) -> Module:
    """Return the module of a block; `start` and `buffers` are mantissas, `ranges` those of its integer inputs.

    Raises `ModelError`, with the line of Python, for anything that cannot become hardware.
    """
    leaves_held = list(_held(block, start, buffers))
    narrowed: dict[str, Format] = {text: Within(word.low, word.high) for text, word in ranges.items()}
    narrowed |= _integer_ranges(name, block, constants, leaves_held, narrowed)
    steps = _traced(block, constants, narrowed, IntegerProgram())
    names = VerilogNames(CLOCKING)
    inputs = tuple(
        VerilogPort(names.add(text), text, _word(format), unit_of(block, port), port.doc)
        for port in type(block).inputs.values()
        for format, text in leaves(port_formats(block, port, narrowed), port.name)
    )
    outputs, results = [], {}
    for port in type(block).outputs.values():
        for format, text, operation in _results(block, port, steps[port.name]):
            outputs.append(VerilogPort(names.add(text), text, _word(format, operation), unit_of(block, port), port.doc))
            results[outputs[-1].name] = operation
    registers, following = [], {}
    for leaf in leaves_held:
        word = _word(narrowed.get(leaf.whole, leaf.format))
        if word.low != word.high:
            registers.append(Register(names.add(leaf.text), leaf.text, word, leaf.start))
            following[registers[-1].name] = _following(steps, leaf.text, word)
    made = Module(name, block, constants, inputs, tuple(outputs), tuple(registers), steps, results, following)
    _refuse_unknown(made)
    _ = made.pipeline
    return made


def entries(ports: Iterable[VerilogPort], name: str) -> list[VerilogPort]:
    """Return the ports of the value that Python calls `name`: one, or one for each entry."""
    return [port for port in ports if port.text.partition("[")[0] == name]


class _Held(NamedTuple):
    """A number that the block keeps: a field of the state, or an entry of the buffer `whole`."""

    whole: str
    text: str
    format: Format
    start: int


def _held(block: Block, start: Any, buffers: Mapping[str, Sequence[int]]) -> Iterator[_Held]:
    state = state_formats(block)
    for (format, text), (_, value) in zip(leaves(state, "x"), mantissas(state, start, "x"), strict=True):
        yield _Held(text, text, format, int(value))
    for name, buffer in type(block).buffers.items():
        formats = port_formats(block, buffer)
        for (format, text), value in zip(leaves(formats, name), buffers[name], strict=True):
            yield _Held(name, text, format, int(value))


def _integer_ranges(
    name: str, block: Block, constants: Any, leaves: Sequence[_Held], narrowed: Mapping[str, Format]
) -> dict[str, Format]:
    """The ranges of plain integers that the block keeps; one for all entries of a buffer."""
    starts: dict[str, Interval] = {}
    for each in leaves:
        if each.format is int:
            low, high = starts.get(each.whole, (each.start, each.start))
            starts[each.whole] = min(low, each.start), max(high, each.start)

    def step(ranges: Mapping[str, Interval]) -> tuple[IntegerProgram, dict[str, list[Operation]]]:
        program = IntegerProgram()
        steps = _traced(block, constants, {**narrowed, **_within(ranges)}, program, only="update")
        return program, {
            text: [_following(steps, e.text, Word(*ranges[text])) for e in leaves if e.whole == text] for text in ranges
        }

    return _within(register_ranges(name, starts, step) if starts else {})


def _within(ranges: Mapping[str, Interval]) -> dict[str, Format]:
    return {text: Within(*interval) for text, interval in ranges.items()}


def _traced(
    block: Block, constants: Any, narrowed: Mapping[str, Format], program: IntegerProgram, only: str = ""
) -> dict[str, Traced]:
    functions = {**type(block).output_functions, **{n: b for n, b in type(block).functions.items() if n == "update"}}
    return {
        name: trace(b.function, function_formats(block, name, b, SteadyValue(constants), narrowed), program=program)
        for name, b in functions.items()
        if only in ("", name)
    }


def _word(format: Format, operation: Operation | None = None) -> Word:
    """Word of a format; for a computed integer, from the range of the result."""
    if format is int and operation is not None:
        return Word(operation.low, operation.high)
    return Word(*bounds(format), format.fraction if isinstance(format, Fixed) else 0)


def _results(block: Block, port: BlockPort, traced: Traced) -> Iterator[tuple[Format, str, Operation]]:
    """The numbers of an output, by the texts "output" or "output[2]"."""
    if not port.shape:
        yield traced.formats["return"], port.name, traced.results["return"]
        return
    for format, text in leaves(traced.formats["out"], "out"):
        yield format, text.replace("out", port.name, 1), traced.writes[text]


def _following(steps: Mapping[str, Traced], text: str, word: Word) -> Operation:
    """Next value of a register: its present value if no update sets it."""
    program = next(iter(steps.values())).program
    present = program.input(text, word.low, word.high)
    if "update" in steps:
        update = steps["update"]
        present = update.writes.get(text, present)
        present = update.results.get(f"return{text.removeprefix('x')}", present) if text.startswith("x.") else present
    return present


def _refuse_unknown(module: Module) -> None:
    """Refuse values that are read but are neither inputs nor registers."""
    for operation in module.live:
        if operation.kind == "input" and operation.name not in module.sources:
            hint = "count in the state, up to a number that it starts again from"
            raise TraceError(f"{operation.name} is not a register", operation.place, hint=hint, key=module.name)
