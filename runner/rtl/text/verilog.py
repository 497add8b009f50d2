"""A module as Verilog-2001: one operator a line, every wire exactly as wide as the range of its value.

Wires are signed, truth values one bit without sign; literals are exactly as wide as their value. So
the text relies on no rule of Verilog about widths or signs but sign extension. A line ends with the
line of Python that made it, with its text the first time.
"""

import linecache
from collections.abc import Generator, Iterator

from proofmass.runner.fixed.integer_ir import Operation, SourceLine
from proofmass.runner.fixed.operations import OPERATIONS
from proofmass.runner.rtl.machine.modules import CLOCKING, Module
from proofmass.runner.rtl.machine.words import VerilogNames, VerilogPort, Word
from proofmass.runner.rtl.text.expressions import VerilogExpressions, fitted


def module_text(module: Module, *, keep_adders: bool = True) -> str:
    """The Verilog of a module.

    With `keep_adders` sums are marked `(* keep *)`: Yosys would make sums of three and more terms
    of LUTs, two to three times as many as carry chains take.
    """
    return "\n".join(_lines(module, keep_adders)) + "\n"


def declared(kind: str, word: Word, name: str) -> str:
    """A declaration, as `input wire signed [15:0] error`.

    >>> declared("reg", Word(-8, 7), "x"), declared("wire", Word(0, 1), "on")
    ('reg signed [3:0] x', 'wire on')
    """
    sign = "signed " if word.signed else ""
    bits = f"[{word.width - 1}:0] " if word.width > 1 or word.signed else ""
    return f"{kind} {sign}{bits}{name}"


def header(
    name: str, clocked: bool, inputs: tuple[VerilogPort, ...], outputs: tuple[VerilogPort, ...]
) -> Iterator[str]:
    """The lines that open a module."""
    rows = [(f"input wire {port}", "") for port in (CLOCKING if clocked else ())]
    for kind, ports in (("input wire", inputs), ("output wire", outputs)):
        rows += [(declared(kind, port.word, port.name), f"  // {about(port)}") for port in ports]
    yield f"module {name} ("
    for i, (row, comment) in enumerate(rows):
        yield f"    {row}{',' if i < len(rows) - 1 else ''}{comment}"
    yield ");"


def about(port: VerilogPort) -> str:
    """Return format, unit and meaning of a port in one line."""
    unit = "" if port.unit == "1" else f" {port.unit}"
    return f"{port.word}{unit}: {first_line(port.doc)}"


def first_line(doc: str) -> str:
    """Return the first line of a docstring."""
    return doc.strip().partition("\n")[0]


def line_comment(place: SourceLine | None, shown: set[SourceLine], mark: str = "//") -> str:
    """Return a comment with a line of Python, and with its text if it is not in `shown` yet."""
    if place is None:
        return ""
    text = "" if place in shown else f"  {linecache.getline(place.path, place.line).strip()}"
    shown.add(place)
    return f"  {mark} {place}{text}".rstrip()


def _lines(module: Module, keep_adders: bool) -> Iterator[str]:
    writer = _Writer(module)
    wires = list(writer.wires(keep_adders))
    latency = module.pipeline.latency
    late = f", {latency} tick{'s' if latency > 1 else ''} late" if latency else ""
    yield f"// {type(module.block).__name__}: {first_line(type(module.block).__doc__ or '')}{late}"
    yield from header(module.name, module.clocked, module.inputs, module.outputs)
    for register in module.registers:
        yield f"    {declared('reg', register.word, register.name)};  // {register.text} {register.word}"
    yield from wires
    yield from writer.moves()
    yield from writer.registers()
    for port in module.outputs:
        yield f"    assign {port.name} = {writer.expressions.stored(module.results[port.name], port.word, latency)};"
    yield "endmodule"


