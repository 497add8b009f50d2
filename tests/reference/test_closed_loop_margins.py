"""Margins of the closed-loop accelerometer: the published numbers, a dense sweep of formulas, and the loop itself."""

import cmath
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import DiscreteTransferFunction
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Wire
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.run.simulate import simulate
from tests.by_hand.accelerometer_loop import PERIOD, open_loop

GRAPH = read_graph(library_file("closed_loop_accelerometer.toml"))


def delayed(samples: int) -> Graph:
    """The loop with samples of delay between controller and converter: a filter 1 / z^samples."""
    if samples == 0:
        return GRAPH
    delay = DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, *[0.0] * samples))
    wires = {*GRAPH.wires} - {Wire("pid.output", "dac.number")}
    wires |= {Wire("pid.output", "delay.input"), Wire("delay.output", "dac.number")}
    return replace(GRAPH, blocks={**GRAPH.blocks, "delay": delay}, wires=tuple(wires))


def by_formula(w: Any, samples: int) -> Any:
    """L(exp(j w T)) in closed form."""
    gain = 8000.0 * 2.0**23 / 5.0 * 2.5 / 2.0**19 * 0.0029239766081871343 * 0.065
    return open_loop(w, 1.0e-7, 4.0e-4, 3.0e-3, gain) * np.exp(-1j * w * PERIOD * samples)


@pytest.mark.parametrize(
    ("samples", "gain", "phase", "delay", "bandwidth", "peak"),
    [
        (0, 31.57, 90.9, 766.8e-6, 323.0, 1.06),
        (1, 22.48, 88.5, 746.8e-6, 342.0, 1.45),
        (25, 2.7, 31.6, None, None, None),
    ],
)
@pytest.mark.friendly(30, "published margins")
def test_published_margins(
    samples: int, gain: float, phase: float, delay: float | None, bandwidth: float | None, peak: float | None
) -> None:
    found = margins(delayed(samples)).as_data()
    assert found["stable"]
    assert found["gain_margin_db"] == pytest.approx(gain, abs=0.05)
    assert found["phase_margin_deg"] == pytest.approx(phase, abs=0.05)
    assert found["gain_crossovers_hz"][0] == pytest.approx(329.2, abs=0.06)
    if delay is not None:
        assert found["delay_margin_s"] == pytest.approx(delay, abs=0.05e-6)
        assert found["bandwidth_hz"] == pytest.approx(bandwidth, abs=0.5)
        assert found["sensitivity_peak_db"] == pytest.approx(peak, abs=0.005)


@pytest.mark.parametrize("samples", [0, 1, 25])
def test_against_a_sweep_of_400_000_frequencies(samples: int) -> None:
    """Gain margin within 0.1 %, phase within 0.05 degree; what is interpolated on the sweep is far better than both."""
    w = np.linspace(0.0, math.pi / PERIOD, 400_001)[1:]
    response = by_formula(w, samples)
    crossing = int(np.flatnonzero(np.abs(response) > 1.0)[-1])
    part = math.log(abs(response[crossing])) / math.log(abs(response[crossing] / response[crossing + 1]))
    crossover = float(w[crossing] + part * (w[1] - w[0]))
    phase = math.degrees(cmath.phase(-complex(by_formula(crossover, samples))))
    turned = np.flatnonzero(np.diff(np.sign(response.imag)) != 0)
    factors = [-1.0 / response[i].real for i in turned if response[i].real < 0.0]
    factors.append(-1.0 / response[-1].real if response[-1].real < 0.0 else math.inf)
    found = margins(delayed(samples))
    assert found.gain_margin == pytest.approx(min(f for f in factors if f > 1.0), rel=1e-3)
    assert found.phase_margin is not None
    assert math.degrees(found.phase_margin) == pytest.approx(phase, abs=0.05)
    assert found.gain_crossovers == pytest.approx([crossover / (2.0 * math.pi)], rel=1e-6)
    assert found.sensitivity_peak == pytest.approx(float(np.max(1.0 / np.abs(1.0 + response))), rel=1e-6)
    disk = 2.0 / np.max(np.abs((1.0 - response) / (1.0 + response)))
    assert found.disk_margin == pytest.approx(float(disk), rel=1e-6)


