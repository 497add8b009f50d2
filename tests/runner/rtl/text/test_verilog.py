"""The Verilog of modules, run by its own rules, against the blocks' functions in plain Python."""

import random
import re
import shutil
from typing import Any, NamedTuple

import pytest

from proofmass.blocks import FixedStiffnessController, ShiftRegister
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, clip, where, wrap
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.words import VerilogPort, Word
from proofmass.runner.rtl.text.verilog import module_text
from tests.by_hand.modules import Reference, module_of
from tests.by_hand.verilog import ModuleByHand

OTHERS = {
    "FixedCorrelationCell": [{"lag": 3, "order": 3}],
    "FixedMassSpringDamper": [
        {"method": "forward_euler", "overflow": "wrap"},
        {"method": "leapfrog"},
        dict.fromkeys(("large_format", "damping_format", "small_format", "step_format"), Fixed(32, 24)),
    ],
    "FixedStiffnessController": [{"rounding": "toward_zero", "overflow": "wrap"}],
    "FixedPID": [{"rounding": "floor", "overflow": "wrap"}],
    "FixedCordicExponentialPipeline": [{"fraction_bits": 8, "iterations": 6}],
}
NUMBERS = {"Correlator"}  # sums of codes: no format says how large they grow
DIGITAL = [
    kind(**parameters)
    for name, kind in sorted(all_blocks().items())
    if kind.outputs and not kind.continuous() and name not in NUMBERS
    and all(port.dtype is not float for port in (*kind.inputs.values(), *kind.outputs.values()))
    for parameters in [{}, *OTHERS.get(name, [])]
]  # fmt: skip


