"""Other starts of an unknown, by hand."""

import math

import pytest

from proofmass.runner.design.identification.unknowns import _SPREAD, OFFSET, Unknown


@pytest.mark.parametrize(
    ("start", "bounds", "ends", "middle"),
    [
        (5.0, (1.0, 100.0), (1.0, 100.0), 10.0),  # above 0 by equal factors
        (0.5, (-1.0, 3.0), (-1.0, 3.0), 1.0),  # else by equal steps
        (0.5, (-math.inf, math.inf), (0.5 / _SPREAD, 0.5 * _SPREAD), 0.5),
        (0.5, (0.4, math.inf), (max(0.4, 0.5 / _SPREAD), 0.5 * _SPREAD), None),
        (-2.0, (-math.inf, math.inf), (-2.0 * _SPREAD, -2.0 / _SPREAD), None),
        (-2.0, (-2.5, math.inf), (max(-2.5, -2.0 * _SPREAD), -2.0 / _SPREAD), None),
    ],
)
def test_starts_lie_between_bounds_or_about_the_first(
    start: float, bounds: tuple[float, float], ends: tuple[float, float], middle: float | None
) -> None:
    unknown = Unknown("sensor.mass", "mass", "kg", start, *bounds)
    assert (unknown.sampled(0.0, 9.0), unknown.sampled(1.0, 9.0)) == pytest.approx(ends)
    assert middle is None or unknown.sampled(0.5, 9.0) == pytest.approx(middle)
    assert Unknown(f"{OFFSET}seen.output", "", "V", start, *bounds).sampled(0.3, 9.0) == start


@pytest.mark.parametrize(
    ("bounds", "ends"),
    [((-math.inf, math.inf), (-8e-9, 8e-9)), ((0.0, math.inf), (0.0, 8e-9)), ((-math.inf, 1e-9), (-8e-9, 1e-9))],
)
@pytest.mark.defect("H876", before="8 of 8 starts agree, which all began at zero", after="as far as its size goes")
def test_starts_of_what_begins_at_zero_lie_about_it(bounds: tuple[float, float], ends: tuple[float, float]) -> None:
    unknown = Unknown("bias.value", "bias", "A", 0.0, *bounds)
    assert (unknown.sampled(0.0, 4e-9), unknown.sampled(1.0, 4e-9)) == pytest.approx(ends, rel=1e-9, abs=0.0)
