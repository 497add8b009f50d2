"""Checker of certificates of fixed point. It shares no code with the search, nor with the checker of norms.

    r' = A r + B w + c,   y = C r + D w + d,   low <= w <= high

A certificate has the registers r at the start and this map of them over a period, in rational
numbers. It has the ends of what enters as w: inputs, and an error wherever bits are dropped.
Numbers y have ranges, under which the map is that of the blocks. That all of this is that of the
graph is taken for granted. In whole numbers of 2^-300 it verifies:

1. that each y, which is a whole number, keeps its range as long as the map holds: then all of them do in every period,
   by induction, and nothing overflows;
2. of a rounding error, that errors by themselves, all that is not exact, move an output by at most
the limit.

What moves r is B w, and by itself r' - r of the start. With |w| the size of both, y moves by a sum
of C A^m w:

- Each power comes from the one before, rounded down to 2^-300. What is dropped travels as A does. So N powers together
  are off by at most 2 N 2^-300 times the sums of the columns of G, the sum of all |A^m|.
- With Y = G (|w| + 1) and |A^N| Y <= t Y, powers from N on move r by at most Y t / (1 - t).
- N grows until the claim is shown, or t is next to nothing. Registers that nothing moves, or that y does not follow,
  are left out: they need not decay.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

ONE, _NOTHING = 1 << 300, 1 << 236  # 1.0 with 300 bits after the point; a rest of 2^-64
_GROWN = 1 << 500  # sums of powers that do not decay
_POWERS, _WORK = 1 << 19, 4 * 10**9  # at most, and products of numbers for them, which take minutes
_Ends = tuple[Any, Any]
_Numbers = np.ndarray[Any, np.dtype[np.object_]]
_Within = Callable[[int, Fraction, Fraction], bool]  # may a number, by place, have these ends


def check_digital(claim: Mapping[str, Any]) -> tuple[str, bool]:
    """Return what a claim says, and whether it holds; raises Python's error for unreadable ones."""
    kind, inputs = claim["kind"], [(str(one["signal"]), *_ends(one["ends"])) for one in claim["inputs"]]
    start = np.array([_number(value) for value in claim["start"]], dtype=object)
    entering, errors = [inputs[place][1:] for place in claim["entering"]], [_ends(one) for one in claim["errors"]]
    counts = {"register": len(start), "input": len(entering), "error": len(errors)}
    names = [f"{name} {i}" for name, count in counts.items() for i in range(count)]
    following, conditions, outputs = (_rows(claim[key], names) for key in ("following", "conditions", "outputs"))
    ranges, said = [_ends(one) for one in claim["ranges"]], [kind]

    def in_range(place: int, low: Fraction, high: Fraction) -> bool:
        return bool(ranges[place][0] <= math.ceil(low) and math.floor(high) <= ranges[place][1])

    def near(_: int, low: Fraction, high: Fraction) -> bool:
        return (step := _number(claim["step"])) > 0 and max(-low, high) * step <= Fraction(float(claim["limit"]))

    holds = kind in ("no overflow", "rounding error") and len(following) == len(start)
    holds &= all(-math.inf < low <= high < math.inf for low, high in (*entering, *errors))
    holds &= len(conditions) == len(ranges)
    holds = holds and _all_within(in_range, conditions, following, start, [*entering, *errors])
    if kind == "rounding error":
        said = [f"{kind} of {claim['output']} of at most {float(claim['limit'])!r}"]
        ends, alone = [(0, 0)] * len(entering) + errors, np.array([1] * len(names) + [0])  # without constants
        holds = holds and len(outputs) > 0 and _all_within(near, outputs * alone, following * alone, 0 * start, ends)
    said += [f"{signal} from {low} to {high} steps" for signal, low, high in inputs]
    return ", ".join(said), holds


def _ends(pair: Sequence[Any]) -> _Ends:
    """Return two ends; infinite where there is none."""
    low, high = pair
    return -math.inf if low is None else _number(low), math.inf if high is None else _number(high)


def _number(text: Any) -> Fraction:
    """Return a number from its digits, such as "-3/16"."""
    numerator, _, denominator = str(text).partition("/")
    return Fraction(int(numerator), int(denominator or 1))


def _rows(forms: Sequence[Mapping[str, Any]], names: Sequence[str]) -> _Numbers:
    """Return the factors of all names in some forms, and the constants last."""
    unknown = {name for form in forms for name in form} - {*names, ""}
    if unknown:
        raise ValueError(f"it has no {min(unknown)}")
    rows = [[_number(form.get(name, 0)) for name in (*names, "")] for form in forms]
    return np.array(rows, dtype=object).reshape(len(forms), len(names) + 1)


