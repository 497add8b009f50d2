"""Noise of ticks in machine code: against plain Python, entry by entry, and against sums that are known."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from proofmass import read_graph
from proofmass.blocks import (
    AnalogToDigital,
    Comparator,
    Constant,
    Difference,
    DigitalToAnalog,
    DiscreteIntegrator,
    FixedDelay,
    FixedGain,
    FixedQuantiser,
    FixedSecondOrderSection,
    FixedToNumber,
    FlickerNoise,
    Gain,
    MassSpringDamper,
    MovingAverage,
    SamplingNoise,
    SigmaDeltaModulator,
    Sine,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.arithmetic.mantissa import Drop, Rounding
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import FOLDER
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, period_map
from proofmass.runner.analysis.noise.grid_errors import size_of
from proofmass.runner.analysis.noise.grids import on_grids
from proofmass.runner.derivatives.dual_noise import Noisy, OneBitGain, noise_blocks
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.targets import native_slopes
from proofmass.runner.targets.found_slopes import Found
from proofmass.runner.targets.still_numbers import StillNumbers

SPAN = 20  # ticks: two groups of eight, and some
SMALL = 1e-12  # part of the largest entry that counts as nothing


def both(
    planned: Plan, nodes: list[Endpoint], tick: int = 3, span: int = SPAN, noise: Noisy | None = None, **options: Any
) -> tuple[PeriodMap, PeriodMap]:
    """The map of some ticks with noise from machine code, and from plain Python."""
    course = Course(planned)
    code = course.slopes(1_000, noise=noise is None or bool(noise))
    assert code is not None
    given: dict[str, Any] = {"noise": noise_blocks(planned) if noise is None else noise, "span": span, **options}
    given = {"quantisers": given["noise"], **given}
    inputs = given.pop("inputs", ())
    fast = period_map(planned, inputs, nodes, **given, memory=course.at(tick), slopes=lambda *_: code)
    return fast, period_map(planned, inputs, nodes, **given, memory=course.at(tick))


def one_bit_loop(gain: float) -> Plan:
    blocks: dict[str, Block] = {"signal": Sine(amplitude=0.4, frequency=90.0), "error": Difference()}
    blocks |= {"integral": DiscreteIntegrator(gain=gain, output_unit="1"), "bit": Comparator()}
    wires = ["signal.output -> error.first", "bit.sign -> error.second", "error.output -> integral.input"]
    return graph_of(blocks, *wires, "integral.output -> bit.input")


def assert_alike(fast: PeriodMap, slow: PeriodMap, rel: float = 1e-12) -> None:
    """Numbers alike, wherever they are not both nothing."""
    assert fast.states == slow.states
    assert fast.inputs == slow.inputs
    assert fast.outputs == slow.outputs
    size = np.abs(slow.matrix[:, :-1]).max()
    assert fast.matrix[:, :-1] == pytest.approx(slow.matrix[:, :-1], rel=rel, abs=SMALL * size)


def graph_of(blocks: Mapping[str, Block], *wires: str, **options: Any) -> Plan:
    return plan(
        Graph(name="noise", blocks=dict(blocks), wires=[*wires], **{"rate": "1 kHz", "duration": "1 s"} | options)
    )


def readout() -> Plan:
    """A moving voltage with noise, converters whose two outputs round alike, a slower one, and an average."""
    blocks: dict[str, Block] = {
        "signal": Sine(amplitude=1.0, frequency=70.0, unit="V"),
        "white": WhiteNoise(density=1e-4, unit="V"),
        "flicker": FlickerNoise(level=1e-3, lowest_frequency=1.0, highest_frequency=100.0, nominal=1.0, unit="V"),
        "sum": Sum(unit="V"),
        "noisy": Sum(unit="V"),
        "sampler": SamplingNoise(),
        "adc": AnalogToDigital(bits=8, reference=5.0),
        "slow": AnalogToDigital(bits=6, reference=5.0),
        "dac": DigitalToAnalog(bits=8, reference=5.0),
        "number": Gain(gain=0.5, output_unit="V"),
        "both": Sum(unit="V"),
        "average": MovingAverage(length=4, unit="V"),
    }
    wires = ["signal.output -> sum.first", "white.output -> sum.second", "sum.output -> noisy.first"]
    wires += ["flicker.value -> noisy.second", "noisy.output -> sampler.voltage", "sampler.output -> adc.voltage"]
    wires += ["noisy.output -> slow.voltage", "adc.number -> dac.number", "dac.voltage -> both.first"]
    wires += ["adc.number -> number.input", "number.output -> both.second", "both.output -> average.input"]
    return graph_of(blocks, *wires, rates={"slow": "250 Hz", "flicker": "500 Hz"})


def registers(rounding: Rounding = "half_even", gain: float = 0.7) -> Plan:
    """A noisy signal through registers: rounded twice alike, filtered, delayed, and controlled."""
    part = Fixed(16, 12)
    blocks: dict[str, Block] = {
        "white": WhiteNoise(density=1e-3),
        "signal": Sine(amplitude=0.4, frequency=90.0),
        "sum": Sum(),
        "in": FixedQuantiser(output_format=part),
        "gain": FixedGain(input_format=part, gain=gain, output_format=Fixed(16, 8), rounding=rounding),
        "again": FixedGain(input_format=part, gain=gain, output_format=Fixed(16, 6), rounding=rounding),
        "section": FixedSecondOrderSection(
            input_format=Fixed(16, 8), output_format=Fixed(16, 8), b0=0.2, b1=0.3, b2=0.1, a1=-0.5, a2=0.1
        ),
        "delay": FixedDelay(format=Fixed(16, 8), ticks=3),
        "out": FixedToNumber(input_format=Fixed(16, 8)),
        "coarse": FixedToNumber(input_format=Fixed(16, 6)),
        "both": Sum(),
    }
    wires = ["signal.output -> sum.first", "white.output -> sum.second", "sum.output -> in.input"]
    wires += ["in.output -> gain.input", "in.output -> again.input", "gain.output -> section.input"]
    wires += ["section.output -> delay.input", "delay.output -> out.input", "again.output -> coarse.input"]
    wires += ["out.output -> both.first", "coarse.output -> both.second"]
    return graph_of(blocks, *wires)


def driven(density: float = 1e-3) -> Plan:
    """A mass whose stiffness is noisy: random numbers make the matrices of its group anew."""
    mass = MassSpringDamper(mass=1e-6, damping=1e-3, stiffness=1.0)
    blocks: dict[str, Block] = {"white": WhiteNoise(density=density, unit="N/m"), "mass": mass}
    blocks |= {
        "middle": Constant(value=1.0, unit="N/m"),
        "stiff": Sum(unit="N/m"),
        "push": Constant(value=1e-3, unit="N"),
    }
    wires = ["white.output -> stiff.first", "middle.output -> stiff.second", "stiff.output -> mass.stiffness"]
    return graph_of(blocks, *wires, "push.output -> mass.force")


def test_numbers_that_are_still_between_slow_ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of slow integrators behind noise: what they hold has no lanes of its own but where they tick."""
    seen = list[tuple[int, int]]()

    class Seen(StillNumbers):
        def choose(self, found: Found, live: Any, ticks: int, events: int) -> None:
            seen.append((ticks, int(self.now.sum())))
            super().choose(found, live, ticks, events)

    monkeypatch.setattr(native_slopes, "StillNumbers", Seen)
    monkeypatch.setattr(native_slopes, "_ENTRIES", 1 << 14)  # a few ticks at once
    count = 24
    names = [f"integral_{number}" for number in range(count)]
    blocks: dict[str, Block] = {"white": WhiteNoise(density=1e-4)}
    blocks |= {name: DiscreteIntegrator(gain=10.0, output_unit="1") for name in names} | {"out": Gain(gain=2.0)}
    chain = ["white.output", *(f"{name}.output" for name in names)]
    wires = [f"{first} -> {name}.input" for first, name in zip(chain, [*names, "out"], strict=True)]
    planned = graph_of(blocks, *wires, rates=dict.fromkeys(names, "62.5 Hz"))
    assert_alike(*both(planned, [("out", "output")], tick=0, span=48))
    assert max(still for _, still in seen) > count
    assert sum(ticks for ticks, still in seen if still) > 24


