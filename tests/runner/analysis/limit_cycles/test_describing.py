"""Describing functions against quadrature by mpmath of what they are the fundamental of."""

import math
from collections.abc import Callable

import control
import mpmath
import pytest

from proofmass.blocks import (
    AnalogToDigital,
    Backlash,
    Comparator,
    CosineFunction,
    DeadZone,
    LowPass,
    Quantiser,
    Relay,
    Saturation,
    Sign,
    SineFunction,
)
from proofmass.runner.analysis.limit_cycles.describing import (
    dead_zone,
    describing_function,
    quantiser,
    relay,
    saturation,
)


def fundamental(function: Callable[[mpmath.mpf], mpmath.mpf], amplitude: float, corners: list[float]) -> complex:
    """1 / (pi A) times the integral of y (sin t + j cos t) over a turn, between the corners of y."""
    turns = sorted(
        {0.0, *(t % (2 * math.pi) for c in corners for a in (math.asin(c / amplitude),) for t in (a, math.pi - a))}
        | {2.0 * math.pi}
    )
    smooth = {"method": "gauss-legendre", "maxdegree": 6}
    value = mpmath.quad(lambda t: function(t) * mpmath.expj(mpmath.pi / 2 - t), turns, **smooth)
    return complex(value) / (math.pi * amplitude)


@pytest.mark.parametrize("amplitude", [0.3, 1.0, 7.0])
def test_a_relay_with_hysteresis(amplitude: float) -> None:
    late = math.asin(0.2 / amplitude)

    def on(t: mpmath.mpf) -> int:
        return 1 if late <= t % (2 * math.pi) < math.pi + late else -1

    expected = fundamental(on, amplitude, [0.2, -0.2])
    assert relay(amplitude, 3.0, 0.2) == pytest.approx(3.0 * expected, rel=1e-9)
    found = describing_function(Relay(lower=-0.2, upper=0.2, on=3.0, off=-3.0), "input", "output", 1.0)
    assert found(amplitude) == relay(amplitude, 3.0, 0.2)
    clocked = describing_function(Comparator(threshold=1.0, hysteresis=0.4), "input", "sign", 1.0)
    assert clocked(amplitude) == relay(amplitude, 1.0, 0.2)
    assert relay(0.1, 3.0, 0.2) == 0.0
    assert relay(amplitude, 1.0) == pytest.approx(4.0 / (math.pi * amplitude))


@pytest.mark.parametrize("amplitude", [0.3, 0.75, 4.0])
def test_a_saturation_and_a_dead_zone(amplitude: float) -> None:
    corners = [0.5, -0.5] if amplitude > 0.5 else []
    expected = fundamental(lambda t: max(min(amplitude * mpmath.sin(t), 0.5), -0.5), amplitude, corners)
    assert saturation(amplitude, 0.5, 2.0) == pytest.approx(2.0 * expected.real, rel=1e-9)
    assert saturation(amplitude, 0.5) + dead_zone(amplitude, 0.5) == pytest.approx(1.0)
    assert describing_function(Saturation(lowest=-0.5, highest=0.5), "input", "output", 1.0)(amplitude) == saturation(
        amplitude, 0.5
    )


@pytest.mark.parametrize("amplitude", [0.4, 0.6, 1.7, 3.2])
def test_a_quantiser(amplitude: float) -> None:
    corners = [sign * (k + 0.5) for k in range(4) for sign in (1, -1) if k + 0.5 < amplitude]
    expected = fundamental(lambda t: mpmath.nint(amplitude * mpmath.sin(t)), amplitude, corners)
    assert quantiser(amplitude, 1.0) == pytest.approx(expected.real, rel=1e-9, abs=1e-12)
    assert quantiser(5.0 * amplitude, 5.0) == pytest.approx(expected.real, rel=1e-9, abs=1e-12)
    converter = AnalogToDigital(bits=8, reference=128.0)  # a volt is a code
    found = describing_function(converter, "voltage", "number", 1.0)(amplitude)
    assert found == pytest.approx(quantiser(amplitude, 1.0), rel=1e-2)


