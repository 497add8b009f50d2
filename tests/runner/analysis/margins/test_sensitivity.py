"""Exact derivatives against closed forms and against differences of whole graphs."""

import math

import numpy as np
import pytest

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    DisplacementReadout,
    Gain,
    GaussMarkov,
    LowPass,
    MassSpringDamper,
    Product,
    Sine,
    Sum,
    TransferFunction,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints, linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.analysis.margins.sensitivity import (
    Sensitivity,
    _critical,
    by_gain,
    margin_sensitivities,
    transfer_sensitivities,
)
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.planning.plan import plan

GRAPH = read_graph(library_file("closed_loop_accelerometer.toml"))


def transfer(graph: Graph, source: str, target: str) -> tuple[Sensitivity, Sensitivity]:
    planned = plan(graph)
    return transfer_sensitivities(linearised(planned), node_of(planned, source), node_of(planned, target))


def loop_margins(graph: Graph, signal: str) -> list[Sensitivity]:
    planned = plan(graph)
    node = node_of(planned, signal)
    system = linearised(planned).loop(node, by_parameters=True)
    return margin_sensitivities(planned, margins_of(linearised(planned).loop(node), "main", signal), system)


def margin_values(graph: Graph, signal: str) -> list[float]:
    """Gain, phase and delay margin in the units of their sensitivities, without derivatives."""
    planned = plan(graph)
    data = margins_of(linearised(planned).loop(node_of(planned, signal)), "main", signal).as_data()
    return [data["gain_margin_db"], data["phase_margin_deg"], data["delay_margin_s"]]


def slopes(found: Sensitivity) -> dict[str, float]:
    return {effect.parameter: effect.derivative for effect in found.effects}


@pytest.mark.friendly(33, "effects agree with a closed form")
def test_scale_factor_of_the_accelerometer_in_closed_form() -> None:
    """SF = -K0 R 2^19 / (kt Vref): nothing else moves it, least of all the pendulum and the controller."""
    scale, bias = transfer(GRAPH, "acceleration.output", "dac.code")
    expected = -8.0e-6 * 342.0 * 2.0**19 / (0.065 * 2.5)
    assert scale.value == pytest.approx(expected, rel=1e-12)
    assert scale.unit == "1/(m/s^2)"
    assert slopes(scale) == pytest.approx(
        {
            "pendulosity.gain": expected / 8.0e-6,
            "reference.offset": -expected / 2.5,
            "resistor.gain": -expected * 342.0,
            "torquer.gain": -expected / 0.065,
        },
        rel=1e-9,
    )
    assert [abs(e.of_one_percent or 0.0) for e in scale.effects] == pytest.approx([abs(expected) / 100.0] * 4)
    # The integrator holds the code of the first converter at zero: an offset there is a displacement, and a code.
    assert bias.value == 0.0
    stiffness, pickoff, torque_per_code = 3.0e-3, 8000.0, 0.065 / 342.0 * 2.5 / 2.0**19
    assert slopes(bias) == pytest.approx({"adc.offset_error": -stiffness / pickoff / torque_per_code}, rel=1e-6)
    assert bias.effects[0].of_one_percent is None


def open_sensor() -> Graph:
    """A force sensor at two rates with an offset, a filter by coefficients, an average and a drift that is at rest."""
    blocks: dict[str, Block] = {
        "force": Constant(value=2e-6, unit="N"),
        "mass": MassSpringDamper(),
        "readout": DisplacementReadout(offset=0.25),
        "analog": TransferFunction(numerator=(2.0, 3e4), denominator=(1.0, 1.5e4), input_unit="V", output_unit="V"),
        "drift": GaussMarkov(nominal=1.5),
        "scaled": Product(first_unit="V"),
        "filter": DiscreteTransferFunction(
            numerator=(0.3, 0.1), denominator=(1.0, -0.4), input_unit="(V)*(1)", output_unit="V"
        ),
        "mean": Decimator(ratio=3, unit="V"),
    }
    wires = [
        "force.output -> mass.force",
        "mass.displacement -> readout.displacement",
        "readout.voltage -> analog.input",
        "analog.output -> scaled.first",
        "drift.value -> scaled.second",
        "scaled.output -> filter.input",
        "filter.output -> mean.input",
    ]
    return Graph(name="sensor", rate=5000, blocks=blocks, wires=wires, probes=["mean.mean"])


