"""Fixed-point values against exact fractions, and against apytypes; the compiled code of each operation beside them."""

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import apytypes
import numpy as np
import pytest
from apytypes import APyFixedArray, OverflowMode, QuantizationMode
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.fixed_point import (
    Fixed,
    FixedValue,
    clip,
    counting_overflows,
    fixed,
    stored,
    where,
    wrap,
)
from tests.by_hand.compiled import over_columns
from tests.by_hand.integer_code import compile_step

ROUNDINGS = ("half_even", "half_up", "floor", "toward_zero")
OVERFLOWS = ("saturate", "wrap")
QUANTIZATION = {
    "half_even": QuantizationMode.RND_CONV,
    "half_up": QuantizationMode.RND,
    "floor": QuantizationMode.TRN,
    "toward_zero": QuantizationMode.TRN_ZERO,
}
OVERFLOW = {"saturate": OverflowMode.SAT, "wrap": OverflowMode.WRAP}
SOURCE = Fixed(16, 12)
EVERY = range(SOURCE.lowest, SOURCE.highest + 1)
TARGETS = [Fixed(10, 7), Fixed(12, 14), Fixed(6, 0, signed=False), Fixed(4, -1)]
VECTORS = 1_000_000


def round_exactly(value: Fraction, rounding: str) -> int:
    """The rule in the language of fractions."""
    if rounding == "half_even":
        return round(value)
    if rounding == "half_up":
        return math.floor(value + Fraction(1, 2))
    return math.floor(value) if rounding == "floor" else math.trunc(value)


def fit_exactly(mantissa: int, target: Fixed, overflow: str) -> int:
    if overflow == "saturate":
        return min(max(mantissa, target.lowest), target.highest)
    return (mantissa - target.lowest) % (1 << target.width) + target.lowest


def over_vectors(function: Callable[..., Any], formats: dict[str, Any], *vectors: np.ndarray) -> np.ndarray:
    """The traced and compiled step on whole vectors; a row for each of its results, which are a tuple."""
    step = compile_step(function, formats)
    return np.array(over_columns(step, vectors[0].astype(np.int64), vectors[-1].astype(np.int64)))


def bits_of(values: Any, signed: bool = True) -> np.ndarray:
    """Mantissas of an array of apytypes, as signed integers."""
    bits = values.bits
    raw = np.array(values.to_bits(numpy=True)).astype(np.uint64)
    return ((raw << np.uint64(64 - bits)).view(np.int64) >> (64 - bits)) if signed else raw.astype(np.int64)


@pytest.mark.exhaustive
@pytest.mark.parametrize("target", TARGETS, ids=str)
def test_casts_of_every_word_against_fractions_and_compiled(target: Fixed) -> None:
    modes = [(r, o) for r in ROUNDINGS for o in OVERFLOWS]

    def casts(a: FixedValue, b: FixedValue) -> tuple[FixedValue, ...]:
        return tuple(a.to(target, r, o) for r, o in modes)  # type: ignore[arg-type]

    words = np.arange(SOURCE.lowest, SOURCE.highest + 1)
    formats = {"a": SOURCE, "b": SOURCE, "return": (target,) * len(modes)}
    found = over_vectors(casts, formats, words)
    scale = Fraction(2) ** (target.fraction - SOURCE.fraction)
    exact = [m * scale for m in EVERY]
    for r, rounding in enumerate(ROUNDINGS):
        rounded = [round_exactly(value, rounding) for value in exact]
        for o, overflow in enumerate(OVERFLOWS):
            assert found[2 * r + o].tolist() == [fit_exactly(m, target, overflow) for m in rounded], modes[2 * r + o]
    for m in EVERY[::131]:
        reference = [value.mantissa for value in casts(FixedValue(m, 12), FixedValue(0, 12))]
        assert reference == found[:, m - SOURCE.lowest].tolist()


@pytest.mark.parametrize("target", [t for t in TARGETS if t.signed], ids=str)
def test_casts_of_every_word_against_apytypes(target: Fixed) -> None:
    words = APyFixedArray(list(EVERY), bits=16, frac_bits=12)
    for rounding in ROUNDINGS:
        for overflow in OVERFLOWS:
            cast = words.cast(
                bits=target.width,
                frac_bits=target.fraction,
                quantization=QUANTIZATION[rounding],
                overflow=OVERFLOW[overflow],
            )
            ours = [FixedValue(m, 12).to(target, rounding, overflow).mantissa for m in EVERY[::17]]  # type: ignore[arg-type]
            assert ours == bits_of(cast)[::17].tolist(), (rounding, overflow)