def test_a_quantiser_with_few_levels_is_a_relay_with_a_dead_zone_far_out() -> None:
    assert quantiser(1e6, 1.0, 1) == pytest.approx(4.0 / (math.pi * 1e6), rel=1e-9)


@pytest.mark.parametrize("amplitude", [0.45, 1.3, 5.0])
@pytest.mark.parametrize("levels", [2, 5, 6])
def test_a_quantiser_of_n_levels(levels: int, amplitude: float) -> None:
    """From -1 to 1: corners halfway between levels, the ends beyond them."""
    step = 2.0 / (levels - 1)
    corners = [-1.0 + (k + 0.5) * step for k in range(levels - 1)]

    def stairs(t: mpmath.mpf) -> mpmath.mpf:
        passed = sum(amplitude * mpmath.sin(t) > corner for corner in corners)
        return -1 + passed * step

    expected = fundamental(stairs, amplitude, [corner for corner in corners if abs(corner) < amplitude])
    found = describing_function(Quantiser(levels=levels), "input", "output", 1.0)
    assert found(amplitude) == pytest.approx(expected.real, rel=1e-9, abs=1e-12)


@pytest.mark.exhaustive("0.3")
@pytest.mark.parametrize("amplitude", [0.3, 2.0, 9.0])
def test_sign_dead_zone_sine_and_cosine(amplitude: float) -> None:
    sign = describing_function(Sign(), "input", "output", 1.0)
    assert sign(amplitude) == pytest.approx(4.0 / (math.pi * amplitude), rel=1e-15)
    zone = describing_function(DeadZone(lowest=-0.5, highest=0.5), "input", "output", 1.0)
    assert zone(amplitude) == dead_zone(amplitude, 0.5)
    sine = describing_function(SineFunction(amplitude=3.0), "input", "output", 1.0)
    expected = fundamental(lambda t: 3.0 * mpmath.sin(amplitude * mpmath.sin(t)), amplitude, [])
    assert sine(amplitude) == pytest.approx(expected.real, rel=1e-9, abs=1e-12)
    assert describing_function(CosineFunction(), "input", "output", 1.0)(amplitude) == 0.0


def test_what_remembers_has_none() -> None:
    with pytest.raises(ValueError, match="memory"):
        describing_function(LowPass(), "input", "output", 1.0)


@pytest.mark.parametrize("amplitude", [0.4, 0.6, 1.0, 2.0, 30.0])
def test_a_backlash(amplitude: float) -> None:
    """Against python-control, and a sine that has been through the block for a turn, summed over the next."""
    block = Backlash(width=1.0)
    found = complex(describing_function(block, "input", "output", 1e-3)(amplitude))
    assert found == pytest.approx(control.friction_backlash_nonlinearity(1.0).describing_function(amplitude), abs=1e-15)
    count = 20_000
    position, total = 0.0, 0.0j
    for i in range(2 * count):
        angle = 2.0 * math.pi * i / count
        driver = amplitude * math.sin(angle)
        position = min(max(position, driver - 0.5), driver + 0.5)
        total += (i >= count) * position * complex(math.sin(angle), math.cos(angle))
    assert found == pytest.approx(total * 2.0 / count / amplitude, abs=1e-4)


@pytest.mark.parametrize("amplitude", [0.4, 1.0, 7.0])
def test_those_of_python_control(amplitude: float) -> None:
    known = {
        Saturation(lowest=-0.7, highest=0.7): control.saturation_nonlinearity(0.7),
        Relay(on=2.0, off=-2.0, upper=0.3, lower=-0.3): control.relay_hysteresis_nonlinearity(2.0, 0.3),
    }
    for block, theirs in known.items():
        found = complex(describing_function(block, "input", "output", 1e-3)(amplitude))
        assert found == pytest.approx(theirs.describing_function(amplitude), rel=1e-12)
