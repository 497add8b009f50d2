"""Steps between ticks, by a method and a source that are written down here."""

import cmath
import math

import pytest

from proofmass.runner.continuous.integrate import DONE, GroupTick, integrate

RATE, CORNER, TOLERANCE = 50.0, 0.31, 1e-4


def heun(
    context: list[float], time: float, length: float, x: list[float], moved: list[float], error: list[float]
) -> None:
    """A step of x' = -50 x + u, where u jumps from 0 to 50 at the corner, of order 2, with the one of order 1 in it."""
    first = RATE * (float(time >= CORNER) - x[0])
    second = RATE * (float(time + length > CORNER) - (x[0] + length * first))
    moved[0] = x[0] + 0.5 * length * (first + second)
    error[0] = moved[0] - (x[0] + length * first)


def passed(context: list[float], time: float, x: list[float], clear: list[float]) -> None:
    clear[0] = float(time > CORNER)


def never(context: list[float], time: float, x: list[float], which: int) -> None:
    raise AssertionError("a corner is no event")


@pytest.mark.parametrize("first", [1.0, 0.4, 0.32, 0.05])
def test_a_step_up_to_a_jump_keeps_the_tolerance_too(first: float) -> None:
    """A first step of any length passes the jump, and the step up to it is as wrong as one that is not allowed."""
    x, largest = [1.0], [1.0]
    flat = [[0.0] for _ in range(4)]
    numbers = 0.0, 1.0, first, TOLERANCE, 2, 1e-12
    group = GroupTick(heun, passed, never, [], *numbers, x, *flat[:2], largest, [0.0, 0.0], *flat[2:], 0, 0)
    status = integrate(group)
    assert status == DONE
    assert largest == [1.0]  # it never leaves the way from 1 down to 0 and up to 1 again
    assert x[0] == pytest.approx(1.0 - math.exp(-RATE * (1.0 - CORNER)), abs=100.0 * TOLERANCE)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_an_error_that_only_seemed_small_is_made_again(tolerance: float) -> None:
    """A state that leaves rest fast and stays small: x' = e^-5t cos 15t, of which a first step of 1 s expects more."""

    def pulse(
        context: list[float], time: float, length: float, x: list[float], moved: list[float], error: list[float]
    ) -> None:
        first, second = (math.exp(-5.0 * t) * math.cos(15.0 * t) for t in (time, time + length))
        moved[0] = x[0] + 0.5 * length * (first + second)
        error[0] = moved[0] - (x[0] + length * first)

    x, flat = [0.0], [[0.0] for _ in range(5)]
    numbers = 0.0, 1.0, 1.0, tolerance, 2, 1e-12
    group = GroupTick(pulse, lambda *_: None, never, [], *numbers, x, *flat[:3], [0.0, 0.0], *flat[3:], 0, 0)
    status = integrate(group)
    rate = complex(-5.0, 15.0)
    assert status == DONE
    assert x[0] == pytest.approx(((cmath.exp(rate) - 1.0) / rate).real, rel=tolerance)


@pytest.mark.defect("S850", before="passed at the start of a tick, and nothing moved", after="told")
@pytest.mark.parametrize("clearances", [[0.0], [1.0, 0.0], [0.0, 1.0]])
def test_an_event_whose_clearance_stays_at_zero_is_told(clearances: list[float]) -> None:
    """By its number, from 1."""

    def apart(context: list[float], time: float, x: list[float], clear: list[float]) -> None:
        clear[:] = clearances

    count, flat = len(clearances), [[0.0] for _ in range(4)]
    numbers = 0.0, 1.0, 1.0, 0.0, 2, 1e-12
    group = GroupTick(heun, apart, lambda *_: None, [], *numbers, *flat, [0.0, 0.0], [0.0] * count, [], count, count)
    assert integrate(group) == 1.0 + clearances.index(0.0)