@pytest.mark.exhaustive(but=2)
@pytest.mark.parametrize("tick", [0, 1, 37])
def test_a_readout_of_several_rates(tick: int) -> None:
    fast, slow = both(readout(), [("average", "mean"), ("slow", "number"), ("dac", "code"), ("adc", "code")], tick)
    assert_alike(fast, slow)
    rounded = [key for key in fast.inputs if key[:2] == ("dac", "rounding error")]
    assert len(rounded) == SPAN, "both outputs of a converter err alike"


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("rounding", ["half_even", "half_up", "floor", "toward_zero"])
def test_registers_of_all_roundings(rounding: Rounding) -> None:
    """Plain Python follows what is not rounded, so that a product of a coefficient alone has the same slopes."""
    assert_alike(*both(registers(rounding), [("both", "output")]))


def test_errors_count_in_steps() -> None:
    fast, slow = both(registers("toward_zero", gain=1.0), [("coarse", "output")])
    entry = "again", "rounding error 0", 0
    assert fast.matrix[fast.order, fast.order + fast.inputs.index(entry)] == 1.0 / 64.0
    assert fast.drops == slow.drops
    assert fast.drops[entry].rounding == "toward_zero"


@pytest.mark.defect(
    "S807", before="half a word has no ties in maps from machine code: none of quarters", after="as in plain Python"
)
def test_grids_are_those_of_plain_python() -> None:
    """Machine code follows what is rounded, plain Python what is not: the offset of a grid is the same."""
    maps = both(registers(gain=4.0), [], span=1, quantisers=("in", "gain", "again"))
    rule = {entry: Drop(60, "half_even") for entry in maps[0].outputs}
    fast, slow = (on_grids(replace(of, drops={**rule, **of.drops})) for of in maps)
    entry = "gain", "rounding error 0", 0
    assert fast[entry].levels == slow[entry].levels == 4
    sizes = [size_of(4, of[entry].offset, "half_even") for of in (fast, slow)]
    assert sizes == pytest.approx([math.sqrt(9.0 / 8.0)] * 2, rel=1e-12)


