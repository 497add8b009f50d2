"""Elementary functions: their largest errors, exact points, special values, symmetry, order, and bits when compiled."""

import functools
import itertools
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic import elementary, scaling
from proofmass.blocks.arithmetic.elementary import (
    binary_logarithm,
    cosine_of_turns,
    decimal_logarithm,
    exponential,
    power,
    sine_of_turns,
)
from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, INTEGER, Program
from proofmass.runner.program.lower import call, program
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.elementwise import Elementwise
from proofmass.runner.targets.wasm import wasm_module
from tests.by_hand.elementary import CASES, LONG_IS_LONGER, Case, error, measured
from tests.by_hand.gcc import compiled_by_gcc, needs_gcc, run_in_c
from tests.by_hand.node import needs_node, run_in_node

FUNCTIONS = {name: getattr(elementary, name) for name in elementary.__all__}
OF_MATH: dict[str, Callable[..., float]] = {
    "sine": math.sin,
    "cosine": math.cos,
    "tangent": math.tan,
    "arctangent": math.atan,
    "arctangent2": math.atan2,
    "arcsine": math.asin,
    "arccosine": math.acos,
    "exponential": math.exp,
    "exponential_less_one": math.expm1,
    "logarithm": math.log,
    "logarithm_of_one_plus": math.log1p,
    "binary_logarithm": math.log2,
    "decimal_logarithm": math.log10,
    "power": math.pow,
    "hypotenuse": math.hypot,
    "hyperbolic_sine": math.sinh,
    "hyperbolic_cosine": math.cosh,
    "hyperbolic_tangent": math.tanh,
}
SIZES = (
    *(0.0, 5e-324, 1e-310, 2.2250738585072014e-308, 1e-17, 1e-9, 1.0 / 3.0, 0.5, 1.0, 2.0, 3.0, 709.0, 745.0, 1e22),
    *(2.0**51 + 0.5, 2.0**52 + 1.0, 2.0**53 - 1.0, 1.7976931348623157e308, math.inf),
)
SPECIAL = (*SIZES, *(-size for size in SIZES), math.nan)
# Arguments with the largest errors found by far more than a test looks at.
WORST = {
    "sine_of_turns": [(0.08116843120388742,), (5e-324,)],
    "cosine_of_turns": [(0.1183688232023599,), (0.1246045517068096,)],
    "sine": [(-3.820913210010997e153,), (3.8997108638223885,)],
    "cosine": [(-1.0871632962915028e87,)],
    "tangent": [(-3.9098999723900363,), (922772.9655196134,)],
    "arctangent": [(0.2366290131286289,)],
    "arctangent2": [(5.0335123377834706e-183, 5.728713781784395e124)],
    "arcsine": [(0.23371499709772903,)],
    "arccosine": [(0.9726895106891311,)],
    "exponential": [(-708.8869741561952,), (-25.99242316005818,)],
    "exponential_less_one": [(0.3467044983156711,)],
    "logarithm": [(0.6992808336983835,)],
    "logarithm_of_fraction": [(0.7070175745778678,), (0.7015118033766384,), (1.0 - 2.0**-53,)],
    "logarithm_of_one_plus": [(0.3975915403702281,), (0.4025218609757173,), (0.41421356237309515,)],
    "power": [(1.2538068001535334, -3133.349166853237), (1.4076667633736089, -2051.5027455658606)],
    "hypotenuse": [(1.2132134299510047e-308, 2.64786568056605e-309)],
    "hyperbolic_sine": [(0.37726402010870386,)],
    "hyperbolic_cosine": [(642.9005943696411,)],
    "hyperbolic_tangent": [(0.17355627372308577,)],
}  # fmt: skip


def limit_of(case: Case) -> float:
    """The largest error that the function states."""
    stated = re.search(r"within ([0-9.]+) ulp", str(case.function.__doc__))
    assert stated, "how far is it from the exact value?"
    return float(stated[1])


def reference(name: str, *arguments: float) -> float:
    """What `math` has, infinity where that is out of range and NaN where there is none."""
    try:
        return OF_MATH[name](*arguments)
    except ValueError:
        return math.nan
    except OverflowError:
        odd = name == "hyperbolic_sine" or (name == "power" and arguments[1] % 2.0 == 1.0)
        return -math.inf if odd and arguments[0] < 0.0 else math.inf


