"""The polynomial compensator in registers against Horner's rule in plain integers, and beside the exponentials."""

import math

import numpy as np
import pytest

from docs.papers import compensators
from docs.papers.pn_runs import library
from proofmass.runner.run.simulate import simulate


def horner(device: str, temperature: np.ndarray) -> np.ndarray:
    """Values in steps of 2^-24: floor after each product."""
    words = [round(t * 65536) for t in temperature.tolist()]
    values = compensators.coefficients(device, polynomial=True)
    c0, c1, c2, c3, c4 = (round(values[f"c{power}"] * 2**24) for power in range(5))
    found = []
    for word in words:
        total = c4
        for coefficient in (c3, c2, c1, c0):
            total = math.floor((total * word + coefficient * 65536) / 65536)
        found.append(total)
    return np.array(found)


@pytest.mark.parametrize("name", ["polynomial", "polynomial, pipelined"])
@pytest.mark.parametrize("device", ["m1", "m2"])
def test_the_registers_are_the_plain_integers(device: str, name: str) -> None:
    """The pipelined one eight ticks later."""
    temperature, value, _ = compensators.compensated(device, name)
    assert np.array_equal(np.round(value * 2.0**24).astype(int), horner(device, temperature))


@pytest.mark.parametrize("device", ["m1", "m2"])
def test_error_against_the_fitted_function(device: str) -> None:
    """Four roundings of 2^-24 V, and half a step of the temperature times the slope."""
    temperature, value, rest = compensators.compensated(device, "polynomial")
    exact = compensators.fitted_function(device, True, temperature)
    slope = np.abs(np.gradient(exact, temperature)).max()
    coefficients = sum(temperature.max() ** power for power in range(5)) / 2.0
    assert np.abs(value - exact).max() < 2.0**-24 * (coefficients + 10.0) + slope * 2.0**-17
    assert np.ptp(rest) == pytest.approx(compensators.fitted(device).fits[3].after, rel=2e-3)


@pytest.mark.exhaustive
def test_in_the_chamber_the_exponentials_leave_less() -> None:
    result = simulate(library("temperature_compensation_polynomial.toml"), engine="compiled")
    left = {name: 1e3 * float(measure.value) for name, measure in result.measures.items()}
    assert left["before"] == pytest.approx(3.9, rel=1e-3)
    assert left["exponentials"] == pytest.approx(0.368, abs=1e-3)
    assert left["polynomial"] == pytest.approx(0.481, abs=1e-3)


@pytest.mark.exhaustive
def test_the_polynomial_is_smaller_and_faster() -> None:
    """The reverse of what Liu, Li and Shen say."""
    exponentials, polynomial = (
        compensators.resources(f"{name}, pipelined", "xc2vp") for name in ("exponentials", "polynomial")
    )
    assert exponentials.luts > 5 * polynomial.luts
    assert exponentials.multipliers > 2 * polynomial.multipliers
    assert (polynomial.clock.megahertz or 0.0) > 1.5 * (exponentials.clock.megahertz or 0.0)
