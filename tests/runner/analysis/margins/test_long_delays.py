"""Margins of loops with long delays, averages and filters, against closed forms and against certified roots."""

import math
import random

import flint
import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    Constant,
    Delay,
    Difference,
    DiscreteIntegrator,
    FiniteImpulseResponse,
    MovingAverage,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation import elimination, rational
from proofmass.runner.analysis.linearisation.many_roots import many_roots
from proofmass.runner.analysis.linearisation.rational import BITS, roots, transfer
from proofmass.runner.analysis.margins.axis import CertifiedAxis
from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.modes import seen
from proofmass.runner.analysis.margins.scalar import figures_of
from proofmass.runner.analysis.margins.swept import SweptAxis
from tests.by_hand.margins_oracle import random_system

RATE = 1000.0


def behind_an_integrator(gain: float, last: Block, output: str) -> Margins:
    """y[n + 1] = y[n] + gain e[n], and something after it that is fed back."""
    blocks: dict[str, Block] = {
        "zero": Constant(value=0.0),
        "error": Difference(),
        "integral": DiscreteIntegrator(gain=gain * RATE, output_unit="1"),
        "last": last,
    }
    wires = ["zero.output -> error.first", f"last.{output} -> error.second"]
    wires += ["error.output -> integral.input", "integral.output -> last.input"]
    loops = {"main": {"open_at": "error.output"}}
    return proofmass.margins(Graph(name="long", rate=RATE, blocks=blocks, wires=wires, loops=loops))


