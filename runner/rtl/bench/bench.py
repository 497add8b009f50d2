"""A self-checking test bench in Verilog: it plays vectors of the simulation and compares every
output in every clock.

One process drives clock and stimuli, so their order is the same in every simulator. It prints PASS,
or the first differences and FAIL.
"""

from collections.abc import Iterator, Mapping, Sequence

from proofmass.runner.host.arrays import Integers
from proofmass.runner.rtl.bench.vectors import Vectors
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.words import VerilogNames, VerilogPort
from proofmass.runner.rtl.text.machine_verilog import top_name
from proofmass.runner.rtl.text.verilog import declared

SHOWN = 10  # differences
_OWN = ("clock", "reset", "n", "wrong", "stimuli", "applied", "expected", "awaited", "machine")  # names of the bench


def bench_files(machine: Machine, vectors: Vectors) -> dict[str, str]:
    """Return the files of the bench by name: its Verilog, and the vectors that it reads from its working folder."""
    name = top_name(machine)
    files = {f"{name}_bench.v": "\n".join(_lines(machine, vectors.clocks)) + "\n"}
    if machine.inputs:
        files[f"{name}_inputs.hex"] = _packed(machine.inputs, vectors.inputs)
    files[f"{name}_outputs.hex"] = _packed(machine.outputs, vectors.outputs)
    return files


def places(ports: Sequence[VerilogPort]) -> Iterator[tuple[VerilogPort, int]]:
    """The lowest bit of each port in a vector, the first port lowest."""
    low = 0
    for port in ports:
        yield port, low
        low += port.word.width


def _lines(machine: Machine, clocks: int) -> Iterator[str]:
    name, late = top_name(machine), machine.latency
    names = VerilogNames(_OWN)
    outputs = {port.name: names.add(port.name) for port in machine.outputs}
    before, due, at = (f"if (n < {clocks}) ", f"n >= {late} && ", f"n - {late}") if late else ("", "", "n")
    yield "`timescale 1ns / 1ps"
    yield f"module {name}_bench;"
    yield "    reg clock, reset;"
    yield "    integer n, wrong;"
    if machine.inputs:
        yield f"    reg [{_width(machine.inputs) - 1}:0] stimuli [0:{clocks - 1}];"
        yield f"    reg [{_width(machine.inputs) - 1}:0] applied;"
    yield f"    reg [{_width(machine.outputs) - 1}:0] expected [0:{clocks - 1}];"
    yield f"    reg [{_width(machine.outputs) - 1}:0] awaited;"
    for port in machine.outputs:
        yield f"    {declared('wire', port.word, outputs[port.name])};"
    yield from _instance(machine, outputs)
    yield "    initial begin"
    if machine.inputs:
        yield f'        $readmemh("{name}_inputs.hex", stimuli);'
    yield f'        $readmemh("{name}_outputs.hex", expected);'
    yield "        wrong = 0; clock = 0; reset = 1;"
    yield "        #5 clock = 1; #5 clock = 0; reset = 0;"
    yield f"        for (n = 0; n < {clocks + late}; n = n + 1) begin"
    if machine.inputs:
        yield f"            {before}applied = stimuli[n];"
    yield f"            awaited = expected[{at}];"
    yield "            #4;"
    for port, low in places(machine.outputs):
        wire, place = outputs[port.name], _bits(port, low)
        expected = f"$signed(awaited{place})" if port.word.signed else f"awaited{place}"
        yield f"            if ({due}{wire} !== awaited{place}) begin"
        yield "                wrong = wrong + 1;"
        yield f"                if (wrong <= {SHOWN})"
        yield f'                    $display("clock %0d: {port.name} is %0d, not %0d", n, {wire}, {expected});'
        yield "            end"
    yield "            #1 clock = 1; #5 clock = 0;"
    yield "        end"
    yield f'        if (wrong == 0) $display("PASS: {clocks} clocks");'
    yield f'        else $display("FAIL: %0d differences in {clocks} clocks", wrong);'
    yield "        $finish;"
    yield "    end"
    yield "endmodule"


def _instance(machine: Machine, found: Mapping[str, str]) -> Iterator[str]:
    rows = [".clock(clock)", ".reset(reset)", ".enable(1'b1)"] if machine.clocked else []
    rows += [f".{port.name}(applied{_bits(port, low)})" for port, low in places(machine.inputs)]
    rows += [f".{port.name}({found[port.name]})" for port in machine.outputs]
    yield f"    {top_name(machine)} machine ("
    yield ",\n".join(f"        {row}" for row in rows)
    yield "    );"


def _width(ports: Sequence[VerilogPort]) -> int:
    return sum(port.word.width for port in ports)


def _bits(port: VerilogPort, low: int) -> str:
    return f"[{low + port.word.width - 1}:{low}]"


def _packed(ports: Sequence[VerilogPort], columns: Mapping[str, Integers]) -> str:
    """One line of hexadecimal digits for each clock."""
    digits = -(-_width(ports) // 4)
    rows = zip(*(columns[port.name].tolist() for port in ports), strict=True)
    where = [(low, (1 << port.word.width) - 1) for port, low in places(ports)]
    words = (sum((value & mask) << low for value, (low, mask) in zip(row, where, strict=True)) for row in rows)
    return "".join(f"{word:0{digits}x}\n" for word in words)
