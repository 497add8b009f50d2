"""Fixed-point blocks linearised: their registers are numbers, roundings count as gain one, limits as what they are."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import (
    PID,
    Constant,
    FixedDelay,
    FixedDifference,
    FixedIntegrator,
    FixedPID,
    FixedQuantiser,
    FixedToNumber,
    LowPass,
    Negation,
)
from proofmass.blocks.arithmetic.cordic import to_the_real_axis
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, period_map
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.derivatives.dual import dual, plain, slopes_of
from proofmass.runner.planning.plan import plan

COEFFICIENTS = {"proportional": 0.5, "integral": 40.0, "derivative_gain": 1e-4, "derivative_pole": 300.0}
FINE = Fixed(24, 20)


def fixed_chain(value: float) -> Graph:
    """A number through a quantiser, a controller in fixed point, and back to a number."""
    blocks: dict[str, Block] = {
        "source": Constant(value=value),
        "into": FixedQuantiser(output_format=FINE),
        "pid": FixedPID(input_format=FINE, output_format=FINE, gain_format=Fixed(30, 28), **COEFFICIENTS),
        "out": FixedToNumber(input_format=FINE),
    }
    wires = ["source.output -> into.input", "into.output -> pid.error", "pid.output -> out.input"]
    return Graph(name="fixed", rate=5000, blocks=blocks, wires=wires, probes=["out.output"])


def response(found: PeriodMap, periods: int) -> list[float]:
    """What comes out for a unit at the input of tick 0."""
    a, b, c, d = found.parts()
    rows, x = [float(d[0, 0])], b[:, 0]
    for _ in range(periods):
        rows.append(float(c[0] @ x))
        x = a @ x
    return rows


def test_a_controller_in_fixed_point_is_the_one_in_numbers() -> None:
    """Its impulse response is that of PID, but for coefficients rounded to 28 bits."""
    got = period_map(plan(fixed_chain(0.0)), [("source", "output")], [("out", "output")]).between()
    blocks: dict[str, Block] = {"source": Constant(), "pid": PID(**COEFFICIENTS)}
    numbers = Graph(name="numbers", rate=5000, blocks=blocks, wires=["source.output -> pid.error"])
    expected = period_map(plan(numbers), [("source", "output")], [("pid", "output")]).between()
    assert response(got, 20) == pytest.approx(response(expected, 20), abs=1e-6)


def test_a_register_that_saturates_lets_nothing_through() -> None:
    found = period_map(plan(fixed_chain(100.0)), [("source", "output")], [("out", "output")])
    assert not found.parts()[3].any()


def test_margins_of_a_loop_closed_in_fixed_point() -> None:
    graph = fixed_chain(0.0)
    wires = [wire for wire in graph.wires if wire.source != "source.output"]
    looped = Graph(
        name="loop",
        rate=5000,
        blocks={**{n: b for n, b in graph.blocks.items() if n != "source"}, "plant": LowPass(), "minus": Negation()},
        wires=[*wires, "out.output -> plant.input", "plant.output -> minus.input", "minus.output -> into.input"],
    )
    numbers = Graph(
        name="loop",
        rate=5000,
        blocks={"pid": PID(**COEFFICIENTS), "plant": LowPass(), "minus": Negation()},
        wires=["pid.output -> plant.input", "plant.output -> minus.input", "minus.output -> pid.error"],
    )
    got, expected = margins(looped, "out.output"), margins(numbers, "pid.output")
    assert got.stable
    assert got.gain_margin == pytest.approx(expected.gain_margin, rel=1e-5)
    assert got.phase_margin == pytest.approx(expected.phase_margin, rel=1e-5)
    assert np.abs(got.poles[:3]) == pytest.approx(np.abs(expected.poles[:3]), rel=1e-5)


@pytest.mark.parametrize(("x", "y"), [(3.0, 4.0), (-3.0, 4.0), (-3.0, -4.0), (3.0, -4.0)])
def test_an_angle_that_is_searched_by_signs_has_the_slopes_of_the_arctangent(x: float, y: float) -> None:
    """-y / r^2 and x / r^2, in all quadrants."""
    one = 1 << 20
    angles = tuple(round(math.atan(2.0**-i) * one) for i in range(18))
    _, angle = to_the_real_axis(
        dual(x * one, {"x": 1.0}),  # type: ignore[arg-type]
        dual(y * one, {"y": 1.0}),  # type: ignore[arg-type]
        angles,
        round(math.pi * one),
        one,
    )
    assert plain(angle) / one == pytest.approx(math.atan2(y, x), abs=1e-5)
    assert slopes_of(angle) == pytest.approx({"x": -y / 25.0, "y": x / 25.0}, rel=1e-9)


@pytest.mark.defect("C1", before="TypeError: & of Dual and int", after="a register that wraps has slope one")
@pytest.mark.parametrize("tick", [0, 3, 4, 5, 40])
def test_registers_that_wrap_have_slope_one(tick: int) -> None:
    """An integrator that wraps and its difference (Hogenauer 1981): one tick late, whatever the register holds."""
    narrow = Fixed(14, 12)  # -2 to 2: a sum of 0.75 a tick wraps in tick 2, then every fifth or sixth
    wraps: dict[str, Any] = {"overflow": "wrap"}
    blocks: dict[str, Block] = {
        "source": Constant(value=0.75),
        "into": FixedQuantiser(output_format=narrow, **wraps),
        "integral": FixedIntegrator(
            gain=8e3,
            input_format=narrow,
            gain_format=Fixed(2, 0),
            sum_format=narrow,
            output_format=narrow,
            output_unit="1",
            **wraps,
        ),
        "before": FixedDelay(format=narrow),
        "comb": FixedDifference(input_format=narrow, output_format=narrow, **wraps),
        "out": FixedToNumber(input_format=narrow),
    }
    wires = [
        "source.output -> into.input",
        "into.output -> integral.input",
        "integral.output -> comb.first",
        "integral.output -> before.input",
        "before.output -> comb.second",
        "comb.output -> out.input",
    ]
    planned = plan(Graph(name="wraps", rate=8000, blocks=blocks, wires=wires, probes=["out.output"]))
    found = period_map(planned, [("source", "output")], [("out", "output")], memory=Course(planned).at(tick))
    assert response(found, 4) == pytest.approx([0.0, 1.0, 0.0, 0.0, 0.0], abs=1e-12)
    assert found.parts()[0].any()


@pytest.mark.defect("C1", before="TypeError: & of Dual and int", after="a quantiser that wraps has slope one")
@pytest.mark.parametrize("value", [0.3, 1.7, 2.3, -5.1])
def test_a_quantiser_that_wraps_has_slope_one(value: float) -> None:
    for format in (Fixed(14, 12), Fixed(14, 12, signed=False)):
        blocks: dict[str, Block] = {
            "source": Constant(value=value),
            "into": FixedQuantiser(output_format=format, overflow="wrap"),
            "out": FixedToNumber(input_format=format),
        }
        wires = ["source.output -> into.input", "into.output -> out.input"]
        planned = plan(Graph(name="wraps", rate=8000, blocks=blocks, wires=wires, probes=["out.output"]))
        found = period_map(planned, [("source", "output")], [("out", "output")])
        assert response(found, 0) == [1.0]
        turns = (float(found.matrix[-1, -1]) - value) / 4.0  # what wraps is off by whole turns of the register
        assert turns == pytest.approx(round(turns), abs=1e-9)
        assert -2.0 <= found.matrix[-1, -1] < 4.0


@pytest.mark.defect("C402", before="unsupported operand type(s) for <<", after="linearised")
@pytest.mark.parametrize("zero", ["proportional", "integral", "derivative_gain"])
def test_a_controller_with_a_gain_of_zero(zero: str) -> None:
    """With an integrator g / (z - 1) a pole reaches the unit circle at the gain margin, by the equation of the PID."""
    gains: dict[str, Any] = {
        "proportional": 1.75,
        "integral": 1600.0,
        "derivative_gain": 1e-5,
        "derivative_pole": 5e3,
    } | {zero: 0.0}
    wide: dict[str, Any] = {"gain_format": Fixed(32, 28)}
    blocks: dict[str, Block] = {
        "set": Constant(value=0.0),
        "word": FixedQuantiser(),
        "error": FixedDifference(),
        "control": FixedPID(**gains, **wide),
        "sum": FixedIntegrator(gain=1000.0, output_unit="1", **wide),
    }
    wires = ["set.output -> word.input", "word.output -> error.first", "error.output -> control.error"]
    wires += ["control.output -> sum.input", "sum.output -> error.second"]
    found = margins(Graph(name="loop", rate=50_000, blocks=blocks, wires=wires), "control.output")
    decay = np.exp(-2.0 * np.pi * 5e3 / 50_000)
    once, late = np.array([1.0, -1.0]), np.array([1.0, -decay])
    parts = (
        gains["proportional"] * np.polymul(once, late),
        gains["integral"] / 50_000 * np.polymul([1.0, 0.0], late),
        gains["derivative_gain"] * 50_000 * (1.0 - decay) * np.polymul(once, once),
    )
    steps = 1000.0 / 50_000 * sum(parts)
    whole = np.polymul(np.polymul(once, once), late)
    assert found.gain_margin is not None
    sizes = [np.abs(np.roots(np.polyadd(whole, found.gain_margin * f * steps))).max() for f in (0.9999, 1.0001)]
    assert sizes[0] < 1.0 < sizes[1]
