"""A module as Verilog-2001: one operator a line, every wire exactly as wide as the range of its value.

Wires are signed, truth values one bit without sign; literals are exactly as wide as their value. So no rule of Verilog
about widths or signs is relied on but the extension of the sign. A line ends with the line of Python that made it, with
its text the first time.
"""

import linecache
from collections.abc import Iterator

from proofmass.runner.fixed.integer_ir import Place
from proofmass.runner.rtl.expressions import Expressions, fitted
from proofmass.runner.rtl.modules import CLOCKING, Module
from proofmass.runner.rtl.words import Names, Port, Word

_WORDS = {
    "narrow": "low_bits",
    "add": "sum",
    "subtract": "difference",
    "multiply": "product",
    "negate": "negated",
    "shift_left": "shifted",
    "shift_right": "shifted",
    "and": "both",
    "or": "either",
    "xor": "unlike",
    "less": "less",
    "less_equal": "at_most",
    "equal": "equal",
    "not_equal": "differs",
    "minimum": "smaller",
    "maximum": "larger",
    "select": "chosen",
}  # first parts of the names of wires
_ADDERS = frozenset({"add", "subtract", "negate"})


def module_text(module: Module, *, keep_adders: bool = True) -> str:
    """The Verilog of a module.

    With `keep_adders` sums are marked `(* keep *)`: Yosys would make sums of three and more terms of LUTs, two to three
    times as many as carry chains take.
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


def header(name: str, clocked: bool, inputs: tuple[Port, ...], outputs: tuple[Port, ...]) -> Iterator[str]:
    """The lines that open a module."""
    rows = [(f"input wire {port}", "") for port in (CLOCKING if clocked else ())]
    for kind, ports in (("input wire", inputs), ("output wire", outputs)):
        rows += [(declared(kind, port.word, port.name), f"  // {about(port)}") for port in ports]
    yield f"module {name} ("
    for i, (row, comment) in enumerate(rows):
        yield f"    {row}{',' if i < len(rows) - 1 else ''}{comment}"
    yield ");"


def about(port: Port) -> str:
    """Format, unit and meaning of a port, in one line."""
    unit = "" if port.unit == "1" else f" {port.unit}"
    return f"{port.word}{unit}: {first_line(port.doc)}"


def first_line(doc: str) -> str:
    """What a docstring begins with."""
    return doc.strip().partition("\n")[0]


def _lines(module: Module, keep_adders: bool) -> Iterator[str]:
    ports = [port.name for port in (*module.inputs, *module.outputs)]
    names = Names([*CLOCKING, *ports, *(register.name for register in module.registers)])
    expressions = Expressions(module.sources)
    wires = list(_wires(module, expressions, names, keep_adders))
    yield f"// {type(module.block).__name__}: {first_line(type(module.block).__doc__ or '')}"
    yield from header(module.name, bool(module.registers), module.inputs, module.outputs)
    for register in module.registers:
        yield f"    {declared('reg', register.word, register.name)};  // {register.text} {register.word}"
    yield from wires
    yield from _clocked(module, expressions)
    for port in module.outputs:
        yield f"    assign {port.name} = {expressions.stored(module.results[port.name], port.word)};"
    yield "endmodule"


def _wires(module: Module, expressions: Expressions, names: Names, keep_adders: bool) -> Iterator[str]:
    """A wire for each operation that needs one."""
    told: set[Place] = set()
    counts = 0
    for node in module.needed:
        source = module.sources.get(node.name) if node.operation == "input" else None
        if source is not None:
            if not source.word.signed and source.word.high > 1:
                name = names.add(f"signed_{source.name}")
                yield f"    wire signed [{node.width - 1}:0] {name} = {{1'b0, {source.name}}};"
                expressions.name(node, name)
            else:
                expressions.name(node, source.name, truth=not source.word.signed)
            continue
        expression = expressions.of(node)
        if expression.alias:
            expressions.name(node, expression.text, truth=expression.truth)
            continue
        counts += 1
        name = names.add(f"{_WORDS[node.operation]}_{counts}")
        wire = f"wire {name}" if expression.truth else f"wire signed [{node.width - 1}:0] {name}"
        if keep_adders and node.operation in _ADDERS and not expression.wiring:
            wire = f"(* keep *) {wire}; assign {name}"  # Icarus takes no attribute where both are one
        yield f"    {wire} = {expression.text};{_comment(node.place, told)}"
        expressions.name(node, name, truth=expression.truth)


def _clocked(module: Module, expressions: Expressions) -> Iterator[str]:
    if not module.registers:
        return
    yield "    always @(posedge clock)"
    yield "        if (reset) begin"
    for register in module.registers:
        yield f"            {register.name} <= {fitted(register.start, register.word)};"
    yield "        end else if (enable) begin"
    for register in module.registers:
        following = module.following[register.name]
        yield f"            {register.name} <= {expressions.stored(following, register.word)};"
    yield "        end"


def _comment(place: Place | None, told: set[Place]) -> str:
    if place is None:
        return ""
    text = "" if place in told else f"  {linecache.getline(place.path, place.line).strip()}"
    told.add(place)
    return f"  // {place}{text}".rstrip()
