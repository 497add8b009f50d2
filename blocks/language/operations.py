"""Meaning of Python's operators and functions for each type, and the ways in which they fail."""

import ast
import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.language import arithmetic, whole
from proofmass.blocks.language.arithmetic import HIGHEST, LOWEST
from proofmass.blocks.language.values import Type


@dataclass(frozen=True)
class Checked:
    """An operation that can fail: in plain Python `reference` raises; a program takes the value and notes a fault."""

    value: Callable[..., Any]
    fails: Callable[..., bool]  # of the operands
    result: Type
    reference: Callable[..., Any]
    by_value: bool = False  # whether `fails` takes the value before the operands


def _fits(value: Callable[..., Any], fails: Callable[..., bool], python: Callable[..., Any]) -> Checked:
    """An operation of integers: a result of more than 64 bits ends the run."""

    def reference(*operands: Any) -> int:
        result: int = python(*operands)
        if not LOWEST <= result <= HIGHEST:
            raise OverflowError("an integer does not fit 64 bits")
        return result

    return Checked(value, fails, int, reference)


def _step_by_step(value: Callable[..., int], fails: Callable[..., bool]) -> Checked:
    """An operation of integers that may exceed 64 bits on its way, where Python would go on, even for hours."""

    def reference(*operands: Any) -> int:
        if len(operands) == 2 and operands[1] < 0:
            raise ValueError(f"a negative shift or power of an integer: {operands[1]}")
        if fails(*operands):
            raise OverflowError("an integer does not fit 64 bits")
        return value(*operands)

    return Checked(value, fails, int, reference)


def _number(value: Callable[..., Any], fails: Callable[..., bool], python: Callable[..., float]) -> Checked:
    return Checked(value, fails, float, python)


def _defined(value: Callable[..., Any], fails: Callable[..., bool], python: Callable[..., Any]) -> Checked:
    """A function of numbers that has no value where its result says so."""
    return Checked(value, fails, float, python, by_value=True)


def _power(a: float, b: float) -> float:
    value: float | complex = float(a) ** float(b)
    if isinstance(value, complex):
        raise ValueError("a negative number to the power of a fraction")
    return value


def _round(a: float) -> int:
    return round(float(a))  # a number with a derivative has no nearest integer


OF_INTEGERS: dict[type[ast.operator], Checked] = {
    ast.Add: _fits(operator.add, arithmetic.add_fails, operator.add),
    ast.Sub: _fits(operator.sub, arithmetic.subtract_fails, operator.sub),
    ast.Mult: _fits(operator.mul, arithmetic.multiply_fails, operator.mul),
    ast.FloorDiv: _fits(arithmetic.floor_divide, arithmetic.floor_divide_fails, operator.floordiv),
    ast.Mod: _fits(arithmetic.modulo, arithmetic.modulo_fails, operator.mod),
    ast.LShift: _step_by_step(arithmetic.shift_left, arithmetic.shift_left_fails),
    ast.RShift: _fits(arithmetic.shift_right, arithmetic.shift_right_fails, operator.rshift),
    ast.Pow: _step_by_step(arithmetic.power, arithmetic.power_fails),
    ast.Div: _number(arithmetic.true_divide, arithmetic.zero_fails, operator.truediv),
}
BITWISE = (ast.BitAnd, ast.BitOr, ast.BitXor)
OF_NUMBERS: dict[type[ast.operator], Checked] = {
    ast.Div: _number(operator.truediv, arithmetic.zero_fails, operator.truediv),
    ast.FloorDiv: _number(arithmetic.number_floor_divide, arithmetic.zero_fails, operator.floordiv),
    ast.Mod: _number(arithmetic.number_modulo, arithmetic.zero_fails, operator.mod),
}
PLAIN = (ast.Add, ast.Sub, ast.Mult)  # of numbers: none fails
NEGATE = _fits(operator.neg, arithmetic.negate_fails, operator.neg)
ABSOLUTE = _fits(abs, arithmetic.negate_fails, abs)
TRUNCATE = _fits(arithmetic.truncate, arithmetic.truncate_fails, int)
NEAREST = _fits(arithmetic.nearest, arithmetic.truncate_fails, _round)
STRIDE = Checked(arithmetic.stride, arithmetic.stride_fails, int, lambda step: step)
POWER = _defined(arithmetic.c_power, arithmetic.undefined_of_two, _power)


