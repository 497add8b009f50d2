"""Proofs of pipelines: cut blocks and graphs of them, mutants of their text, and what is said of those."""

import random
import re
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.arithmetic.cordic import grown, hyperbolic_shifts
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.registers.fixed_cordic_exponential import Constants, exponential_constants, exponential_formats
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.bench.text import proof_lines
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.reference import ModuleReference, reference_of
from proofmass.runner.rtl.proof.proof import Proof, prove
from proofmass.runner.rtl.proof.prove_machine import prove_machine
from proofmass.runner.rtl.text.machine_verilog import machine_text
from proofmass.runner.rtl.text.verilog import module_text
from tests.by_hand.modules import Reference, module_of
from tests.by_hand.verilog import ModuleByHand
from tests.runner.rtl.machine.test_pipeline import Chain
from tests.runner.rtl.text.test_machine_verilog import cut_graph
from tests.runner.rtl.text.test_verilog import Accumulator, drawn

pytest.importorskip("pyosys")
pytest.importorskip("bitwuzla")


def proved(module: Module, text: str = "") -> Proof:
    guesses = {(node.low, node.high) for node in module.live}
    return prove(ModuleReference(module), text or module_text(module), guesses)


def changed(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


class Cube(Block):
    """Third power, a multiplication between two cuts."""

    input = Input("1", "Base.", dtype=FixedValue)


@Cube.formats
def cube_formats(p: Cube) -> dict[str, Fixed]:
    return {"input": Fixed(16, 12), "output": Fixed(24, 12)}


@Cube.output("1")
def output(p: Cube, input: FixedValue) -> FixedValue:
    """The cube."""
    square = pipe(input * input)
    return pipe(square * input).to(Fixed(24, 12))


class Exponential(Block):
    """CORDIC exponential, a cut behind each rotation."""

    angle = Input("1", "Exponent.", dtype=FixedValue)


@Exponential.formats
def exponential_ports(p: Exponential) -> dict[str, Fixed]:
    return exponential_formats(16)


@Exponential.constants
def rotations(p: Exponential, period: float) -> Constants:
    return exponential_constants(16, 16, 0)


@Exponential.output("1")
def exponential(c: Constants, p: Exponential, angle: FixedValue) -> FixedValue:
    """The exponential."""
    value, rest = c.start, angle.mantissa
    for shift, step in zip(hyperbolic_shifts(16), c.angles, strict=True):
        value, rest = map(pipe, grown(value, rest, shift, step))
    return FixedValue(value, 16).to(c.output, "floor", "refuse")


class State(NamedTuple):
    phase: FixedValue
    level: FixedValue
    peak: FixedValue


class Mixture(Block):
    """A phase that turns by itself, a level behind a product that is cut, and its peak behind another cut."""

    input = Input("1", "Input.", dtype=FixedValue)


@Mixture.formats
def mixture_formats(p: Mixture) -> dict[str, Fixed]:
    word = Fixed(10, 6)
    return {"input": Fixed(8, 4), "x": word, "mixed": word, "peak": word}


@Mixture.output("1")
def mixed(p: Mixture, x: State, input: FixedValue) -> FixedValue:
    """The input times the phase, now, and the level."""
    return (pipe(input * x.phase) + x.level).to(Fixed(10, 6))


@Mixture.output("1")
def peak(p: Mixture, x: State) -> FixedValue:
    """The peak."""
    return x.peak


@Mixture.update
def update(p: Mixture, x: State, input: FixedValue) -> State:
    product = pipe(input * x.phase)
    level = (x.level + (product >> 2)).to(Fixed(10, 6))
    before = pipe(x.level)
    if before > x.peak and pipe(pipe(input)) > 0:
        return State((x.phase * 3 + 1).to(Fixed(10, 6), "floor", "wrap"), level, before)
    return State((x.phase * 3 + 1).to(Fixed(10, 6), "floor", "wrap"), level, x.peak)


@pytest.mark.exhaustive("Exponential-int")
@pytest.mark.parametrize(
    ("block", "latency"),
    [(Cube(), 2), (Exponential(), 18), (Chain(), 2), (Accumulator(cuts=3, after=True), 4), (Mixture(), 2)],
    ids=lambda each: type(each).__name__,
)
def test_cut_blocks_are_proved(block: Block, latency: int) -> None:
    module = module_of(block)
    proof = proved(module)
    assert module.pipeline.latency == latency
    assert proof.proved == proof.goals > 2 * len(module.outputs) + 2 * len(module.registers)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("first", "second"), [(2, 0), (1, 3)])
