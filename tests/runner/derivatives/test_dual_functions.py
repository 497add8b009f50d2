"""Functions of blocks on dual numbers: against mpmath, and against differences for every block there is."""

import math
import random
from pathlib import Path
from typing import Any

import mpmath
import pytest

from proofmass.blocks.arithmetic import elementary, rounding
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of, unit_of
from proofmass.runner.contract.drawn import random_block
from proofmass.runner.derivatives.dual import SIGNALS, dual, plain, slopes_of
from proofmass.runner.derivatives.dual_functions import dual_math, for_duals
from proofmass.runner.derivatives.dual_plan import dual_constants
from proofmass.runner.plan.constants import constants_of, start_of

PERIOD = 1e-4
QUANTISERS = {
    "AnalogToDigital",
    "DigitalToAnalog",
    "MashModulator",
    "PipelineAnalogToDigital",
    "Quantiser",
    "SigmaDeltaModulator",
    "SuccessiveApproximation",
    "UnipolarDigitalToAnalog",
    "WeightedDigitalToAnalog",
}
OF_VOLTAGES = {
    "AnalogToDigital",
    "MashModulator",
    "PipelineAnalogToDigital",
    "Quantiser",
    "SigmaDeltaModulator",
    "SuccessiveApproximation",
}  # of signals about 1, where others take codes
OF_WEIGHTS = {"PipelineAnalogToDigital", "SuccessiveApproximation", "WeightedDigitalToAnalog"}  # converters by these
SPREAD = 1e-4  # of gains of stages: larger ones skip more codes than are allowed for
KINDS = {
    name: kind
    for name, kind in all_blocks().items()
    if not name.startswith("Fixed") and not any(port.shape for port in kind.inputs.values())
}  # those in fixed point: test_dual_fixed