@pytest.mark.exhaustive("(32, 30)")
@pytest.mark.parametrize("source", [Fixed(32, 30), Fixed(24, 6), Fixed(16, 12)], ids=str)
def test_products_sums_and_casts_of_random_words_against_apytypes(source: Fixed) -> None:
    narrow = Fixed(source.width - 5, source.fraction - 3)
    modes = [("half_even", "saturate"), ("half_up", "wrap"), ("toward_zero", "saturate"), ("floor", "wrap")]

    def step(a: FixedValue, b: FixedValue) -> tuple[FixedValue, ...]:
        return (a + b, a - b, a * b, *((a * b).to(narrow, r, o) for r, o in modes))  # type: ignore[arg-type]

    rng = np.random.default_rng(source.width)
    a, b = rng.integers(source.lowest, source.highest, (2, VECTORS), endpoint=True)
    sum_format = Fixed(source.width + 1, source.fraction)
    formats = {"a": source, "b": source}
    formats |= {"return": (sum_format, sum_format, Fixed(2 * source.width, 2 * source.fraction), *[narrow] * 4)}  # type: ignore[dict-item]
    found = over_vectors(step, formats, a, b)
    x, y = (
        APyFixedArray.from_array(
            np.ldexp(v.astype(float), -source.fraction), bits=source.width, frac_bits=source.fraction
        )
        for v in (a, b)
    )
    product = x * y
    for ours, theirs in zip(found[:3], (x + y, x - y, product), strict=True):
        assert np.array_equal(ours, bits_of(theirs))
    for ours, (rounding, overflow) in zip(found[3:], modes, strict=True):
        cast = product.cast(
            bits=narrow.width,
            frac_bits=narrow.fraction,
            quantization=QUANTIZATION[rounding],
            overflow=OVERFLOW[overflow],
        )
        assert np.array_equal(ours, bits_of(cast)), (rounding, overflow)
    for i in range(0, VECTORS, 9973):
        values = step(FixedValue(int(a[i]), source.fraction), FixedValue(int(b[i]), source.fraction))
        assert [value.mantissa for value in values] == found[:, i].tolist()


def test_operations_on_every_pair_of_bytes() -> None:
    first, second = Fixed(8, 3), Fixed(8, 5)

    def step(a: FixedValue, b: FixedValue) -> tuple[Any, ...]:
        return a + b, a - b, a * b, abs(a), clip(a, -1, b), where(a < b, a, b), a == b, a >= b, wrap(a + a, first)

    wide, truth = Fixed(20, 8), Fixed(1, 0, signed=False)
    results = (wide, wide, wide, wide, wide, wide, truth, truth, first)
    words = np.arange(-128, 128)
    a, b = (v.ravel() for v in np.meshgrid(words, words))
    found = over_vectors(step, {"a": first, "b": second, "return": results}, a, b)
    x, y = a * 32, b * 8  # both in steps of 2**-8
    expected = [x + y, x - y, a * b, abs(x), np.minimum(np.maximum(x, -256), y), np.minimum(x, y), x == y, x >= y]
    for ours, theirs in zip(found, [*expected, (2 * a + 128) % 256 - 128], strict=True):
        assert np.array_equal(ours, theirs)


def test_apytypes_is_the_version_whose_modes_are_meant() -> None:
    assert tuple(map(int, apytypes.__version__.split(".")[:2])) >= (0, 4)


formats = st.builds(Fixed, st.integers(1, 70), st.integers(-20, 80), st.booleans())


@st.composite
def values(draw: st.DrawFn) -> FixedValue:
    format = draw(formats)
    return FixedValue(draw(st.integers(format.lowest, format.highest)), format.fraction)


@given(values(), values(), st.integers(-9, 9))
def test_arithmetic_is_that_of_fractions(a: FixedValue, b: FixedValue, k: int) -> None:
    assert (a + b).value == a.value + b.value
    assert (a - b).value == a.value - b.value
    assert (a * b).value == a.value * b.value
    assert (-a).value == -a.value
    assert abs(a).value == abs(a.value)
    assert (a << k).value == a.value * Fraction(2) ** k
    assert (a >> k).value == a.value / Fraction(2) ** k
    assert (a + k).value == (k + a).value == a.value + k
    assert (k - a).value == k - a.value
    assert (k * a).value == k * a.value
    compared = (a < b, a <= b, a > b, a >= b, a == b, a != b)
    x, y = a.value, b.value
    assert compared == (x < y, x <= y, x > y, x >= y, x == y, x != y)
    assert clip(a, -1, b).value == min(max(x, -1), y)
    assert where(a < b, a, b).value == min(x, y)
    assert where(a < b, a, k).value == (x if x < y else k)
    assert where(a < b, k, b).value == (k if x < y else y)


@given(values(), formats, st.sampled_from(ROUNDINGS), st.sampled_from(OVERFLOWS))
def test_casts_are_those_of_fractions(a: FixedValue, target: Fixed, rounding: Any, overflow: Any) -> None:
    rounded = round_exactly(a.value / target.resolution, rounding)
    with counting_overflows() as overflows:
        found = a.to(target, rounding, overflow)
    assert found.value == fit_exactly(rounded, target, overflow) * target.resolution
    assert target.lowest <= found.mantissa <= target.highest
    assert overflows.total == (not target.lowest <= rounded <= target.highest)
    if overflows.total:
        with pytest.raises(OverflowError, match="does not fit Fixed"):
            a.to(target, rounding, "refuse")
    else:
        assert a.to(target, rounding, "refuse").value == found.value