def test_graphs_of_cut_blocks_are_proved(first: int, second: int) -> None:
    planned = plan(cut_graph(first, second))
    machine = compose(planned)
    proofs = list(prove_machine(planned, machine, machine_text(machine)))
    assert [proof.name for proof in proofs] == [*(module.name for module in machine.modules), "cut"]
    assert [proof.proved for proof in proofs] == [proof.goals for proof in proofs]


# -- mutants -------------------------------------------------------------------------------------------------------

DELAY = "reg {0}; always @(posedge clock) if (reset) {0} <= 1'b0; else if (enable) {0} <= {1};"
REFUTED = (  # changes of the text of Accumulator(cuts=2, after=True), whose sum is 3 ticks late, and what is said
    ("product_7 = a * b", "product_7 = a + b",
     "total is 0 in Python and -3 in Verilog 2 ticks later for reset = 0, enable = 1, a = -1, b = -1, total = -1"),
    ("= cut_1 + shifted", "= cut_1 - shifted", "in Verilog 3 ticks later for reset = 0, enable = 1"),
    ("total <= 20'sd0", "total <= 20'sd1", "total is 0 in Python and 1 in Verilog for reset = 1"),
    ("cut_1 + shifted_2_late_3", "cut_1 + shifted_2_late_2",
     "sum is made of shifted_2_late_2, 2 ticks late, and cut_1, 3 ticks late"),
    ("cut_1 + shifted_2_late_3", "cut_1 + shifted_2", "sum is made of a, 0 ticks late, and cut_1, 3 ticks late"),
    ("= difference_6_late_3;", "= difference_6_late_2;",
     "difference is to be 3 ticks late and is made of difference_6_late_2, 2 ticks late"),
    ("cut_8 <= product_7;", "more <= product_7; cut_8 <= more;",
     "total is made of total, 2 ticks late, and cut_9, 3 ticks late"),
    ("total + cut_9", "total + cut_8", "total is made of cut_8, 1 tick late, and total, 2 ticks late"),
    ("= total + cut_9", "= a + cut_9", "total is made of a, 0 ticks late, and cut_9, 2 ticks late"),
    ("= total + cut_9", "= cut_8 + cut_8", "total is to be 2 ticks late and is made of cut_8, 1 tick late"),
    ("cut_8 <= product_7", "cut_8 <= cut_9", "a loop of registers of the pipeline: cut_"),
    ("ready_2 <= ready_1", "ready_2 <= 1'b1", "total is made of total, 1 tick late, and cut_9, 2 ticks late"),
    ("if (ready_2)", "if (ready_1)", "total is made of total, 1 tick late, and cut_9, 2 ticks late"),
    ("ready_2 <= 1'b0", "ready_2 <= 1'b1", "total moves before the first values are there"),
    ("ready_1 <= 1'b1", "ready_1 <= !ready_1", "ready_1 does not rest 1000 clocks after a reset"),
    ("total <= 20'sd0", "total <= cut_9", "total has no start of its own under reset"),
    ("else if (enable)", "else if (1'b1)", "ready_2 moves in clocks without enable"),
    ("    if (enable) begin", "    if (1'b1) begin", "cut_9 moves in clocks without enable"),
    ("    if (enable) begin", "    if (enable && ready_2) begin", "cut_8 waits 2 ticks for what is 0 ticks late"),
    ("assign sum = ", f"{DELAY.format('now', 'more')} {DELAY.format('more', 'ready_2')} assign sum = !now ? 20'sd0 : ",
     "sum is given by other operations when its first values come"),
)  # fmt: skip


