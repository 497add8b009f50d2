"""Proofs of Verilog: blocks, the composed calibration, mutants of the text, and counter-examples."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks import (
    ChipCounter,
    FixedCast,
    FixedCorrelationCell,
    FixedDampingController,
    FixedStiffnessController,
    ShiftRegister,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.reference import ModuleReference, reference_of
from proofmass.runner.rtl.proof.proof import Proof, prove
from proofmass.runner.rtl.text.machine_verilog import machine_text
from proofmass.runner.rtl.text.verilog import module_text
from tests.by_hand.modules import module_of
from tests.by_hand.verilog import ModuleByHand

pytest.importorskip("pyosys")
pytest.importorskip("bitwuzla")

CALIBRATION = library_file("self_calibration_fixed.toml")
NUMBERS = {"Correlator"}  # sums of codes: no format says how large they grow
DIGITAL = [
    kind()
    for name, kind in sorted(all_blocks().items())
    if kind.outputs and not kind.continuous() and name not in NUMBERS
    and all(port.dtype is not float for port in (*kind.inputs.values(), *kind.outputs.values()))
]  # fmt: skip
LONG = {
    "FixedCordicAngle",
    "FixedCordicVectoring",
    "FixedInPhaseQuadratureDemodulator",
    "FixedMassSpringDamper",
    "FixedStateSpace",
}


def _some_exhaustive(blocks: Sequence[Block]) -> list[Any]:
    """Parameters of a test: those whose proof takes seconds are exhaustive; FixedCordicRotation stays for them."""
    return [
        pytest.param(block, id=name, marks=[pytest.mark.exhaustive] if name in LONG else [])
        for name, block in ((type(block).__name__, block) for block in blocks)
    ]


def proved(module: Module, text: str = "", seconds: float = 30.0) -> Proof:
    guesses = {(node.low, node.high) for node in module.live}
    return prove(ModuleReference(module), text or module_text(module), guesses, seconds)


@pytest.mark.exhaustive(but=12)
@pytest.mark.exhaustive(
    "FixedCascadedIntegratorComb",
    "FixedCompensationRegister",
    "FixedCordicRotation",
    "FixedCordicScaledExponential",
    "FixedPID",
    "FixedCordicExponential",
    "FixedSlopeEstimator",
)
@pytest.mark.parametrize("block", _some_exhaustive(DIGITAL))
def test_every_digital_block_is_proved(block: Block) -> None:
    module = module_of(block)
    proof = proved(module)
    assert proof.proved == proof.goals
    assert proof.goals >= len(module.outputs) + len(module.registers)


@pytest.mark.exhaustive
def test_the_composed_calibration_is_proved() -> None:
    planned = plan(read_graph(CALIBRATION))
    machine = compose(planned, name="calibration")
    guesses = {(node.low, node.high) for module in machine.modules for node in module.live}
    whole = prove(reference_of(planned, machine), machine_text(machine), guesses)
    assert whole.name == "calibration"
    assert whole.proved == whole.goals == 29
    assert not whole.counter_examples


# -- mutants -------------------------------------------------------------------------------------------------------

CHANGES: tuple[tuple[str, Any], ...] = (  # a token of a line, and what takes its place
    (r" \+ ", " - "),
    (r" - ", " + "),
    (r" \* ", " + "),
    (r" < ", " <= "),
    (r" <= (?=\w+;)", " < "),
    (r" > ", " < "),
    (r" == ", " != "),
    (r" & ", " | "),
    (r" \^ ", " & "),
    (r" \? (\w+) : (\S+);", r" ? \2 : \1;"),
    (r"'sd(\d+)", lambda found: f"'sd{int(found[1]) ^ 1}"),
    (r"\[(\d+):(\d+)\];", lambda found: f"[{found[1]}:{int(found[2]) + 1}];"),
    (r"else if \(enable\)", "else if (!enable)"),
    (r"<<< (\d+)", lambda found: f"<<< {int(found[1]) - 1}"),
)
MUTATED = (
    ShiftRegister(),
    ChipCounter(),
    FixedCast(),
    FixedCorrelationCell(lag=2, order=4),
    FixedStiffnessController(),
    FixedDampingController(),
)
EITHER = "at the bound the two choices are equal"
EQUIVALENT = (  # lines, and why they do the same
    ("wire signed [2:0] shifted_3 = both_2[10:9];", "the same bits at another place: it is their parity that counts"),
    ("wire signed [15:0] smaller_7 = (16'sd32767 <= larger_6) ? 16'sd32767 : larger_6;", EITHER),
    ("wire signed [19:0] smaller_4 = (20'sd524287 <= larger_3) ? 20'sd524287 : larger_3;", EITHER),
    ("wire signed [19:0] smaller_4 = (20'sd524286 < larger_3) ? 20'sd524287 : larger_3;", EITHER),
    ("wire signed [19:0] smaller_4 = (20'sd524287 <= larger_3) ? 20'sd524287 : larger_3;", EITHER),
    ("wire signed [19:0] smaller_4 = (20'sd524286 < larger_3) ? 20'sd524287 : larger_3;", EITHER),
    ("wire signed [15:0] smaller_11 = (16'sd32767 <= larger_10) ? 16'sd32767 : larger_10;", EITHER),
)


def mutants(text: str) -> Iterator[str]:
    """Texts with one token changed, each change where it fits first."""
    code, _, rest = text.partition(");\n")
    for pattern, instead in CHANGES:
        lines = rest.split("\n")
        for i, line in enumerate(lines):
            before, slashes, comment = line.partition("  //")
            changed, count = re.subn(pattern, instead, before, count=1)
            if count and changed != before and "reg " not in before:
                yield ");\n".join([code, "\n".join([*lines[:i], changed + slashes + comment, *lines[i + 1 :]])])
                break


def is_refuted(module: Module, text: str) -> bool:
    try:
        return bool(proved(module, text, seconds=5.0).counter_examples)
    except ModelError:
        return True


@pytest.mark.exhaustive
def test_mutants_of_the_text_are_refuted_but_for_those_that_do_the_same() -> None:
    refuted, survivors = 0, list[str]()
    for block in MUTATED:
        module = module_of(block)
        text = module_text(module)
        for mutant in mutants(text):
            changed = next(new for new, old in zip(mutant.split("\n"), text.split("\n"), strict=True) if new != old)
            if is_refuted(module, mutant):
                refuted += 1
            else:
                survivors.append(changed.partition("  //")[0].strip())
    assert refuted >= 30
    assert sorted(survivors) == sorted(line for line, _ in EQUIVALENT)


def test_a_counter_example_is_what_verilog_and_python_make_of_it() -> None:
    module = module_of(FixedStiffnessController())
    text = module_text(module).replace("= modelled - measured", "= modelled + measured")
    assert text != module_text(module)
    found = {each.name: each for each in proved(module, text).counter_examples}
    assert set(found) == {"error"}
    stimulus = found["error"].stimulus
    after = []
    for each in (module_text(module), text):
        hardware = ModuleByHand(each)
        hardware.held = {name: stimulus[name] & ((1 << hardware.kinds[name].width) - 1) for name in hardware.held}
        inputs = {name: stimulus[name] for name in ("measured", "modelled", "window")}
        hardware.clock(inputs, reset=stimulus["reset"], enable=stimulus["enable"])
        after.append(str(hardware.number(hardware.held["error"], hardware.kinds["error"])))
    assert after == [found["error"].python, found["error"].verilog]
    assert str(found["error"]).startswith(f"error is {found['error'].python} in Python and {found['error'].verilog} in")


def test_a_text_without_a_register_or_with_other_bits_is_refused() -> None:
    module = module_of(ShiftRegister())
    with pytest.raises(ModelError, match="the Verilog has no such register") as caught:
        proved(module, module_text(module).replace("cells", "bits"))
    assert [problem.key for problem in caught.value.problems] == ["block.cells"]
    with pytest.raises(ModelError, match="Yosys refuses the Verilog"):
        proved(module, module_text(module).replace("endmodule", ""))


class Halved(Block):
    """Half of a number: it fits, but only because its last bit is lost before."""

    input = Input("1", "Number.", dtype=FixedValue)


@Halved.formats
def formats(p: Halved) -> dict[str, Fixed]:
    """A byte in, seven bits out, the last of which is worth two."""
    return {"input": Fixed(8), "output": Fixed(7)}


@Halved.output("1")
def output(p: Halved, input: FixedValue) -> FixedValue:
    """The half of it."""
    return (input >> 1).to(Fixed(7), "floor", "refuse")


def test_values_that_must_fit_are_proved_to_fit() -> None:
    proof = proved(module_of(Halved()))
    assert (proof.goals, proof.proved) == (1, 1)


@pytest.mark.exhaustive
def test_the_command_proves_and_writes_what_it_found(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["rtl", str(CALIBRATION), "--block", "counter", "-o", str(tmp_path), "--ticks", "3", "--prove"]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert re.search(r"module +goals +proved +seconds +solver\nchip_counter +\d +\d +\d+\.\d +bitwuzla\n", text)
    assert '"proved": 4' in (tmp_path / "report.json").read_text(encoding="utf-8")
    assert "chip_counter" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.exhaustive
def test_without_the_extra_the_command_says_what_to_install(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("proofmass.blocks.declaration.libraries.installed", lambda package: False)
    assert main(["rtl", str(CALIBRATION), "--block", "counter", "-o", str(tmp_path), "--ticks", "3", "--prove"]) == 1
    text = capsys.readouterr().err
    assert "pyosys is not installed: it makes proofs, resources and models of Verilog" in text
    assert 'pip install "proofmass[rtl]"' in text


def test_the_command_ends_with_1_on_a_counter_example(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong(*given: object, **options: object) -> str:
        return machine_text(*given, **options).replace("1'sd0 : sum", "1'sd1 : sum")  # type: ignore[arg-type]

    monkeypatch.setattr("proofmass.runner.commands.rtl_command.machine_text", wrong)
    words = ["rtl", str(CALIBRATION), "--block", "counter", "-o", str(tmp_path), "--ticks", "3", "--prove"]
    assert main(words) == 1
    assert "chip_counter.chip_ is 0 in Python and" in capsys.readouterr().out