def test_an_open_sensor_in_closed_form() -> None:
    scale, bias = transfer(open_sensor(), "force.output", "mean.mean")
    gain, stiffness = 3.530e8, 49.5627
    rest = 2.0 * 1.5 * (0.4 / 0.6)  # of the filters, and the drift at rest
    assert scale.value == pytest.approx(gain / stiffness * rest, rel=1e-9)
    assert bias.value == pytest.approx(0.25 * rest, rel=1e-9)
    expected = {
        "mass.stiffness": -gain / stiffness**2 * rest,
        "readout.gain": rest / stiffness,
        "analog.numerator[1]": gain / stiffness * rest / 3e4,
        "analog.denominator[1]": -gain / stiffness * rest / 1.5e4,
        "drift.nominal": gain / stiffness * rest / 1.5,
        "filter.numerator[0]": gain / stiffness * 3.0 / 0.6,
        "filter.numerator[1]": gain / stiffness * 3.0 / 0.6,
        "filter.denominator[0]": -gain / stiffness * rest / 0.6,
        "filter.denominator[1]": -gain / stiffness * rest / 0.6,
    }
    assert slopes(scale) == pytest.approx(expected, rel=1e-7)
    offset = slopes(bias)
    assert offset["readout.offset"] == pytest.approx(rest, rel=1e-9)
    assert offset["analog.denominator[1]"] == pytest.approx(-0.25 * rest / 1.5e4, rel=1e-7)
    assert "force.value" not in offset
    assert "mass.stiffness" not in offset


def differences(graph: Graph, key: str, step: float, signal: str) -> list[float]:
    """Central differences of the margins of a changed graph, four-point so that they are good to eight digits."""
    name, parameter = key.rsplit(".", 1)
    base = getattr(graph.blocks[name], parameter.partition("[")[0])
    found = []
    for distance in (-2.0, -1.0, 1.0, 2.0):
        if parameter.endswith("]"):
            entry, index = parameter[:-1].split("[")
            value: object = [v + distance * step * (i == int(index)) for i, v in enumerate(base)]
            changed = graph.with_parameters({f"{name}.{entry}": value})
        else:
            changed = graph.with_parameters({key: base + distance * step})
        found.append(margin_values(changed, signal))
    return [(a - 8.0 * b + 8.0 * c - d) / (12.0 * step) for a, b, c, d in zip(*found, strict=True)]


