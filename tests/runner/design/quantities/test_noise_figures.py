"""Noise in a band and referred to an input, with its derivatives: a white noise behind a gain, by hand."""

import math

import pytest

from proofmass import Graph, noise
from proofmass.blocks import Constant, Gain, LowPass, Sum, WhiteNoise
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.quantities import Noise
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.design.quantities.evaluator import Evaluator
from proofmass.runner.design.quantities.output_figures import read_noise
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from tests.runner.analysis.noise.test_one_bit import modulator

DENSITY, BEFORE, BEHIND = 0.02, 5.0, 3.0


def planned(before: float) -> Plan:
    """A white noise between two gains."""
    return plan(
        Graph(
            name="",
            rate=1000,
            blocks={
                "push": Constant(value=1.0),
                "before": Gain(gain=before),
                "hiss": WhiteNoise(density=DENSITY),
                "noisy": Sum(),
                "behind": Gain(gain=BEHIND),
            },
            wires=[
                *("push.output -> before.input", "before.output -> noisy.first", "hiss.output -> noisy.second"),
                "noisy.output -> behind.input",
            ],
        )
    )


PLANNED = planned(BEFORE)
PARAMETERS = {"before.gain": BEFORE, "behind.gain": BEHIND, "hiss.density": DENSITY}


@pytest.mark.parametrize(
    ("source", "band", "width"),
    [
        ("", (20.0, 120.0), 100.0),
        ("", (20.0, 9e9), 480.0),
        ("push.output", (20.0, 120.0), 100.0),
        ("push.output", None, 500.0),
    ],
)
def test_a_white_noise_behind_a_gain(source: str, band: tuple[float, float] | None, width: float) -> None:
    """Rms n g sqrt(width) at the output, n sqrt(width) / k at the input."""
    found = read_noise(OperatingPoints(PLANNED), Noise("behind.output", source, band, "1"), PARAMETERS, True)
    assert found is not None
    size = DENSITY * math.sqrt(width)
    rms = size / BEFORE if source else size * BEHIND
    assert found.value == pytest.approx(rms, rel=1e-9)
    by_gain = (-rms / BEFORE, 0.0) if source else (0.0, rms / BEHIND)
    slopes = {name: found.slopes.get(name, 0.0) for name in PARAMETERS}
    expected = dict(zip(PARAMETERS, (*by_gain, rms / DENSITY), strict=True))
    assert slopes == pytest.approx(expected, rel=1e-6, abs=1e-6 * rms)


def lagged(corner: float) -> Plan:
    """A white noise behind a lag, and another one that an input does not reach."""
    return plan(
        Graph(
            name="",
            rate=1000,
            blocks={
                "push": Constant(value=1.0),
                "hiss": WhiteNoise(density=DENSITY),
                "lag": LowPass(corner_frequency=corner),
                "noisy": Sum(),
                "other": WhiteNoise(density=DENSITY),
                "apart": Gain(gain=2.0),
            },
            wires=[
                *("hiss.output -> lag.input", "push.output -> noisy.first", "lag.output -> noisy.second"),
                "other.output -> apart.input",
            ],
        )
    )


@pytest.mark.defect("S1085", before="what lay below 50 mHz was left out: 0.11 of the rms", after="all of it")
def test_all_frequencies_count_at_an_input() -> None:
    """A lag of 1 mHz, sampled: mean square n^2 / 2 T (1 - p) / (1 + p), p = exp(-2 pi f T)."""
    found = read_noise(OperatingPoints(lagged(1e-3)), Noise("noisy.output", "push.output", None, "1"), {}, False)
    assert found is not None
    pole = math.exp(-2.0 * math.pi * 1e-3 * 1e-3)
    square = DENSITY**2 / 2e-3 * -math.expm1(-2.0 * math.pi * 1e-6) / (1.0 + pole)
    assert found.value == pytest.approx(math.sqrt(square), rel=1e-6)


@pytest.mark.defect("S1086", before="a band above half the rate had a noise of 0: any limit was met", after="refused")
@pytest.mark.parametrize("source", ["", "push.output"])
def test_a_band_above_half_the_rate_is_empty(source: str) -> None:
    wanted = Noise("noisy.output", source, (600.0, 700.0), "1")
    with pytest.raises(ModelError, match="the band is empty"):
        read_noise(OperatingPoints(lagged(10.0)), wanted, {}, False)


@pytest.mark.defect("H923", before="RuntimeWarning, and a density without an integral", after="push does not move it")
def test_an_input_that_moves_nothing_is_named() -> None:
    wanted = Noise("apart.output", "push.output", None, "1")
    with pytest.raises(ModelError, match=r"push\.output does not move apart\.output"):
        read_noise(OperatingPoints(lagged(10.0)), wanted, {}, False)


def test_a_small_gain_is_moved_by_a_part_of_itself() -> None:
    """Rms n sqrt(width) / k at the input, of k = 1e-6: its derivative is minus that over k."""
    small = 1e-6
    noise_at = Noise("behind.output", "push.output", (20.0, 120.0), "1")
    found = read_noise(OperatingPoints(planned(small)), noise_at, {"before.gain": small}, True)
    assert found is not None
    assert found.value == pytest.approx(DENSITY * 10.0 / small, rel=1e-9)
    assert found.slopes["before.gain"] == pytest.approx(-DENSITY * 10.0 / small**2, rel=1e-6)


@pytest.mark.parametrize("slopes", [False, True])
@pytest.mark.parametrize("band", [None, (20.0, 120.0)])
def test_an_output_without_noise_has_no_derivatives(slopes: bool, band: tuple[float, float] | None) -> None:
    """The root of 0 has none; those of an output with noise are left out where none are wanted."""
    found = read_noise(OperatingPoints(PLANNED), Noise("before.output", "", band, "1"), PARAMETERS, slopes)
    assert found == (0.0, {})
    noisy = read_noise(OperatingPoints(PLANNED), Noise("behind.output", "", band, "1"), PARAMETERS, slopes)
    assert noisy is not None
    assert bool(noisy.slopes) == slopes


@pytest.mark.exhaustive
@pytest.mark.defect("S788", before="`worst` and `tune` took the error of a bit as white", after="with its spectrum")
def test_the_noise_of_a_search_is_that_of_the_budget() -> None:
    """A modulator of second order, in a band in which its error is not white."""
    graph, band = modulator((1.0, 1.0), (1.0, 2.0), 0.05, 0.01), (2e5, 3e5)
    quantity = Noise("modulator.output", "", band, "V")
    (found,) = Evaluator(graph, {"noise": quantity}, "", {}).readings({}, slopes=False).values()
    assert found is not None
    assert found.value == pytest.approx(noise(graph, "modulator.output", band=band).rms, rel=1e-9)
