"""Products of the maps of ticks, in machine code.

Most of their numbers are zero, and there are thousands of maps: matrices of NumPy take ten times as
long.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import AnyArray, Array, Truths
from proofmass.runner.program.form import FLOAT, INTEGER, Storage, Value

NUMBER = Value(INTEGER)
CONSTANT, MOVED = (Storage(FLOAT, None, writable=writable) for writable in (False, True))
PLACES, COUNTS = (Storage(INTEGER, None, writable=writable) for writable in (False, True))
_POWER = 64  # of two, by which products are scaled where they are larger, or smaller
_LARGE, _LARGEST = 2.0**_POWER, 2.0**960
_SMALLEST = 2.0**-1022  # that has all of its digits


def run(function: Callable[..., Any], numbers: tuple[int, ...], arrays: list[AnyArray], kinds: tuple[Any, ...]) -> None:
    """Call a Python function of integers and arrays as machine code; arrays are laid out row by row."""
    arrays = [*map(np.ascontiguousarray, arrays)]  # those that it writes are so
    _code(function, len(numbers), kinds)(*numbers, *(each.ctypes.data for each in arrays))


@cache
def _code(function: Callable[..., Any], numbers: int, kinds: tuple[Any, ...]) -> Callable[..., Any]:
    # start-up time: loops of one value in a period need no compiler
    from proofmass.runner.targets.machine_code import load_python

    return load_python(function, (*(NUMBER,) * numbers, *kinds))


def joined(
    n: int, others: int, valued: Truths, tick: Indices, row: Indices, column: Indices, value: Array
) -> tuple[Array, Array, Array, Array]:
    """Return a, b, c and d of each value of a wire: ticks without one are joined to those with one.

    Take the numbers of maps of ticks that are not zero, tick by tick. Rows and columns are n
    states, the wire, and `others`, through which what comes to them goes on. In a tick these are one
    after the other.
    """
    values = int(valued.sum())
    a, b, c = np.zeros((values, n, n)), np.zeros((values, n)), np.zeros((values, n))
    places = [of.astype(np.int64) for of in (valued, tick, row, column)]
    arrays = [*places, value, np.eye(n, n + 1), np.empty((n + 1 + others, n + 1)), a, b, c]
    numbers = len(valued), len(value), n, others
    run(_join, numbers, arrays, (PLACES, (PLACES,) * 3, CONSTANT, (MOVED,) * 2, (MOVED,) * 3))
    return a, b, c, np.zeros(values)


def products(
    a: Array, b: Array, c: Array, loops: npt.NDArray[Any], steps: int
) -> tuple[npt.NDArray[Any], npt.NDArray[np.int64]]:
    """Return the product of all a + b c loop for each row of `loops`, and the power of two that it lacks.

    It is scaled after some `steps`.
    """
    (count, ticks), n = loops.shape, b.shape[1]
    rows = np.zeros((n, count, n), dtype=loops.dtype)
    rows[range(n), :, range(n)] = 1.0
    exponents = np.zeros(count, dtype=np.int64)
    arrays = [a, b, c, loops.T, rows, np.empty_like(rows), np.empty((count, n), loops.dtype), exponents]
    numbers = ticks, steps, n, count, loops.dtype.itemsize // exponents.itemsize
    run(_multiply, numbers, arrays, ((CONSTANT,) * 4, (MOVED,) * 3, COUNTS))
    return rows.transpose(1, 0, 2), exponents


def lifted(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array]:
    """Return the states at the end of a period and the values in it, by the states at its start and the values."""
    ticks, n = b.shape
    moved, read = np.eye(n, n + ticks), np.zeros((ticks, n + ticks))
    arrays = [a, b, c, d, moved, np.empty_like(moved), np.zeros(n + ticks), read]
    run(_lift, (ticks, n), arrays, ((CONSTANT,) * 4, (MOVED,) * 4))
    return moved + 0.0, read  # no zero has a sign


def repeated(a: Array, b: Array, c: Array) -> Truths:
    """Return whether each value but the first is that of the tick before, whatever the states and the input.

    It is if its row says so to the last bit.
    """
    ticks, n = b.shape
    found = np.zeros(ticks, dtype=np.int64)
    run(_compare, (ticks, n), [a, b, c, found], ((CONSTANT,) * 3, COUNTS))
    return np.asarray(found[1:] != 0)


def held(a: Array, b: Array, each: int) -> tuple[Array, Array]:
    """Return the maps of so many ticks with the same value."""
    ticks, n = b.shape
    value, rows = np.zeros(n + 1), np.zeros((n, n + 1))
    value[n] = 1.0
    made = np.zeros((ticks // each, n, n + 1))
    arrays = [a, b, value, rows, np.empty_like(rows), made]
    run(_hold, (len(made), each, n), arrays, ((CONSTANT,) * 3, (MOVED,) * 3))
    return made[:, :, :n], made[:, :, n]


# -- functions of programs -------------------------------------------------------------------------


def _join(
    ticks: int, count: int, n: int, others: int, valued: Any, places: Any, numbers: Any, room: Any, maps: Any
) -> None:
    """Multiply the maps of ticks between values of the wire: [A b] of what has happened since one."""
    (of_tick, row, column), (since, after), (a, b, c) = places, room, maps
    wide, entry, value = n + 1, 0, -1
    for tick in range(ticks + 1):
        has = tick < ticks and valued[tick] != 0
        if has or tick == ticks:
            if value >= 0:
                for i in range(n):
                    b[value * n + i] = since[i * wide + n]
                    for j in range(n):
                        a[(value * n + i) * n + j] = since[i * wide + j]
                for at in range(n * wide):
                    since[at] = 1.0 if at % (wide + 1) == 0 else 0.0
            value += 1
        for at in range((n + 1 + others) * wide):
            after[at] = 0.0
        first = entry
        while entry < count and of_tick[entry] == tick:
            entry += 1
        for turn in range(others + 1):
            for k in range(first, entry):
                to, of, number = row[k], column[k], numbers[k]
                if to == n + 1 + turn or (turn == others and to <= n):
                    if of < n:
                        for j in range(wide):
                            after[to * wide + j] += number * since[of * wide + j]
                    elif of > n:
                        for j in range(wide):
                            after[to * wide + j] += number * after[of * wide + j]
                    elif has:
                        after[to * wide + n] += number
        for at in range(n * wide):
            since[at] = after[at]
        if has:
            for j in range(n):
                c[value * n + j] = after[n * wide + j]


def move(k: int, n: int, wide: int, a: Any, b: Any, given: Any, rows: Any, after: Any) -> None:
    """Move rows of states on by the map of a value: a x + b u, side by side."""
    for i in range(n):
        entered = b[k * n + i]
        for w in range(wide):
            after[i * wide + w] = entered * given[w]
        for j in range(n):
            moved = a[(k * n + i) * n + j]
            if moved != 0.0:
                for w in range(wide):
                    after[i * wide + w] += moved * rows[j * wide + w]
    for at in range(n * wide):
        rows[at] = after[at]


def _compare(ticks: int, n: int, maps: Any, found: Any) -> None:
    """Tell of each value whether its row is that of the value before, taken one tick on."""
    a, b, c = maps
    for k in range(ticks - 1):
        entered, same = 0.0, True
        for i in range(n):
            entered += c[(k + 1) * n + i] * b[k * n + i]
        for j in range(n):
            shown = 0.0
            for i in range(n):
                read = c[(k + 1) * n + i]
                if read != 0.0:
                    shown += read * a[(k * n + i) * n + j]
            same = same and shown == c[k * n + j]
        found[k + 1] = 1 if same and entered == 0.0 else 0


def _hold(values: int, each: int, n: int, maps: Any, room: Any) -> None:
    """Multiply the maps of the ticks of each value: [A b] of what happens while it is held."""
    (a, b, value), (rows, after, made) = maps, room
    wide = n + 1
    for held_value in range(values):
        for at in range(n * wide):
            rows[at] = 1.0 if at % (wide + 1) == 0 else 0.0
        for k in range(held_value * each, (held_value + 1) * each):
            move(k, n, wide, a, b, value, rows, after)
            for at in range(n * wide):
                if abs(rows[at]) < _SMALLEST:  # rounding would keep it from going on to zero
                    rows[at] = 0.0
        for at in range(n * wide):
            made[held_value * n * wide + at] = rows[at]


def _multiply(ticks: int, steps: int, n: int, count: int, numbers: int, maps: Any, room: Any, exponents: Any) -> None:
    """Multiply products by the maps of all values.

    A complex number is two `numbers`, one after the other. After some `steps` large and small products
    are scaled.
    """
    (a, b, c, loops), (rows, after, back) = maps, room
    each = n * numbers
    wide = count * each
    for k in range(ticks):
        for w in range(wide):
            back[w] = 0.0
        for i in range(n):
            read = c[k * n + i]
            if read != 0.0:
                for w in range(wide):
                    back[w] += read * rows[i * wide + w]
        for of in range(count):
            loop = (k * count + of) * numbers
            for at in range(of * each, (of + 1) * each, numbers):
                if numbers == 1:
                    back[at] *= loops[loop]
                else:
                    real, imaginary = back[at], back[at + 1]
                    back[at] = real * loops[loop] - imaginary * loops[loop + 1]
                    back[at + 1] = real * loops[loop + 1] + imaginary * loops[loop]
        move(k, n, wide, a, b, back, rows, after)
        if (k + 1) % steps == 0 or k + 1 == ticks:
            for of in range(count):
                largest, scale = 0.0, 1.0
                for i in range(n):
                    for at in range(i * wide + of * each, i * wide + (of + 1) * each):
                        largest = max(largest, abs(rows[at]))
                while _LARGE < largest * scale < math.inf:
                    scale /= _LARGE
                    exponents[of] += _POWER
                while 0.0 < largest * scale < 1.0 / _LARGE and scale < _LARGEST:
                    scale *= _LARGE
                    exponents[of] -= _POWER
                if scale != 1.0:
                    for i in range(n):
                        for at in range(i * wide + of * each, i * wide + (of + 1) * each):
                            rows[at] *= scale


def _lift(ticks: int, n: int, maps: Any, made: Any) -> None:
    """Write what states and values depend on: the states at the start, and the values before."""
    (a, b, c, d), (moved, after, given, read) = maps, made
    wide = n + ticks
    for k in range(ticks):
        now, value = k * wide, n + k
        for i in range(n):
            shown = c[k * n + i]
            if shown != 0.0:
                for w in range(value):
                    read[now + w] += shown * moved[i * wide + w]
        read[now + value] = d[k]
        given[value] = 1.0
        move(k, n, wide, a, b, given, moved, after)
        given[value] = 0.0
