"""The open loop against python-control, with and without states, and where its poles lie on the unit circle."""

import control
import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop, TransferMatrix
from proofmass.runner.analysis.linearisation.period_map import PeriodMap


def opened(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, period: float) -> OpenLoop:  # type: ignore[type-arg]
    """The loop with the feedback given as wires give it, so with the sign turned."""
    n = len(a)
    matrix = np.vstack([np.hstack([a, b, np.zeros((n, 1))]), np.hstack([-c, -d, np.zeros((len(c), 1))])])
    states = tuple(("x", f"state_{i}", -1) for i in range(n))
    ends = tuple(("x", "wire", i) for i in range(len(c)))
    return OpenLoop(PeriodMap(states, ends, ends, matrix, {}, period))


@pytest.mark.parametrize("number", range(8))
def test_responses_and_poles(number: int) -> None:
    """States of very unlike size, as those of a sensor are: metres beside converter codes."""
    dice = np.random.default_rng(number)
    n = int(dice.integers(1, 9))
    a = dice.normal(size=(n, n))
    a *= dice.uniform(0.3, 0.95) / np.max(np.abs(np.linalg.eigvals(a)))
    b, c = dice.normal(size=(n, 1)), 0.1 * dice.normal(size=(1, n))
    d = np.full((1, 1), 0.3 * (number % 3 - 1))
    scale = 10.0 ** dice.uniform(-8, 8, size=n)
    system = control.ss(a, b, c, d, 1e-3)
    loop = opened(a * (1.0 / scale) * scale[:, None], b * scale[:, None], c / scale, d, 1e-3)
    w = np.linspace(1.0, np.pi / 1e-3, 200)
    expected = np.array([complex(system(np.exp(1j * v * 1e-3))) for v in w])
    assert loop.response(w) == pytest.approx(expected, rel=1e-9)
    assert loop.complementary(w)[:, 0, 0] == pytest.approx(expected / (1.0 + expected), rel=1e-9)
    closed = control.feedback(system, 1).poles()
    assert np.sort(np.abs(loop.poles)) == pytest.approx(np.sort(np.abs(closed)), rel=1e-6)
    assert np.exp(loop.growths(np.ones(1))[0]) == pytest.approx(np.max(np.abs(closed)), rel=1e-9)
    louder = control.feedback(2.5 * system, 1).poles()
    assert np.exp(loop.growths(np.array([2.5]))[0]) == pytest.approx(np.max(np.abs(louder)), rel=1e-9)


def test_a_loop_without_states() -> None:
    """A pass within the period alone, as a static path through a slower block gives: u[1] comes back from u[0]."""
    d = np.array([[0.0, 0.0], [0.5, 0.0]])
    loop = opened(np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((2, 0)), d, 2e-3)
    assert loop.per_period == 2
    assert loop.sample == 1e-3
    w = np.array([100.0, 700.0])
    assert loop.lifted(w)[0].tolist() == d.tolist()
    assert loop.response(w) == pytest.approx(0.25 * np.exp(-1j * w * 1e-3))
    assert np.exp(loop.growths(np.ones(1))[0]) == 0.0


def test_an_integrator_does_not_hurt_the_closed_loop() -> None:
    loop = opened(np.ones((1, 1)), np.ones((1, 1)), np.full((1, 1), 0.5), np.zeros((1, 1)), 1.0)
    assert loop.complementary(np.zeros(1))[0, 0, 0] == pytest.approx(1.0)
    assert loop.poles == pytest.approx([0.5])


@pytest.mark.parametrize("number", range(6))
def test_states_that_act_on_each_other_have_a_form_of_their_own(number: int) -> None:
    """Random sets of such states, the earlier ones acting on some of the later, in an order of its own."""
    dice = np.random.default_rng(number)
    sizes = [1, 1, 4, 1, 2, 1, 1, 5]
    n = sum(sizes)
    of = np.repeat(np.arange(len(sizes)), sizes)
    a = dice.normal(size=(n, n)) * ((of[:, None] == of) | ((of[:, None] > of) & (dice.uniform(size=(n, n)) < 0.2)))
    a *= 0.9 / np.max(np.abs(np.linalg.eigvals(a)))
    order = dice.permutation(n)
    a = a[np.ix_(order, order)]
    b, c, d = dice.normal(size=(n, 2)), dice.normal(size=(3, n)), dice.normal(size=(3, 2))
    z = np.exp(2j * np.pi * dice.uniform(size=40))
    expected = np.array([c @ np.linalg.solve(place * np.eye(n) - a, b) + d for place in z])
    found = TransferMatrix(a, b, c, d)
    assert found(z) == pytest.approx(expected, rel=1e-11, abs=1e-11)
    out, into = np.exp(1j * np.outer(z.real, np.arange(3))), np.exp(-1j * np.outer(z.imag, np.arange(2)))
    assert found.weighted(z, out, into) == pytest.approx(np.einsum("fi,fik,fk->f", out, expected, into), rel=1e-10)