@given(st.fractions(-(2**99), 2**99) | st.floats(-1e6, 1e6) | st.integers(-(10**6), 10**6), st.sampled_from(ROUNDINGS))
def test_constants_are_rounded_as_casts_are(value: Any, rounding: Any) -> None:
    target = Fixed(400, 40)
    assert fixed(value, target, rounding).mantissa == round_exactly(Fraction(value) * 2**40, rounding)


def test_constants_are_exact_unless_a_rounding_is_said() -> None:
    assert fixed(-0.75, Fixed(8, 4)).value == Fraction(-3, 4)
    assert fixed(Fraction(5, 16), Fixed(8, 4)).mantissa == 5
    assert fixed(96, Fixed(4, -4)).mantissa == 6
    with pytest.raises(ValueError, match=r"0.1 is not a multiple of 1/4096: say a rounding"):
        fixed(0.1, Fixed(16, 12))
    with pytest.raises(ValueError, match=r"8 does not fit Fixed\(16, 12\), which holds -8 to 7.999755859"):
        fixed(8, Fixed(16, 12))
    for value in (math.inf, math.nan):
        with pytest.raises(ValueError, match="cannot hold "):
            fixed(value, Fixed(16, 12))


def test_formats_know_their_range() -> None:
    assert (Fixed(8, 4).lowest, Fixed(8, 4).highest) == (-128, 127)
    assert (Fixed(8, 4, signed=False).lowest, Fixed(8, 4, signed=False).highest) == (0, 255)
    assert (Fixed(1).lowest, Fixed(1).highest) == (-1, 0)
    assert Fixed(8, -2).resolution == 4
    assert repr(Fixed(8, 4)) == "Fixed(8, 4)"
    assert repr(Fixed(8, 4, signed=False)) == "Fixed(8, 4, signed=False)"
    for width, fraction in ((0, 0), (513, 0), (8, 1000)):
        with pytest.raises(ValueError, match="a format"):
            Fixed(width, fraction)


def test_registers_take_what_has_a_place_in_them() -> None:
    assert stored(FixedValue(3, 2), Fixed(8, 4)) == 12
    assert stored(0, Fixed(8, 4)) == 0
    with pytest.raises(TypeError, match=r"6 fraction bits do not go into Fixed\(8, 4\): round with .to"):
        stored(FixedValue(3, 6), Fixed(8, 4))
    with pytest.raises(OverflowError, match=r"8 does not fit Fixed\(8, 4\), which holds -8 to 7.9375"):
        stored(8, Fixed(8, 4))
    with pytest.raises(OverflowError, match="a number of over 300 digits"):
        stored(FixedValue(1 << 2000, 0), Fixed(8, 4))


def test_wrapping_on_purpose_is_no_overflow() -> None:
    with counting_overflows() as overflows:
        assert [wrap(m, Fixed(3)) for m in range(-5, 6)] == [3, -4, -3, -2, -1, 0, 1, 2, 3, -4, -3]
        assert wrap(FixedValue(70, 4), Fixed(6, 4, signed=False)).mantissa == 6
        assert FixedValue(70, 4).to(Fixed(6, 4), overflow="wrap").mantissa == 6
    assert overflows.total == 1
    with pytest.raises(TypeError, match="do not wrap in"):
        wrap(FixedValue(70, 5), Fixed(6, 4))


def test_misuse_is_refused_with_the_remedy() -> None:
    one = FixedValue(16, 4)
    cases: list[tuple[Callable[[], Any], str]] = [
        (lambda: one + 0.5, "a float has no fixed-point format: write fixed"),
        (lambda: one < 0.5, "a float has no fixed-point format: write fixed"),
        (lambda: one / 2, "multiply by a constant reciprocal"),
        (lambda: 1 / one, "multiply by a constant reciprocal"),
        (lambda: one << one, "a constant number of places"),  # type: ignore[operator]
        (lambda: where(one, 1, 2), "a condition is a comparison"),
        (lambda: one.to(Fixed(8, 2), "nearest"), "rounding is one of half_even"),  # type: ignore[arg-type]
        (lambda: one.to(Fixed(8, 2), "floor", "clip"), "overflow is one of saturate"),  # type: ignore[arg-type]
    ]
    for misuse, remedy in cases:
        with pytest.raises(TypeError, match=remedy):
            misuse()


def test_counts_nest_and_end() -> None:
    with counting_overflows() as outer:
        FixedValue(300, 4).to(Fixed(8, 4))
        with counting_overflows() as inner:
            FixedValue(300, 4).to(Fixed(8, 4), overflow="wrap")
            FixedValue(-300, 4).to(Fixed(8, 4), overflow="wrap")
        FixedValue(100, 4).to(Fixed(8, 4))
    FixedValue(300, 4).to(Fixed(8, 4))
    assert (outer.total, inner.total) == (1, 2)


def test_a_value_as_a_number_of_python() -> None:
    some, none = FixedValue(-3, 2), FixedValue(0, 5)
    assert (float(some), float(none)) == (-0.75, 0.0)
    assert (bool(some), bool(none)) == (True, False)
    assert (+some).mantissa == -3
