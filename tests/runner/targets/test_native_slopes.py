"""Maps of ticks from machine code against those of dual numbers in plain Python, entry by entry."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from proofmass import read_graph
from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Delay,
    Difference,
    DiscreteIntegrator,
    FixedCordicAngle,
    FixedDelay,
    FixedQuantiser,
    FixedSecondOrderSection,
    FixedToNumber,
    FractionalDelay,
    Gain,
    MassSpringDamper,
    MedianFilter,
    MovingAverage,
    Product,
    RepeatingSequence,
    Sum,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import FOLDER
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation import period_map
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.targets.native_slopes import SlopeCode

CHIPS = tuple(1.0 if (5 * n * n + n) % 7 < 3 else -0.5 for n in range(70))


def both(planned: Plan, node: Endpoint, tick: int = 0, span: int = len(CHIPS)) -> tuple[PeriodMap, PeriodMap]:
    """The map of some ticks from machine code, and from plain Python."""
    course = Course(planned)
    memory = course.at(tick)
    options: dict[str, Any] = {"cut": True, "memory": memory, "span": span}
    code = course.slopes()
    assert code is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(period_map, "SteppedTicks", None)  # plain Python does not step in
        fast = period_map.period_map(planned, [node], [node], **options, slopes=lambda *_: code)
    return fast, period_map.period_map(planned, [node], [node], **options)


def assert_alike(fast: PeriodMap, slow: PeriodMap, rel: float = 1e-12) -> None:
    """Numbers alike, wherever they are not both nothing."""
    assert fast.states == slow.states
    assert fast.outputs == slow.outputs
    assert fast.inputs == slow.inputs
    size = abs(slow.matrix[:, :-1]).max()
    assert fast.matrix[:, :-1] == pytest.approx(slow.matrix[:, :-1], rel=rel, abs=1e-12 * size)


def loop_through(
    between: Mapping[str, Block],
    first: str,
    last: str,
    wires: tuple[str, ...] = (),
    level: float = 0.3,
    **options: Any,
) -> Plan:
    """A loop whose gain follows a sequence, through some blocks."""
    blocks: dict[str, Block] = {
        "reference": Constant(value=level),
        "error": Difference(),
        "chips": RepeatingSequence(values=CHIPS),
        "product": Product(),
        "integral": DiscreteIntegrator(gain=20.0, output_unit="1"),
    }
    own = ["reference.output -> error.first", "integral.output -> error.second", "error.output -> product.first"]
    own += ["chips.output -> product.second", f"product.output -> {first}", f"{last} -> integral.input"]
    options |= {"rate": "1 kHz", "duration": "1 s"}
    return plan(Graph(name="loop", blocks={**blocks, **between}, wires=[*own, *wires], **options))


def through(block: Block) -> Plan:
    (port,) = type(block).outputs
    return loop_through({"block": block}, "block.input", f"block.{port}")


def fixed() -> Plan:
    """Registers that round and saturate, with a delay line of mantissas."""
    section = FixedSecondOrderSection(b0=0.2, b1=0.3, b2=0.1, a1=-0.5, a2=0.1)
    registers = {"in": FixedQuantiser(), "section": section, "delay": FixedDelay(ticks=3), "out": FixedToNumber()}
    wires = ("in.output -> section.input", "section.output -> delay.input", "delay.output -> out.input")
    return loop_through(registers, "in.input", "out.output", wires)


def driven(gate: Sequence[float] = (1.0,)) -> Plan:
    """A mass whose stiffness moves with the loop while a gate is open."""
    mass = MassSpringDamper(mass=1e-6, damping=1e-3, stiffness=1.0)
    blocks = {"spring": Gain(gain=0.1, output_unit="N/m"), "mass": mass, "force": Gain(output_unit="N")}
    blocks |= {"stiff": Sum(unit="N/m"), "middle": Constant(value=1.0, unit="N/m"), "out": Gain(input_unit="m")}
    blocks |= {"gate": RepeatingSequence(values=tuple(gate)), "gated": Product()}
    wires: tuple[str, ...] = ("error.output -> gated.first", "gate.output -> gated.second")
    wires += ("gated.output -> spring.input", "spring.output -> stiff.first", "middle.output -> stiff.second")
    wires += ("stiff.output -> mass.stiffness", "force.output -> mass.force", "mass.displacement -> out.input")
    return loop_through(blocks, "force.input", "out.output", wires)


BLOCKS = [Gain(gain=0.7), Delay(ticks=3), MovingAverage(length=4), FractionalDelay(), MedianFilter(length=3)]


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: type(block).__name__)
@pytest.mark.parametrize("tick", [0, 137])
def test_blocks_that_remember(block: Block, tick: int) -> None:
    fast, slow = both(through(block), ("error", "output"), tick)
    assert fast.ticks is not None
    assert len(fast.ticks.d) == len(CHIPS)
    assert_alike(fast, slow)


@pytest.mark.parametrize("order", [1, -1])
def test_loops_among_the_same_blocks_are_opened_together(order: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """What comes to `inner` in a tick comes from `product` in that tick, and in part by a register from both."""
    between = {"inner": Difference(), "back": Gain(gain=0.3), "late": Delay(ticks=2)}
    wires = ("integral.output -> late.input", "late.output -> back.input", "back.output -> inner.second")
    planned = loop_through(between, "inner.first", "inner.output", wires)
    nodes = [("inner", "output"), ("product", "output"), ("error", "output")][::order]
    course, ran = Course(planned), list[Sequence[Endpoint]]()
    course.loops = tuple(nodes)
    taken = SlopeCode.ticks
    monkeypatch.setattr(SlopeCode, "ticks", lambda *given: ran.append(given[2]) or taken(*given))
    runs = [OrbitRun(planned, Ends((node,), (node,), cut=True), course.onward(0)) for node in nodes]
    together = [run.map(0, len(CHIPS)) for run in runs]
    assert [len(wires) for wires in ran] == [3]
    for node, found in zip(nodes, together, strict=True):
        assert_alike(found, both(planned, node)[1])


def test_a_converter_is_its_input() -> None:
    converter = {"block": AnalogToDigital(bits=12, reference=5.0), "in": Gain(output_unit="V")}
    planned = loop_through(converter, "in.input", "block.number", ("in.output -> block.voltage",))
    assert_alike(*both(planned, ("error", "output"), 30))


@pytest.mark.parametrize("node", [("error", "output"), ("section", "output"), ("delay", "output")])
def test_registers(node: Endpoint) -> None:
    assert_alike(*both(fixed(), node, 30))


@pytest.mark.exhaustive("node2", "200-node1")
@pytest.mark.exhaustive("0-node0")
@pytest.mark.parametrize("node", [("error", "output"), ("stiff", "output"), ("out", "output")])
@pytest.mark.parametrize("tick", [0, 200])
def test_a_stiffness_that_moves(node: Endpoint, tick: int) -> None:
    assert_alike(*both(driven(), node, tick), rel=1e-9)


@pytest.mark.exhaustive
def test_a_stiffness_that_moves_after_some_ticks() -> None:
    assert_alike(*both(driven((*[0.0] * 30, *[1.0] * 40)), ("error", "output")), rel=1e-9)


def test_a_slower_part_holds_its_value() -> None:
    slow = {"slow": DiscreteIntegrator(gain=3.0, output_unit="1")}
    planned = loop_through(slow, "slow.input", "slow.output", rates={"slow": "500 Hz"})
    for node, values in ((("slow", "output"), 35), (("error", "output"), 70)):
        fast, python = both(planned, node, 11)
        assert fast.ticks is not None
        assert len(fast.ticks.d) == values
        assert_alike(fast, python)


@pytest.mark.defect("S773", before="CORDIC in a loop of 70 ticks: does not come back", after="the slope of an angle")
def test_an_angle_by_rotations_has_the_slope_of_an_angle() -> None:
    """Of (1, y) it is atan y: the last rotations leave y to the rest of the search, which integers drop."""
    part, turns = Fixed(24, 20), Fixed(24, 24)
    chips = {"chips": RepeatingSequence(values=tuple(1.0 if n**3 % 71 < 35 else -0.5 for n in range(71)))}
    registers = {
        "one": Constant(value=1.0),
        "real": FixedQuantiser(output_format=part),
        "in": FixedQuantiser(output_format=part),
        "angle": FixedCordicAngle(input_format=part, turn_bits=24, iterations=24),
        "out": FixedToNumber(input_format=turns),
    }
    wires = ("one.output -> real.input", "real.output -> angle.real", "in.output -> angle.imaginary")
    angle = loop_through(registers | chips, "in.input", "out.output", (*wires, "angle.angle -> out.input"), level=0.0)
    gain = loop_through({"block": Gain(gain=0.5 / math.pi)} | chips, "block.input", "block.output", level=0.0)
    of_angle, of_gain = (linearised(planned).loop(("error", "output")).map.matrix for planned in (angle, gain))
    assert of_angle[:, :-1] == pytest.approx(of_gain[:, :-1], rel=1e-5)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("name", "node"),
    [
        ("imu_3dof", ("x.model", "displacement")),
        ("self_calibration_accelerometer", ("reference.readout", "voltage")),
        ("self_test_population", ("axis.model", "displacement")),
        ("self_calibration_gyroscope", ("reference.readout", "voltage")),
    ],
)
def test_the_library(name: str, node: Endpoint) -> None:
    planned = plan(read_graph(next(FOLDER.rglob(f"{name}.toml"))))
    assert_alike(*both(planned, node, 2_000, 1_023), rel=1e-9)
