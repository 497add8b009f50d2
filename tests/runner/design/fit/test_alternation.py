"""The alternation: each step against NumPy's least squares, the rate near the optimum against what it predicts."""

import numpy as np
import pytest

from proofmass.runner.design.fit.alternation import LARGEST_ARGUMENT, alternate, convergence_rate
from tests.by_hand.temperature_sets import DEVICES, M1, TEMPERATURE, Device

both = pytest.mark.parametrize("device", DEVICES.values(), ids=DEVICES)


def step_by_step(output: np.ndarray, b: np.ndarray, turns: int) -> list[np.ndarray]:  # type: ignore[type-arg]
    """The paper's steps 2 to 4 as they are written."""
    way = [b]
    for _ in range(turns):
        waves = np.exp(np.outer(TEMPERATURE, b))
        a = np.linalg.lstsq(waves, output, rcond=None)[0]
        moved = TEMPERATURE[:, None] * waves * a
        b = b + np.linalg.lstsq(moved, output - waves @ a, rcond=None)[0]
        way.append(b)
    return way


@both
@pytest.mark.parametrize("turns", [1, 2, 5, 30])
def test_each_step_is_least_squares(device: Device, turns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    output = device.output()
    monkeypatch.setattr("proofmass.runner.design.fit.alternation.MOST_ITERATIONS", turns + 1)
    found = alternate(TEMPERATURE, output, (-1.0, 1.0), tolerance=0.0)
    assert found.iterations == turns + 1
    assert not found.converged
    assert found.b == pytest.approx(step_by_step(output, np.array([-1.0, 1.0]), turns)[-1].tolist(), rel=1e-8)


@both
def test_rate_predicts_the_way(device: Device) -> None:
    there = alternate(TEMPERATURE, device.output(), device.exponents, tolerance=0.0)
    rate = convergence_rate(TEMPERATURE, there.a, there.b)
    assert rate == pytest.approx(device.rate, abs=6e-5)
    way = step_by_step(device.output(), np.array(there.b) * [1.001, 0.999], 400)
    far, near = (np.linalg.norm(way[n] - there.b) for n in (300, 400))
    assert (near / far) ** (1.0 / 100.0) == pytest.approx(rate, abs=2e-4)


def test_shifting_the_temperature_changes_the_rate_only() -> None:
    volts = alternate(TEMPERATURE, M1.output(), (-6.0, 1.5))
    centred = alternate(TEMPERATURE - 1.2, M1.output(), (-6.0, 1.5))
    assert centred.mean_square == pytest.approx(volts.mean_square, rel=1e-9)
    assert centred.b == pytest.approx(volts.b, rel=1e-4)
    assert centred.iterations < volts.iterations / 2


@pytest.mark.exhaustive
def test_a_way_out_of_range_ends_without_convergence() -> None:
    spike = np.where(TEMPERATURE > 1.79, 1.0, 0.0)
    found = alternate(TEMPERATURE, spike, (-160.0, 160.0))
    assert np.isfinite([*found.a, *found.b, found.mean_square]).all()
    assert max(map(abs, found.b)) * 1.8 <= LARGEST_ARGUMENT


def test_equal_exponents_are_survived() -> None:
    found = alternate(TEMPERATURE, M1.output(), (1.0, 1.0), tolerance=1e-6)
    assert np.isfinite([*found.a, *found.b, found.mean_square]).all()


def test_work_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.design.fit.alternation.MOST_WORK", 61 * 50)
    found = alternate(TEMPERATURE, M1.output(), (-1.0, 1.0))
    assert (found.iterations, found.converged) == (50, False)