def _factorial(n: int) -> int:
    if n > 20:
        raise OverflowError("an integer does not fit 64 bits")
    return math.factorial(n)


def _is_close(a: float, b: float, relative: float, absolute: float) -> bool:
    return math.isclose(a, b, rel_tol=relative, abs_tol=absolute)


def _turned(turns: int) -> int:
    if arithmetic.next_turn_fails(turns):
        raise RuntimeError(f"a loop of over {arithmetic.MOST_TURNS:,} turns in one tick")
    return arithmetic.next_turn(turns)


def _ended(start: int, stop: int, step: int) -> int:
    if arithmetic.range_end_fails(start, stop, step):
        raise RuntimeError(f"a range of over {arithmetic.MOST_TURNS:,} in one tick")
    return stop


RANGE_END = Checked(arithmetic.range_end, arithmetic.range_end_fails, int, _ended)
TURN = Checked(arithmetic.next_turn, arithmetic.next_turn_fails, int, _turned)


def _index(index: int, length: int) -> int:
    if arithmetic.place_fails(index, length):
        raise IndexError(f"there is no entry {index} among {length}")
    return arithmetic.place(index, length)


PLACE = Checked(arithmetic.place, arithmetic.place_fails, int, _index)

# Functions of Python: what is called in their place, the types of the arguments, and that of the result.
CheckedFunction = tuple[Any, tuple[Type, ...], Type]
_MAY_FAIL = ("sqrt", "exp", "log", "log2", "log10", "log1p", "expm1", "exp2", "sin", "cos", "tan", "asin", "acos",
             "sinh", "cosh", "acosh", "atanh")  # fmt: skip
_NEVER_FAIL = ("erf", "erfc", "atan", "tanh", "asinh", "fabs", "degrees", "radians")
FUNCTIONS: dict[Any, CheckedFunction] = {
    **{f: (_defined(f, arithmetic.undefined, f), (float,), float) for f in (getattr(math, name) for name in _MAY_FAIL)},
    **{getattr(math, name): (getattr(math, name), (float,), float) for name in _NEVER_FAIL},
    math.cbrt: (_defined(arithmetic.c_cube_root, arithmetic.undefined, math.cbrt), (float,), float),
    **{f: (f, (float,), bool) for f in (math.isnan, math.isinf, math.isfinite)},
    math.atan2: (math.atan2, (float, float), float),
    math.copysign: (arithmetic.signed, (float, float), float),
    math.fmod: (_defined(arithmetic.c_remainder, arithmetic.undefined_of_two, math.fmod), (float, float), float),
    math.pow: (_defined(arithmetic.c_power, arithmetic.undefined_of_two, math.pow), (float, float), float),
    math.ldexp: (
        _defined(arithmetic.times_power_of_two, arithmetic.times_power_of_two_fails, math.ldexp),
        (float, int),
        float,
    ),
    math.isqrt: (Checked(whole.integer_root, whole.integer_root_fails, int, math.isqrt), (int,), int),
    math.gcd: (_fits(whole.greatest_divisor, whole.greatest_divisor_fails, math.gcd), (int, int), int),
    math.lcm: (_fits(whole.least_multiple, whole.least_multiple_fails, math.lcm), (int, int), int),
    math.factorial: (Checked(whole.factorial, whole.factorial_fails, int, _factorial), (int,), int),
}
NO_FUNCTION: CheckedFunction = (None, (), float)
TO_INTEGER: dict[Any, Checked] = {
    int: TRUNCATE,
    math.trunc: TRUNCATE,
    round: NEAREST,
    math.floor: _fits(arithmetic.floor, arithmetic.truncate_fails, math.floor),
    math.ceil: _fits(arithmetic.ceil, arithmetic.truncate_fails, math.ceil),
}
EXTREMES: dict[Any, Checked] = {
    min: Checked(whole.least, whole.is_empty, float, min),
    max: Checked(whole.largest, whole.is_empty, float, max),
}
TOTALS: dict[Any, Checked] = {
    sum: _step_by_step(whole.total, whole.total_fails),
    math.prod: _step_by_step(whole.product, whole.product_fails),
}
IS_CLOSE = Checked(arithmetic.is_close, arithmetic.is_close_fails, bool, _is_close)