@pytest.mark.exhaustive(but=7)
@pytest.mark.parametrize(("old", "new", "said"), REFUTED)
def test_mutants_are_refuted_and_it_is_said_why(old: str, new: str, said: str) -> None:
    module = module_of(Accumulator(cuts=2, after=True))
    text = changed(module_text(module), old, new)
    if "more <=" in new and "reg more" not in new:
        text = changed(text, "    reg signed [15:0] cut_9;", "    reg signed [15:0] cut_9, more;")
    proof = proved(module, text)
    assert proof.proved < proof.goals
    assert said in "\n".join(proof_lines([proof]))


@pytest.mark.parametrize("name", ["enable", "reset"])
def test_what_clocks_registers_may_stand_among_numbers(name: str) -> None:
    module = module_of(Mixture())
    proof = proved(
        module, changed(module_text(module), "sum_14 + $signed({1'b0, both_16", f"sum_14 + $signed({{1'b0, {name}")
    )
    assert [(each.name, each.late) for each in proof.counter_examples] == [("level", 1)]


@pytest.mark.parametrize("edge", ["negedge clock", "posedge enable", "posedge ready_1", "posedge (clock & enable)"])
def test_registers_of_another_clock_are_refused(edge: str) -> None:
    module = module_of(Accumulator(cuts=2, after=True))
    first = module_text(module).index("@(posedge clock)")
    text = module_text(module)[:first] + module_text(module)[first:].replace("posedge clock", edge, 1)
    with pytest.raises(ModelError, match="registers of another clock") as caught:
        proved(module, text)
    assert "block/cut_1" in str(caught.value.problems[0].got)


def test_what_does_the_same_in_another_way_is_proved() -> None:
    module = module_of(Accumulator(cuts=2, after=True))
    text = changed(module_text(module), "if (ready_2) total <= smaller_12", "total <= ready_2 ? smaller_12 : total")
    proof = proved(module, changed(text, "cut_8 <= product_7", "cut_8 <= b * a"))
    assert proof.proved == proof.goals


def looks_equal(module: Module, text: str) -> bool:
    """Whether outputs are those of Python, in clocks some of which have no enable and some a reset, from any start."""
    for seed in range(4):
        draws, hardware = random.Random(seed), ModuleByHand(text)
        hardware.held = {name: draws.getrandbits(hardware.kinds[name].width) for name in hardware.held}
        reference, due = Reference(module), list[dict[str, int]]()
        hardware.clock({port.name: 0 for port in module.inputs}, reset=1)
        for _ in range(40):
            inputs = {port.name: drawn(draws, port) for port in module.inputs}
            reset, enable = draws.random() < 0.05, draws.random() < 0.8
            found = hardware.clock(inputs, reset=int(reset), enable=int(enable))
            if enable:
                due.append(reference.tick(inputs))
                if len(due) > module.pipeline.latency and found != due[-1 - module.pipeline.latency]:
                    return False
            if reset:
                reference, due = Reference(module), []
    return True


@pytest.mark.exhaustive
def test_proofs_and_simulations_agree_on_values_in_the_place_of_others() -> None:
    module = module_of(Chain())
    text = module_text(module)
    names = ("a", "a_late_1", "a_late_2", "first", "first_late_1", "first_late_2", "cut_7")
    places = re.finditer(rf"(?<=[-+=] )({'|'.join(names)})(?=;| [-+])", text)
    mutants = [(place, name) for place in places for name in names if name != place[0]]
    verdicts = [looks_equal(module, text)]
    for place, name in random.Random(3).sample(mutants, 12):
        mutant = text[: place.start()] + name + text[place.end() :]
        proof = proved(module, mutant)
        verdicts.append(looks_equal(module, mutant))
        assert (proof.proved == proof.goals) == verdicts[-1], f"{name} for {place[0]} at {place.start()}"
    assert set(verdicts) == {True, False}


