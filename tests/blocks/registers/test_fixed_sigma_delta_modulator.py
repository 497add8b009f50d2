"""The modulator against exact fractions, and against the one in floating point where nothing is rounded."""

import math
from fractions import Fraction

import pytest

from proofmass.blocks import FixedSigmaDeltaModulator, SigmaDeltaModulator
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.responses import response

WORD = Fixed(12, 11)


@pytest.mark.exhaustive(but=2)
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize(("gains", "bits"), [((1.0,), 1), ((0.3, 0.4), 2), ((0.2, 0.3, 0.4, 0.5), 3)])
def test_against_fractions(gains: tuple[float, ...], bits: int, rounding: str) -> None:
    feedback, state = (1.0, 0.9, 0.8, 1.1)[: len(gains)], Fixed(16, 12)
    block = FixedSigmaDeltaModulator(
        gains=gains,
        feedback=feedback,
        resonance=0.02,
        bits=bits,
        input_format=WORD,
        state_format=state,
        rounding=rounding,
    )
    g, f = ([Fraction(round(v * 512), 512) for v in values] for values in (gains, feedback))
    x, expected, inputs = [Fraction(0)] * len(g), [], words(WORD, 600)
    levels = [Fraction(2 * k - 2**bits + 1, 2 ** (bits - 1)) for k in range(2**bits)]
    for m in inputs:
        k = min(max(math.floor(x[-1] * Fraction(2) ** (bits - 2)) + 2 ** (bits - 1), 0), 2**bits - 1)
        expected.append({"code": k, "output": int(levels[k] * 2 ** (bits - 1))})
        before, following = value_of(m, WORD), []
        for i, now in enumerate(x):
            back = Fraction(round(0.02 * 512), 512) * x[-1] if i == len(x) - 2 else 0
            total = now + g[i] * (before - f[i] * levels[k] - back)
            following.append(value_of(cast(total, state, rounding, "saturate"), state))
            before = now
        x = following
    assert drive_fixed(block, [{"input": m} for m in inputs]) == expected


@pytest.mark.exhaustive
def test_bit_by_bit_as_in_floating_point() -> None:
    """Gains of 1/2 and words of 15 bits after the point need 17: nothing is rounded, and both give the same stream."""
    inputs = [m // 2 for m in words(Fixed(16, 15), 3000, seed=5)]
    block = FixedSigmaDeltaModulator(
        input_format=Fixed(16, 15), coefficient_format=Fixed(4, 2), state_format=Fixed(24, 17)
    )
    found = [row["code"] for row in drive_fixed(block, [{"input": m} for m in inputs])]
    assert found == response(SigmaDeltaModulator(), [m / 2.0**15 for m in inputs], "code")


@pytest.mark.parametrize(
    ("changes", "text"),
    [({"gains": (1.0,)}, "1 numbers, as gains has"), ({"gains": (1.0,) * 5}, "at most 4 numbers")],
)
def test_coefficients_that_do_not_fit_are_refused(changes: dict[str, tuple[float, ...]], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        FixedSigmaDeltaModulator(**changes)