def argument_names(function: Callable[..., float]) -> tuple[str, ...]:
    return function.__code__.co_varnames[: function.__code__.co_argcount]


def test_every_function_is_measured() -> None:
    assert set(CASES) == set(FUNCTIONS)
    assert {"sine_of_turns", "cosine_of_turns", "bounded_exponential", "logarithm_of_fraction", *OF_MATH} == set(
        FUNCTIONS
    )


@pytest.mark.skipif(not LONG_IS_LONGER, reason="long doubles have no more bits than numbers here")
@pytest.mark.parametrize("name", CASES)
def test_errors_are_below_what_each_function_states(name: str) -> None:
    largest, at = measured(CASES[name], 10**5, seed=7)
    assert largest < limit_of(CASES[name]), at


@pytest.mark.parametrize(("name", "at"), [(name, at) for name, every in WORST.items() for at in every])
def test_errors_where_they_are_largest(name: str, at: tuple[float, ...]) -> None:
    assert error(CASES[name], at) < (limit_of(CASES[name]) if abs(at[0]) > 1e-300 or name != "sine_of_turns" else 2.0)


@pytest.mark.parametrize("name", OF_MATH)
def test_special_values_are_those_of_math(name: str) -> None:
    for arguments in itertools.product(SPECIAL, repeat=len(argument_names(FUNCTIONS[name]))):
        got, expected = FUNCTIONS[name](*arguments), reference(name, *arguments)
        if expected == 0.0 or not math.isfinite(expected):
            assert (repr(got)) == repr(expected), arguments
        else:
            assert abs(got - expected) <= 2.0 * math.ulp(expected), arguments


SEAMS = (
    *(0.5 * math.log(2.0) * k for k in (1, 3, 5, 21, 101)),
    *(math.pi / 4.0 * k for k in range(1, 12)),
    *(0.236, 0.5, 0.7208, 1.0, 2.0**0.5, 0.5**0.5, 1.0 / 0.236, 1.0 / 0.7208, 1e-9, 1e-17, 2.0, 3.0, 22.0, 40.0, 1.5e6),
)
RISING = {
    "sine": (-1.5707, 1.5707),
    "tangent": (-1.5707, 1.5707),
    "arctangent": (-1e300, 1e300),
    "arcsine": (-1.0, 1.0),
    "exponential": (-745.0, 709.0),
    "exponential_less_one": (-745.0, 709.0),
    "logarithm": (0.0, 1e300),
    "logarithm_of_fraction": (2.0**-64, 1.0),
    "logarithm_of_one_plus": (-1.0, 1e300),
    "binary_logarithm": (0.0, 1e300),
    "decimal_logarithm": (0.0, 1e300),
    "hyperbolic_sine": (-709.0, 709.0),
    "hyperbolic_cosine": (0.0, 709.0),
    "hyperbolic_tangent": (-1e300, 1e300),
}


@pytest.mark.parametrize("name", RISING)
def test_neighbours_are_in_order(name: str) -> None:
    low, high = RISING[name]
    dice = np.random.default_rng(3)
    every = np.concatenate([*_stretches(dice), dice.uniform(max(low, -750.0), min(high, 750.0), 20000)])
    every = every[(every > low) & (every < high)]
    function = Elementwise(FUNCTIONS[name], dict.fromkeys(argument_names(FUNCTIONS[name]), float), float)
    assert np.all(function(every) <= function(np.nextafter(every, high)))


def _stretches(dice: Any) -> Iterator[Any]:
    """All numbers about the seams between the forms that a function has."""
    for seam in SEAMS:
        for sign in (-1.0, 1.0):
            yield sign * (seam + math.ulp(seam) * np.arange(-50, 50))
    yield dice.choice([-1.0, 1.0], 20000) * np.ldexp(1.0 + dice.random(20000), dice.integers(-60, 60, 20000))