def test_a_counter_example_is_what_the_text_gives_later() -> None:
    module = module_of(Cube())
    text = changed(module_text(module), "= input__late_1 * cut_2", "= input__late_1 + cut_2")
    (found,) = proved(module, text).counter_examples
    assert (found.name, found.late) == ("output_", 2)
    given = {"input_": found.stimulus["input_"]}
    for each, expected in ((module_text(module), found.python), (text, found.verilog)):
        hardware = ModuleByHand(each)
        hardware.clock({}, reset=1)
        assert str([hardware.clock(given if n == 5 else {}) for n in range(8)][5 + found.late]["output_"]) == expected


def test_a_wrong_latency_of_the_whole_is_refuted() -> None:
    planned = plan(cut_graph(1, 3))
    machine = compose(planned)
    reference = reference_of(planned, machine)
    reference.latency += 1
    (fault, *_) = prove(reference, machine_text(machine)).faults
    assert re.fullmatch(r"\w+ is to be 5 ticks late and is made of [\w.]+, 4 ticks late", fault)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("enable && ready_1),\n        .first", "enable),\n        .first",
         "again.total_ is made of again.total_, 3 ticks late, and again.cut_4, 4 ticks late"),
        (".second(quantiser_output_late_1)", ".second(quantiser_output)",
         "again.cut_2 is made of quantiser_output, 0 ticks late, and energy.cut_2, 1 tick late"),
        (".first(delay_output_late_3)", ".first(delay_output_late_2)",
         "sum_output is made of delay_output_late_2, 3 ticks late, and again.total_, 4 ticks late"),
        ("assign chips_bit = chips_bit_late_4", "assign chips_bit = chips_bit_late_3",
         "chips_bit is to be 4 ticks late and is made of chips_bit_late_3, 3 ticks late"),
        ("if (enable) energy_product_late_2", "if (ready_1) energy_product_late_2",
         "energy_product_late_2 moves in clocks without enable"),
        ("late_2 <= energy_product_late_1", "late_2 <= energy_product_early",
         "energy_product is to be 4 ticks late and is made of energy_product_late_3, 3 ticks late"),
    ],
)  # fmt: skip
def test_mutants_of_what_joins_the_blocks_are_refuted(old: str, new: str, said: str) -> None:
    planned = plan(cut_graph(1, 3))
    machine = compose(planned)
    proof = prove(reference_of(planned, machine), changed(machine_text(machine), old, new))
    assert proof.faults[0] == said


# -- the command ---------------------------------------------------------------------------------------------------

GRAPH = """\
name = "cubed"
rate = "1 kHz"
probes = ["cube.output"]
wires = ["sine.output -> quantiser.input", "quantiser.output -> cube.input"]

[blocks.sine]
kind = "Sine"

[blocks.quantiser]
kind = "FixedQuantiser"

[blocks.cube]
kind = "Cube"
"""


def test_the_command_proves_a_pipeline_and_ends_with_1_where_it_is_out_of_step(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "cubed.toml").write_text(GRAPH, encoding="utf-8")
    own = Path(__file__).parents[4] / "docs" / "rtl.md"
    code = next(each for each in own.read_text(encoding="utf-8").split("```python\n") if "class Cube" in each)
    (tmp_path / "cube.py").write_text(code.partition("\n\ngraph = ")[0], encoding="utf-8")
    words = ["rtl", str(tmp_path / "cubed.toml"), "--blocks", str(tmp_path / "cube.py"), "-o", str(tmp_path / "out")]
    assert main([*words, "--ticks", "3", "--prove"]) == 0
    assert re.search(r"cube +5 +5 +\d", capsys.readouterr().out)

    def early(*given: Any, **options: Any) -> str:
        return changed(machine_text(*given, **options), "input__late_1 * cut_2", "input_ * cut_2")

    monkeypatch.setattr("proofmass.runner.commands.rtl_command.machine_text", early)
    assert main([*words, "--ticks", "3", "--prove"]) == 1
    assert "\ncube.cut_4 is made of input_, 0 ticks late, and cut_2, 1 tick late\n" in capsys.readouterr().out
    assert '"faults": [\n        "cut_4 is made of' in (tmp_path / "out" / "report.json").read_text(encoding="utf-8")