def drawn(draws: random.Random, port: VerilogPort) -> int:
    """Ends of the range more often than by chance."""
    low, high = port.word.low, port.word.high
    return draws.choice([low, high, draws.randint(low, high), draws.randint(low // 64, high // 64)])


def compare(module: Module, ticks: int) -> None:
    """Outputs and registers of the text, tick by tick, and that nothing moves without an enable."""
    hardware, reference, draws = ModuleByHand(module_text(module)), Reference(module), random.Random(1)
    if module.clocked:
        hardware.clock({port.name: drawn(draws, port) for port in module.inputs}, reset=1)
    late: list[dict[str, int]] = []
    for tick in range(ticks + module.pipeline.latency):
        inputs = {port.name: drawn(draws, port) for port in module.inputs}
        if tick % 5 == 2:
            hardware.clock(inputs, enable=0)
        found = hardware.clock(inputs)
        late.append(reference.tick(inputs))
        if tick >= module.pipeline.latency:
            assert found == late[tick - module.pipeline.latency], f"tick {tick}"
    if not module.pipeline.latency:
        assert {name: hardware.number(bits, hardware.kinds[name]) for name, bits in hardware.held.items()} == {
            register.name: reference.held[register.text] for register in module.registers
        }


@pytest.mark.exhaustive(but=10)
@pytest.mark.parametrize("block", DIGITAL, ids=repr)
def test_every_digital_block_does_in_hardware_what_it_does_in_python(block: Block) -> None:
    ranges = {name: Word(-5, 20) for name, port in type(block).inputs.items() if port.dtype is int}
    compare(module_of(block, ranges), 60)


class Mixer(Block):
    """Every operation of a step, in one block."""

    a = Input("1", "Signed.", dtype=FixedValue)
    b = Input("1", "Unsigned.", dtype=FixedValue)
    on = Input("1", "A truth value.", dtype=bool)


@Mixer.formats
def mixer_formats(p: Mixer) -> dict[str, Fixed]:
    ports = {"a": Fixed(9, 4), "b": Fixed(6, 2, signed=False)}
    return ports | {"signed": Fixed(8, 4), "unsigned": Fixed(7, 0, signed=False), "shifted": Fixed(24), "low": Fixed(5)}


@Mixer.output("1")
def signed(p: Mixer, a: FixedValue, b: FixedValue, on: bool) -> FixedValue:
    """Products, absolute values, a saturation."""
    return (abs(a) * b - where(on, a * a, -b)).to(Fixed(8, 4), "half_up")


@Mixer.output("1")
def unsigned(p: Mixer, a: FixedValue, b: FixedValue, on: bool) -> FixedValue:
    """Bits of both, and comparisons counted."""
    bits = (a.mantissa & 21) ^ (b.mantissa | 2)
    count = (a < b) + (a == 3) + (on & (b >= 8))
    return FixedValue(clip(bits + count, 0, 127))


@Mixer.output("1")
def shifted(p: Mixer, a: FixedValue, b: FixedValue) -> FixedValue:
    """Shifts by signals."""
    places = clip(b.mantissa, 0, 9)
    return FixedValue((a.mantissa << places) + (a.mantissa >> places) + (1 << places))


@Mixer.output("1")
def low(p: Mixer, a: FixedValue, on: bool) -> FixedValue:
    """Low bits with their sign."""
    if a.mantissa > 40 and on:
        return FixedValue(wrap(a.mantissa * 3, Fixed(5)))
    return FixedValue(wrap(-a.mantissa, Fixed(5)))


@Mixer.output("1")
def odd(p: Mixer, a: FixedValue, b: FixedValue, on: bool) -> bool:
    """Truth values of truth values."""
    return ((a.mantissa & 1) == 1) != on if b > 3 else not on


def test_every_operation_has_the_widths_and_signs_that_it_needs() -> None:
    compare(module_of(Mixer()), 400)


def test_rules_of_verilog_of_which_the_text_makes_no_use() -> None:
    """The interpreter here is one: a literal that is a bit short counts as positive among wider numbers."""
    ports = ["    input wire signed [7:0] x,", "    output wire signed [11:0] y"]
    text = "\n".join(["module trap (", *ports, ");", "    assign y = x + -8'sd128;", "endmodule"])
    assert ModuleByHand(text).clock({"x": 1}) == {"y": 129}
    assert ModuleByHand(text.replace("-8'sd128", "8'sh80")).clock({"x": 1}) == {"y": -127}


class State(NamedTuple):
    total: FixedValue


class Accumulator(Block):
    """Sum of products, with cuts."""

    cuts: int = param("1", "Cuts before the sum.", default=2, at_least=0)
    after: bool = param("1", "Whether there is one behind it.", default=True)

    a = Input("1", "Factor.", dtype=FixedValue)
    b = Input("1", "Factor.", dtype=FixedValue)


@Accumulator.formats
def accumulator_formats(p: Accumulator) -> dict[str, Fixed]:
    return {"a": Fixed(8, 4), "b": Fixed(8, 4), "x.total": Fixed(20, 8), "sum": Fixed(20, 8), "difference": Fixed(9, 4)}


@Accumulator.output("1")
def sum(p: Accumulator, x: State, a: FixedValue) -> FixedValue:
    """The sum before this tick, and half of a factor."""
    return ((pipe(x.total) if p.after else x.total) + (a >> 1)).to(Fixed(20, 8))


@Accumulator.output("1")
def difference(p: Accumulator, a: FixedValue, b: FixedValue) -> FixedValue:
    """Not cut."""
    return a - b


@Accumulator.update
def update(p: Accumulator, x: State, a: FixedValue, b: FixedValue) -> State:
    product = a * b
    for _ in range(p.cuts):
        product = pipe(product)
    return State((x.total + product).to(Fixed(20, 8)))


@pytest.mark.parametrize(("cuts", "after", "latency"), [(0, False, 0), (0, True, 1), (2, False, 2), (2, True, 3)])
def test_cut_blocks_do_the_same_later(cuts: int, after: bool, latency: int) -> None:
    module = module_of(Accumulator(cuts=cuts, after=after))
    assert module.pipeline.latency == latency
    compare(module, 200)


def test_lines_name_the_python_that_made_them_and_wires_are_as_wide_as_their_values() -> None:
    text = module_text(module_of(FixedStiffnessController()))
    line = next(line for line in text.splitlines() if "product" in line and "wire" in line)
    assert re.fullmatch(
        r"    wire signed \[30:0\] product_\d+ = error \* 12'sd1471;  // fixed_stiffness_controller.py:64"
        r"  correction = \(x\.correction \+ c\.gain \* x\.error\)\.to\(.*\)",
        line,
    )
    lines = text.splitlines()
    assert lines[0].startswith("// FixedStiffnessController: Integrates the static error")
    assert "    input wire signed [15:0] measured,  // (16, 12) V: Response y of the device." in lines
    assert "    reg signed [19:0] error;  // x.error (20, 12)" in lines
    assert "            error <= 20'sd0;" in lines
    assert all(" // " in line for line in lines if line.startswith(("    wire", "    (* keep *)")))


def test_sums_are_kept_unless_they_may_be_merged() -> None:
    module = module_of(FixedStiffnessController())
    kept, merged = module_text(module), module_text(module, keep_adders=False)
    code = [line.partition("//")[0] for line in kept.splitlines()]
    assert [" + " in line or " - " in line for line in code] == ["(* keep *) wire" in line for line in code]
    assert "keep" not in merged
    assert re.sub(r"\(\* keep \*\) (wire [^;]*?(\w+)); assign \2", r"\1", kept) == merged


def test_a_shift_register_is_its_bits() -> None:
    module = module_of(ShiftRegister())
    assert [(r.text, r.word, r.start) for r in module.registers] == [("x.cells", Word(0, 1023), 1023)]
    text = module_text(module)
    assert re.findall(r"\breg\b.*;", text) == ["reg [9:0] cells;"]
    assert "output wire bit_  //" in text  # a word of SystemVerilog


def test_a_block_without_registers_has_no_clock() -> None:
    text = module_text(module_of(Mixer()))
    assert "clock" not in text
    assert "always" not in text


@pytest.mark.skipif(shutil.which("iverilog") is None, reason="Icarus Verilog is not installed")
def test_icarus_takes_the_text_without_a_word(tmp_path: Any) -> None:
    import subprocess

    for block in (Mixer(), Accumulator(), FixedStiffnessController()):
        (tmp_path / "block.v").write_text(module_text(module_of(block)))
        command = ["iverilog", "-g2001", "-Wall", "-o", str(tmp_path / "out"), str(tmp_path / "block.v")]
        found = subprocess.run(command, capture_output=True, text=True, check=True)
        assert found.stdout + found.stderr == ""