@pytest.mark.exhaustive
@pytest.mark.parametrize("apart", [4, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_margins_of_the_accelerometer_against_differences(apart: int) -> None:
    found = loop_margins(GRAPH, "dac.voltage")
    assert [quantity.quantity for quantity in found] == [
        "main: gain margin",
        "main: phase margin",
        "main: delay margin",
    ]
    assert {"pendulum.inertia", "pid.derivative_pole", "reference.offset"} <= set(slopes(found[0]))
    for key in list(slopes(found[0]))[::apart]:
        name, parameter = key.rsplit(".", 1)
        value = getattr(GRAPH.blocks[name], parameter)
        expected = differences(GRAPH, key, 1e-4 * (abs(value) or 1.0), "dac.voltage")
        for quantity, slope in zip(found, expected, strict=True):
            scale = 1e-7 * abs(quantity.value) / (abs(value) or 1.0)
            assert slopes(quantity)[key] == pytest.approx(slope, rel=1e-6, abs=scale), (quantity.quantity, key)


@pytest.mark.exhaustive
def test_a_loop_of_two_rates_against_differences() -> None:
    """Gain and phase margin of a loop with several values of its wire in a period, by eigenvectors."""
    blocks: dict[str, Block] = {
        "plant": TransferFunction(numerator=(3e4,), denominator=(1.0, 400.0, 3e5)),
        "fast": DiscreteTransferFunction(numerator=(0.6, 0.3), denominator=(1.0, -0.1)),
        "slow": DiscreteTransferFunction(numerator=(-0.3, 0.25), denominator=(1.0, -1.0)),
    }
    wires = ["plant.strictly_proper_part -> fast.input", "fast.output -> slow.input", "slow.output -> plant.input"]
    graph = Graph(name="rates", rate=10_000, blocks=blocks, wires=wires, rates={"slow": 2500})
    found = loop_margins(graph, "fast.output")
    assert [quantity.quantity for quantity in found] == ["main: gain margin", "main: phase margin"]
    for key in ("plant.denominator[2]", "slow.numerator[0]"):
        name, parameter = key.rsplit(".", 1)
        value = getattr(graph.blocks[name], parameter.partition("[")[0])[int(parameter[-2])]
        *expected, _ = differences(graph, key, 1e-4 * abs(value), "fast.output")
        assert [slopes(quantity)[key] for quantity in found] == pytest.approx(expected, rel=1e-6), key


@pytest.mark.defect("S772", before="+1 % of -25 was -24.75", after="-25.25")
def test_gain_moves_the_gain_margin_by_itself() -> None:
    blocks: dict[str, Block] = {"total": DiscreteIntegrator(output_unit="1"), "back": Gain(gain=-25.0)}
    graph = Graph(
        name="integrator",
        rate=100,
        blocks=blocks,
        wires=["total.output -> back.input", "back.output -> total.input"],
    )
    gain, phase, delay = loop_margins(graph, "back.output")
    assert gain.value == pytest.approx(20.0 * math.log10(8.0))
    assert slopes(gain)["back.gain"] == pytest.approx(20.0 / math.log(10.0) / 25.0)
    (back,) = [effect for effect in gain.effects if effect.parameter == "back.gain"]
    assert back.of_one_percent == pytest.approx(-0.2 / math.log(10.0)), "-25.25 is nearer to the limit than -25"
    # |L| = 1 at w = 2 asin(k / 2) / T, where the phase margin is 90 degrees - asin(k / 2), k = 0.25 here.
    slope = -math.degrees(0.5 / math.sqrt(1.0 - 0.125**2))
    assert slopes(phase)["total.gain"] == pytest.approx(slope * 0.25, rel=1e-9)
    turn = math.asin(0.125)
    by_k = (-0.5 * 0.01 / (2.0 * turn) - (math.pi / 2.0 - turn) * 0.01 / (4.0 * turn**2)) / math.sqrt(1.0 - 0.125**2)
    assert slopes(delay)["total.gain"] == pytest.approx(by_k * 0.25, rel=1e-9)


def test_what_does_not_settle_has_no_scale_factor() -> None:
    graph = Graph(
        name="integrator",
        rate=100,
        blocks={"source": Constant(), "total": DiscreteIntegrator(output_unit="s")},
        wires=["source.output -> total.input"],
    )
    with pytest.raises(ModelError, match=r"total.output does not settle"):
        transfer(graph, "source.output", "total.output")


def test_a_parameter_at_zero_is_ranked_by_a_hundredth_where_it_is_a_ratio() -> None:
    gain, _, _ = loop_margins(GRAPH, "dac.voltage")
    effects = {effect.parameter: effect for effect in gain.effects}
    assert effects["adc.gain_error"].of_one_percent == pytest.approx(0.01 * effects["adc.gain_error"].derivative)
    changes = [abs(effect.of_one_percent or 0.0) for effect in gain.effects]
    assert changes == sorted(changes, reverse=True)


def test_sum_takes_part() -> None:
    graph = Graph(
        name="sum",
        rate=100,
        blocks={"source": Constant(value=3.0), "other": Constant(value=0.5), "sum": Sum()},
        wires=["source.output -> sum.first", "other.output -> sum.second"],
    )
    scale, bias = transfer(graph, "source.output", "sum.output")
    assert (scale.value, bias.value) == (1.0, 0.5)
    assert slopes(bias) == {"other.value": 1.0}


def beside_a_hidden_mode(neutral: float, a: list[list[float]], c: list[float], continuous: bool) -> OpenLoop:
    """A loop from its last state to a row of states, and a state that takes no part in it."""
    n, wire = len(a) + 1, (("x", "output", 0),)
    matrix = np.zeros((n + 1, n + 2))
    matrix[0, 0], matrix[1:n, 1:n], matrix[n - 1, n], matrix[n, 1:n] = neutral, a, 1.0, -np.array(c)
    states = tuple(("x", f"state_{i}", -1) for i in range(n))
    return OpenLoop(PeriodMap(states, wire, wire, matrix, {}, 0.0 if continuous else 1e-3), continuous)


def test_the_critical_pole_is_one_that_the_factor_moves() -> None:
    """Of 5 / (z - 1) a factor of 0.4 puts the pole 1 - 5 f at -1: outwards by 5 a unit of the factor.

    Of 8 / (s + 1)^3 the poles are -1 + 2 f^(1/3) exp(+-j pi / 3), and a third one far inside.
    """
    sampled = beside_a_hidden_mode(1.0 + 1e-9, [[1.0]], [5.0], False)
    by_factor, move = _critical(sampled, 0.4)
    assert move(by_factor) == pytest.approx(5.0)
    chain = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -3.0, -3.0]]
    analog = beside_a_hidden_mode(1e-9, chain, [8.0, 0.0, 0.0], True)
    by_factor, move = _critical(analog, 1.0)
    assert move(by_factor).real == pytest.approx(1.0 / 3.0)