# What to write instead of functions that cannot be compiled to the bits of Python.
INSTEAD: dict[Any, str] = {
    print: "record it: add the output to probes; to look inside, breakpoint() and --engine python",
    input: "give the block a parameter or an input port",
    open: "read files in `constants`, or declare a Recording",
    sum: "add the entries up in a loop: sum() keeps digits that a loop does not",
    sorted: "compare the entries in a loop",
    map: "write a loop",
    filter: "write a loop",
    any: "write a loop, or conditions with or",
    all: "write a loop, or conditions with and",
    isinstance: "a port or field has one type only",
    list: "declare a Buffer for values that change, or a tuple for constants",
    dict: "write a tuple and an integer index",
    str: "functions of a block work with numbers",
    eval: "write the expression",
    exec: "write the statements",
    math.gamma: "Python has its own: compute it in `constants`",
    math.lgamma: "Python has its own: compute it in `constants`",
    math.fsum: "add the entries up in a loop",
    math.dist: "write math.sqrt of the sum of squares",
    math.hypot: "write math.sqrt of the sum of squares",
    reversed: "write range(len(entries) - 1, -1, -1)",
    math.frexp: "Python gives it as a tuple of two types: compute it in `constants`",
    math.modf: "write a - float(math.trunc(a))",
    math.remainder: "write a - b * float(round(a / b))",
    math.nextafter: "write a * (1.0 + 2.0**-52)",
    math.ulp: "write abs(a) * 2.0**-52",
    math.comb: "compute it in `constants`",
    math.perm: "compute it in `constants`",
}
_OF_NUMPY = {  # functions of NumPy whose names differ
    "arcsin": "math.asin",
    "arccos": "math.acos",
    "arctan": "math.atan",
    "arctan2": "math.atan2",
    "arcsinh": "math.asinh",
    "arccosh": "math.acosh",
    "arctanh": "math.atanh",
    "absolute": "abs",
    "maximum": "max",
    "minimum": "min",
    "power": "**",
    "rint": "round",
    "clip": "min(max(x, low), high)",
    "deg2rad": "math.radians",
    "rad2deg": "math.degrees",
}


def instead_of_numpy(value: Any) -> str:
    """Return what to write instead of a function or value of NumPy."""
    name = getattr(value, "__name__", "")
    if name in ("array", "zeros", "ones", "empty"):
        return INSTEAD[list]
    instead = _OF_NUMPY.get(name) or (f"math.{name}" if hasattr(math, name) else "")
    return f"write {instead}" if instead else "write numbers: float, int, bool, and functions of math"


def modules_of(target: Any) -> tuple[str, str]:
    """Return the modules that a function comes from, and the object that it is a method of:
    "random" for all dice.

    >>> import random
    >>> modules_of(random.gauss), modules_of(random.random)
    (('random', 'random'), ('', 'random'))
    """
    homes = (getattr(of, "__module__", "") or "" for of in (target, getattr(target, "__self__", None)))
    names = [str(home).split(".") for home in homes]
    module, owner = ("random" if "random" in parts else parts[0].lstrip("_") for parts in names)
    return module, owner


UNREPEATABLE = {
    "random": "for noise name the argument `normal`: a fresh normal deviate that follows from the seed",
    "secrets": "for noise name the argument `normal`: a fresh normal deviate that follows from the seed",
    "uuid": "for noise name the argument `normal`: a fresh normal deviate that follows from the seed",
    "time": "name the argument `time`: the seconds since the start of the run, or `tick`",
    "datetime": "name the argument `time`: the seconds since the start of the run",
}
OUTSIDE = (
    "os",
    "sys",
    "subprocess",
    "socket",
    "threading",
    "multiprocessing",
    "pathlib",
    "shutil",
    "ctypes",
    "asyncio",
)
