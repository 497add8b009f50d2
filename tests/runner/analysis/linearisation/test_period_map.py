"""The linear map of a period: what is in it, what is held, and what cannot be linearised."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Decimator,
    DiscreteTransferFunction,
    MassSpringDamper,
    Product,
    RunningStatistics,
    Saturation,
    Sine,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, late_by, period_map
from proofmass.runner.continuous.exact_hold import hold
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference.interpret import Interpreter


def chain(*blocks: tuple[str, Block, str, str], source: Block | None = None, **more: Any) -> Graph:
    """A source and blocks in a row, each with the names of its input and its output."""
    made: dict[str, Block] = {"source": source or Constant()}
    wires, last = [], "source.output"
    for name, block, entry, port in blocks:
        made[name] = block
        wires.append(f"{last} -> {name}.{entry}")
        last = f"{name}.{port}"
    return Graph(name="chain", rate=1000, blocks=made, wires=wires, probes=[last], **more)


def response(found: PeriodMap, periods: int) -> list[float]:
    """What the outputs do after a unit at the first input."""
    a, b, c, d = found.parts()
    x, u, rows = np.zeros(found.order), np.zeros(len(found.inputs)), []
    u[0] = 1.0
    for _ in range(periods):
        rows += list(c @ x + d @ u)
        x, u = a @ x + b @ u, np.zeros(len(u))
    return rows


def test_a_continuous_block_is_its_exact_hold() -> None:
    block = MassSpringDamper()
    planned = plan(chain(("mass", block, "force", "displacement"), source=Constant(unit="N")))
    found = period_map(planned, [("source", "output")], [("mass", "displacement")]).between()
    a = [[0.0, 1.0], [-block.stiffness / block.mass, -block.damping / block.mass]]
    transition, entry = hold(a, [[0.0], [1.0 / block.mass]], 1e-3)
    parts = found.parts()
    assert parts[0] == pytest.approx(np.array(transition), rel=1e-12)
    assert parts[1] == pytest.approx(np.array(entry), rel=1e-12)
    assert parts[2].tolist() == [[1.0, 0.0]]
    assert found.names(found.states) == ["mass.displacement", "mass.velocity"]
    assert found.period == 1e-3


def test_delay_lines_are_states_and_coefficients_are_not() -> None:
    line = DiscreteTransferFunction(numerator=(0.5, 0.0, 2.0), denominator=(1.0, 0.0, 0.0))
    planned = plan(chain(("line", line, "input", "output")))
    everything = period_map(planned, [("source", "output")], [("line", "output")])
    assert everything.order == 9
    found = everything.between()
    assert found.names(found.states) == ["line.delays[0]", "line.delays[1]"]
    assert response(found, 4) == [0.5, 0.0, 2.0, 0.0]


def test_a_decimator_makes_a_period_of_its_window() -> None:
    planned = plan(chain(("mean", Decimator(ratio=4), "input", "mean"), ("hold", UnitDelay(), "input", "output")))
    found = period_map(planned, [("source", "output")], [("hold", "output")]).between()
    assert len(found.inputs) == len(found.outputs) == 4
    assert found.period == pytest.approx(4e-3)
    assert found.names(found.inputs) == [f"source.output[{i}]" for i in range(4)]
    assert response(found, 3) == [0.0] * 5 + [0.25] * 4 + [0.0] * 3
    assert all(name.partition(".")[2] != "filled" for name in found.names(found.states))  # a counter is no state


def test_rates_between_a_fast_and_a_slow_block() -> None:
    graph = chain(
        ("fast", UnitDelay(), "input", "output"), ("slow", UnitDelay(), "input", "output"), rates={"slow": 200}
    )
    found = period_map(plan(graph), [("source", "output")], [("slow", "output")]).between()
    assert len(found.inputs) == 5
    assert len(found.outputs) == 1
    # The slow block samples in ticks 0, 5, 10: the source of tick 4 is the only one that it sees.
    _, b, _, _ = found.parts()
    assert np.flatnonzero(np.abs(b).sum(axis=0)).tolist() == [4]


def test_integers_are_linear_where_their_arithmetic_is() -> None:
    """A code counts as a number: a converter as its gain, and a filter of codes as its coefficients."""
    adc = ("adc", AnalogToDigital(bits=16, reference=2.0), "voltage", "code")
    planned = plan(chain(adc, ("sum", CodeSum(), "code", "total_of_codes"), source=Constant(unit="V")))
    gain = period_map(planned, [("source", "output")], [("adc", "code")])
    assert gain.order == 0
    assert gain.parts()[3].tolist() == [[16384.0]]
    total = period_map(planned, [("source", "output")], [("sum", "total_of_codes")])
    assert total.names(total.states) == ["sum.total"]
    assert response(total, 3) == [0.0, -3.0 * 16384.0 / 4.0, -3.0 * 16384.0 / 4.0]


def test_a_saturation_counts_as_what_it_is_at_the_operating_point() -> None:
    for amplitude, slope in ((0.5, 1.0), (2.0, 0.0)):
        source = Sine(frequency=250.0, amplitude=amplitude)  # largest in tick 1
        planned = plan(chain(("limit", Saturation(), "input", "output"), source=source))
        found = period_map(planned, [("source", "output")], [("limit", "output")], memory=Course(planned).at(1))
        assert found.parts()[3].tolist() == [[slope]]


def test_the_operating_point_is_that_of_a_run() -> None:
    source = Sine(frequency=10.0, offset=0.3)
    graph = Graph(
        name="square",
        rate=1000,
        blocks={"source": source, "delay": UnitDelay(), "square": Product(), "out": UnitDelay()},
        wires=[
            "source.output -> delay.input",
            "delay.output -> square.first",
            "delay.output -> square.second",
            "square.output -> out.input",
        ],
    )
    planned = plan(graph)
    engine = Interpreter(planned, 0)
    engine.advance(17, ())
    held = engine.memory().states["delay"].held
    assert Course(planned).at(17).states["delay"].held == held
    found = period_map(planned, [("source", "output")], [("out", "output")], memory=Course(planned).at(17))
    assert found.parts()[0][1, 0] == pytest.approx(2.0 * held, rel=1e-14)


def test_step_and_level_are_those_of_the_graph_itself() -> None:
    block = MassSpringDamper()
    planned = plan(chain(("mass", block, "force", "displacement"), source=Constant(value=1e-6, unit="N")))
    found = period_map(planned, [("source", "output")], [("mass", "displacement")], memory=Course(planned).at(5))
    memories = [Course(planned).at(tick).states["mass"] for tick in (5, 6)]
    assert found.matrix[:2, -1] == pytest.approx(np.array(memories[1]) - np.array(memories[0]), rel=1e-9)
    assert found.matrix[2, -1] == memories[0].displacement


class Parity(Block):
    """The lowest bit of a code, as a number: parity = code & 1."""

    code = Input("1", "Code.", dtype=int)


@Parity.output("1")
def parity(p: Parity, code: int) -> float:
    """The bit."""
    return float(code & 1)


class Sum(NamedTuple):
    total: int


class CodeSum(Block):
    """Integers only: total[n+1] = total[n] + ((3 code) >> 2, its sign turned as digital circuits do)."""

    code = Input("1", "Code.", dtype=int)


@CodeSum.output("1")
def total_of_codes(p: CodeSum, x: Sum) -> int:
    """The sum."""
    return x.total


@CodeSum.update
def add(p: CodeSum, x: Sum, code: int) -> Sum:
    return Sum(x.total + ((((3 * code) >> 2) ^ -1) + 1))


class Running(NamedTuple):
    total: float
    count: int


class Scrambled(Block):
    """Adds its input up and keeps a scrambled counter: total[n+1] = total[n] + input."""

    input = Input("1", "What is added.")


@Scrambled.output("1")
def total(p: Scrambled, x: Running) -> float:
    """The sum."""
    return x.total


@Scrambled.update
def update(p: Scrambled, x: Running, input: float) -> Running:
    return Running(x.total + input, (5 * x.count + 1) & 255)


def test_bits_of_a_signal_are_refused_with_the_block_and_its_line() -> None:
    graph = chain(
        ("adc", AnalogToDigital(), "voltage", "code"), ("parity", Parity(), "code", "parity"), source=Constant(unit="V")
    )
    with pytest.raises(ModelError) as caught:
        period_map(plan(graph), [("source", "output")], [("parity", "parity")])
    (problem,) = caught.value.problems
    assert problem.key == "blocks.parity"
    assert problem.message == "cannot be linearised: parity has no derivative here"
    assert "&" in problem.got


def test_counters_of_bits_keep_their_values_and_the_rest_is_linear() -> None:
    planned = plan(chain(("sum", Scrambled(), "input", "total")))
    found = period_map(planned, [("source", "output")], [("sum", "total")])
    assert found.names(found.states) == ["sum.total"]
    assert response(found, 3) == [0.0, 1.0, 1.0]


def test_a_square_root_at_zero_has_no_derivative() -> None:
    graph = chain(("statistics", RunningStatistics(), "input", "standard_deviation"))
    with pytest.raises(ModelError, match=r"blocks.statistics: cannot be linearised"):
        period_map(
            plan(graph),
            [("source", "output")],
            [("statistics", "standard_deviation")],
            memory=Course(plan(graph)).at(10),
        )


def test_too_long_a_period_is_refused() -> None:
    graph = chain(("mean", Decimator(ratio=500_000), "input", "mean"), ("after", UnitDelay(), "input", "output"))
    with pytest.raises(ModelError, match="tick together too rarely"):
        period_map(plan(graph), [("source", "output")], [("after", "output")])


def test_an_output_is_late_by_the_offset_of_its_clock() -> None:
    """Of one wire to another alone: several have no one delay."""
    blocks = ("first", UnitDelay(), "input", "output"), ("last", UnitDelay(), "input", "output")
    planned = plan(chain(*blocks, rates={"last": 100}, offsets={"last": "3 ms"}))
    first, last = ("first", "output"), ("last", "output")
    assert late_by(planned, first, last) == pytest.approx(3e-3)
    late = [
        period_map(planned, *ends).late
        for ends in (([first], [last]), ([first, last], [last]), ([first], [first, last]))
    ]
    assert late == pytest.approx([3e-3, 0.0, 0.0])
