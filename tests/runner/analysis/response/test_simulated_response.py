"""Responses by simulation: linear graphs give the linear response, others what theory says of them."""

import math

import numpy as np
import pytest

from proofmass import Graph, Response, response
from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    Gain,
    LowPass,
    Saturation,
    Sine,
    WhiteNoise,
)
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.response.stimuli import KINDS, StimulusKind
from tests.by_hand.amounts import chosen


@pytest.fixture(scope="module")
def two_rates() -> Graph:
    """A loop whose controller runs at a fifth of the rate, with noise, a signal of its own and an averaged output."""
    blocks = {
        "force": Sine(amplitude=0.3, frequency=7.0),
        "noise": WhiteNoise(density=1e-2),
        "error": Difference(),
        "plant": LowPass(corner_frequency=30.0),
        "control": DiscreteIntegrator(gain=60.0, output_unit="1"),
        "mean": Decimator(ratio=2),
        "gain": Gain(gain=2.0),
    }
    wires = [
        "force.output -> error.first", "control.output -> error.second", "error.output -> plant.input",
        "plant.output -> control.input", "plant.output -> mean.input", "noise.output -> gain.input",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, rates={"control": "200 Hz"})


@pytest.mark.exhaustive("sine", "prbs", "multitone")
@pytest.mark.parametrize("kind", KINDS)
def test_a_linear_graph_of_two_rates(two_rates: Graph, kind: StimulusKind) -> None:
    """The deviation is what the transient leaves, whatever signals and noise the graph has besides."""
    found = response(two_rates, "force.output", "mean.mean", simulate=kind, amplitude=1.0, band=(5.0, 45.0))
    assert found.simulated is not None
    assert len(found.simulated.frequencies) >= 8
    assert found.simulated.deviation < 1e-6
    assert np.max(np.abs(found.simulated.decibels)) < 1e-3


def test_the_simulation_is_not_the_linearisation(two_rates: Graph) -> None:
    """Gain of the sine from the run alone, by least squares, against both."""
    found = response(two_rates, "force.output", "mean.mean", simulate="sine", amplitude=1.0, band=(20.0, 20.5))
    assert found.simulated is not None
    assert found.simulated.gain == pytest.approx(found.wires.gain(found.simulated.frequencies), rel=1e-5)


@pytest.mark.defect("S967", before="a clock offset was 58 deg and 67 % from linear", after="the phase of the offset")
@pytest.mark.parametrize("kind", KINDS)
def test_a_clock_offset_turns_the_phase_of_the_simulation(kind: StimulusKind) -> None:
    blocks = {"u": Constant(value=0.0), "b": Gain()}
    offsets = {"u": "20 ms", "b": "60 ms"}
    graph = Graph(name="", rate="10 Hz", blocks=blocks, wires=["u.output -> b.input"], offsets=offsets)
    run = response(graph, "u.output", "b.output", simulate=kind, amplitude=1.0, band=(1.0, 4.5)).simulated
    assert run is not None
    assert run.gain == pytest.approx(np.exp(-2j * np.pi * run.frequencies * 0.04), abs=1e-9)
    assert run.deviation < 1e-9


CLIP = Graph(
    name="",
    rate="10 kHz",
    blocks={"u": Constant(value=0.0), "clip": Saturation(lowest=-1.0, highest=1.0)},
    wires=["u.output -> clip.input"],
)


def clipped(amplitude: float) -> Response:
    return response(CLIP, "u.output", "clip.output", simulate="sine", amplitude=amplitude, band=(10.0, 50.0))


@pytest.mark.parametrize("amplitude", chosen([0.5, 2.0], [10.0]))
def test_a_limit_has_the_gain_of_its_describing_function(amplitude: float) -> None:
    """2 / pi (asin(1 / A) + sqrt(1 - 1 / A^2) / A), and the rest of the power goes into harmonics."""
    run = clipped(amplitude).simulated
    assert run is not None
    part = min(1.0, 1.0 / amplitude)
    gain = 2.0 / math.pi * (math.asin(part) + part * math.sqrt(1.0 - part * part))
    assert np.abs(run.gain) == pytest.approx(gain, rel=1e-3)
    assert run.deviation == pytest.approx(1.0 - gain, abs=1e-3)
    top = part**2 * (1.0 - 2.0 / math.pi * math.asin(part)) if part < 1.0 else 0.0
    inner = (math.asin(part) - part * math.sqrt(1.0 - part * part)) / math.pi
    square = (inner + top) * amplitude**2  # mean square of a clipped sine
    first = (gain * amplitude) ** 2 / 2.0
    assert run.rest == pytest.approx(math.sqrt(max(square - first, 0.0) / first), abs=1e-3)


def test_a_converter_is_linear_for_large_signals_only() -> None:
    blocks = {"u": Constant(value=1e-4, unit="V"), "adc": AnalogToDigital(bits=8, reference=1.0)}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=["u.output -> adc.voltage"])
    far = [response(graph, "u.output", "adc.number", simulate="multitone", amplitude=a, band=(3.0, 90.0)).simulated
           for a in (0.9, 1e-3)]  # fmt: skip
    assert far[0] is not None
    assert far[1] is not None
    assert far[0].deviation < 0.01
    assert far[1].deviation == pytest.approx(1.0, abs=0.05)  # below half a step nothing comes out


@pytest.mark.parametrize(("wrong", "message"), [
    ({"amplitude": None}, "the stimulus needs an amplitude"),
    ({"amplitude": "1 V"}, "is not an amplitude"),
    ({"amplitude": 0.0}, "is not an amplitude"),
    ({"amplitude": math.nan}, "is not an amplitude"),
    ({"simulate": "chrip"}, "there is no such stimulus"),
    ({"band": (10.0, 6000.0)}, "the band does not suit"),
    ({"band": (1e-9, 60.0)}, "would be too long"),
])  # fmt: skip
def test_what_is_wrong_is_said(wrong: dict[str, object], message: str) -> None:
    options = {"simulate": "sine", "amplitude": 1.0, **wrong}
    with pytest.raises(ModelError, match=message):
        response(CLIP, "u.output", "clip.output", **options)  # type: ignore[arg-type]


def test_a_stimulus_between_continuous_blocks_is_refused(two_rates: Graph) -> None:
    with pytest.raises(ModelError, match="between continuous blocks"):
        response(two_rates, "plant.output", "mean.mean", simulate="sine", amplitude=1.0)


def test_progress_ends_when_the_last_run_does() -> None:
    """All runs together, the quiet one too, are one whole."""
    graph = Graph(
        name="",
        rate="1 kHz",
        blocks={"zero": Constant(value=0.0), "lag": LowPass(corner_frequency=50.0)},
        wires=["zero.output -> lag.input"],
    )
    parts = list[float]()
    response(
        graph, "zero.output", "lag.output", simulate="sine", amplitude=1.0, band=(20.0, 20.5),
        progress=lambda done, of: parts.append(done / of),
    )  # fmt: skip
    assert parts == sorted(parts)
    assert (parts[-1], max(parts)) == (1.0, 1.0)
