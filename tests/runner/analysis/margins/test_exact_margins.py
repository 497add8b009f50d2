"""Margins that a grid of frequencies misses, and published loops."""

import math

import flint
import numpy as np
import pytest

from proofmass.blocks import (
    Constant,
    Difference,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    Gain,
    Negation,
    TransferFunction,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.rational import Transfer, transfer
from proofmass.runner.analysis.margins.axis import CertifiedAxis
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.analysis.margins.scalar import figures_of
from proofmass.runner.analysis.margins.stability import margins, missed
from proofmass.runner.planning.plan import plan
from tests.by_hand.amounts import amounts
from tests.by_hand.margins_oracle import differences, random_system, truth_of


def test_a_loop_of_one_at_rest_has_the_crossover_after_its_rise() -> None:
    """L = (1 + 2 s) / (1 + s)^2: |1 + 2 j w|^2 = |1 + j w|^4 at w^2 = 2. A filter that only falls has none."""
    rising = CertifiedAxis(Transfer(flint.fmpz_poly([1, 2]), flint.fmpz_poly([1, 2, 1])), sampled=False)
    assert [crossing.w for crossing in rising.gain_crossings()] == [pytest.approx(math.sqrt(2.0), rel=1e-15)]
    falling = CertifiedAxis(Transfer(flint.fmpz_poly([1]), flint.fmpz_poly([1, 1])), sampled=False)
    assert falling.gain_crossings() == []


@pytest.mark.parametrize("off", [-1, 1])
def test_a_rounding_error_at_rest_makes_no_crossover(off: int) -> None:
    """(1 + 2^-50) / (1 + s) would cross over at 4e-8 rad/s; 1 + 1e-11 is no rounding error."""
    one = 2**50
    rising = CertifiedAxis(
        Transfer(flint.fmpz_poly([one + off, 2 * one]), flint.fmpz_poly([one, 2 * one, one])), sampled=False
    )
    assert [crossing.w for crossing in rising.gain_crossings()] == [pytest.approx(math.sqrt(2.0), rel=1e-14)]
    falling = CertifiedAxis(Transfer(flint.fmpz_poly([one + off]), flint.fmpz_poly([one, one])), sampled=False)
    assert falling.gain_crossings() == []
    more = CertifiedAxis(Transfer(flint.fmpz_poly([10**11 + 1]), flint.fmpz_poly([10**11, 10**11])), sampled=False)
    assert [crossing.w for crossing in more.gain_crossings()] == [pytest.approx(math.sqrt(2e-11), rel=1e-10)]


def servo(phase_margin: str = "60 deg") -> Graph:
    """Two slow integrations at 1 MHz, crossover 0.036 Hz: a pole at 1, one at 1 - 5e-9."""
    return Graph(
        name="slow servo",
        rate="1 MHz",
        blocks={
            "zero": Constant(value=0.0),
            "error": Difference(),
            "lead": Gain(gain=0.05),
            "second": DiscreteIntegrator(gain=1.0, output_unit="1"),
            "first": DiscreteTransferFunction(numerator=(1e-6,), denominator=(1.0, -0.999999995)),
        },
        wires=[
            "zero.output -> error.first",
            "first.output -> error.second",
            "error.output -> lead.input",
            "lead.output -> second.input",
            "second.output -> first.input",
        ],
        loops={"main": {"open_at": "error.output", "phase_margin": phase_margin}},
    )


def pendulum(quality: float) -> Graph:
    """A vacuum-packaged pendulum at 100 Hz with proportional-derivative control at 1 MHz."""
    w = 2.0 * math.pi * 100.0
    return Graph(
        name="pendulum",
        rate="1 MHz",
        blocks={
            "zero": Constant(value=0.0),
            "error": Difference(),
            "control": DiscreteTransferFunction(numerator=(801.0, -800.0), denominator=(1.0, 0.0)),
            "plant": TransferFunction(numerator=(2e-3 * w * w,), denominator=(1.0, w / quality, w * w)),
        },
        rates={"error": "1 MHz"},
        wires=[
            "zero.output -> error.first",
            "plant.strictly_proper_part -> error.second",
            "error.output -> control.input",
            "control.output -> plant.input",
        ],
        loops={"main": {"open_at": "control.output"}},
    )


@pytest.mark.defect("S1", before="phase margin no limit; 60 deg passes", after="1.28 deg, refused")
def test_a_slow_loop_at_a_fast_clock() -> None:
    """L = 0.05 T / (z - 1) times 1e-6 / (z - 1 + 5e-9): nearly 0.05 / (j w (j w + 0.005)) for w T << 1."""
    graph = servo()
    found = margins(graph)
    w = math.sqrt((math.sqrt(0.005**4 + 4.0 * 0.05**2) - 0.005**2) / 2.0)
    assert found.gain_crossovers == pytest.approx([w / (2.0 * math.pi)], rel=1e-6)
    assert math.degrees(found.phase_margin or 0.0) == pytest.approx(math.degrees(math.atan(0.005 / w)), abs=1e-4)
    assert math.degrees(found.phase_margin or 0.0) == pytest.approx(1.28, abs=0.005)
    (problem,) = missed(plan(graph), {"main": found})
    assert "phase margin" in problem.message
    assert problem.got == "1.281 deg"


@pytest.mark.defect("S1", before="both crossovers missed, no limit", after="26.72 deg at 99.89 and 100.11 Hz")
@pytest.mark.parametrize("quality", [1e5, 1e6, 1e9, math.inf])
def test_crossovers_about_a_resonance_of_any_width(quality: float) -> None:
    found = margins(pendulum(quality))
    assert found.verdict == "stable"
    assert found.gain_crossovers == pytest.approx([99.888, 100.112], abs=2e-3)
    assert math.degrees(found.phase_margin or 0.0) == pytest.approx(26.72, abs=0.3)
    assert found.gain_margin is not None


def fast_and_very_slow(slow: str) -> Graph:
    blocks: dict[str, Block] = {
        "first": DiscreteTransferFunction(numerator=(0.1,), denominator=(1.0, -0.9)),
        "minus": Negation(),
        "slow": UnitDelay(),
        "both": Difference(),
    }
    wires = [
        "first.strictly_proper_part -> minus.input",
        "minus.output -> both.first",
        "minus.output -> slow.input",
        "slow.output -> both.second",
        "both.output -> first.input",
    ]
    return Graph(name="fast and very slow", rate="1 kHz", blocks=blocks, rates={"slow": slow}, wires=wires)


@pytest.mark.exhaustive
def test_a_wire_with_a_hundred_values_in_a_period() -> None:
    """x' = (0.9 - 0.1 f) x + 0.1 f w, where w is x of the slow tick before: stable for |0.9 - 0.1 f| < 1.

    Within a slow period x comes to f w / (1 + f), which is 1/2 for f = 1, and w is a slow period late. With r added to
    the wire x' = 0.8 x - 0.1 r + 0.1 w and w = x[0] + r[0]. |S - I/2| is largest at rest, where all periods are alike.
    """
    found = margins(fast_and_very_slow("10 Hz"), "first.strictly_proper_part")
    assert found.gain_margin == pytest.approx(19.0, rel=1e-9)
    assert found.poles == pytest.approx([math.sqrt(0.5), -math.sqrt(0.5)], rel=1e-9)
    k = np.arange(101.0)
    start, held = 0.8**k, 0.5 - 0.5 * 0.8**k
    fed = -0.1 * np.tril(0.8 ** (k[:, None] - k[:100] - 1.0), -1)
    fed[:, 0] += held
    first = fed[100] / (1.0 - start[100] - held[100])
    answers = fed[:100] + np.outer(start[:100] + held[:100], first)
    assert found.disk_margin == pytest.approx(1.0 / np.linalg.norm(0.5 * np.eye(100) + answers, 2), rel=1e-8)


@pytest.mark.exhaustive
@pytest.mark.defect("C3", before="MemoryError: 521 GiB", after="refused: open the loop at its slowest wire")
def test_a_wire_with_too_many_values_in_a_period_is_refused() -> None:
    with pytest.raises(ModelError, match=r"too many values of first\.strictly_proper_part"):
        margins(fast_and_very_slow("0.1 Hz"), "first.strictly_proper_part")


def test_an_unstable_loop_has_crossovers_and_gains_that_would_make_it_stable() -> None:
    """L = k / (z - 1): stable for 0 < k < 2."""
    integral = DiscreteIntegrator(output_unit="1", gain=-3.0)
    graph = Graph(name="i", rate="1 Hz", blocks={"i": integral}, wires=["i.output -> i.input"])
    found = margins(graph)
    assert found.verdict == "unstable"
    assert found.gain_margin is found.phase_margin is None
    assert found.stable_gains == ((0.0, pytest.approx(2.0 / 3.0, rel=1e-12)),)
    assert found.distance == pytest.approx(0.5, rel=1e-12)  # at half the rate: 1 - 3/2


@pytest.mark.parametrize("count", amounts(8, 300))
def test_random_loops_against_mpmath(count: int) -> None:
    """Orders to 12, Q to 1e9, crossovers from 1e-9 of the rate to half of it, hidden modes, two and three rates."""
    told = {"stable": 0, "unstable": 0, "marginal": 0}
    for number in range(count):
        system = random_system(number)
        found = margins_of(system, "main", "out.strictly_proper_part")
        told[found.verdict] += 1
        assert differences(system, found, truth_of(system)) == [], number
    assert told["stable"] >= count * 40 / 300
    assert told["unstable"] >= count * 100 / 300


def test_gain_range_of_a_sampled_servo_in_textbooks() -> None:
    """1/(s (s + 1)), sampled each second: 0 < K < 2.39 (Phillips and Nagle, Digital Control System Analysis, 7.4)."""
    graph = Graph(
        name="textbook",
        rate="1 Hz",
        blocks={"plant": TransferFunction(numerator=(1.0,), denominator=(1.0, 1.0, 0.0)), "minus": Negation()},
        rates={"minus": "1 Hz"},
        wires=["plant.strictly_proper_part -> minus.input", "minus.output -> plant.input"],
    )
    found = margins(graph, "minus.output")
    e = math.exp(-1.0)
    assert found.gain_margin == pytest.approx((1.0 - e) / (1.0 - 2.0 * e), rel=1e-9)  # z^2 + ... + 1, by Jury
    assert found.gain_margin == pytest.approx(2.39, abs=0.005)


def test_disk_margin_of_a_published_loop() -> None:
    """25 / (s^3 + 10 s^2 + 10 s + 10): 0.46 at 1.94 rad/s (Seiler, Packard and Gahinet, 2020, and python-control)."""
    a = np.array([[-10.0, -10.0, -10.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    loop = transfer(a, np.array([[1.0], [0.0], [0.0]]), np.array([[0.0, 0.0, 25.0]]), 0.0)
    assert loop is not None
    found = figures_of(CertifiedAxis(loop, False), 0.0, True)
    assert found.gain_margin == pytest.approx(3.6, rel=1e-12)
    assert math.degrees(found.phase_margin or 0.0) == pytest.approx(29.1, abs=0.05)
    assert found.disk_margin == pytest.approx(0.46, abs=0.005)


def test_gains_between_which_a_resonance_is_held() -> None:
    """L = s / (s^2 - 0.1 s + 1) / (s + 10)^2: by Routh with k + 10 between the roots of b^2 - 1970.1 b + 39601."""
    below = np.polymul([1.0, -0.1, 1.0], [1.0, 20.0, 100.0])
    loop = transfer(np.vstack([-below[1:], np.eye(3, 4)]), np.eye(4, 1), np.array([[0.0, 0.0, 1.0, 0.0]]), 0.0)
    assert loop is not None
    found = figures_of(CertifiedAxis(loop, False), 0.0, False)
    assert found.stable_gains == (tuple(pytest.approx(b - 10.0) for b in sorted(np.roots([1.0, -1970.1, 39601.0]))),)


def test_largest_gain_of_the_example_of_slicot() -> None:
    """AB13DD, three resonances: its manual gives 5.0e5 at 1.4142 rad/s."""
    a = np.zeros((6, 6))
    for i, (stiffness, damping) in enumerate([(0.5, 2e-4), (1.0, 2e-5), (2.0, 2e-6)]):
        a[2 * i, 2 * i + 1], a[2 * i + 1, 2 * i], a[2 * i + 1, 2 * i + 1] = 1.0, -stiffness, -damping
    b, c = np.array([[1.0], [0.0]] * 3), np.array([[1.0, 0.0] * 3])
    quotient = transfer(a, b, c, 0.0)
    assert quotient is not None
    w, gain = CertifiedAxis(quotient, False).largest_ratio(quotient.numerator, quotient.denominator)
    assert gain == pytest.approx(5.0e5, rel=1e-6)
    assert w == pytest.approx(1.4142, abs=5e-5)


@pytest.mark.parametrize(
    ("above", "below", "sampled", "place", "value"),
    [
        ([1, 2], [1, 1], False, math.inf, 2.0),  # (1 + 2 s) / (1 + s) grows to its end
        ([2, 1], [1, 1], False, 0.0, 2.0),
        ([1], [0, 1], False, 0.0, math.inf),  # 1 / s
        ([0, 1], [1], False, math.inf, math.inf),
        ([1, 1], [0, 1, 0, 1], False, 1.0, math.inf),  # poles at rest and at 1 rad/s: that within is named
        ([3, 0, 1], [1, 2, 1], False, 0.0, 3.0),
        ([0, 2], [1, 2, 1], False, 1.0, 1.0),  # 2 s / (1 + s)^2: 2 w / (1 + w^2)
        ([1, 3], [2, 1], True, math.pi, 3.0),
        ([0, 1], [1], True, math.pi, math.inf),
    ],
)
def test_the_largest_ratio_lies_at_an_end_between_or_at_a_pole(
    above: list[int], below: list[int], sampled: bool, place: float, value: float
) -> None:
    loop = Transfer(flint.fmpz_poly(above), flint.fmpz_poly(below))
    found = CertifiedAxis(loop, sampled).largest_ratio(loop.numerator, loop.denominator)
    assert found == (pytest.approx(place, rel=1e-14), pytest.approx(value, rel=1e-14))
