"""Outputs that hold their value between ticks, and delays, in recordings of another rate."""

import math

import numpy as np
import pytest

from proofmass import Graph
from proofmass.blocks import Gain, LowPass, Sine
from proofmass.runner.design.identification.fitted import Estimate, fit
from proofmass.runner.design.identification.model import _widest_gap
from proofmass.runner.host.arrays import AnyArray

FINE, SLOW = 2000.0, 100.0  # rows and values a second
TIMES = np.arange(1000) / FINE
MOVES = np.random.default_rng(2).standard_normal(50)


def held(times: AnyArray) -> AnyArray:
    """What goes into a converter: a random value, another every 10 ms."""
    return MOVES[np.clip(np.floor(times * SLOW + 1e-9).astype(int), 0, 49)]


def slow_gain() -> Graph:
    blocks = {"source": Sine(), "slow": Gain(gain=1.0)}
    return Graph(name="", rate=FINE, blocks=blocks, wires=["source.output -> slow.input"], rates={"slow": SLOW})


def fitted(out: AnyArray, **more: object) -> dict[str, Estimate]:
    data = {"time": TIMES, "in": held(TIMES), "out": out}
    free = {"inputs": {"source.output": "in"}, "outputs": {"slow.output": "out"}, "free": ["slow.gain"]}
    found = fit(slow_gain(), data, **free, **more)  # type: ignore[arg-type]
    assert not any("straight lines" in note for note in found.notes)
    return {e.name: e for e in found.estimates}


@pytest.mark.defect("S961", before="a gain of 3 was 2.2: lines between held values", after="a staircase, 3")
def test_a_slow_output_is_a_staircase() -> None:
    assert fitted(3.0 * held(TIMES))["slow.gain"].value == pytest.approx(3.0, rel=1e-9)


@pytest.mark.defect("S961", before="a delay of 2.6 ms was 7.76 +- 0.15 ms", after="known to a row of 0.5 ms")
@pytest.mark.parametrize("delay", [1.6e-3, 2.6e-3, 7.1e-3])
def test_a_delay_of_a_staircase_is_known_to_a_row(delay: float) -> None:
    """Rows at 2.5 ms and 3 ms tell of an edge between them: it is there by the later one."""
    found = fitted(3.0 * held(TIMES - delay) * (delay <= TIMES), delays=["slow.output"], skip="20 ms")
    late = found["delay of slow.output"]
    assert late.value == pytest.approx(math.ceil(delay * FINE) / FINE, rel=1e-3)
    assert late.standard_error == pytest.approx(1.0 / FINE / math.sqrt(12.0), rel=1e-3)
    assert found["slow.gain"].value == pytest.approx(3.0, rel=1e-3)


def test_what_moves_between_ticks_does_so_on_lines() -> None:
    """A low pass at 100 Hz of ticks, recorded at 2 kHz: of a slow sine its values lie within 0.3 % of lines."""
    blocks = {"source": Sine(), "lag": LowPass(corner_frequency=1.0), "seen": Gain(gain=1.0)}
    wires = ["source.output -> lag.input", "lag.output -> seen.input"]
    graph = Graph(name="", rate=SLOW, blocks=blocks, wires=wires)
    slope = 2.0 * np.pi * 2.0
    data = {"time": TIMES, "in": np.ones(1000), "out": 3.0 * (1.0 - np.exp(-slope / 2.0 * TIMES))}
    graph = graph.with_parameters({"lag.corner_frequency": "1 Hz"})
    free = {"inputs": {"source.output": "in"}, "outputs": {"seen.output": "out"}, "free": ["seen.gain"]}
    found = fit(graph, data, **free)  # type: ignore[arg-type]
    assert any("straight lines" in note for note in found.notes)
    assert found.estimates[0].value == pytest.approx(3.0, rel=3e-3)


@pytest.mark.parametrize(
    ("parts", "gap"), [([0.0], 1.0), ([0.25, 0.25], 1.0), ([0.0, 0.5], 0.5), ([0.9, 0.1, 0.2], 0.7)]
)
def test_the_widest_gap_goes_round(parts: list[float], gap: float) -> None:
    assert _widest_gap(np.array(parts)) == pytest.approx(gap)


@pytest.mark.defect("S960", before="4 of 4 starts agree on a delay of 1 ms for 11 ms", after="they begin elsewhere")
def test_starts_differ_in_their_delays() -> None:
    """A ringing of 200 Hz fits itself a turn, 5 ms, early or late, and upside down half a turn."""

    def ringing(times: AnyArray) -> AnyArray:
        return np.where(times < 0.0, 0.0, np.exp(-times / 0.01) * np.sin(400.0 * np.pi * times))

    times, noise = np.arange(240) / 4e3, 0.01 * np.random.default_rng(1).standard_normal(240)
    graph = Graph(name="", rate=4e3, blocks={"s": Sine(), "g": Gain()}, wires=["s.output -> g.input"])
    data = {"time": times, "in": ringing(times), "out": 0.8 * ringing(times - 0.0113) + noise}
    signals = {"inputs": {"s.output": "in"}, "outputs": {"g.output": "out"}}
    one, many = (fit(graph, data, **signals, free=["g.gain"], delays=["g.output"], starts=n) for n in (1, 4))  # type: ignore[arg-type]
    assert many.outputs[0].explained > 0.98 > one.outputs[0].explained
    assert many.reached < 4
    gain, delay = many.estimates
    assert gain.value == pytest.approx(0.8, abs=4.0 * gain.standard_error)
    assert delay.value == pytest.approx(0.0113, abs=4.0 * delay.standard_error)
