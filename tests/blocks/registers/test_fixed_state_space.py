"""The state space against big integers for orders 1 to 4, and against its recursion in floating point."""

from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import FixedStateSpace
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

WORD, COEFFICIENT, STATE, OUT = Fixed(14, 11), Fixed(16, 13), Fixed(20, 14), Fixed(13, 9)


def coefficients(order: int) -> dict[str, tuple[float, ...] | float]:
    """A random stable system, whose states do go beyond their format at times."""
    rng = np.random.default_rng(order)
    matrix = rng.normal(size=(order, order))
    matrix *= 0.97 / np.abs(np.linalg.eigvals(matrix)).max()
    return {
        "transition": tuple(matrix.ravel().tolist()),
        "entry": tuple(rng.uniform(-2, 2, order).tolist()),
        "readout": tuple(rng.uniform(-1, 1, order).tolist()),
        "direct": 0.3,
    }


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_against_big_integers(order: int, overflow: str) -> None:
    rounding = ROUNDINGS[order - 1]
    given = coefficients(order)
    formats = {"input_format": WORD, "coefficient_format": COEFFICIENT, "state_format": STATE, "output_format": OUT}
    block = FixedStateSpace(**given, **formats, rounding=rounding, overflow=overflow)

    def register(value: float) -> Fraction:
        return Fraction(round(Fraction(value) * 2**13), 2**13)

    a = [register(value) for value in block.transition]
    b, c, d = [*map(register, block.entry)], [*map(register, block.readout)], register(block.direct)
    x = [Fraction(0)] * order
    expected = []
    inputs = words(WORD, 300)
    for m in inputs:
        u = value_of(m, WORD)
        y = d * u + sum(factor * state for factor, state in zip(c, x, strict=True))
        expected.append(cast(y, OUT, rounding, overflow))
        moved = [b[i] * u + sum(a[i * order + j] * x[j] for j in range(order)) for i in range(order)]
        x = [value_of(cast(value, STATE, rounding, overflow), STATE) for value in moved]
    rows = drive_fixed(block, [{"input": m} for m in inputs])
    assert [row["output"] for row in rows] == expected


@pytest.mark.exhaustive
def test_against_floating_point() -> None:
    block = FixedStateSpace(coefficient_format=Fixed(30, 27), state_format=Fixed(32, 27), output_format=Fixed(32, 26))
    inputs = words(Fixed(16, 12), 800)
    found = [row["output"] / 2**26 for row in drive_fixed(block, [{"input": m} for m in inputs])]
    a, x = np.reshape(block.transition, (2, 2)), np.zeros(2)
    expected = []
    for m in inputs:
        expected.append(float(np.dot(block.readout, x) + block.direct * m / 4096))
        x = a @ x + np.array(block.entry) * (m / 4096)
    assert found == pytest.approx(expected, abs=1e-5)
    assert max(map(abs, expected)) > 1


def test_sizes_must_agree() -> None:
    with pytest.raises(ModelError, match=r"4 numbers, as entry has 2"):
        FixedStateSpace(transition=(0.5,))
    with pytest.raises(ModelError, match="2 numbers, as entry has"):
        FixedStateSpace(readout=(1.0,))
    with pytest.raises(ModelError, match="at most 8 numbers"):
        FixedStateSpace(entry=(0.1,) * 9, readout=(0.1,) * 9, transition=(0.0,) * 81)