def test_noise_that_makes_matrices_anew() -> None:
    assert_alike(*both(driven(), [("mass", "displacement")]), rel=1e-9)


def test_deviates_have_the_values_of_a_run_where_they_are_drawn() -> None:
    """The stiffness is that of the moment, which a random number moves by half."""
    fast, slow = both(driven(density=0.02), [("mass", "displacement")], drawn=True)
    assert_alike(fast, slow, rel=1e-9)
    still, _ = both(driven(density=0.02), [("mass", "displacement")])
    (a, *_), (b, *_) = fast.parts(), still.parts()
    assert np.abs(a - b).max() > 0.1 * np.abs(b).max()


def test_an_input_is_added_to_its_wire() -> None:
    planned = readout()
    assert_alike(*both(planned, [("average", "mean")], inputs=[("sum", "output")]))


@pytest.mark.parametrize(
    ("planned", "source", "target"),
    [(readout(), ("sum", "output"), ("average", "mean")), (driven(), ("push", "output"), ("mass", "displacement"))],
    ids=["rates", "matrices made anew"],
)
def test_small_signals_alone(planned: Plan, source: Endpoint, target: Endpoint) -> None:
    """A map between two wires without noise is machine code too."""
    fast, slow = both(planned, [target], inputs=[source], noise={})
    assert (fast.rounded, slow.rounded) == (True, False)
    assert_alike(fast, slow)