@pytest.mark.parametrize(
    ("function", "exact", "arguments"),
    [
        (elementary.sine_of_turns, lambda x: mpmath.sin(2 * mpmath.pi * x), (0.0, 0.2, 0.25, 0.6, -0.37, 1000.125)),
        (elementary.cosine_of_turns, lambda x: mpmath.cos(2 * mpmath.pi * x), (0.1, 0.25, 0.6, -0.37, 1000.125)),
        (elementary.logarithm_of_fraction, mpmath.log, (1e-18, 1e-6, 0.3, 0.71, 0.999)),
        (elementary.logarithm_of_one_plus, lambda x: mpmath.log(1 + x), (1e-12, 1e-3, 0.4, 1.7, 1e5, 1e15)),
        (elementary.exponential, mpmath.exp, (-300.0, -1.0, 0.0, 1e-9, 0.4, 20.0, 300.0)),
        (elementary.exponential_less_one, mpmath.expm1, (-3.0, 1e-9, 0.4, 20.0)),
        (elementary.sine, mpmath.sin, (0.2, -4.0, 1e7)),
        (elementary.cosine, mpmath.cos, (0.2, -4.0, 1e7)),
        (elementary.tangent, mpmath.tan, (0.2, -4.0)),
        (elementary.arctangent, mpmath.atan, (-2.0, 0.3)),
        (elementary.arcsine, mpmath.asin, (-0.9, 0.3)),
        (elementary.arccosine, mpmath.acos, (-0.9, 0.3)),
        (elementary.logarithm, mpmath.log, (1e-3, 0.4, 1e5)),
        (elementary.binary_logarithm, lambda x: mpmath.log(x, 2), (0.4, 1e5)),
        (elementary.decimal_logarithm, mpmath.log10, (0.4, 1e5)),
        (elementary.hyperbolic_sine, mpmath.sinh, (-0.3, 2.0)),
        (elementary.hyperbolic_cosine, mpmath.cosh, (-0.3, 2.0)),
        (elementary.hyperbolic_tangent, mpmath.tanh, (-0.3, 2.0)),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_elementary_functions_and_two_derivatives(function: Any, exact: Any, arguments: tuple[float, ...]) -> None:
    with mpmath.workdps(60):
        for x in arguments:
            found = for_duals(function)(dual(dual(x, {"x": 1.0}, 0), {"x": 1.0}, 1))
            first, second = mpmath.diff(exact, mpmath.mpf(x)), mpmath.diff(exact, mpmath.mpf(x), 2)
            assert plain(found) == function(x)
            assert plain(slopes_of(found, 1).get("x", 0.0)) == pytest.approx(float(first), rel=1e-14, abs=1e-13)
            got = slopes_of(slopes_of(found, 1).get("x", 0.0), 0).get("x", 0.0)
            assert got == pytest.approx(float(second), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(
    ("function", "exact", "x", "y"),
    [
        (elementary.arctangent2, mpmath.atan2, 0.3, -2.0),
        (elementary.arctangent2, mpmath.atan2, -3.0, -0.2),
        (elementary.hypotenuse, mpmath.hypot, 3.0, -0.4),
        (elementary.power, mpmath.power, 1.7, -2.3),
        (elementary.power, mpmath.power, 0.2, 3.0),
    ],
)
def test_elementary_functions_of_two_numbers(function: Any, exact: Any, x: float, y: float) -> None:
    """Slopes by both numbers, and the mixed one of two levels."""
    found = for_duals(function)(dual(x, {"x": 1.0}, 0), dual(y, {"y": 1.0}, 1))
    with mpmath.workdps(60):
        at = (mpmath.mpf(x), mpmath.mpf(y))
        assert plain(found) == function(x, y)
        assert slopes_of(found)["x"] == pytest.approx(float(mpmath.diff(exact, at, (1, 0))), rel=1e-13)
        assert plain(slopes_of(found, 1)["y"]) == pytest.approx(float(mpmath.diff(exact, at, (0, 1))), rel=1e-13)
        mixed = slopes_of(slopes_of(found, 1)["y"])["x"]
        assert mixed == pytest.approx(float(mpmath.diff(exact, at, (1, 1))), rel=1e-12)
    one_level = for_duals(function)(dual(x, {"x": 1.0}), dual(y, {"y": 1.0}))
    assert slopes_of(one_level) == {"x": slopes_of(found)["x"], "y": plain(slopes_of(found, 1)["y"])}


ARGUMENTS = {"acosh": (1.5, 30.0), "default": (0.2, 0.7), "sin": (0.2, -4.0), "exp": (-3.0, 5.0), "atan": (-2.0, 0.3)}
FUNCTIONS = (
    "sqrt cbrt exp exp2 expm1 log log2 log10 log1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf erfc"
)


@pytest.mark.parametrize("name", [*FUNCTIONS.split(), "degrees", "radians"])
def test_functions_of_math(name: str) -> None:
    exact: Any = getattr(mpmath, name, None) or {
        "log2": lambda x: mpmath.log(x, 2),
        "exp2": lambda x: mpmath.mpf(2) ** x,
        "asin": mpmath.asin,
    }.get(name)
    for x in ARGUMENTS.get(name, ARGUMENTS["default"]):
        found = getattr(dual_math, name)(dual(x, {"x": 1.0}))
        assert plain(found) == getattr(math, name)(x)
        assert getattr(dual_math, name)(x) == getattr(math, name)(x)
        assert slopes_of(found)["x"] == pytest.approx(float(mpmath.diff(exact, x)), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "x", "y"),
    [("atan2", 0.3, -2.0), ("atan2", -3.0, -0.2), ("hypot", 3.0, -0.4), ("pow", 1.7, -2.3), ("fmod", 7.3, 2.0),
     ("copysign", 2.0, -1.0)],
)  # fmt: skip
def test_functions_of_two_numbers(name: str, x: float, y: float) -> None:
    function = getattr(math, name)
    found = getattr(dual_math, name)(dual(x, {"x": 1.0}), dual(y, {"y": 1.0}))
    assert plain(found) == pytest.approx(function(x, y), rel=1e-15)
    h = 1e-6
    by_x = (function(x + h, y) - function(x - h, y)) / (2 * h)
    assert slopes_of(found)["x"] == pytest.approx(by_x, rel=1e-8)
    if name != "fmod":
        by_y = (function(x, y + h) - function(x, y - h)) / (2 * h)
        assert slopes_of(found).get("y", 0.0) == pytest.approx(by_y, rel=1e-8, abs=1e-9)
    assert getattr(dual_math, name)(x, y) == function(x, y)


def test_scaling_and_counting() -> None:
    x = dual(-2.75, {"x": 1.0})
    assert [f(x) for f in (dual_math.floor, dual_math.ceil)] == [-3, -2]
    assert dual_math.trunc(x) is x
    mantissa, exponent = dual_math.frexp(x)
    assert (plain(mantissa), exponent) == math.frexp(-2.75)
    assert slopes_of(mantissa) == {"x": 0.25}
    assert slopes_of(dual_math.ldexp(x, 4)) == {"x": 16.0}
    assert slopes_of(dual_math.fsum([x, 1.0, x])) == {"x": 2.0}
    assert dual_math.fsum([0.1] * 10) == 1.0
    assert slopes_of(dual_math.fabs(x)) == {"x": -1.0}
    assert dual_math.isfinite(x)
    assert not dual_math.isfinite(dual(math.inf, {"x": 1.0}))


def test_quantisers_and_counts_are_told_apart() -> None:
    def quantised(value: float) -> int:
        return int(rounding.round_half_even(value))

    def turns(value: float) -> float:
        return value - rounding.nearest_integer(value)

    x = dual(2.6, {"x": 3.0})
    assert for_duals(quantised)(2.6) == 3
    assert repr(for_duals(quantised)(x)) == "Dual(3.0, {'x': 3.0})"  # as in the run: a parameter moves it
    signal = dual(x, {"y": 1.0}, SIGNALS)
    assert repr(for_duals(quantised)(signal)) == repr(signal)
    assert slopes_of(for_duals(turns)(x)) == {"x": 3.0}
    assert plain(for_duals(turns)(x)) == pytest.approx(-0.4)


def test_helpers_recursion_defaults_and_inner_functions() -> None:
    def power(base: float, exponent: int) -> float:
        return base * power(base, exponent - 1) if exponent else 1.0

    globals()["power"] = power

    def through(value: float, *, times: int = 3) -> float:
        return sum(math.exp(v) for v in [power(value, times)])

    found = for_duals(through)(dual(0.5, {"x": 1.0}))
    assert slopes_of(found)["x"] == pytest.approx(3 * 0.25 * math.exp(0.125))


@pytest.mark.exhaustive(but=80)
@pytest.mark.exhaustive("RunningPercentile", "SpectrumMeter")
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_every_block_against_differences(kind: type[Block], tmp_path: Path) -> None:
    """Each function by each real state, input, constant and entry of a buffer, at random places."""
    dice = random.Random(kind.__name__)
    for _ in range(4):
        block = random_block(kind, dice, tmp_path)
        if "gain_spread" in kind.parameters:
            block = kind(**{n: getattr(block, n) for n in kind.parameters} | {"gain_spread": SPREAD})
        for role in (*kind.output_functions, "update", "derivative"):
            behaviour = kind.output_functions.get(role) or kind.functions.get(role)
            if behaviour is not None:
                _compare(block, behaviour.function, _arguments(block, behaviour.arguments, dice), kind.__name__)


@pytest.mark.exhaustive(but=80)
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_constants_of_every_block_against_differences(kind: type[Block], tmp_path: Path) -> None:
    dice = random.Random(kind.__name__)
    for _ in range(4):
        block = random_block(kind, dice, tmp_path)
        made = constants_of(block, block, PERIOD)
        for name, parameter in kind.parameters.items():
            if parameter.kind is not float:
                continue
            found = dual_constants(block, _with(block, name, dual(getattr(block, name), {name: 1.0})), PERIOD)
            found, made_flat = _flat(found), _flat(made)
            assert [plain(v) for v in found] == made_flat
            step = 1e-6 * (abs(getattr(block, name)) or 1.0)
            above, below = (_values_at(block, name, getattr(block, name) + s * step) for s in (1.0, -1.0))
            for got, high, low, value in zip(found, above, below, made_flat, strict=True):
                if _corner(high, value, low):
                    continue
                expected = (high - low) / (2.0 * step)
                assert slopes_of(got).get(name, 0.0) == pytest.approx(
                    expected, rel=1e-5, abs=1e-8 * abs(value) / step + 1e-300
                )


SIX_BITS: dict[str, dict[str, Any]] = {
    "AnalogToDigital": {"bits": 6},
    "SuccessiveApproximation": {"bits": 6},
    "PipelineAnalogToDigital": {"stages": 3, "last_bits": 3},
}


@pytest.mark.parametrize("name", SIX_BITS)
def test_converters_have_the_slope_of_their_steps_from_the_lowest_code_to_the_highest(name: str) -> None:
    block = KINDS[name](reference=1.0, **SIX_BITS[name])
    behaviour = KINDS[name].output_functions["number"]
    made = _arguments(block, behaviour.arguments, random.Random(1))
    place = 1 + behaviour.arguments.index("voltage")
    for steps in [code + part for code in range(-36, 36) for part in (-0.3, 0.3)]:
        voltage = dual(steps / 32.0, {"x": 1.0})
        found = for_duals(behaviour.function)(*made[:place], voltage, *made[place + 1 :])
        assert plain(found) == min(max(round(steps), -32), 31)
        assert slopes_of(found).get("x", 0.0) == (32.0 if -32.0 < steps < 31.0 else 0.0), steps


def _corner(up: float, middle: float, down: float) -> bool:
    """Whether the function bends within the step, so that a difference tells no derivative."""
    return bool(abs(up - 2.0 * middle + down) > 0.1 * abs(up - down) + 1e-6 * abs(middle))


def _values_at(block: Block, name: str, value: float) -> list[float]:
    return _flat(constants_of(block, _with(block, name, value), PERIOD))


def _flat(constants: Any) -> list[Any]:
    """Constants one by one, entries of lists too."""
    return [entry for value in constants for entry in (value if isinstance(value, tuple) else (value,))]


def _with(block: Block, name: str, value: Any) -> Any:
    class Changed:
        pass

    changed: Any = Changed()
    for parameter in type(block).parameters:
        setattr(changed, parameter, getattr(block, parameter))
    setattr(changed, name, value)
    return changed


def _arguments(block: Block, names: tuple[str, ...], dice: random.Random) -> list[Any]:
    """Constants, then whatever the function takes, as plain numbers; lists for buffers."""
    known: dict[str, Any] = {"time": 0.0123, "tick": 5, "normal": 0.7}
    for name, buffer in type(block).buffers.items():
        length = 7 if buffer.recorded else shape_of(block, buffer)[0]
        known[name] = sorted(_drawn(buffer.dtype, dice) for _ in range(length))
    if type(block).__name__ in OF_WEIGHTS:
        start_of(block, known, PERIOD)
    for name, port in type(block).inputs.items():
        known[name] = _drawn(port.dtype, dice) * (
            1e-7 if unit_of(block, port) == "m" else 1
        )  # plates that do not touch
    state = type(block).state_class()
    if state is not None:
        known["x"] = state(*(_drawn(k, dice) for k in state.__annotations__.values()))
    for port in type(block).outputs.values():
        if port.shape:
            known["out"] = [0] * shape_of(block, port)[0]
    return [constants_of(block, block, PERIOD), *(known[name] for name in names)]


def _drawn(kind: type, dice: random.Random) -> Any:
    return dice.uniform(0.1, 0.9) if kind is float else dice.randrange(2) if kind is int else dice.random() < 0.5


def _compare(block: Block, function: Any, arguments: list[Any], kind: str) -> None:
    base = _flat_results(function, arguments)
    for place in _places(arguments):
        value = _at(arguments, place)
        seeded = _moved(arguments, place, dual(value, {"x": 1.0}))
        found = _flat_results(for_duals(function), seeded)
        step = 1e-6 * (abs(value) or 1.0)
        if kind in OF_WEIGHTS:
            step = 0.02 * (abs(value) or 1.0)
        elif kind in OF_VOLTAGES:
            step = 0.3 * (abs(value) or 1.0)
        elif kind in QUANTISERS and place[0] > 0:
            step = 300.0
        high, low = (_flat_results(function, _moved(arguments, place, value + s * step)) for s in (1.0, -1.0))
        for got, up, down, middle in zip(found, high, low, base, strict=True):
            if _corner(up, middle, down):
                continue
            coarse = max(1.0, _half_a_step(block)) if kind in QUANTISERS else 0.0
            coarse = 3.0 if kind in OF_WEIGHTS else coarse  # wrong weights skip codes, too
            expected = (up - down) / (2.0 * step)
            allowed = 1e-5 * abs(expected) + 2e-9 * abs(middle) / step + coarse / step
            assert abs(slopes_of(got).get("x", 0.0) - expected) <= allowed, (kind, function.__name__, place)
            assert abs(plain(got) - middle) <= coarse


def _half_a_step(block: Any) -> float:
    """Of the levels of a modulator, which may have two of any size."""
    return float(block.reference / (block.levels - 1)) if hasattr(block, "feedback") else 0.0


def _flat_results(function: Any, arguments: list[Any]) -> list[Any]:
    """What a function returns, and what it leaves in its buffers."""
    own = [list(a) if isinstance(a, list) else a for a in arguments]
    result = function(*own)
    out = list(result) if isinstance(result, tuple) else [] if result is None else [result]
    return [*out, *(entry for a in own if isinstance(a, list) for entry in a)]


def _places(arguments: list[Any]) -> list[tuple[int, int]]:
    """Every real number among the arguments but time and noise; of a long buffer some fifty of its entries."""
    found = []
    for i, argument in enumerate(arguments):
        entries = argument if isinstance(argument, list | tuple) else [argument]
        apart = 1 + len(entries) // 50
        found += [(i, j) for j, entry in enumerate(entries) if isinstance(entry, float) and j % apart == 0]
    return found


def _at(arguments: list[Any], place: tuple[int, int]) -> float:
    argument = arguments[place[0]]
    return float(argument[place[1]] if isinstance(argument, list | tuple) else argument)


def _moved(arguments: list[Any], place: tuple[int, int], value: Any) -> list[Any]:
    i, j = place
    moved = list(arguments)
    if isinstance(moved[i], list):
        moved[i] = [value if k == j else entry for k, entry in enumerate(moved[i])]
    elif isinstance(moved[i], tuple):
        moved[i] = type(moved[i])(*(value if k == j else entry for k, entry in enumerate(moved[i])))
    else:
        moved[i] = value
    return moved


@pytest.mark.defect("C2", before="ZeroDivisionError or ValueError", after="a value without a slope")
@pytest.mark.parametrize(
    ("name", "arguments"),
    [("sqrt", (0.0,)), ("cbrt", (0.0,)), ("asin", (1.0,)), ("acos", (1.0,)), ("acosh", (1.0,)), ("pow", (0.0, 0.5)),
     ("atan2", (0.0, 0.0)), ("hypot", (0.0, 0.0)), ("fabs", (0.0,))],
)  # fmt: skip
def test_where_there_is_no_slope(name: str, arguments: tuple[float, ...]) -> None:
    function, x = getattr(dual_math, name), dual(arguments[0], {"x": 1.0})
    found = function(x, *arguments[1:])
    assert plain(found) == getattr(math, name)(*arguments)
    assert math.isnan(slopes_of(found)["x"])
    assert slopes_of(0.0 * found) == {}  # what is multiplied by nothing does nothing
    nested = function(dual(x, {"y": 1.0}, 1), *arguments[1:])
    assert math.isnan(plain(slopes_of(nested, 1)["y"]))


@pytest.mark.parametrize(
    ("function", "arguments"),
    [(elementary.arcsine, (1.0,)), (elementary.arccosine, (2.0,)), (elementary.power, (0.0, 0.5)),
     (elementary.arctangent2, (0.0, 0.0)), (elementary.hypotenuse, (0.0, 0.0)), (elementary.logarithm, (0.0,))],
)  # fmt: skip
def test_where_elementary_functions_have_no_slope(function: Any, arguments: tuple[float, ...]) -> None:
    found = for_duals(function)(dual(arguments[0], {"x": 1.0}), *arguments[1:])
    assert repr(plain(found)) == repr(function(*arguments))
    assert math.isnan(slopes_of(found)["x"])


def test_powers_of_ours_at_zero() -> None:
    power, x, y = for_duals(elementary.power), dual(0.0, {"x": 1.0}), dual(1.5, {"y": 1.0})
    assert power(x, 1.5) == 0.0
    assert slopes_of(power(x, 1.0)) == {"x": 1.0}
    assert power(x, 0.0) == 1.0
    assert slopes_of(power(0.0, y)) == {}


@pytest.mark.defect("C2", before="ValueError: math domain error", after="slopes of 0**1.5, 0**1, x**0, 0**y")
def test_powers_at_zero() -> None:
    x, y = dual(0.0, {"x": 1.0}), dual(1.5, {"y": 1.0})
    assert dual_math.pow(x, 1.5) == 0.0
    assert slopes_of(dual_math.pow(x, 1.0)) == {"x": 1.0}
    assert dual_math.pow(x, 0.0) == 1.0
    assert slopes_of(dual_math.pow(0.0, y)) == {}
