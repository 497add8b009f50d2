"""The cell in registers against sums of fractions, and the coefficient of a known response."""

from fractions import Fraction

import pytest

from proofmass.blocks import FixedCorrelationCell
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

IN, OUT = Fixed(12, 8), Fixed(10, 7)


def chips(order: int, taps: tuple[int, ...], count: int) -> list[int]:
    """A maximal-length sequence that begins with ones, as +1 and -1."""
    bits = [1] * order
    while len(bits) < count:
        bits.append(sum(bits[-tap] for tap in taps) % 2)
    return [2 * bit - 1 for bit in bits[:count]]


@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("lag", [1, 2, 7])
def test_against_sums_of_fractions(lag: int, rounding: str) -> None:
    """Three periods of 31 chips; before the start the chips are zero."""
    block = FixedCorrelationCell(lag=lag, order=5, input_format=IN, output_format=OUT, rounding=rounding)
    sequence, responses = chips(5, (3, 5), 93), words(IN, 93)
    rows = drive_fixed(block, [{"bit": chip > 0, "response": m} for chip, m in zip(sequence, responses, strict=True)])
    for period in range(2):
        terms = [
            sequence[n - lag] * value_of(responses[n], IN) for n in range(31 * period, 31 * period + 31) if n >= lag
        ]
        expected = cast(Fraction(sum(terms)) / 32, OUT, rounding, "saturate")
        found = {row["coefficient"] for row in rows[31 * period + 31 : 31 * period + 62]}
        assert found == {expected}
    assert {row["coefficient"] for row in rows[:31]} == {0}


def test_the_coefficient_of_a_known_response() -> None:
    """y[n] = 3 b[n-1] - b[n-2] in the second period: (32 h[k] - sum of h) / 32."""
    sequence = chips(5, (3, 5), 93)
    responses = [(3 * sequence[n - 1] - sequence[n - 2]) * 64 for n in range(93)]
    samples = [{"bit": chip > 0, "response": m} for chip, m in zip(sequence, responses, strict=True)]
    for lag, coefficient in ((1, 3), (2, -1), (5, 0)):
        block = FixedCorrelationCell(lag=lag, order=5, input_format=Fixed(12, 6), output_format=Fixed(16, 11))
        found = drive_fixed(block, samples)[92]["coefficient"]
        assert Fraction(found, 2**11) == Fraction(32 * coefficient - 2, 32)