@pytest.mark.defect("S792", before="scale factor 2.88, bias 1.3: of converters that do not round", after="as a run")
def test_scale_factor_and_bias_are_those_of_converters_that_round() -> None:
    """Steps of 1 V: a sine of 2.4 V is 0, 2, 2, 2 and so on, whose squares have the mean 3; 1.3 V is one step."""
    blocks = {
        "level": Constant(value=0.0),
        "carrier": Sine(frequency=1e4, amplitude=2.4, unit="V"),
        "adc": AnalogToDigital(bits=3, reference=4.0),
        "square": Product(),
        "turned": Product(),
        "offset": Constant(value=1.3, unit="V"),
        "constant": AnalogToDigital(bits=3, reference=4.0),
        "sum": Sum(),
    }
    wires = [
        "carrier.output -> adc.voltage", "adc.number -> square.first", "adc.number -> square.second",
        "level.output -> turned.first", "square.output -> turned.second", "turned.output -> sum.first",
        "offset.output -> constant.voltage", "constant.number -> sum.second",
    ]  # fmt: skip
    about = linearised(plan(Graph(name="coarse", rate=80_000, blocks=blocks, wires=wires)))
    scale, bias = transfer_sensitivities(about, ("level", "output"), ("sum", "output"))
    assert scale.value == pytest.approx(3.0)
    assert bias.value == pytest.approx(1.0)
    slopes = {effect.parameter: effect.derivative for effect in bias.effects}
    assert slopes["offset.value"] == pytest.approx(1.0)


@pytest.mark.exhaustive
def test_slopes_of_a_loop_by_a_gain_of_zero_beside_it() -> None:
    """A carrier of eight samples, and a path that a gain of zero leaves out: only its slope has the filter in it."""
    blocks = {
        "rest": Constant(value=0.0),
        "error": Difference(),
        "carrier": Sine(frequency=1_000.0),
        "up": Product(),
        "down": Product(),
        "filter": LowPass(corner_frequency=500.0),
        "none": Gain(gain=0.0),
        "sum": Sum(),
        "plant": DiscreteIntegrator(gain=800.0, output_unit="1"),
    }
    wires = [
        "rest.output -> error.first", "plant.output -> error.second", "error.output -> up.first",
        "carrier.output -> up.second", "up.output -> down.first", "carrier.output -> down.second",
        "error.output -> filter.input", "filter.output -> none.input", "down.output -> sum.first",
        "none.output -> sum.second", "sum.output -> plant.input",
    ]  # fmt: skip
    loops = {"main": {"open_at": "plant.output"}}
    graph = Graph(name="beside", rate=8_000, blocks=blocks, wires=wires, samples=800, loops=loops)
    node, planned = ("plant", "output"), plan(graph)
    system = OperatingPoints(planned).loop(node, by_parameters=True)
    found = margins_of(system, "main", "plant.output")
    assert found.least_gain_margin == pytest.approx(margins(graph).least_gain_margin, rel=1e-9)
    slope = by_gain(system, found)("none.gain")
    ends = [margins(graph.with_parameters({"none.gain": gain})).least_gain_margin for gain in (1e-4, -1e-4)]
    assert slope == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-4)


def test_a_bias_has_the_unit_of_its_output_and_a_scale_factor_that_of_the_quotient() -> None:
    blocks: dict[str, Block] = {
        "force": Constant(value=1.0, unit="N"),
        "gain": Gain(gain=2.5, input_unit="N", output_unit="V"),
    }
    graph = Graph(name="units", rate=10, blocks=blocks, wires=["force.output -> gain.input"])
    scale, bias = transfer(graph, "force.output", "gain.output")
    assert (scale.unit, bias.unit) == ("V/N", "V")
    assert (scale.value, bias.value) == pytest.approx((2.5, 0.0))