@pytest.mark.parametrize(
    ("name", "sign"),
    [
        *((name, -1.0) for name in ("sine_of_turns", "sine", "tangent", "arctangent", "arcsine")),
        *((name, -1.0) for name in ("hyperbolic_sine", "hyperbolic_tangent")),
        *((name, 1.0) for name in ("cosine_of_turns", "cosine", "hyperbolic_cosine")),
    ],
)
@given(st.one_of(st.floats(-(2.0**50), 2.0**50), st.floats(-1.0, 1.0)))
def test_odd_and_even(name: str, sign: float, value: float) -> None:
    got, mirrored = FUNCTIONS[name](value), FUNCTIONS[name](-value)
    assert mirrored == sign * got or (math.isnan(got) and math.isnan(mirrored))


turns = st.one_of(
    st.floats(-(2.0**50), 2.0**50),
    st.floats(-1.0, 1.0),
    st.builds(lambda quarters, small: 0.25 * quarters + small, st.integers(-8, 8), st.floats(-1e-9, 1e-9)),
)


@given(turns)
@example(0.08116843120388742)
@example(5e-324)
def test_sine_of_turns_near_its_zeros(turns: float) -> None:
    with mpmath.workprec(1200):
        near_zero = abs(mpmath.sinpi(2 * mpmath.mpf(turns))) <= 1e-300
    assert error(CASES["sine_of_turns"], (turns,)) < (2.0 if near_zero else 1.3)
    assert abs(sine_of_turns(turns)) <= 1.0


@given(turns)
@example(0.1183688232023599)
def test_cosine_of_turns_near_its_zeros(turns: float) -> None:
    assert error(CASES["cosine_of_turns"], (turns,)) < 1.6
    assert abs(cosine_of_turns(turns)) <= 1.0


@given(st.integers(-(2**48), 2**48))
def test_exact_at_every_quarter_turn(quarters: int) -> None:
    assert sine_of_turns(0.25 * quarters) == (0.0, 1.0, 0.0, -1.0)[quarters % 4]
    assert cosine_of_turns(0.25 * quarters) == (1.0, 0.0, -1.0, 0.0)[quarters % 4]


@pytest.mark.parametrize("multiple", [1, 2, 3, 1000, 10**6, 10**9, 10**18, 6381956970095103 * 2**797])
def test_sine_and_tangent_next_to_multiples_of_a_quarter_turn(multiple: int) -> None:
    """The last is the number that is nearest of all to a multiple of pi / 2 (Muller, Elementary Functions)."""
    with mpmath.workprec(2000):
        angle = float(multiple) if multiple > 10**20 else float(multiple * mpmath.pi / 2)
    for name in ("sine", "cosine", "tangent"):
        assert error(CASES[name], (angle,)) < 1.0


@given(st.integers(-1074, 1023))
def test_powers_of_two_are_exact(exponent: int) -> None:
    value = math.ldexp(1.0, exponent)
    assert binary_logarithm(value) == exponent
    assert power(2.0, float(exponent)) == value
    assert scaling.mantissa_and_exponent(value) == (1.0, exponent)
    assert scaling.scaled(1.0, float(exponent)) == value


def test_powers_of_ten_are_exact() -> None:
    assert [decimal_logarithm(float(f"1e{k}")) for k in range(-300, 301)] == [float(k) for k in range(-300, 301)]
    assert [power(10.0, float(k)) for k in range(23)] == [float(10**k) for k in range(23)]


@given(st.floats(1e-300, 1e300), st.integers(0, 5))
def test_small_powers_are_products(base: float, exponent: int) -> None:
    assert error(CASES["power"], (base, float(exponent))) < 0.76
    assert power(base, 0.0) == 1.0
    assert power(base, 1.0) == base


def test_whole_exponents_of_any_size_are_odd_or_even() -> None:
    """Beyond 2^53 all are even: -1 to their power is 1, as of `math.pow`."""
    sizes = [float(2**k + more) for k in (1, 51, 52, 53, 54, 60, 1000) for more in range(-3, 5)]
    found = [power(-1.0, sign * size) for size in sizes for sign in (1.0, -1.0)]
    assert found == [math.pow(-1.0, sign * size) for size in sizes for sign in (1.0, -1.0)]
    assert {-1.0, 1.0} == set(found)


