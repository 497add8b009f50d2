"""The digital filter against scipy.signal.lfilter and control."""

import control
import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import DiscreteTransferFunction
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

INPUTS = np.random.default_rng(5).normal(size=400)


def filtered(numerator: list[float], denominator: list[float], port: str = "output") -> list[float]:
    block = DiscreteTransferFunction(numerator=numerator, denominator=denominator)
    return [row[port] for row in drive(block, [{"input": u} for u in INPUTS.tolist()])]


@pytest.mark.parametrize("order", [1, 2, 3, 5, 8])
def test_butterworth_against_lfilter(order: int) -> None:
    b, a = signal.butter(order, 0.3)
    expected = signal.lfilter(b, a, INPUTS)
    assert filtered(b.tolist(), a.tolist()) == pytest.approx(expected, abs=1e-12)
    assert filtered((3.0 * b).tolist(), (3.0 * a).tolist()) == pytest.approx(expected, abs=1e-12)


def test_order_64_is_exact_for_a_moving_average() -> None:
    expected = signal.lfilter([1.0] * 65, [1.0], INPUTS)
    assert filtered([1.0] * 65, [1.0] + [0.0] * 64) == pytest.approx(expected, abs=1e-12)


def test_shorter_numerator_means_a_delay() -> None:
    expected = signal.lfilter([0.0, 0.0, 2.0, 1.0], [1.0, -0.5, 0.25, 0.1], INPUTS)
    result = filtered([2.0, 1.0], [1.0, -0.5, 0.25, 0.1])
    assert result == pytest.approx(expected, abs=1e-13)
    assert filtered([2.0, 1.0], [1.0, -0.5, 0.25, 0.1], "strictly_proper_part") == result


def test_coefficients_are_in_powers_of_z_as_in_control() -> None:
    system = control.tf([0.5, 0.2], [2.0, -1.0, 0.3], 0.1)
    expected = control.forced_response(system, inputs=INPUTS).outputs
    assert filtered([0.5, 0.2], [2.0, -1.0, 0.3]) == pytest.approx(expected, abs=1e-13)


def test_strictly_proper_part_is_the_output_less_the_direct_part() -> None:
    b, a = [3.0, 1.0, 0.5], [2.0, -0.4, 0.1]
    both = zip(filtered(b, a), filtered(b, a, "strictly_proper_part"), INPUTS.tolist(), strict=True)
    assert max(abs(whole - part - 1.5 * u) for whole, part, u in both) < 1e-14
    assert DiscreteTransferFunction.feedthrough("output") == ("input",)
    assert DiscreteTransferFunction.feedthrough("strictly_proper_part") == ()


def test_the_default_is_a_unit_delay() -> None:
    rows = drive(DiscreteTransferFunction(), [{"input": u} for u in INPUTS.tolist()])
    assert [row["output"] for row in rows] == [0.0, *INPUTS.tolist()[:-1]]


@pytest.mark.parametrize(
    ("numerator", "denominator", "text"),
    [
        ([1.0], [1.0], "expected: 2 to 65 coefficients: order 1 to 64"),
        ([1.0], [1.0] * 66, "expected: 2 to 65 coefficients: order 1 to 64"),
        ([1.0], [0.0, 1.0], "expected: a first coefficient other than 0"),
        ([1.0, 2.0, 3.0], [1.0, 1.0], "expected: at most 2 coefficients, as in the denominator"),
    ],
)
def test_what_is_no_proper_transfer_function_is_refused(
    numerator: list[float], denominator: list[float], text: str
) -> None:
    with pytest.raises(ModelError) as error:
        DiscreteTransferFunction(numerator=numerator, denominator=denominator)
    assert text in str(error.value)
