"""All questions to an axis, compared with the answers of a dense grid."""

import math

import numpy as np
import pytest

from proofmass.runner.analysis.margins.scalar import Axis
from tests.by_hand.axis_by_grid import ByGrid, Numbers, Places


def compared(axis: Axis, loop: ByGrid, rel: float = 1e-8) -> None:
    """Compare everything that is well conditioned: not next to a touched circle, or a pole on the boundary."""
    last = math.pi if loop.sampled else math.inf
    w = np.array([0.01, 0.3, 1.1, 2.9])
    assert np.abs(axis.values(w) - loop.at(w)).max() < 1e-9 * np.abs(loop.at(w)).max()
    gains = axis.gain_crossings()
    inside = [c for c in gains if 1e-6 < c.w < (math.pi - 1e-5 if loop.sampled else 1e6)]
    assert [c.w for c in inside] == pytest.approx(loop.roots_of(lambda value: np.abs(value) - 1.0), rel=rel)
    for crossing in gains:
        value = complex(loop.at(np.array(crossing.w)))
        assert crossing.size == pytest.approx(1.0, rel=1e-6)
        assert abs(np.exp(1j * crossing.lag) + value / abs(value)) < 1e-5
    phases = axis.phase_crossings()
    negative = [v for v in loop.roots_of(lambda value: value.imag) if loop.at(np.array(v)).real < 0.0]
    between = [c for c in phases if c.w < last * (1.0 - 1e-5)] if loop.sampled else [c for c in phases if c.w < 1e6]
    assert [c.w for c in between] == pytest.approx(
        [v for v in negative if not loop.sampled or v < last * (1.0 - 1e-5)], rel=rel
    )
    for crossing in phases:
        assert crossing.lag == pytest.approx(0.0, abs=1e-6)
        if crossing.w < last:
            assert crossing.size == pytest.approx(abs(complex(loop.at(np.array(crossing.w)))), rel=1e-6)
    ends(axis, loop)
    peaks(axis, loop)
    counts(axis, loop)


def ends(axis: Axis, loop: ByGrid) -> None:
    """L at rest and at the end of the axis, as fractions."""
    powers = [1] * 9, [(-1) ** k for k in range(9)]
    size = max(len(loop.above), len(loop.below))
    high = [(p[size - 1] if len(p) == size else 0) for p in (loop.above, loop.below)]
    rest = [sum(v * s for v, s in zip(p, powers[0], strict=False)) for p in (loop.above, loop.below)]
    half = [sum(v * s for v, s in zip(p, powers[1], strict=False)) for p in (loop.above, loop.below)]
    pairs = (rest, half) if loop.sampled else ([loop.above[0], loop.below[0]], high)
    for found, (top, bottom), w in zip(
        (axis.rest(), axis.end()), pairs, (0.0, math.pi if loop.sampled else math.inf), strict=True
    ):
        if bottom == 0:
            assert found is None
            continue
        assert found is not None
        assert (found.w, found.size) == pytest.approx((w, abs(top / bottom)))
        assert found.lag == (0.0 if top / bottom < 0.0 else math.pi)
    last = axis.end()
    if loop.sampled and last is not None:
        assert (last in axis.phase_crossings()) == (last.lag == 0.0)


def sensitivity(value: Places) -> Numbers:
    """|S|."""
    return np.abs(1.0 / (1.0 + value))


def difference(value: Places) -> Numbers:
    """|S - T|."""
    return np.abs((1.0 - value) / (1.0 + value))


def peaks(axis: Axis, loop: ByGrid) -> None:
    """The largest |S| and |S - T|, and where |T| has fallen by 3 dB."""
    poles = loop.closed_poles()
    on = np.abs(np.abs(poles) - 1.0) < 1e-6 if loop.sampled else np.abs(poles.real) < 1e-6 * np.abs(poles)
    if on.any():
        return
    for (w, found), measure in ((axis.largest(0), sensitivity), (axis.largest(1), difference)):
        assert found == pytest.approx(loop.largest(measure), rel=1e-6)
        if 0.0 < w < math.inf:
            assert found == pytest.approx(
                float(measure(loop.at(np.array(min(w, math.pi - 1e-9) if loop.sampled else w)))), rel=1e-6
            )
    first = complex(loop.at(np.array(1e-9)))
    at_rest = abs(first / (1.0 + first))
    fall = axis.fall()
    if at_rest > 1e-7:
        falls = loop.roots_of(lambda value: np.abs(value / (1.0 + value)) - at_rest * math.sqrt(0.5))
        assert fall == (pytest.approx(falls[0], rel=1e-6) if falls else None)
    else:
        assert fall is None


def counts(axis: Axis, loop: ByGrid) -> None:
    """Closed-loop poles outside at some gains, and how one moves that a gain puts on the boundary."""
    for factor in (0.013, 0.37, 1.7, 23.0):
        poles = loop.closed_poles(factor)
        distance = np.abs(np.abs(poles) - 1.0) if loop.sampled else np.abs(poles.real)
        if len(poles) and distance.min() > 1e-5:
            assert axis.outside(factor) == loop.outside(factor)
    for crossing in axis.phase_crossings():
        if not 1e-3 < crossing.size < 1e3 or not 1e-3 < crossing.w < 100.0:
            continue
        factor, place = 1.0 / crossing.size, np.exp(1j * crossing.w) if loop.sampled else 1j * crossing.w
        moved = []
        for scale in (1.0 - 1e-6, 1.0 + 1e-6):
            near = loop.closed_poles(factor * scale)
            moved.append(complex(near[np.argmin(np.abs(near - place))]))
        speed = moved[1] - moved[0]
        if 1e-9 < abs(speed) < 1e-4:
            expected = (speed / place if loop.sampled else speed).real / abs(speed)
            assert axis.outwards(factor, crossing.w) == pytest.approx(expected, abs=1e-3)
