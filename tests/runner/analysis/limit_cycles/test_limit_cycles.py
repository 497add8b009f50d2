"""Nonlinear blocks as gains, and limit cycles: against closed forms and simulation."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    AnalogToDigital,
    Comparator,
    Constant,
    Difference,
    DiscreteIntegrator,
    Gain,
    LowPass,
    Relay,
    Saturation,
    TransferFunction,
)
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Wire
from proofmass.runner.analysis.limit_cycles.limit_cycles import (
    LimitCycle,
    _at_half_the_rate,
    _fundamental,
    predicted,
    simulated,
)
from proofmass.runner.analysis.limit_cycles.quasi_linear import with_gains
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.command_line import main


class Sign(Block):
    """One bit: 1 or -1."""

    input = Input("1", "What is compared with zero.")


@Sign.output("1")
def output(p: Sign, input: float) -> float:
    """The sign."""
    return 1.0 if input >= 0.0 else -1.0


def servo(nonlinear: Block, numerator: float = 10.0, **more: float) -> Graph:
    """A block in a loop with 10 / (s (s + 1) (s + 2)): L is real at w = sqrt 2, where it is -10 / 6."""
    blocks: dict[str, Block] = {
        "set": Constant(value=0.3),
        "error": Difference(),
        "limit": nonlinear,
        "plant": TransferFunction(numerator=(numerator,), denominator=(1.0, 3.0, 2.0, 0.0)),
    }
    wires = [
        "set.output -> error.first",
        "plant.strictly_proper_part -> error.second",
        "error.output -> limit.input",
        "limit.output -> plant.input",
    ]
    return Graph(name="servo", rate=50, blocks=blocks, wires=wires, probes=["error.output"], **more)  # type: ignore[arg-type]


def test_a_relay_with_a_plant_of_third_order() -> None:
    """A = (4 M / pi) |L|; beside it the relay as simulated, which has harmonics too."""
    ideal = Relay(lower=-1e-9, upper=1e-9, on=0.5, off=-0.5)
    (cycle,) = predicted(servo(ideal), "limit")
    assert cycle.frequency == pytest.approx(math.sqrt(2.0) / (2.0 * math.pi), rel=1e-6)
    assert cycle.amplitude == pytest.approx(4.0 * 0.5 / math.pi * 10.0 / 6.0, rel=1e-6)
    seen = simulated(servo(ideal, duration=60), "limit")
    assert seen is not None
    assert seen.frequency == pytest.approx(cycle.frequency, rel=0.03)
    assert seen.amplitude == pytest.approx(cycle.amplitude, rel=0.06)


@pytest.mark.defect("S1091", before="a stable loop that rang had a limit cycle, in a run", after="none that lasts")
@pytest.mark.parametrize(("numerator", "lasts"), [(5.0, False), (60.0, True)])
def test_what_decays_is_no_limit_cycle(numerator: float, lasts: bool) -> None:
    """The loop without the limit is stable below 6, by Routh."""
    seen = simulated(servo(Saturation(lowest=-1.0, highest=1.0), numerator, duration=60), "limit")
    assert (seen is not None) == lasts


@pytest.mark.defect(
    "S1090", before="a relay was that of its table, where a wire drove it to 5 times that", after="refused"
)
def test_a_block_that_a_wire_moves_has_no_describing_function() -> None:
    still = servo(Relay(on=1.0, off=-1.0))
    wires = (*still.wires, Wire("size.output", "limit.on"))
    moved = still.changed(blocks={**still.blocks, "size": Constant(value=5.0)}, wires=wires)
    assert predicted(still, "limit")
    for ask in (lambda: predicted(moved, "limit"), lambda: with_gains(moved, {}, {"limit": 2.0})):
        with pytest.raises(ModelError, match="is moved by a wire") as error:
            ask()
        assert error.value.problems[0].got == "size.output -> limit.on"
    assert (
        with_gains(moved, {"limit": 0.7}, {}).blocks["limit"] == with_gains(still, {"limit": 0.7}, {}).blocks["limit"]
    )


def test_the_amplitude_of_a_signal_is_the_mean_of_its_whole_cycles() -> None:
    """Cycles of 8 samples with the amplitudes 2, 1, 1 and 3 between two that are not whole, about 5."""
    amplitudes = np.repeat([2.0, 2.0, 1.0, 1.0, 3.0, 3.0], 8)
    times = 0.25 + 1e-3 * np.arange(48)
    phases = 2.0 * math.pi * (np.arange(48) + 0.5) / 8.0
    values = amplitudes * np.sin(phases) + 0.1 * np.sin(3.0 * phases) + 5.0
    found = _fundamental(times[3:-2], values[3:-2])
    assert found is not None
    assert (found.frequency, found.amplitude) == pytest.approx((125.0, 7.0 / 4.0), rel=1e-12)
    assert _fundamental(times[:9], values[:9]) is None, "one crossing upwards is no cycle"
    assert _fundamental(times[:0], values[:0]) is None
    few = np.array([-1.0, 0.0, 3.0, -3.0, 3.0, 0.0])  # upwards at 1 and, half way, at 3.5 samples
    turned = sum(value * np.exp(2j * math.pi * k / 2.5) for k, value in zip((1, 2, 3), few[1:4], strict=True))
    found = _fundamental(np.arange(6.0), few)
    assert found is not None
    assert (found.frequency, found.amplitude) == pytest.approx((1.0 / 2.5, 2.0 * abs(turned) / 3.0), rel=1e-12)
    square = _fundamental(times, np.tile([0.5, -0.5], 24))
    assert square == LimitCycle(pytest.approx(0.5), pytest.approx(500.0))


def test_hysteresis_makes_the_cycle_slower_and_larger() -> None:
    """Im L = -pi h / (4 M) on the critical locus -1 / N(A)."""
    (cycle,) = predicted(servo(Relay(lower=-0.2, upper=0.2)), "limit")
    s = 2j * math.pi * cycle.frequency
    value = 10.0 / (s * (s + 1.0) * (s + 2.0))
    assert value.imag == pytest.approx(-math.pi * 0.2 / 4.0, rel=1e-6)
    assert value.real == pytest.approx(-math.pi / 4.0 * math.sqrt(cycle.amplitude**2 - 0.04), rel=1e-6)
    assert cycle.frequency < math.sqrt(2.0) / (2.0 * math.pi)


def test_a_saturated_loop_cycles_only_where_it_is_unstable() -> None:
    """N(A) = 6 / 10 at the limit, as quasi-linear theory has it; a stable loop has none."""
    (cycle,) = predicted(servo(Saturation(lowest=-1.0, highest=1.0)), "limit")
    part = 1.0 / cycle.amplitude
    expected = 2.0 / math.pi * (math.asin(part) + part * math.sqrt(1.0 - part * part))
    assert expected == pytest.approx(0.6, rel=1e-9)
    assert predicted(servo(Saturation(lowest=-1.0, highest=1.0), numerator=5.0), "limit") == []


def modulator(order: int, **more: int) -> Graph:
    """MOD1, or MOD2 with the filter (1.5 z - 0.5) / (z - 1)^2, without input."""
    blocks: dict[str, Block] = {
        "set": Constant(value=0.0),
        "error": Difference(),
        "first": DiscreteIntegrator(gain=1000.0, output_unit="1"),
        "quantiser": Sign(),
    }
    wires = ["set.output -> error.first", "quantiser.output -> error.second", "error.output -> first.input"]
    last = "first"
    if order == 2:
        blocks |= {"between": Difference(), "second": DiscreteIntegrator(gain=1000.0, output_unit="1")}
        blocks["inner"] = Gain(gain=1.5)
        wires += [
            "first.output -> between.first",
            "quantiser.output -> inner.input",
            "inner.output -> between.second",
            "between.output -> second.input",
        ]
        last = "second"
    wires.append(f"{last}.output -> quantiser.input")
    return Graph(name="modulator", rate=1000, blocks=blocks, wires=wires, probes=[f"{last}.output"], **more)


@pytest.mark.exhaustive
def test_a_modulator_without_input_cycles_at_half_its_rate() -> None:
    """L(-1) = -1/2 and the bits are +-1: the integrator swings by +-1/2, as it does."""
    (cycle,) = predicted(modulator(1), "quantiser")
    assert (cycle.frequency, cycle.amplitude) == (500.0, pytest.approx(0.5, rel=1e-5))
    seen = simulated(modulator(1, samples=2000), "quantiser")
    assert seen is not None
    assert (seen.frequency, seen.amplitude) == (pytest.approx(500.0), pytest.approx(0.5))


@pytest.mark.parametrize("gain", [0.3, 1.0, 1.9, 2.1])
def test_the_gain_of_a_one_bit_quantiser(gain: float) -> None:
    """MOD1 with the gain k has its pole at 1 - k: stable up to 2 (Ardalan and Paulos 1987)."""
    found = proofmass.margins(with_gains(modulator(1), {"quantiser": gain}, {}), "quantiser.output")
    assert found.stable == (gain < 2.0)
    assert found.poles == pytest.approx([1.0 - gain])
    if found.stable:
        assert found.gain_margin == pytest.approx(2.0 / gain)


def test_second_order_with_a_gain() -> None:
    """z^2 + (1.5 k - 2) z + 1 - k / 2 is stable for 0 < k < 2, by Jury's test."""
    found = proofmass.margins(with_gains(modulator(2), {"quantiser": "1"}, {}), "quantiser.output")
    assert found.gain_margin == pytest.approx(2.0, rel=1e-9)
    assert found.stable_gains == ((0.0, pytest.approx(2.0, rel=1e-9)),)


