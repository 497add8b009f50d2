"""The continuous transfer function: its state-space form against scipy and control."""

import math

import control
import numpy as np
import numpy.typing as npt
import pytest
from scipy import signal

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.filters.transfer_function import (
    Constants,
    State,
    TransferFunction,
    constants,
    derivative,
    output,
    strictly_proper_part,
)

CASES = [
    ([1.0], [1.0, 1.0]),
    ([3.0, -1.0], [2.0, 5.0]),
    ([4.0], [1.0, 0.0]),  # an integrator
    ([2.0], [7.0, 0.0, 0.0]),  # a double integrator
    ([1.0, 0.0], [1.0, 3.4e-3 / 50.43e-9, 49.5627 / 50.43e-9]),
    ([1.0, 2.0, 3.0], [-4.0, 5.0, 6.0]),
    ([0.0, 0.0, 2.0], [1.0, 2.0, 3.0, 4.0]),
    ([1e-3, 2.0, 5e3, 1e7], [1e-3, 4.0, 9e3, 2e7]),
    ([1.0, 0.1, 2.0, 0.3, 5.0], [3.0, 1.0, 4.0, 1.0, 5.0]),
    signal.butter(4, 2 * math.pi * 20e3, analog=True),
    signal.bessel(3, 2 * math.pi * 50.0, analog=True),
]


def block_of(case: int) -> TransferFunction:
    numerator, denominator = CASES[case]
    return TransferFunction(numerator=[float(v) for v in numerator], denominator=[float(v) for v in denominator])


def matrices(block: TransferFunction) -> tuple[Constants, npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    c = constants(block, 1.0)
    unit = np.eye(4)
    a = np.array([derivative(c, State(*row), 0.0) for row in unit]).T
    return c, a, np.array(derivative(c, State(0.0, 0.0, 0.0, 0.0), 1.0))


@pytest.mark.parametrize("case", range(len(CASES)))
def test_frequency_response_against_control(case: int) -> None:
    block = block_of(case)
    c, a, b = matrices(block)
    order = len(block.denominator) - 1
    assert c.rate == 2.0 ** round(math.log2(c.rate))
    system = control.tf(list(block.numerator), list(block.denominator))
    for omega in c.rate * np.array([0.01, 0.1, 0.5, 1.0, 3.0, 100.0]):
        x = np.linalg.solve(1j * omega * np.eye(4) - a, b)
        assert x[order:] == pytest.approx(np.zeros(4 - order), abs=0.0)
        y = output(c, State(*x), 1.0)
        assert y == pytest.approx(system(1j * omega), rel=1e-10)
        assert strictly_proper_part(c, State(*x)) == pytest.approx(y - c.direct, rel=1e-12)


@pytest.mark.parametrize("case", range(len(CASES)))
def test_poles_are_those_of_the_denominator_and_unused_states_decay(case: int) -> None:
    block = block_of(case)
    c, a, _ = matrices(block)
    order = len(block.denominator) - 1
    used, unused = np.linalg.eigvals(a[:order, :order]), np.linalg.eigvals(a[order:, order:])
    expected = np.sort_complex(np.roots(block.denominator))
    assert np.sort_complex(used) == pytest.approx(expected, rel=1e-6, abs=1e-7 * c.rate)
    assert list(unused) == [-c.rate] * (4 - order)
    assert not a[order:, :order].any()


def test_unused_states_stay_zero() -> None:
    c = constants(block_of(1), 1.0)
    assert derivative(c, State(0.7, 0.0, 0.0, 0.0), -2.0)[1:] == (0.0, 0.0, 0.0)


def test_scaling_rounds_nothing() -> None:
    block = block_of(9)
    c = constants(block, 1.0)
    assert [c.a1 * c.rate, c.a2 * c.rate**2, c.a3 * c.rate**3, c.a4 * c.rate**4] == list(block.denominator[1:])
    assert c.b4 * c.rate**4 == block.numerator[0]


def test_step_response_against_scipy() -> None:
    block = block_of(7)
    c, a, b = matrices(block)
    times = np.linspace(0.0, 3e-3, 40)
    _, expected = signal.step((block.numerator, block.denominator), T=times)
    values, vectors = np.linalg.eig(a[:3, :3])
    modes = np.linalg.solve(vectors, b[:3])
    states = [(vectors @ (modes * np.expm1(values * t) / values)).real for t in times]
    assert [output(c, State(*x, 0.0), 1.0) for x in states] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("numerator", "denominator", "text"),
    [
        ([1.0], [1.0], "expected: 2 to 5 coefficients: order 1 to 4, higher ones as blocks in series"),
        ([1.0], [1.0] * 6, "expected: 2 to 5 coefficients: order 1 to 4, higher ones as blocks in series"),
        ([1.0], [0.0, 1.0], "expected: a first coefficient other than 0"),
        ([1.0, 2.0, 3.0], [1.0, 1.0], "expected: at most 2 coefficients, as in the denominator"),
    ],
)
def test_what_is_no_proper_transfer_function_is_refused(
    numerator: list[float], denominator: list[float], text: str
) -> None:
    with pytest.raises(ModelError) as error:
        TransferFunction(numerator=numerator, denominator=denominator)
    assert text in str(error.value)


def test_feedthrough_per_port() -> None:
    assert TransferFunction.feedthrough("output") == ("input",)
    assert TransferFunction.feedthrough("strictly_proper_part") == ()