class _Writer:
    """The lines of one module, and the names in it."""

    def __init__(self, module: Module) -> None:
        self.module = module
        ports = [port.name for port in (*module.inputs, *module.outputs)]
        self.names = VerilogNames([*CLOCKING, *ports, *(register.name for register in module.registers)])
        self.expressions = VerilogExpressions(module.pipeline.stages)
        self._told: set[SourceLine] = set()
        self._count = 0
        self._moves: list[tuple[str, str]] = []  # registers of the pipeline, and their next values

    def wires(self, keep_adders: bool) -> Iterator[str]:
        """Write a wire for each operation that needs one, and registers if it is taken later."""
        for operation in self.module.needed:
            if operation.kind == "input":
                name, truth = yield from self._source(operation)
            else:
                name, truth = yield from self._operation(operation, keep_adders)
            names = [name]
            for k in range(1, self.module.pipeline.delays.get(operation, 0) + 1):
                names.append(self.names.add(f"{name}_late_{k}"))
                yield f"    {self._declared('reg', names[-1], operation, truth)};"
                self._moves.append((names[-1], names[-2]))
            self.expressions.name(operation, names, truth=truth)

    def _source(self, operation: Operation) -> Generator[str, None, tuple[str, bool]]:
        """The name of a port or register, signed if a number; and whether it is one bit."""
        source = self.module.sources[operation.name]
        if source.word.signed or source.word.high == 1:
            return source.name, not source.word.signed
        name = self.names.add(f"signed_{source.name}")
        yield f"    {self._declared('wire', name, operation, False)} = {{1'b0, {source.name}}};"
        return name, False

    def _operation(self, operation: Operation, keep_adders: bool) -> Generator[str, None, tuple[str, bool]]:
        expression = self.expressions.of(operation)
        if expression.alias:
            return expression.text, expression.truth
        self._count += 1
        name = self.names.add(f"{OPERATIONS[operation.kind].word}_{self._count}")
        comment = line_comment(operation.place, self._told)
        if operation.kind == "pipe":
            self._moves.append((name, expression.text))
            yield f"    {self._declared('reg', name, operation, expression.truth)};{comment}"
            return name, expression.truth
        wire = self._declared("wire", name, operation, expression.truth)
        if keep_adders and OPERATIONS[operation.kind].adder and not expression.wiring:
            wire = f"(* keep *) {wire}; assign {name}"  # Icarus refuses attributes of both as one
        yield f"    {wire} = {expression.text};{comment}"
        return name, expression.truth

    def moves(self) -> Iterator[str]:
        """Write the registers of the pipeline, whose values after a reset are not used."""
        if self._moves:
            yield "    always @(posedge clock)"
            yield "        if (enable) begin"
            yield from (f"            {name} <= {taken};" for name, taken in self._moves)
            yield "        end"

    def registers(self) -> Iterator[str]:
        """Write the registers of the block; those after cuts wait until the first values have come through."""
        pipeline = self.module.pipeline
        ready = [self.names.add(f"ready_{k}") for k in range(1, pipeline.waits + 1)]
        yield from (f"    reg {name};" for name in ready)
        if not self.module.registers:
            return
        yield "    always @(posedge clock)"
        yield "        if (reset) begin"
        yield from (f"            {name} <= 1'b0;" for name in ready)
        for register in self.module.registers:
            yield f"            {register.name} <= {fitted(register.start, register.word)};"
        yield "        end else if (enable) begin"
        yield from (f"            {name} <= {before};" for name, before in zip(ready, ["1'b1", *ready], strict=False))
        for register in self.module.registers:
            stage = pipeline.registers[register.name]
            taken = self.expressions.stored(self.module.following[register.name], register.word, stage)
            waits = f"if ({ready[stage - 1]}) " if stage else ""
            yield f"            {waits}{register.name} <= {taken};"
        yield "        end"

    def _declared(self, kind: str, name: str, operation: Operation, truth: bool) -> str:
        return f"{kind} {name}" if truth else f"{kind} signed [{operation.width - 1}:0] {name}"