def test_the_gain_for_an_amplitude() -> None:
    graph = servo(Relay(lower=-1e-9, upper=1e-9))
    found = proofmass.margins(with_gains(graph, {}, {"limit": 4.0}), "limit.output")
    assert found.gain_margin == pytest.approx(0.6 / (4.0 / (math.pi * 4.0)), rel=1e-9)
    with pytest.raises(ModelError, match="shifts the phase"):
        with_gains(servo(Relay(lower=-0.2, upper=0.2)), {}, {"limit": 1.0})


def test_mistakes_are_answered() -> None:
    graph = servo(Saturation())
    for gains, message in (
        ({"limt": 1.0}, "did you mean limit"),
        ({"error": 1.0}, "is not a gain: that needs one wired input and one output"),
        ({"limit": "3 kg"}, "kg"),
    ):
        with pytest.raises(ModelError, match=message):
            with_gains(graph, gains, {})
    with pytest.raises(ModelError, match="memory"):
        predicted(graph, "plant")


@pytest.mark.exhaustive
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "servo.toml"
    path.write_text(write_graph(servo(Relay(lower=-0.05, upper=0.05), duration=30)))
    assert main(["margins", str(path), "--limit-cycle", "limit"]) == 0
    said = capsys.readouterr().out
    assert "  predicted         amplitude 2.2251, 0.21978 Hz\n" in said
    assert "  simulated         amplitude 2." in said
    assert main(["margins", str(path), "--limit-cycle", "limit", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["limit_cycles"]
    assert (data["block"], data["unit"], len(data["predicted"])) == ("limit", "1", 1)
    assert main(["margins", str(path), "--gain", "limit=0.3"]) == 0
    assert "gain margin       +6.02 dB (x 2)" in capsys.readouterr().out
    assert main(["margins", str(path), "--gain", "limit"]) == 2


def test_a_loop_that_is_real_at_all_frequencies_ends() -> None:
    """Two integrators, one of them without delay: z / (z - 1)^2 = -1 / (2 - 2 cos w), never beside the real axis."""
    graph = modulator(2)
    blocks = {**graph.blocks, "inner": Gain(gain=1.0)}
    found = proofmass.margins(with_gains(replace(graph, blocks=blocks), {"quantiser": 1.0}, {}), "quantiser.output")
    assert found.verdict == "marginal"
    assert found.gain_crossovers == (pytest.approx(1000.0 / 6.0),)


@pytest.mark.defect(
    "S403", before="a continuous loop without limits", after="the sampled loop, a gain margin of x 1.64"
)
@pytest.mark.parametrize("rates", [{}, {"bit": 1000}])
@pytest.mark.parametrize(
    ("bit", "port", "unit"),
    [(Comparator(), "sign", "1"), (AnalogToDigital(bits=16, reference=32768.0), "number", "V")],
)
def test_a_clocked_block_keeps_its_tick_as_a_gain(bit: Block, port: str, unit: str, rates: dict[str, int]) -> None:
    """L = 2 (1 - a) / (z - a), a = exp(-2 pi 100 / 1000), becomes unstable at z = -1."""
    graph = Graph(
        name="one bit",
        rate=1000,
        blocks={
            "set": Constant(value=0.1, unit=unit),
            "error": Difference(unit=unit),
            "bit": bit,
            "plant": LowPass(corner_frequency=100.0, output_unit=unit),
        },
        rates=rates,
        wires=[
            "set.output -> error.first",
            "plant.output -> error.second",
            "error.output -> bit.input" if unit == "1" else "error.output -> bit.voltage",
            f"bit.{port} -> plant.input",
        ],
    )
    found = proofmass.margins(with_gains(graph, {"bit": 2.0}, {}))
    decay = math.exp(-0.2 * math.pi)
    assert not found.system.continuous
    assert found.gain_margin == pytest.approx((1.0 + decay) / (2.0 * (1.0 - decay)), rel=1e-12)
    assert found.gain_margin_frequency == pytest.approx(500.0)


def delayed(gain: float) -> OpenLoop:
    """A gain and a delay of one sample, at 1 kHz: L(-1) is the gain with its sign turned."""
    wire = (("x", "output", 0),)
    return OpenLoop(
        PeriodMap((("x", "held", -1),), wire, wire, np.array([[0.0, 1.0, 0.0], [-gain, 0.0, 0.0]]), {}, 1e-3)
    )


def test_two_samples_of_a_relay_are_the_relay_itself() -> None:
    """N(A) = 4 M / (pi A), but a sine of two samples is +-A: A = M |L|, where L is negative, of a relay alone."""

    def relay(amplitude: float) -> complex:
        return complex(4.0 * 3.0 / (math.pi * amplitude))

    (cycle,) = _at_half_the_rate(delayed(0.25), relay)
    assert cycle == LimitCycle(pytest.approx(0.75, rel=1e-12), 500.0)
    assert not list(_at_half_the_rate(delayed(-0.25), relay))
    assert not list(_at_half_the_rate(delayed(0.0), relay))
    assert not list(_at_half_the_rate(delayed(0.25), lambda amplitude: 0.5 * relay(amplitude) + 1.0))