def _all_within(within: _Within, forms: _Numbers, following: _Numbers, start: _Numbers, ends: Sequence[_Ends]) -> bool:
    """Return whether all values of some forms, with what enters, keep their ranges."""
    n, sides = len(start), np.array(ends, dtype=object).reshape(-1, 2).T
    a, c = following[:, :n], forms[:, :n]
    first = (a * start).sum(axis=1) + following[:, -1] - start
    moves = np.stack([np.column_stack([following[:, n:-1] * side, first]) for side in sides])
    at_once = np.sort(np.stack([forms[:, n:-1] * side for side in sides]), axis=0).sum(axis=2)
    at_once = at_once + (c * start).sum(axis=1) + forms[:, -1]
    followed = (a != 0) | np.eye(n, dtype=bool)
    for _ in range(n.bit_length()):
        followed = followed @ followed
    moving = followed @ (moves != 0).any(axis=(0, 2))
    needed = [tuple(np.flatnonzero(moving & followed[row != 0].any(axis=0)).tolist()) for row in c]
    groups: dict[tuple[int, ...], list[int]] = {}
    for place in sorted(range(len(c)), key=lambda one: -len(needed[one])):
        wider = next((some for some in groups if {*needed[place]} <= {*some}), needed[place])
        groups.setdefault(wider, []).append(place)
    return all(
        any(
            all(map(within, places, low + at_once[0, places], high + at_once[1, places]))
            for low, high in _moved(a[np.ix_(some, some)], moves[:, some], c[np.ix_(places, some)])
        )
        for some, places in groups.items()
    )


def _moved(a: _Numbers, moves: _Numbers, c: _Numbers) -> Iterator[tuple[_Numbers, _Numbers]]:
    """Yield ends of what C r moves by, nearer and nearer."""
    if max(abs(np.linalg.eigvals(a.astype(float))), default=0.0) >= 1.0:  # to refuse soon what does not decay
        return
    (a, parts), (moves, steps), (c, shares) = map(_whole, (a, moves, c))
    n, unit, sizes = len(a), ONE * steps * shares, np.abs(moves).max(axis=0).sum(axis=1) + steps
    onward, below, above = (_Product(matrix) for matrix in (a, *moves))
    powers = np.vstack([ONE * np.eye(n, dtype=object), ONE * c])
    g, total, low, high, due = 0 * powers[:n], np.zeros((2, len(c)), dtype=object), 0, 0, 1
    work = 1 + len(powers) * (n + int((a != 0).sum() + (moves != 0).sum()))
    for count in range(1, min(_POWERS, 2 + _WORK // work)):
        responses = np.stack([product.of(powers[n:]) for product in (below, above)])
        total = total + np.sort(responses, axis=0).sum(axis=2)
        low, high = np.minimum(low, total[0]), np.maximum(high, total[1])
        g, powers = g + np.abs(powers[:n]), onward.of(powers) // parts
        if count < due:
            continue
        due += count // 8 + 1
        off = 2 * count * g.sum(axis=0) // ONE + 1
        y = (g + off) @ sizes
        t = max([0, *((np.abs(powers[:n]) + off) @ y // y + 1)])
        if t < ONE:
            beyond = (np.abs(c) * y).sum(axis=1) * t // (ONE - t) + (off * sizes).sum() + 1
            yield (low - beyond) * Fraction(1, unit), (high + beyond) * Fraction(1, unit)
        if t < _NOTHING or (g > _GROWN).any():
            return


def _whole(numbers: _Numbers) -> tuple[_Numbers, int]:
    """Return numbers as whole numbers of a part of one, and how many parts one has."""
    parts = math.lcm(*(one.denominator for one in numbers.ravel().tolist()))
    return np.asarray(np.frompyfunc(lambda one: int(one * parts), 1, 1)(numbers), dtype=object), parts


class _Product:
    """Products with a matrix of few numbers."""

    def __init__(self, right: _Numbers) -> None:
        self._width = right.shape[1]
        self._numbers = [(int(i), int(j), right[i, j]) for i, j in zip(*np.nonzero(right), strict=True)]

    def of(self, left: _Numbers) -> _Numbers:
        """Return the product with a matrix on the left."""
        product = np.zeros((self._width, len(left)), dtype=object)
        columns = left.T.copy()
        for i, j, number in self._numbers:
            product[j] += columns[i] * number
        return product.T