def test_exponential_at_both_ends() -> None:
    assert exponential(709.782712893384) == pytest.approx(1.7976931348622732e308, rel=1e-15)
    assert exponential(709.782712893385) == math.inf
    assert exponential(-745.1332191019411) == 5e-324
    assert exponential(-745.1332191019412) == 0.0
    assert math.isnan(exponential(math.nan))


def test_bounded_exponential_is_held_at_both_ends_and_hides_no_nan() -> None:
    bounded = elementary.bounded_exponential
    assert bounded(math.inf) == bounded(354.0) == pytest.approx(math.exp(354.0), rel=3e-16)
    assert bounded(-math.inf) == bounded(-354.0) == pytest.approx(math.exp(-354.0), rel=3e-16)
    assert math.isnan(bounded(math.nan))


def hostile_arguments() -> tuple[Any, Any]:
    """Pairs of numbers of all kinds: of every function's own arguments, and special ones."""
    dice = np.random.default_rng(1)
    samples = [sampler(dice, 40) for case in CASES.values() for sampler in case.samplers]
    special = np.array(list(itertools.product(SPECIAL, repeat=2)))
    first = np.concatenate([special[:, 0], *(sample[0] for sample in samples)])
    second = np.concatenate([special[:, 1], *(sample[-1] for sample in samples)])
    return first, second


def everything() -> Program:
    """A program that writes what every function gives for every pair of numbers."""
    builder = Builder("everything", "")
    count = builder.parameter(INTEGER, "count")
    first, second = builder.array(FLOAT, None, "first"), builder.array(FLOAT, None, "second")
    results = [builder.array(FLOAT, None, name, writable=True) for name in FUNCTIONS]
    with builder.counted(0, count, 1, "entry") as entry:
        given = [builder.load(first, entry), builder.load(second, entry)]
        for function, result in zip(FUNCTIONS.values(), results, strict=True):
            value: Any = call(builder, function, given[: len(argument_names(function))])
            builder.store(result, entry, value)
    return program(builder.function())


@functools.cache
def expected_bits() -> dict[str, Any]:
    """What plain Python gives."""
    pairs = list(zip(*(column.tolist() for column in hostile_arguments()), strict=True))
    return {
        name: _bits(np.array([function(*pair[: len(argument_names(function))]) for pair in pairs]))
        for name, function in FUNCTIONS.items()
    }


def given_arrays() -> list[Any]:
    first, second = hostile_arguments()
    return [first, second, *(np.zeros_like(first) for _ in FUNCTIONS)]


@pytest.mark.exhaustive
@pytest.mark.parametrize("settings", [machine_code.Settings(), machine_code.Settings(wide=True)], ids=["one", "wide"])
def test_machine_code_has_the_same_bits(settings: machine_code.Settings) -> None:
    arrays = given_arrays()
    machine_code.load(everything(), settings)(len(arrays[0]), *(array.ctypes.data for array in arrays))
    assert dict(zip(FUNCTIONS, map(_bits, arrays[2:]), strict=True)) == expected_bits()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_vectors_have_the_same_bits(name: str) -> None:
    function, arguments = FUNCTIONS[name], hostile_arguments()
    names = argument_names(function)
    results = Elementwise(function, dict.fromkeys(names, float), float)(*arguments[: len(names)])
    assert _bits(results) == expected_bits()[name]


@pytest.mark.exhaustive("-O3")
@needs_gcc
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_c_has_the_same_bits(level: str, tmp_path: Path) -> None:
    arrays = given_arrays()
    run_in_c(compiled_by_gcc(everything(), tmp_path, level), arrays, len(arrays[0]))
    assert dict(zip(FUNCTIONS, map(_bits, arrays[2:]), strict=True)) == expected_bits()


@needs_node
def test_webassembly_has_the_same_bits(tmp_path: Path) -> None:
    arrays, module = given_arrays(), wasm_module(everything())
    assert not module.libm
    run_in_node(module, [len(arrays[0])], arrays, tmp_path)
    assert dict(zip(FUNCTIONS, map(_bits, arrays[2:]), strict=True)) == expected_bits()


def _bits(values: Any) -> list[int]:
    """The bits of numbers; those of a NaN say nothing."""
    bits: list[int] = np.where(np.isnan(values), np.nan, values).view(np.int64).tolist()
    return bits