@pytest.mark.parametrize("samples", [0, 3])
def test_response_against_the_formula(samples: int) -> None:
    w = np.geomspace(1.0, math.pi / PERIOD, 1000)
    found = margins(delayed(samples)).system.response(w)
    assert found == pytest.approx(by_formula(w, samples), rel=1e-9)


@pytest.mark.exhaustive
def test_first_unstable_delay_and_gain() -> None:
    """Stable up to 38 samples more; x 37.0 stable, x 38.5 not: by poles, and as the delay and gain margin say."""
    assert margins(delayed(38)).stable
    assert not margins(delayed(39)).stable
    base = margins(delayed(0))
    assert base.delay_margin is not None
    assert math.floor(base.delay_margin / PERIOD) == 38
    for factor, stable in ((37.0, True), (38.5, False)):
        louder = GRAPH.with_parameters({"pickoff.gain": 8000.0 * factor})
        assert margins(louder).stable is stable
    for factor, stable in ((13.0, True), (13.6, False)):
        louder = delayed(1).with_parameters({"pickoff.gain": 8000.0 * factor})
        assert margins(louder).stable is stable


@pytest.mark.exhaustive
def test_the_same_margins_wherever_the_loop_is_opened() -> None:
    """One loop without branches has one return ratio: each of its nine outputs gives the same numbers."""
    expected = margins(GRAPH)
    for signal in ("adc.number", "minus.output", "pid.output", "resistor.output", "torque.output", "pendulum.angle"):
        found = margins(GRAPH, signal)
        for name in ("gain_margin", "phase_margin", "delay_margin", "disk_margin", "sensitivity_peak", "bandwidth"):
            assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-7), (signal, name)


def unquantised(factor: float) -> Graph:
    """The loop without converters, its gain raised, at rest but for one push."""
    lsb, codes = 2.5 / 2.0**19, 2.0**23 / 5.0
    blocks = {
        name: GRAPH.blocks[name] for name in ("pendulum", "pickoff", "torque", "resistor", "torquer", "minus", "pid")
    }
    changed = Graph(
        name="unquantised",
        rate="50 kHz",
        blocks={
            **{name: block for name, block in blocks.items() if name != "pickoff"},
            "pickoff": _gain(8000.0 * codes * factor, "rad", "1"),
            "converter": _gain(lsb, "1", "V"),
            "push": _push(),
        },
        wires=[
            "push.output -> torque.first",
            "torquer.output -> torque.second",
            "torque.output -> pendulum.torque",
            "pendulum.angle -> pickoff.input",
            "pickoff.output -> minus.input",
            "minus.output -> pid.error",
            "pid.output -> converter.input",
            "converter.output -> resistor.input",
            "resistor.output -> torquer.input",
        ],
        probes=["pendulum.angle"],
    )
    return changed


def _gain(gain: float, source: str, target: str) -> Any:
    from proofmass.blocks import Gain

    return Gain(gain=gain, input_unit=source, output_unit=target)


def _push() -> Any:
    from proofmass.blocks import Pulse

    return Pulse(amplitude=1e-6, repetition=1e6, duty=1e-9, unit="N*m")


def growth(factor: float) -> float:
    """How much the swing of the angle grows from the middle to the end of a run."""
    angle = simulate(unquantised(factor), samples=400_000, engine="compiled")["pendulum.angle"].values
    third = len(angle) // 4
    return float(np.ptp(angle[-third:]) / np.ptp(angle[2 * third : 3 * third]))


def test_a_simulated_loop_decays_below_its_gain_margin_and_grows_above() -> None:
    limit: Margins = margins(unquantised(1.0), "converter.output")
    assert limit.gain_margin is not None
    assert limit.gain_margin == pytest.approx(margins(GRAPH).gain_margin, rel=1e-9)
    assert growth(limit.gain_margin * 0.999) < 0.9
    assert growth(limit.gain_margin * 1.001) > 1.1
