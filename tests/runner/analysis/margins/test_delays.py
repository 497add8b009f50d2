"""Delay margins of loops with several values of the wire in a period, in closed form."""

import math

import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    Gain,
    Product,
    RepeatingSequence,
    UnitDelay,
)
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.loops import REQUIREMENTS
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps
from proofmass.runner.analysis.margins.followed_delays import stable_delay
from proofmass.runner.analysis.margins.many import ManyMargins
from proofmass.runner.analysis.margins.text import margins_text
from proofmass.runner.planning.plan import plan, varied
from tests.by_hand.amounts import chosen


def integrator(gains: tuple[float, ...]) -> Graph:
    """Return y' = y - g y, in which g is one gain after the other."""
    return Graph(
        name="turning gain",
        rate="1 kHz",
        blocks={
            "zero": Constant(value=0.0),
            "error": Difference(),
            "product": Product(),
            "gains": RepeatingSequence(values=gains),
            "sum": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -1.0)),
        },
        wires=[
            "zero.output -> error.first",
            "sum.strictly_proper_part -> error.second",
            "error.output -> product.first",
            "gains.output -> product.second",
            "product.output -> sum.input",
        ],
        loops={"main": {"open_at": "sum.strictly_proper_part"}},
    )


@pytest.mark.defect("S674", before="64 ms, whatever the delay", after="the largest delay that is stable")
@pytest.mark.parametrize("low", [0.0, 0.003, 0.008])
def test_an_integrator_of_small_gains(low: float) -> None:
    """z^s (z - 1) = -g is stable up to g = 2 sin(pi / (2 (2 s + 1))). Of small gains the mean counts.

    The mean is right to its square, so the delay is compared to one value.
    """
    check_integrator((low, 0.012))


@pytest.mark.defect("H872", before="64 ms, or more", after="the largest delay that is stable")
@pytest.mark.parametrize("mean", chosen([0.03], [0.006, 0.001]))
def test_an_integrator_of_forty_small_gains(mean: float) -> None:
    check_integrator(tuple((2.0 * mean * np.random.default_rng(3).permutation(40) / 39.0).tolist()))


@pytest.mark.parametrize("gain", chosen([0.5], [0.2]))
def test_what_ends_within_a_long_period_is_stable(gain: float) -> None:
    """2^-1200 is no number: a small delay leaves nothing of the start. `gain` is that of z^s (z - 1) = -g."""
    ones = np.ones((1200, 1))
    maps = TickMaps(ones[:, :, None], gain * ones, -ones, np.zeros(1200), {})
    expected = 0.5 * (0.5 * math.pi / math.asin(0.5 * gain) - 1.0)
    assert stable_delay(maps, 64) == pytest.approx(expected, abs=1.0)


def test_a_loop_that_no_delay_leaves_stable_has_no_more() -> None:
    """Gains of 1.2 and 1.4 take y to the other side; one value later z (z - 1) = -1.3 has roots of size 1.14."""
    found = proofmass.margins(integrator((1.2, 1.4)), "main")
    assert found.delay_margin == 0.0
    assert "delay margin      0 s (0.00 samples)\n" in margins_text(found)


def check_integrator(gains: tuple[float, ...]) -> None:
    mean = float(np.mean(gains))
    delay = 0.5 * (0.5 * math.pi / math.asin(0.5 * mean) - 1.0)
    found = proofmass.margins(integrator(gains), "main")
    assert found.delay_margin is not None
    assert found.delay_margin == pytest.approx(1e-3 * delay, abs=1.1e-3)


RATIO = 30  # values of the wire in a period


