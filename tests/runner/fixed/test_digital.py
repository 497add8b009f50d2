"""Digital blocks in a graph: raw values inside, units outside, overflows counted or refused alike in both engines."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, fixed, where, wrap
from proofmass.blocks.declaration.catalog import all_blocks, load_own_blocks
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.declaration.instance import format_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan.keys import OverflowsOf
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.listing import listing
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import RunError, simulate
from proofmass.runner.targets.llvm_text import content_of

HOLDING = """
from proofmass import Block, Input
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue

class Holding(Block):
    '''Its second entry is written while the input is above zero.'''

    input = Input("1", "Signal.", dtype=FixedValue)

@Holding.formats
def formats(p: Holding) -> dict[str, Fixed]:
    return {"input": Fixed(12, 8), "output": Fixed(12, 8)}

@Holding.output("1", shape=(2,), dtype=FixedValue)
def output(p: Holding, input: FixedValue, out: list[FixedValue]) -> None:
    '''The signal, and its positive part.'''
    out[0] = input
    if input > 0:
        WRITTEN
"""
HELD = """
rate = "1 kHz"
samples = 40
wires = ["sine.output -> quantiser.input", "quantiser.output -> holding.input"]
probes = ["holding.output"]
blocks.sine = { kind = "Sine", frequency = "100 Hz" }
blocks.quantiser = { kind = "FixedQuantiser", output_format = "(12, 8)" }
blocks.holding.kind = "Holding"
"""
BOTH: list[EngineName] = ["python", "compiled"]
KINDS = all_blocks()


def accumulator(overflow: str = "saturate", probes: tuple[str, ...] = ("total.output",), **more: Any) -> Graph:
    """A ramp of 1 V a tick, quantised, into an integrator that holds up to 8 V s."""
    blocks: dict[str, Block] = {
        "ramp": KINDS["Ramp"](slope=0.5, unit="V"),
        "quantiser": KINDS["FixedQuantiser"](unit="V"),
        "total": KINDS["FixedIntegrator"](
            input_unit="V", output_unit="V*s", sum_format="(12, 8)", output_format="(12, 8)", overflow=overflow
        ),
    }
    wires = ["ramp.output -> quantiser.input", "quantiser.output -> total.input"]
    return Graph(name="accumulator", rate=1, blocks=blocks | more, wires=wires, probes=probes, samples=40)


def exact_sums(ticks: int, wraps: bool) -> tuple[list[float], int]:
    """Sums of 0, 0.5, 1 ... 7.9998 V in a register of 12 bits, and the additions that went beyond it."""
    total, values, beyond = 0, [], 0
    for n in range(ticks):
        values.append(total / 256)
        held = min(round(0.5 * n * 4096), 32767)
        total = round((total * 16 + held) / 16)  # a tie goes to the even step in Python too
        beyond += not -2048 <= total <= 2047
        total = (total + 2048) % 4096 - 2048 if wraps else min(total, 2047)
    return values, beyond


@pytest.mark.parametrize("engine", BOTH)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
def test_values_are_in_the_unit_and_overflows_counted(engine: EngineName, overflow: str) -> None:
    result = simulate(accumulator(overflow), engine=engine)
    expected, beyond = exact_sums(40, overflow == "wrap")
    trace = result["total.output"]
    assert trace.values.tolist() == expected
    assert (trace.unit, trace.format, trace.values.dtype) == ("V*s", Fixed(12, 8), np.float64)
    assert trace.mantissas.tolist() == [value * 256 for value in expected]
    assert result.to_xarray()["total.output"].attrs["fixed_point"] == "(12, 8)"
    assert result.overflows == {"total": beyond, "quantiser": 24}
    assert beyond > 10


@pytest.mark.parametrize("engine", BOTH)
@pytest.mark.parametrize("samples", [40, 5000])
def test_a_refused_overflow_ends_the_run_by_name(engine: EngineName, samples: int) -> None:
    graph = accumulator("refuse")
    with pytest.raises(RunError) as caught:
        simulate(graph, samples=samples, engine=engine)
    text = str(caught.value)
    assert "total.update: failed in tick 6, t = 6 s" in text
    assert "OverflowError: 10.5 does not fit Fixed(12, 8), which holds -8 to 7.99609375" in text
    assert "take a wider format, or let it saturate or wrap; probe what drives it: input = quantiser.output" in text


@pytest.mark.parametrize("engine", BOTH)
def test_a_converter_that_leaves_its_format_ends_the_run_by_name(engine: EngineName) -> None:
    graph = accumulator(quantiser=KINDS["FixedQuantiser"](unit="V", overflow="refuse"))
    with pytest.raises(RunError, match=r"quantiser\.output: failed in tick 16") as caught:
        simulate(graph, samples=3000, engine=engine)
    assert "OverflowError: 8 does not fit Fixed(16, 12), which holds -8 to 7.999755859" in str(caught.value)


@pytest.mark.parametrize("engine", BOTH)
def test_the_count_goes_on_after_an_interruption(engine: EngineName, tmp_path: Any) -> None:
    import signal

    graph = accumulator("wrap")
    whole = simulate(graph, samples=3000, engine=engine)
    stopped = simulate(
        graph,
        samples=3000,
        engine=engine,
        folder=tmp_path,
        progress=lambda done, _: signal.raise_signal(signal.SIGINT) if done > 500 else None,
    )
    assert stopped.interrupted
    assert 0 < stopped.overflows["total"] < whole.overflows["total"]
    resumed = simulate(graph, samples=3000, engine=engine, folder=tmp_path, resume=True)
    assert resumed.overflows == whole.overflows
    assert np.array_equal(resumed["total.output"].values, whole["total.output"].values)


def test_what_cannot_overflow_is_not_counted() -> None:
    wide = KINDS["FixedDifference"](output_format="(17, 12)")
    graph = accumulator(difference=wide)
    wires = [*graph.wires, "quantiser.output -> difference.first", "quantiser.output -> difference.second"]
    unitless = {
        name: type(block)(**{"unit": "1"}) for name, block in graph.blocks.items() if name in ("ramp", "quantiser")
    }
    total = KINDS["FixedIntegrator"](sum_format="(12, 8)", output_format="(12, 8)")
    made = plan(Graph(name="two", rate=1, blocks={**graph.blocks, **unitless, "total": total}, wires=wires, samples=9))
    assert not made.digital["difference"].overflows
    assert made.digital["total"].overflows
    counted = [key.block for key in write_tick(made).memory.kinds if isinstance(key, OverflowsOf)]
    assert counted == ["total"]


def test_the_listing_names_the_line_of_every_operation() -> None:
    graph = accumulator()
    text = listing(write_tick(plan(graph)).program)
    assert "update_" in text
    assert "fixed_integrator.py:" in text


def test_gains_are_numbers_of_the_run_and_formats_are_not() -> None:
    def source(**changed: Any) -> str:
        planned = plan(accumulator().with_parameters({f"total.{k}": v for k, v in changed.items()}))
        return content_of(write_tick(planned).program)

    assert source(gain=1.5) == source()
    assert source(sum_format="(13, 8)") != source()


def test_a_graph_reads_back_with_its_formats() -> None:
    graph = accumulator()
    text = write_graph(graph)
    assert 'sum_format = "(12, 8)"' in text
    assert read_graph_text(text).blocks == graph.blocks


# -- blocks of one's own -------------------------------------------------------------------------------------------


COUNT = Fixed(10, 0, signed=False)


class Magnitude(Block):
    """Length of a vector of two by shifts and adds, times the gain of the rotations."""

    stages: int = param("1", "Rotations.", default=14, at_least=1, at_most=20)
    word: Fixed = param("1", "Format of inputs and output.", default=Fixed(18, 14))

    first = Input("1", "First entry.", dtype=FixedValue)
    second = Input("1", "Second entry.", dtype=FixedValue)

    counts = Buffer("Ticks with the second entry below zero, and the others.", FixedValue, (2,))


class MagnitudeState(NamedTuple):
    angle: FixedValue
    negative: bool


class Table(NamedTuple):
    angles: tuple[FixedValue, ...]  # without a format: known to the trace


@Magnitude.formats
def formats(p: Magnitude) -> dict[str, Fixed]:
    return {"first": p.word, "second": p.word, "output": p.word, "x.angle": Fixed(20, 16), "counts": COUNT}


@Magnitude.constants
def constants(p: Magnitude, period: float) -> Table:
    return Table(tuple(fixed(math.atan(2.0**-i), Fixed(24, 22), "half_even") for i in range(p.stages)))


@Magnitude.output("1")
def output(c: Table, p: Magnitude, first: FixedValue, second: FixedValue) -> FixedValue:
    """Length of the vector, times 1.6468 / 2."""
    return (rotated(c, abs(first), second)[0] >> 1).to(p.word)


@Magnitude.output("1", dtype=bool)
def negative(c: Table, x: MagnitudeState) -> bool:
    """Whether the angle of the tick before was negative."""
    return x.negative


@Magnitude.update
def update(
    c: Table, x: MagnitudeState, counts: list[FixedValue], first: FixedValue, second: FixedValue
) -> MagnitudeState:
    angle = rotated(c, abs(first), second)[1].to(Fixed(20, 16))
    if second < 0:
        counts[0] = wrap(counts[0] + 1, COUNT)
    else:
        counts[1] = wrap(counts[1] + 1, COUNT)
    return MagnitudeState(angle, angle < 0)


def rotated(c: Table, x: FixedValue, y: FixedValue) -> tuple[FixedValue, FixedValue]:
    inner, angle = Fixed(26, 20), FixedValue(0)
    x, y = x.to(inner), y.to(inner)
    for i, step in enumerate(c.angles):
        up = y < 0
        x, y, angle = (
            where(up, x - (y >> i), x + (y >> i)).to(inner, "floor"),
            where(up, y + (x >> i), y - (x >> i)).to(inner, "floor"),
            where(up, angle - step, angle + step),
        )
    return x, angle


def around(block: Block) -> Graph:
    blocks: dict[str, Block] = {"block": block}
    wires = []
    for name in type(block).inputs:
        blocks |= {f"{name}_noise": KINDS["WhiteNoise"](density=0.03)}
        blocks |= {f"{name}_quantiser": KINDS["FixedQuantiser"](output_format=format_of(block, name))}
        wires += [f"{name}_noise.output -> {name}_quantiser.input", f"{name}_quantiser.output -> block.{name}"]
    probes = [
        *(f"block.{port}" for port in type(block).outputs),
        *(f"{name}_quantiser.output" for name in type(block).inputs),
    ]
    return Graph(name="around", rate=1000, blocks=blocks, wires=wires, probes=probes)


@pytest.mark.exhaustive
def test_a_loop_over_a_table_with_buffers_and_truth_values() -> None:
    python, compiled = (simulate(around(Magnitude()), samples=1000, engine=engine) for engine in BOTH)
    for signal in python:
        assert np.array_equal(python[signal].values, compiled[signal].values)
    x, y = (python[f"{name}_quantiser.output"].values for name in ("first", "second"))
    growth = math.prod(math.sqrt(1 + 4.0**-i) for i in range(14))
    assert python["block.output"].values == pytest.approx(np.hypot(x, y) * growth / 2, abs=3 * 2.0**-14)
    assert np.array_equal(python["block.negative"].values[1:], y[:-1] < 0)


class Wide(Block):
    """A product of three words of 32 bits."""

    input = Input("1", "A word.", dtype=FixedValue)


@Wide.formats
def wide_formats(p: Wide) -> dict[str, Fixed]:
    return {"input": Fixed(32, 30), "output": Fixed(32, 30)}


def test_more_than_64_bits_are_refused_with_place_and_remedy() -> None:
    class Cube(Wide):
        """Cube of a word."""

    @Cube.formats
    def formats(p: Cube) -> dict[str, Fixed]:
        return wide_formats(p)

    @Cube.output("1")
    def output(p: Cube, input: FixedValue) -> FixedValue:
        """The cube."""
        return (input * input * input).to(Fixed(32, 30))

    with pytest.raises(ModelError) as caught:
        plan(around(Cube()))
    text = str(caught.value)
    line = output.__code__.co_firstlineno + 3
    assert (
        f"test_digital.py:{line}: blocks.block.output: the multiply is wider than the 64 bits of compiled code" in text
    )
    assert f"[{-(2**93)}, {2**62 * (2**31 - 1)}], 94 bits" in text
    assert "round or clip the operands with .to(format) before, or take narrower formats" in text


def test_what_does_not_fit_its_register_is_refused_before_the_run() -> None:
    class Twice(Wide):
        """Twice a word."""

    @Twice.formats
    def formats(p: Twice) -> dict[str, Fixed]:
        return wide_formats(p)

    @Twice.output("1")
    def output(p: Twice, input: FixedValue) -> FixedValue:
        """The word twice."""
        return input + input

    with pytest.raises(ModelError, match="the value does not fit its register") as caught:
        plan(around(Twice()))
    assert "add .to(format), or clip(value, low, high)" in str(caught.value)


def test_a_missing_format_and_a_time_in_seconds_are_refused() -> None:
    class Late(Wide):
        """Time since the start."""

    @Late.formats
    def formats(p: Late) -> dict[str, Fixed]:
        return {"input": Fixed(16, 12)}

    @Late.output("1")
    def output(p: Late, input: FixedValue, time: float) -> FixedValue:
        """The input."""
        return input

    with pytest.raises(ModelError, match="time is a floating-point number, and the block works in fixed point"):
        plan(around(Late()))
    with pytest.raises(ModelError, match=r"Late\.formats: the format of output is not said"):
        format_of(Late(), "output")


def test_a_gain_beyond_its_format_is_refused() -> None:
    with pytest.raises(ModelError, match=r"5000.0 does not fit Fixed\(32, 30\), which holds -2 to 1.999"):
        plan(accumulator().with_parameters({"total.gain": 5000.0}))


class Scale(NamedTuple):
    factor_and_shift: tuple[FixedValue, int]  # no register, although `formats` says one for all constants


class Scaled(Block):
    """Three quarters of a word, halved."""

    input = Input("1", "A word.", dtype=FixedValue)


@Scaled.formats
def scaled_formats(p: Scaled) -> dict[str, Fixed]:
    return {"input": Fixed(16, 12), "scaled": Fixed(16, 12), "c": Fixed(8, 6)}


@Scaled.constants
def scaled_constants(p: Scaled, period: float) -> Scale:
    return Scale((fixed(0.75, Fixed(8, 6)), 1))


@Scaled.output("1")
def scaled(c: Scale, input: FixedValue) -> FixedValue:
    """The word times 3 / 8."""
    factor, shift = c.factor_and_shift
    return ((input * factor) >> shift).to(Fixed(16, 12), "floor")


@pytest.mark.parametrize("engine", BOTH)
def test_words_beside_other_numbers_are_constants_of_the_code(engine: EngineName) -> None:
    result = simulate(around(Scaled()), samples=50, engine=engine)
    words = np.asarray(result["input_quantiser.output"].mantissas)
    assert np.array_equal(result["block.scaled"].mantissas, words * 3 // 8)


@pytest.mark.defect("S1044", before="an entry of registers kept from the tick before", after="zero, in all engines")
@pytest.mark.parametrize("engine", BOTH)
@pytest.mark.parametrize("written", ["out[1] = input", "out[1] += input"])
def test_an_output_in_registers_begins_each_tick_with_zeros(engine: EngineName, written: str, tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(HOLDING.replace("WRITTEN", written))
    graph = read_graph_text(HELD, own=load_own_blocks(tmp_path / "own.py"))
    values = simulate(graph, engine=engine)["holding.output"].values
    assert values[:, 0].min() < -0.9
    assert np.array_equal(values[:, 1], np.maximum(values[:, 0], 0.0))
