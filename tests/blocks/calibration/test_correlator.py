"""The correlation cells against a direct sum over the same chips and codes."""

from proofmass.blocks import Correlator
from tests.by_hand.functions import drive


def test_sums_of_two_periods_against_the_definition() -> None:
    bits = [bool((n * n + n // 3) % 3 == 1) for n in range(63)]
    codes = [(7 * n) % 23 - 11 for n in range(63)]
    rows = drive(Correlator(cells=5, chips=31), [{"bit": b, "code": y} for b, y in zip(bits, codes, strict=True)])
    for period in (0, 1):
        expected = [
            sum((1 if bits[n - k] else -1) * codes[n] for n in range(31 * period, 31 * period + 31) if n - k >= 0)
            for k in range(5)
        ]
        assert rows[31 * (period + 1)]["impulse_response"] == expected
    assert rows[30]["impulse_response"] == [0] * 5


def test_more_cells_than_a_word_of_history() -> None:
    bits = [bool(n % 7 in (0, 2, 3)) for n in range(101)]
    codes = [n % 13 - 6 for n in range(101)]
    rows = drive(Correlator(cells=70, chips=100), [{"bit": b, "code": y} for b, y in zip(bits, codes, strict=True)])
    expected = [sum((1 if bits[n - k] else -1) * codes[n] for n in range(k, 100)) for k in range(70)]
    assert rows[100]["impulse_response"] == expected