@pytest.mark.defect("H866", before="64 ms or more, of each", after="the largest delay that is stable")
@pytest.mark.parametrize("gain", [0.3, pytest.param(0.06, marks=pytest.mark.exhaustive)])
def test_a_ramp_that_a_mean_of_it_turns_once_in_thirty_values(gain: float) -> None:
    """y moves by s = -g u / 30 a tick, and u is the mean of y over a period of 30.

    Of a mean over 30 values that are r + 30 q late, r are those of a period before the others. So

    z^(q+2) (z - 1) + g ((1 - r / 30) z + r / 30) + g / 30 (z - 1) (m z + l) = 0

    with m and l the sums of k / 30 below 30 - r and from there on: what s has moved y by.
    """
    graph = Graph(
        name="a ramp and its mean",
        rate="1 kHz",
        blocks={
            "y": DiscreteIntegrator(gain=-1e3 * gain / RATIO, output_unit="1", input_unit="1"),
            "mean": Decimator(ratio=RATIO),
        },
        wires=["y.output -> mean.input", "mean.mean -> y.input"],
        loops={"main": {"open_at": "y.output"}},
    )

    def grows(late: int) -> bool:
        periods, rest = divmod(late, RATIO)
        ramp = np.arange(RATIO) / RATIO
        of_mean = gain * np.array([1.0 - rest / RATIO, rest / RATIO])
        of_ramp = gain / RATIO * np.array([np.sum(ramp[: RATIO - rest]), np.sum(ramp[RATIO - rest :])])
        late_values = np.polyadd(of_mean, np.polymul([1.0, -1.0], of_ramp))
        poles = np.roots(np.polyadd([1.0, -1.0, *[0.0] * (periods + 2)], late_values))
        return float(np.max(np.abs(poles))) > 1.0

    first = next(late for late in range(1, 10_000) if grows(late))
    assert first > 100
    assert proofmass.margins(graph).delay_margin == pytest.approx(1e-3 * (first - 1))


@pytest.mark.defect("S853", before="5 ms", after="1 ms: a pole that leaves the circle at -1 counts")
def test_a_pole_at_half_the_rate_of_the_period() -> None:
    """y[n+1] = -0.8 y[n] - 0.3 v, of v = y and 0 in turn the mean of the period before.

    A period late, z^3 + 0.8 z^2 + 0.3 = 0 has a root beyond -1. Without the delay, and with half of it, it is
    z^2 + 0.8 z + 0.3 = 0.
    """
    graph = Graph(
        name="a filter that rings at half its rate",
        rate="1 kHz",
        blocks={
            "filter": DiscreteTransferFunction(numerator=(-0.6,), denominator=(1.0, 0.8)),
            "product": Product(),
            "gains": RepeatingSequence(values=(1.0, 0.0)),
            "mean": Decimator(ratio=2),
        },
        wires=[
            "filter.strictly_proper_part -> product.first",
            "gains.output -> product.second",
            "product.output -> mean.input",
            "mean.mean -> filter.input",
        ],
        rates={"filter": "500 Hz"},
        loops={"main": {"open_at": "product.output"}},
    )
    assert max(abs(np.roots([1.0, 0.8, 0.3]))) < 1.0 < max(abs(np.roots([1.0, 0.8, 0.0, 0.3])))
    assert proofmass.margins(graph).delay_margin == pytest.approx(1e-3)


@pytest.mark.defect("S856", before="1.51 samples", after="one: a pole that leaves the circle at -1 counts")
def test_a_pole_at_half_the_rate() -> None:
    """Of z^2 + 0.8 z + 0.3 = 0 no root is outside, but one of z^3 + 0.8 z^2 + 0.3 = 0; so for gains near it."""
    graph = Graph(
        name="a filter and a register",
        rate="1 kHz",
        blocks={
            "filter": DiscreteTransferFunction(numerator=(-1.0,), denominator=(1.0, 0.8)),
            "gain": Gain(gain=0.3),
            "register": UnitDelay(),
        },
        wires=[
            "filter.strictly_proper_part -> gain.input",
            "gain.output -> register.input",
            "register.output -> filter.input",
        ],
        loops={"main": {"open_at": "register.output"}},
    )
    found = proofmass.margins(graph)
    assert found.delay_margin == pytest.approx(1e-3)
    assert found.delay_margin_frequency == pytest.approx(500.0)
    planned = plan(graph)
    (several,) = ManyMargins(planned, "auto").values([varied(planned, {"gain": Gain(gain=0.31)})])
    assert not isinstance(several, ModelError)
    assert dict(zip(REQUIREMENTS, several, strict=False))["delay_margin"] == pytest.approx(1e-3)
