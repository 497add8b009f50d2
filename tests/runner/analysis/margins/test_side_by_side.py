"""Margins of many loops at once against closed forms, and which loops are left to the certified path."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.analysis.margins.side_by_side import Amounts, LoopKind, Neutral, OpenLoops, amounts, kind_of

NEAR = {"rel": 1e-9, "abs": 1e-12}
GAINS = [0.5, 0.45, 0.52, 0.61]


def loops(gains: Sequence[float], a: Sequence[Sequence[float]], b: Sequence[float], c: Sequence[float]) -> OpenLoops:
    """Loops that differ by their gain alone."""
    count = len(gains)
    rows = [np.array(gain * np.array(c)) for gain in gains]
    return OpenLoops(np.array([a] * count), np.array([b] * count), np.array(rows), np.zeros(count))


def delayed(gains: Sequence[float]) -> OpenLoops:
    """k z^-1 / (z - 1), whose states are of very different size."""
    return loops(gains, [[1.0, 0.0], [1e6, 0.0]], [1.0, 0.0], [0.0, 1e-6])


def resonant(gains: Sequence[float], r: float, angle: float) -> OpenLoops:
    """k / (z^2 - 2 r cos(angle) z + r^2)."""
    return loops(gains, [[2.0 * r * math.cos(angle), -r * r], [1.0, 0.0]], [1.0, 0.0], [0.0, 1.0])


def crossing(*angles: Sequence[float]) -> Figures:
    """Return gain and phase crossovers at some angles of a period of a second."""
    gains, phases = (tuple(0.5 * w / math.pi for w in each) for each in angles)
    return Figures(gain_crossovers=gains, phase_crossovers=phases)


def checked(found: Amounts, row: int, **expected: float) -> None:
    for name, value in expected.items():
        assert float(getattr(found, name)[row]) == pytest.approx(value, **NEAR), name


def test_an_integrator() -> None:
    """k / (z - 1): |L| = 1 at 2 asin(k / 2), at a phase of -90 deg less half the angle; -k / 2 at half the rate."""
    found = amounts(loops(GAINS, [[1.0]], [1.0], [1.0]), LoopKind(np.ones(1), (2.0 * math.asin(0.5 * GAINS[0]),), ()))
    assert found.stable.all()
    assert found.certain.all()
    for row, k in enumerate(GAINS):
        w, margin = 2.0 * math.asin(0.5 * k), 0.5 * math.pi - math.asin(0.5 * k)
        checked(found, row, gain_margin=2.0 / k, gain_reduction=0.0, phase_margin=margin, delay_margin=margin / w)
        checked(found, row, sensitivity_peak=2.0 / (2.0 - k))


def test_an_integrator_and_a_delay() -> None:
    """k z^-1 / (z - 1): the phase is -90 deg less 3 / 2 of the angle, so -180 deg at 60 deg, where |L| = k."""
    one = OpenLoops(*(part[:1] for part in delayed(GAINS)))
    kind = kind_of(one, crossing([2.0 * math.asin(0.5 * GAINS[0])], [math.pi / 3.0, math.pi]), 1.0)
    assert kind.phase_crossovers == pytest.approx((math.pi / 3.0,)), "no limit at half the rate, where L is above zero"
    assert kind.scale[0] < 1e-3 * kind.scale[1]
    found = amounts(delayed(GAINS), kind)
    assert found.certain.all()
    turns = np.exp(1j * np.linspace(1e-3, math.pi, 400_001))
    for row, k in enumerate(GAINS):
        w, margin = 2.0 * math.asin(0.5 * k), 0.5 * math.pi - 3.0 * math.asin(0.5 * k)
        checked(found, row, gain_margin=1.0 / k, gain_reduction=0.0, phase_margin=margin, delay_margin=margin / w)
        peak = float(np.max(np.abs(turns * (turns - 1.0) / (turns * (turns - 1.0) + k))))
        assert found.sensitivity_peak[row] == pytest.approx(peak, rel=1e-8)


def test_an_unstable_plant() -> None:
    """k / (z - 1.1) has its pole at 1.1 - k: stable from 0.1 to 2.1."""
    gains = [0.5, 0.4, 0.05, 2.2, 0.1 + 1e-6]
    w = math.acos((2.21 - 0.25) / 2.2)
    found = amounts(loops(gains, [[1.1]], [1.0], [1.0]), LoopKind(np.ones(1), (w,), ()))
    assert found.stable.tolist() == [True, True, False, False, True]
    assert found.certain.tolist() == [True, True, False, False, False], "no crossover; a pole next to the circle"
    for row, k in enumerate(gains[:2]):
        w = math.acos((2.21 - k * k) / 2.2)
        z = complex(math.cos(w), math.sin(w))
        margin = abs(np.angle(-k / (z - 1.1)))
        checked(found, row, gain_margin=2.1 / k, gain_reduction=0.1 / k, phase_margin=margin)
        checked(found, row, delay_margin=(np.angle(-k / (z - 1.1)) % (2.0 * math.pi)) / w)


R, ANGLE = 0.9, 0.6


@pytest.mark.parametrize(("peak", "certain"), [(0.9, True), (0.99, True), (0.9995, False)])
def test_a_resonance_that_nearly_touches_one(peak: float, certain: bool) -> None:
    """|L| has its peak k / ((1 - r^2) sin(angle)), and is -k / (1 - r^2) where cos w = r cos(angle)."""
    k = peak * (1.0 - R * R) * math.sin(ANGLE)
    kind = LoopKind(np.ones(2), (), (math.acos(R * math.cos(ANGLE)),))
    found = amounts(resonant([k, 0.5 * k], R, ANGLE), kind)
    assert found.certain.tolist() == [certain, True]
    checked(found, 0, gain_margin=(1.0 - R * R) / k, gain_reduction=0.0, phase_margin=math.inf, delay_margin=math.inf)
    checked(found, 1, gain_margin=2.0 * (1.0 - R * R) / k)


def test_a_phase_crossover_of_nothing_is_no_limit() -> None:
    """Of |L| below 1e-9 nobody counts the gain margin."""
    small = 1e-10
    place = math.acos(R * math.cos(ANGLE))
    kind = kind_of(resonant([small], R, ANGLE), crossing([], [place]), 1.0)
    assert kind.phase_crossovers == ()
    found = amounts(resonant([small, 1e-2], R, ANGLE), kind)
    assert found.certain.tolist() == [True, False]
    checked(found, 0, gain_margin=math.inf, gain_reduction=0.0, sensitivity_peak=1.0)


def test_an_integrator_beside_a_way_through() -> None:
    """d + k / (z - 1): its pole is at 1 - k / (1 + d), |L| = 1 at 4 sin^2(w / 2) = k^2 / (1 - d^2 + d k)."""
    gains, d = [0.8, 0.7, 3.0], 0.3
    own = loops(gains, [[1.0]], [1.0], [1.0])._replace(d=np.full(3, d))
    places = [2.0 * math.asin(0.5 * k / math.sqrt(1.0 - d * d + d * k)) if k < 1.0 else math.nan for k in gains]
    kind = kind_of(OpenLoops(*(part[:1] for part in own)), crossing(places[:1], [math.pi]), 1.0)
    found = amounts(own, kind)
    assert found.stable.tolist() == [True, True, False]
    assert found.certain.tolist() == [True, True, False]
    for row, (k, w) in enumerate(zip(gains[:2], places, strict=False)):
        z = complex(math.cos(w), math.sin(w))
        margin = math.pi + float(np.angle(d + k / (z - 1.0)))
        checked(found, row, gain_margin=1.0 / (0.5 * k - d), phase_margin=margin, delay_margin=margin / w)
        checked(found, row, sensitivity_peak=2.0 / (2.0 + 2.0 * d - k))


def test_a_slow_loop_has_its_peak_at_rest() -> None:
    """k / (z - 1 - x): |1 / (1 + L)| is x / (k - x) at rest, and |L| = 1 at 4 sin^2(w / 2) = (k^2 - x^2) / (1 + x)."""
    x, k = 3e-5, 4.5e-5
    w = 2.0 * math.asin(0.5 * math.sqrt((k * k - x * x) / (1.0 + x)))
    found = amounts(loops([k], [[1.0 + x]], [1.0], [1.0]), LoopKind(np.ones(1), (w,), ()))
    assert found.certain.all()
    assert found.sensitivity_peak[0] == pytest.approx(2.0, rel=1e-9)
    assert found.gain_reduction[0] == pytest.approx(x / k, rel=1e-9)
    assert found.delay_margin[0] == pytest.approx((math.pi - math.atan2(math.sin(w), math.cos(w) - 1.0 - x)) / w)


def test_two_crossovers_close_to_each_other() -> None:
    """k^2 = 4 r^2 c^2 - 4 r cos(angle) (1 + r^2) c + 4 r^2 cos^2(angle) + (1 - r^2)^2 with c = cos w."""
    r, gains, places = 0.99, list[float](), list[list[float]]()
    for peak in (1.05, 1.03):
        gains.append(peak * (1.0 - r * r) * math.sin(ANGLE))
        rest = 4.0 * (r * math.cos(ANGLE)) ** 2 + (1.0 - r * r) ** 2 - gains[-1] ** 2
        roots = np.roots([4.0 * r * r, -4.0 * r * math.cos(ANGLE) * (1.0 + r * r), rest])
        places.append(sorted(np.arccos(roots).tolist()))
        assert 1e-3 < places[-1][1] - places[-1][0] < 1e-2
    kind = LoopKind(np.ones(2), tuple(places[0]), (math.acos(r * math.cos(ANGLE)),))
    found = amounts(resonant(gains, r, ANGLE), kind)
    assert found.certain.all()
    for row, (k, crossovers) in enumerate(zip(gains, places, strict=True)):
        z = np.exp(1j * np.array(crossovers))
        lags = np.angle(-k / (z * z - 2.0 * r * math.cos(ANGLE) * z + r * r))
        assert found.phase_margin[row] == pytest.approx(np.min(np.abs(lags)), rel=1e-6)
        assert found.delay_margin[row] == pytest.approx(np.min(lags % (2.0 * math.pi) / crossovers), rel=1e-6)


@pytest.mark.defect(
    "S1033", before="last digits by how many run side by side: another digest with 8 or 16 lanes", after="none"
)
@pytest.mark.parametrize("states", [2, 3, 7])
@pytest.mark.parametrize("seen", [False, True])
def test_a_loop_has_the_same_bits_alone_and_among_others(states: int, seen: bool) -> None:
    """Sums over states would come in another order, were a single loop taken as one of fewer dimensions."""
    random = np.random.default_rng(3)
    whole = random.normal(size=(17, states + 1, states + 1)) / states  # of which loops of sensors are parts
    rows = [*range(states)]
    several = OpenLoops(whole[:, rows][:, :, rows], whole[:, :-1, -1], -whole[:, states, rows], -whole[:, -1, -1])
    kind = LoopKind(np.ones(states), (0.5, 1.5), (2.0,))
    neutral = Neutral(random.uniform(0.5, 2.0, states), seen)
    together, left = amounts(several, kind), neutral.left_out(several)[0]
    for number in range(17):
        own = OpenLoops(*(part[number : number + 1] for part in several))
        one, among = amounts(own, kind), (part[number : number + 1] for part in together[:-1])  # of as many places
        assert [part.tobytes() for part in one[:-1]] == [part.tobytes() for part in among]
        alone = neutral.left_out(own)[0]
        assert [part.tobytes() for part in alone] == [part[number : number + 1].tobytes() for part in left]