def test_a_quantiser_of_one_bit_has_its_gain() -> None:
    planned = one_bit_loop(gain=1000.0)
    noise: Noisy = {"bit": (OneBitGain(gain=0.8, variance=0.3),)}
    fast, slow = both(planned, [("bit", "sign")], noise=noise)
    assert_alike(fast, slow)
    assert fast.inputs[0][:2] == ("bit", "error of one bit")
    assert fast.matrix[fast.order, fast.order] == pytest.approx(math.sqrt(0.3))


@pytest.mark.defect("S873", before="a pole of 0.779 after three ticks: the loop stayed closed", after="1")
def test_a_wire_that_is_cut_passes_nothing_on() -> None:
    """What enters at the integral takes its place: no error of the bit moves it more than once."""
    node, bit = ("integral", "output"), (OneBitGain(gain=0.8, variance=0.3),)
    fast, slow = both(one_bit_loop(gain=100.0), [node], inputs=[node], cut=True, noise={"bit": bit}, span=3)
    assert_alike(fast, slow)
    assert fast.parts()[0] == pytest.approx(np.eye(1))


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_levels_of_a_modulator(size: float) -> None:
    """Within its eight levels a choice is a rounding, beyond them it stands still. Slopes by its weights are those of
    what is rounded, and in plain Python of what is not.
    """
    blocks: dict[str, Block] = {
        "signal": Sine(amplitude=size, frequency=20.0, unit="V"),
        "white": WhiteNoise(density=1e-4, unit="V"),
        "sum": Sum(unit="V"),
        "modulator": SigmaDeltaModulator(gains=(0.5, 0.5), levels=8),
    }
    wires = ["signal.output -> sum.first", "white.output -> sum.second", "sum.output -> modulator.input"]
    fast, slow = both(graph_of(blocks, *wires), [("modulator", "output")])
    assert [key[1] for key in fast.states] == 2 * ["weights"] + 2 * ["returns"] + 2 * ["integrators"]
    assert fast.inputs == slow.inputs
    assert fast.matrix[:, 4:-1] == pytest.approx(slow.matrix[:, 4:-1], rel=1e-12, abs=1e-12)
    columns = [fast.order + fast.inputs.index(("modulator", "rounding error", tick)) for tick in range(4)]
    errors = fast.matrix[fast.order : fast.order + 4, columns]
    assert errors[:2, 0] == pytest.approx([2.0 / 7.0, -1.0 / 7.0])  # a level, of which half comes back
    assert errors[3, :3].any() == (size < 1.0)  # beyond the last level nothing does


def test_a_sum_of_random_numbers() -> None:
    """After n ticks a sum of numbers of the deviation s is s times the sum of all of them: each has the slope s."""
    blocks: dict[str, Block] = {"white": WhiteNoise(density=0.2), "sum": DiscreteIntegrator(gain=1.0, output_unit="1")}
    fast, _ = both(graph_of(blocks, "white.output -> sum.input"), [("sum", "output")], tick=0)
    (state,) = (row for row, entry in enumerate(fast.states) if entry[0] == "sum")
    s = 0.2 * math.sqrt(1000.0 / 2.0) * 1e-3  # of a one-sided density at 1 kHz, over a tick of 1 ms
    assert fast.matrix[state, fast.order : -1] == pytest.approx([s] * SPAN)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["mems_microphone", "closed_loop_fluxgate", "six_axis_imu", "quartz_error_terms"])
def test_the_library(name: str) -> None:
    planned = plan(read_graph(next(FOLDER.rglob(f"{name}.toml"))))
    node = next(probe.node for probe in planned.probes)
    assert_alike(*both(planned, [node], 128, 128), rel=1e-9)