@pytest.mark.defect("S711", before="2.0 s with 100 samples, minutes with 300", after="0.3 s, 0.6 s with 300")
@pytest.mark.parametrize("ticks", [100, 300, pytest.param(1000, marks=pytest.mark.exhaustive)])
def test_an_integrator_behind_a_delay(ticks: int) -> None:
    """|L| = g / (2 sin(w / 2)), arg(-L) = pi / 2 - (ticks + 1 / 2) w: the sum counts from the next sample on."""
    limit = 2.0 * math.sin(0.5 * math.pi / (2 * ticks + 1))
    found = behind_an_integrator(0.4 * limit, Delay(ticks=ticks), "output")
    whole = ticks + 0.5
    w = 2.0 * math.asin(0.2 * limit)
    assert found.gain_margin == pytest.approx(2.5, rel=1e-12)
    assert found.phase_margin == pytest.approx(0.5 * math.pi - whole * w, rel=1e-12)
    assert found.delay_margin == pytest.approx((0.5 * math.pi / w - whole) / RATE, rel=1e-12)
    assert found.stable_gains == ((0.0, found.gain_margin),)
    crossings = [2.0 * math.pi * f / RATE for f in found.phase_crossovers]
    expected = [(0.5 + 2 * k) * math.pi / whole for k in range((ticks + 1) // 2 + 1)]
    assert crossings == pytest.approx([w for w in expected if w <= math.pi + 1e-9], rel=1e-12)
    angles = np.linspace(1e-5, math.pi, 1600 * ticks)
    response = 0.4 * limit * np.exp(-1j * whole * angles) / (2j * np.sin(0.5 * angles))
    assert found.sensitivity_peak == pytest.approx(float(np.max(1.0 / np.abs(1.0 + response))), rel=1e-5)
    assert len(found.poles) == ticks + 1


@pytest.mark.parametrize("kind", ["average", "filter"])
@pytest.mark.parametrize("length", [100, pytest.param(300, marks=pytest.mark.exhaustive)])
def test_an_integrator_behind_an_average(length: int, kind: str) -> None:
    """The average has the phase of (length - 1) / 2 samples, and the size sin(length w / 2) / (length sin(w / 2))."""
    last: Block = MovingAverage(length=length)
    if kind == "filter":
        last = FiniteImpulseResponse(taps=(1.0 / length,) * length)
    w = math.pi / length  # where the delay of length / 2 samples, and the integrator, have turned by half a turn
    limit = 2.0 * math.sin(0.5 * w) ** 2 * length
    found = behind_an_integrator(0.4 * limit, last, "mean" if kind == "average" else "output")
    assert found.gain_margin == pytest.approx(2.5, rel=1e-9)
    assert found.gain_margin_frequency == pytest.approx(w * RATE / (2.0 * math.pi), rel=1e-9)


def agree(one: Figures, two: Figures) -> None:
    """Compare all figures; where a peak lies is known to the root of its rounding.

    Of a loop a billionth from instability, L in doubles leaves seven digits of what is left.
    """
    first, second = one.as_data(), two.as_data()
    loose = max(1.0, 1e-7 / one.distance)
    for name, value in first.items():
        other, rel = second[name], 1e-3 if name == "sensitivity_peak_frequency_hz" else 1e-6 * loose
        if isinstance(value, list):
            pairs = [np.array(each, dtype=float).ravel() for each in (other, value)]
            assert pairs[0].tolist() == pytest.approx(pairs[1].tolist(), rel=rel, abs=1e-6, nan_ok=True), name
        else:
            assert other == (value if value is None else pytest.approx(value, rel=rel)), name


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize(
    "number", [*range(12), *(pytest.param(n, marks=pytest.mark.exhaustive) for n in range(12, 200))]
)
def test_a_grid_and_certified_roots_agree(number: int) -> None:
    """Resonators of a Q up to a billion, poles at 1 less a billionth; not where |L| at rest is 1 to rounding."""
    system = random_system(number)
    quotient = system.quotient
    assert quotient is not None
    visible, verdict, poles, _ = seen(system, quotient)
    certified = CertifiedAxis(visible, True)
    at_rest = certified.rest()
    if at_rest is not None and abs(at_rest.size - 1.0) < 1e-6:
        return
    swept = SweptAxis(visible, [pole.value for pole in poles])
    stable = verdict == "stable"
    agree(figures_of(certified, 1.0, stable), figures_of(swept, 1.0, stable))


def random_sparse(number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:  # type: ignore[type-arg]
    """Return a loop whose states act on few others, through chains and rings."""
    dice = random.Random(number)
    n = dice.randint(2, 12)
    a = np.zeros((n, n))
    for i in range(n):
        for _ in range(dice.choice((1, 1, 1, 2))):
            a[i, dice.randrange(n)] = dice.choice((1.0, 0.5, -0.75, dice.uniform(-1.0, 1.0)))
    b, c = (np.array([dice.choice((0.0, 1.0, dice.uniform(-1.0, 1.0))) for _ in range(n)]) for _ in range(2))
    return a, b, c, dice.choice((0.0, 0.25))


@pytest.mark.parametrize("number", range(40))
def test_elimination_gives_the_quotient_of_the_matrices(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both ways are exact: N D' = N' D to the last bit, and D has the degree of the states."""
    a, b, c, d = random_sparse(number)
    sparse = transfer(a, b, c, d)
    monkeypatch.setattr(rational, "eliminated", lambda *_: None)
    dense = transfer(a, b, c, d)
    assert sparse is not None
    assert dense is not None
    assert sparse.numerator * dense.denominator == dense.numerator * sparse.denominator
    assert sparse.denominator.degree() == dense.denominator.degree() == len(a)


def test_many_states_that_all_count_are_left() -> None:
    """Forty integrators side by side are no chain."""
    n = elimination.LARGEST_CORE + 16
    assert elimination.eliminated(np.diag(np.linspace(0.1, 0.9, n)), np.ones(n), np.ones(n), 0.0) is None


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("number", range(12))
def test_many_roots_are_certified_ones(number: int) -> None:
    """Of loops of few states, with poles next to 1 and to each other; each ball holds its root."""
    system = random_system(number)
    quotient = system.quotient
    assert quotient is not None
    flint.ctx.prec = BITS
    found = many_roots(quotient.closed, BITS)
    assert found is not None
    certified = roots(quotient.closed)
    assert len(found) == len(certified)
    for root in certified:
        assert any(ball.overlaps(root) for ball in found)
