"""Programs written by hand that use every statement, each with what plain Python says to it.

A case is a program whose entry takes arrays alone, the arrays before, and the arrays behind.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, External, Program, Storage, Value
from tests.by_hand.programs import Writer, program

HIGHEST, LOWEST = 2**63 - 1, -(2**63)
Case = tuple[Program, list[Any], list[Any]]


def ranges() -> Case:
    """Counted loops to the ends of 64 bits, in all directions: the number of turns, and the last counter."""
    limits = [
        (0, 5, 1), (5, 0, 1), (0, 10, 3), (0, 9, 3), (10, 0, -3), (9, 0, -3), (0, 10, -1), (3, 3, 1), (-4, 4, 2),
        (HIGHEST - 3, HIGHEST, 2), (HIGHEST - 7, HIGHEST, 5), (LOWEST + 7, LOWEST, -5), (HIGHEST - 2, HIGHEST, 1),
        (LOWEST, HIGHEST, 2**62), (HIGHEST, LOWEST, -(2**62)), (LOWEST, LOWEST + 2, 1), (7, -9, -HIGHEST),
    ]  # fmt: skip
    given, out = Storage(INTEGER, 2 * len(limits), False, "limits"), Storage(INTEGER, 6 * len(limits), True, "out")
    w = Writer("entry", given, out)
    for place, (first, last, step) in enumerate(limits):
        loaded = [w.load(given, 2 * place), w.load(given, 2 * place + 1)]
        for side, ends in enumerate((loaded, (first, last), (loaded[0], last))):  # of the caller or the program itself
            turns = w.variable(INTEGER, "turns")
            with w.count(ends[0], ends[1], step) as i:
                w.set(turns, w.do("add_integers", w.get(turns), 1))
                w.store(out, 6 * place + 2 * side + 1, i)
            w.store(out, 6 * place + 2 * side, w.get(turns))
    before = np.full(6 * len(limits), 77)
    behind = before.copy()
    for place, limit in enumerate(limits):
        counters = range(*limit)
        behind[6 * place : 6 * place + 6 : 2] = len(counters)
        if counters:
            behind[6 * place + 1 : 6 * place + 6 : 2] = counters[-1]
    numbers = np.array([end for limit in limits for end in limit[:2]])
    return program(w.function), [numbers, before], [numbers, behind]


def primes() -> Case:
    """Loops within loops, left and gone on with early."""
    out = Storage(INTEGER, 30, True, "out")
    w = Writer("entry", out)
    count = w.variable(INTEGER, "count")
    with w.count(2, 1000) as n:
        divisor = w.variable(INTEGER, "divisor")
        w.set(divisor, 2)
        composite = w.variable(TRUTH, "composite")
        w.set(composite, False)
        test: list[Any] = []
        with w.into(test):
            d = w.get(divisor)
            small = w.do("less_equal_integers", w.do("multiply_integers", d, d), n)
        with w.loop(test, small):
            with w.when(w.do("equal_integers", w.do("modulo", n, d), 0)):
                w.set(composite, True)
                w.stop()
            w.set(divisor, w.do("add_integers", d, 1))
        with w.when(w.get(composite)):
            w.skip()
        place = w.get(count)
        w.store(out, place, n)
        w.set(count, w.do("add_integers", place, 1))
        with w.when(w.do("equal_integers", w.get(count), 30)):
            w.leave()
    sieve = [n for n in range(2, 200) if all(n % d for d in range(2, n))][:30]
    return program(w.function), [np.zeros(30, dtype=np.int64)], [np.array(sieve)]


def calls() -> Case:
    """Functions with no, one and several results, with views and an array that is given twice."""
    x, y = Value(FLOAT, "x"), Value(FLOAT, "y")
    parts = Writer("parts", x, y, results=(FLOAT, INTEGER, TRUTH), inline=True)
    less = parts.do("less", x, y)
    with parts.when(less):
        parts.leave(parts.do("subtract", y, x), 1, less)
    parts.leave(parts.do("subtract", x, y), -1, less)
    moved, source = Storage(FLOAT, 3, True, "moved"), Storage(FLOAT, 3, False, "source")
    shift = Writer("shift", moved, source, Value(FLOAT, "by"))
    by = shift.function.parameters[2]
    with shift.count(0, 3) as i:
        shift.store(moved, i, shift.do("add", shift.load(source, i), by))  # type: ignore[arg-type]
    total = Writer("total", Storage(FLOAT, 3, False, "entries"), results=(FLOAT,))
    entries = total.function.parameters[0]
    value = total.load(entries, 0)  # type: ignore[arg-type]
    for place in (1, 2):
        value = total.do("add", value, total.load(entries, place))  # type: ignore[arg-type]
    total.leave(value)
    numbers, integers, truths = (
        Storage(FLOAT, 8, True, "f"),
        Storage(INTEGER, 2, True, "i"),
        Storage(TRUTH, 2, True, "t"),
    )
    w = Writer("entry", numbers, integers, truths)
    for place in (0, 1):
        size, sign, below = w.call(parts.function, w.load(numbers, place), w.load(numbers, 1 - place))
        w.store(numbers, 6 + place, size)
        w.store(integers, place, sign)
        w.store(truths, place, below)
    first, second = w.view(numbers, 0, 3), w.view(numbers, w.do("add_integers", w.load(integers, 0), 2), 3)
    w.call(shift.function, first, first, 10.0)
    w.call(shift.function, second, first, 0.5)
    w.store(numbers, 2, *w.call(total.function, second))
    before = [np.array([1.0, 2.5, 3.0, 0, 0, 0, 0, 0]), np.zeros(2, dtype=np.int64), np.zeros(2, dtype=bool)]
    behind = [
        np.array([11.0, 12.5, 11.5 + 13.0 + 13.5, 11.5, 13.0, 13.5, 1.5, 1.5]),
        np.array([1, -1]),
        np.array([True, False]),
    ]
    return program(parts.function, shift.function, total.function, w.function), before, behind


def variables() -> Case:
    """What is set on one way only, what is set again, and what is never set."""
    numbers, integers = Storage(FLOAT, 4, True, "f"), Storage(INTEGER, 3, True, "i")
    w = Writer("entry", numbers, integers)
    x, n, t = w.variable(FLOAT, "x"), w.variable(INTEGER, "n"), w.variable(TRUTH, "t")
    never = w.variable(FLOAT, "never")
    with w.when(w.do("less", w.load(numbers, 0), 1.0)) as otherwise:
        w.set(x, w.load(numbers, 1))
        w.set(t, True)
    with w.into(otherwise):
        w.set(n, 5)
    before = w.get(x)
    w.set(x, w.do("multiply", before, 2.0))
    w.store(numbers, 1, before)
    w.store(numbers, 2, w.get(x))
    w.store(numbers, 3, w.get(never))
    w.store(integers, 0, w.get(n))
    w.store(integers, 1, w.do("integer_of_truth", w.get(t)))
    forever: list[Any] = []
    with w.loop(forever, True):
        w.set(n, w.do("add_integers", w.get(n), 3))
        with w.when(w.do("less_integers", 10, w.get(n))):
            w.store(integers, 2, w.get(n))
            w.leave()
    given = [np.array([0.5, 3.25, 9.0, 9.0]), np.array([9, 9, 9])]
    return program(w.function), given, [np.array([0.5, 3.25, 6.5, 0.0]), np.array([0, 1, 12])]


def carried() -> Case:
    """A loop of eight turns, each of which computes from the last; one is gone on from early, and one ends it."""
    start, ends = Storage(FLOAT, 3, False, "start"), Storage(INTEGER, 3, False, "ends")
    out = Storage(FLOAT, 3, True, "out")
    w = Writer("entry", start, ends, out)
    for place in range(3):
        total = w.variable(FLOAT, "total")
        w.set(total, w.load(start, place))
        with w.count(7, -1, -1) as i:
            with w.when(w.do("equal_integers", i, 4)):
                w.skip()
            w.set(total, w.do("multiply", w.do("add", w.get(total), w.do("float_of_integer", i)), 0.7))
            with w.when(w.do("equal_integers", i, w.load(ends, place))):
                w.stop()
        w.store(out, place, w.get(total))
    given, last, totals = np.array([0.3, -5.0, 1e300]), np.array([2, 9, 7]), []
    for begun, end in zip(given, last, strict=True):
        value = begun
        for turn in (7, 6, 5, 3, 2, 1, 0):
            value = (value + turn) * 0.7
            if turn == end:
                break
        totals.append(value)
    return program(w.function), [given, last, np.zeros(3)], [given, last, np.array(totals)]


SMALL: dict[str, Callable[[], Case]] = {f.__name__: f for f in (ranges, primes, calls, variables, carried)}


def of_libm() -> Case:
    """Functions of the C library, among them one that an optimiser would like to put another in the place of."""
    import math

    numbers = Storage(FLOAT, 6, True, "f")
    w = Writer("entry", numbers)
    x = w.load(numbers, 0)
    sine, power = External("sin", (FLOAT,), FLOAT), External("pow", (FLOAT, FLOAT), FLOAT)
    w.store(numbers, 1, *w.call(sine, x))
    w.store(numbers, 2, *w.call(power, x, 2.0))
    w.store(numbers, 3, *w.call(power, x, 0.5))
    w.store(numbers, 4, *w.call(External("exp", (FLOAT,), FLOAT), 1.0))
    w.store(numbers, 5, *w.call(power, 2.0, x))
    x0 = 0.7310585786300049
    behind = [x0, math.sin(x0), math.pow(x0, 2.0), math.pow(x0, 0.5), math.exp(1.0), math.pow(2.0, x0)]
    return program(w.function), [np.array([x0, 0, 0, 0, 0, 0])], [np.array(behind)]
