"""Checker of certificates of proofs over tolerances. It shares no code with the search that found them.

A certificate says that the poles of a sampled loop lie in a disc for all parameters and factors between their ends. Its
leaves have the open loop [A B; C D] at the corners of a box, bounds of how far closed ones may lie beyond, a disc and a
matrix T. That these enclose those of the graph is taken for granted. In whole numbers of 2^-300 the checker verifies:

1. the hash of the certificate, that factors and discs are those of its claim, and that the leaves cover all;
2. that the closed loops at all corners and factors, with the bounds, less the centre of the disc, have a norm below its
   radius r in the coordinates of T: r^2 I - B'B has positive leading minors (Bareiss, Math. Comp. 22, 1968, 565);
3. of a scale factor or bias D + C (I - A)^-1 B that A and I - R M have such norms, M = [I - A, -B; -C, g - D] with the
   limit g. Then det M has the sign of det R, and is a positive number times g less the scale factor;
4. of a peak that [A, B; C / g, D / g] has one that leaves inputs and outputs as they are (bounded real lemma);
5. of noise that [A; C] has one, outputs left as they are, and that the squares of [T^-1 B; D] add up to the limit's;
6. at rest that |R b| + |I - R (I - J)| r < r, entry by entry, for all steps b and slopes J of a box (Krawczyk);
7. where parameters move by at most d in a period, that a leaf m follows k only if |T_m^-1 T_k| r_k^N < 1, after N =
   floor(h / d) + 1 periods, h from the leaf to the end of its box beyond which m lies (dwell time; Morse, 1996).
"""

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np

FORMAT = "proofmass proof 1"
_BITS, _FEWER, ONE = 300, 80, 1 << 300  # after the point: of matrices, and of those whose norm is below one; 1.0
_PI = Decimal("3.14159265358979323846264338327950288419716939937511")
_DIGITS, _TERMS = 50, 150  # of decimals; of the series of sine and cosine, whose last is below 2^-400
_SLACK = Fraction(1, 1 << 290)  # more than the errors of sine and cosine
_CIRCLE, _MOST_PERIODS = (0.0, 0.0, 1.0), 10**9  # a disc; for which a norm is kept, or more
_TURN = np.array([[0, -1], [1, 0]], dtype=object)  # the imaginary unit
_FACTORS = {"stable": "gain", "gain margin": "gain", "decay rate": "gain", "phase margin": "phase"}
_FACTORS |= {"delay margin": "phase", "disk margin": "disk", "scale factor": "rest", "bias": "rest"}
_FACTORS |= {"noise": "noise", "peak": "peak"}
_UNITS = {"gain margin": " dB", "phase margin": " deg", "delay margin": " s", "decay rate": " 1/s"}
_Whole = np.ndarray[Any, np.dtype[np.object_]]  # of integers; where it has three sides, a matrix and its errors
_Box = tuple[tuple[float, float], ...]
_Data = Mapping[str, Any]
_Leaf = tuple[_Box, _Data, _Data]  # what it covers, it, and its loop with the box in which its norm serves


class FalseCertificateError(Exception):
    """A certificate that proves nothing, and why."""


def check_certificate(text: str) -> list[str]:
    """Return what a certificate proves, a line each; raises `FalseCertificateError`."""
    try:
        data = json.loads(text)
        content = {key: value for key, value in data.items() if key != "sha256"}
        _refuse(data.get("format") != FORMAT, f"is not a {FORMAT}")
        _refuse(data.get("sha256") != digest_of(content), "was changed: its hash is another")
        _refuse(not data["claims"] or not isinstance(data["graph_sha256"], str), "has no claim about a graph")
        with localcontext(prec=_DIGITS):
            return [_claim(data, claim) for claim in data["claims"]]
    except (TypeError, ValueError, AttributeError, LookupError, ArithmeticError, RecursionError) as error:
        raise FalseCertificateError(f"cannot be read: {error}") from None


def _refuse(wrong: bool, why: str) -> None:
    if wrong:
        raise FalseCertificateError(why)


def digest_of(content: _Data) -> str:
    """Return the SHA-256 of the content of a certificate."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def _claim(data: _Data, claim: _Data) -> str:
    kind, limit, any_change = claim["kind"], float(claim["limit"]), claim.get("any_change") is True
    factor, at_rest = _FACTORS[kind], kind == "bias" or claim.get("at_rest") is True
    of_output = factor in ("rest", "noise", "peak")
    most = of_output and (factor != "rest" or claim["most"] is True)
    sides = [_side((one["low"], one["high"])) for one in claim["coordinates"]]
    steps = [Fraction(b) - Fraction(a) for a, b in sides] if any_change else [*map(Fraction, claim.get("changes", ()))]
    moves = any_change or bool(steps)
    where = f"{' to '.join(filter(None, [claim['loop'], claim['open_at'] * of_output]))}, {kind}"
    size = repr(limit) if of_output else f"{limit:g}{_UNITS.get(kind, '')}"
    where += (kind != "stable") * f" of at {'most' if most else 'least'} {size}" + " at rest" * at_rest
    where += f" under {'any' if any_change else 'slow'} change" * moves
    _check_ends(claim, where)
    leaves = [(tuple(map(_side, leaf["box"])), leaf, data["loops"][leaf["loop"]]) for leaf in claim["leaves"]]
    covered = _covered((*sides, _side(claim["ends"])), [core for core, _, _ in leaves])
    _refuse(not covered, f"{where}: its boxes do not cover the tolerances")
    for number, (core, leaf, loop) in enumerate(leaves):
        _refuse(not 0 < _disc(claim, leaf, core[-1]) <= 1, f"{where}: a disc is not that of the claim")
        _refuse(at_rest != ("rest" in loop and _rests(loop["rest"])), f"{where}: no point of rest is enclosed")
        contracts = _contracts(loop, leaf, core, factor, most)
        _refuse(not contracts, f"{where}: box {number} does not contract, or lies on the other side")
    stays = at_rest or factor == "rest" or kind == "delay margin" or min(steps, default=0) < 0
    wrong = moves and (stays or any(_too_soon(claim, steps, *pair) for pair in itertools.permutations(leaves, 2)))
    _refuse(wrong, f"{where}: no norm serves all of the tolerances, or follows another so soon")
    named = [f"{'1 / ' * c['inverse']}{c['name']} from {c['low']:g} to {c['high']:g}" for c in claim["coordinates"]]
    if moves:
        named = [f"{one} by at most {float(step):g} a period" for one, step in zip(named, steps, strict=True)]
    return ", ".join([f"{where}: {len(leaves)} box{'es' * (len(leaves) > 1)}", *named])


def _side(ends: Sequence[float]) -> tuple[float, float]:
    low, high = map(float, ends)
    _refuse(not -math.inf < low <= high < math.inf, "has a side without ends")
    return low, high


def _check_ends(claim: _Data, where: str) -> None:
    """Raise where the factors are fewer than those of the claim."""
    (low, high), kind, factor = map(Decimal, _side(claim["ends"])), claim["kind"], _FACTORS[claim["kind"]]
    limit, period = Decimal(float(claim["limit"])), Decimal(float(claim.get("period", 0.0)))
    right = (limit >= 0 or factor == "rest") and (period > 0 or kind not in ("delay margin", "decay rate"))
    if right and factor == "phase":
        right = low <= 0 and high >= _PI * (limit / 180 if kind == "phase margin" else min(limit / period, Decimal(2)))
    elif factor == "gain":
        gain = Decimal(10) ** (limit / 20 if kind == "gain margin" else 0)
        right &= low * gain <= 1 and high >= gain and (kind != "stable" or limit == 0)
    else:
        right &= low == high >= limit and (low == limit or factor == "disk")
    _refuse(not right or claim["factor"] != factor, f"{where}: its factors are not those of the claim")


def _disc(claim: _Data, leaf: _Data, factors: tuple[float, float]) -> Decimal:
    """Return how large a disc is, of that which its claim needs: of a delay it leaves out an arc, near at its ends."""
    real, imaginary, radius = map(Fraction, map(float, leaf.get("disc", _CIRCLE)))
    kind, limit, period = claim["kind"], float(claim["limit"]), float(claim.get("period", 0.0))
    if kind == "delay margin" and factors[0] > 0.0:
        x, y = _turn(Fraction(factors[0]) * Fraction(period) / Fraction(limit))
        away = min((1 + real) ** 2 + imaginary**2, (x - real) ** 2 + (y + imaginary) ** 2)
        return Decimal(imaginary >= 0 and radius > 0 and radius**2 <= away - _SLACK)
    most = (-Decimal(limit) * Decimal(period)).exp() * (1 - Decimal(10) ** -45) if kind == "decay rate" else 1
    return Decimal(float(radius)) / most if real == imaginary == 0 else Decimal(0)


def _too_soon(claim: _Data, steps: Sequence[Fraction], one: _Leaf, after: _Leaf) -> bool:
    """Return whether a leaf may follow another before that one shortens by more than the norm of the next lengthens."""
    (cores, leaf, loop), (others, following, _), times = one, after, list[int]()
    for core, box, there, step in zip(cores, (*loop["box"], cores[-1]), others, (*steps, Fraction(0)), strict=True):
        (a, b), (first, last), (low, high) = (map(Fraction, ends) for ends in (core, box, there))
        apart = max(first, low) - min(last, high)
        if apart > step or (apart == step == 0 and core != there):  # of what stays one side of a common end is enough
            return False
        ways = [a - first] * (low < first) + [last - b] * (high > last)
        times += [way // step + 1 for way in ways if step]
    same = leaf["transform"] == following["transform"]
    if same or not times or claim["kind"] in ("noise", "peak"):
        return bool(times) and not same
    left = _disc(claim, leaf, cores[-1]) ** min(*times, _MOST_PERIODS) * (1 << _FEWER)
    t, norm = _whole(leaf["transform"]), _norm(_whole(following["transform"]))
    return not _is_shorter(np.stack([ONE * _unit(len(t)), 0 * t]), t, norm, (ONE << _FEWER) // (int(left) + 2))


def _is_shorter(matrix: _Whole, t: _Whole, after: tuple[_Whole, _Whole], room: int) -> bool:
    """Return whether a matrix leaves of every vector less than `room`, in the norms before, of T, and after."""
    x, apart = after
    off = np.abs(x) @ matrix[1] @ np.abs(t) // (ONE * ONE) + apart * room // ONE + 3
    unknown = math.isqrt(int(off.sum(axis=0).max()) * int(off.sum(axis=1).max())) + 1  # at least their spectral norm
    b = x @ matrix[0] @ t >> (3 * _BITS - _FEWER)
    r = ((room - unknown) >> (_BITS - _FEWER)) - 2 * len(b)  # of dropping bits
    return r > 0 and all(minor > 0 for minor in _minors(r * r * _unit(len(b)) - b.T @ b))


def _covered(whole: _Box, boxes: Sequence[_Box]) -> bool:
    """Return whether boxes that came of halving cover all of a box."""
    for place, (low, high) in enumerate(whole):
        middle = 0.5 * low + 0.5 * high
        below, above = ([b for b in boxes if b[place][1] <= middle], [b for b in boxes if b[place][0] >= middle])
        if low < middle < high and len(below) + len(above) == len(boxes) and below and above:
            halves = ((low, middle), below), ((middle, high), above)
            return all(_covered((*whole[:place], side, *whole[place + 1 :]), some) for side, some in halves)
    return whole in boxes


def _contracts(loop: _Data, leaf: _Data, box: _Box, factor: str, most: bool) -> bool:
    """Return whether all closed loops of a box shorten every vector in the coordinates of its T, on their side."""
    whole, parts, limit = [*map(_side, loop["box"])], 2 if factor == "phase" else 1, Fraction(box[-1][1])
    holds = all(low <= a and b <= high for (a, b), (low, high) in zip(box[:-1], whole, strict=True))
    holds &= sorted(loop["interpolated"] + loop["bounded"]) == [i for i, (low, high) in enumerate(whole) if low < high]
    n, k, inputs = (int(loop.get(name, loop["values"])) for name in ("order", "values", "inputs"))
    middles, radii = (_whole(loop["corners"][name]) for name in ("middle", "radius"))
    t, beyond, left, noise = (_whole(leaf.get(name, [])) for name in ("transform", "beyond", "left", "noise"))
    size = {"disk": n + k, "noise": n + k, "peak": n + k, "rest": 2 * n + k}.get(factor, parts * n)
    holds &= {"rest": left.shape == (n + 1, n + 1), "noise": noise.shape == (n + k, inputs)}.get(factor, inputs == k)
    holds &= n >= 0 and middles.shape == radii.shape == (2 ** len(loop["interpolated"]), n + k, n + inputs)
    holds &= t.shape == beyond.shape == (size, size) and not any((part < 0).any() for part in (beyond, radii, noise))
    still = slice(n if factor in ("disk", "noise", "peak") else size, None)  # inputs and outputs, as they are
    holds = bool(holds) and not ((t - ONE * _unit(size))[still].any() or t[:n, still].any())
    _refuse(not holds, "has a loop of another box, or matrices that do not fit")
    real, imaginary, radius = (int(Fraction(part) * ONE) for part in map(float, leaf.get("disc", _CIRCLE)))
    centre = real * _unit(parts) + imaginary * _TURN[:parts, :parts]
    away = np.stack([np.kron(centre, _unit(size // parts)), -beyond - 1])
    places = [slice(n), slice(n, None)][n == 0 :] if factor == "rest" else [slice(size)]
    norms = [(i, _norm(t[i, i])) for i in places]
    for corner in np.stack([middles, radii + 1], axis=1):
        for f in _factors(factor, box[-1], k):
            moved = _closed(corner, f, n, factor, limit, left) - away
            if not all(_is_shorter(moved[:, i, i], t[i, i], norm, radius) for i, norm in norms):
                return False
    if factor == "noise":
        x = norms[0][1][0]
        mixed = (x - ONE * _unit(size))[still].any() or x[:n, still].any()
        entering = (np.abs(x @ middles[:, :, n:]) + np.abs(x) @ (radii[:, :, n:] + noise + 3)) // ONE + 2
        return not mixed and all(squares.sum() <= (limit * ONE) ** 2 for squares in entering**2)
    return factor != "rest" or ([*_minors(left)][-1] > 0) == most


def _rests(rest: _Data) -> bool:
    """Return whether each sensor of a box has one point of rest within r of a centre."""
    r, b, near = (_whole(rest[key]) for key in ("reach", "step", "step_radius"))
    left, j, off = (_whole(rest[key]) for key in ("left", "matrix", "matrix_radius"))
    fits = r.shape == b.shape == near.shape and left.shape == j.shape == off.shape == 2 * r.shape
    apart = np.abs(ONE * ONE * _unit(len(r)) - left @ (ONE * _unit(len(r)) - j)) + np.abs(left) @ (np.abs(off) + 2)
    needed = (np.abs(left @ b) + np.abs(left) @ (np.abs(near) + 2)) * ONE + apart @ r
    return fits and bool((needed < ONE * ONE * r).all())


def _norm(t: _Whole) -> tuple[_Whole, _Whole]:
    """Return a matrix near the inverse of T, and bounds of how near: the norm is the length of T^-1 x."""
    near = (t / ONE).astype(float)
    scale = np.maximum(np.abs(near).max(axis=1), 1e-300)
    x = _whole(np.linalg.inv(near / scale[:, None]) / scale)
    return x, np.abs(x @ t - ONE * ONE * _unit(len(t))) // ONE + 1


def _closed(opened: _Whole, f: _Whole, n: int, factor: str, limit: Fraction, left: _Whole) -> Any:
    """Return A + B E C with E = F (I - D F)^-1; of a disk of size a [A + B E C, B E; a E C, a (E - I / 2)]."""
    ends, k = (slice(n), slice(n, None)), opened.shape[1] - n
    if factor == "noise":
        return np.concatenate([opened[:, :, :n], np.zeros((2, n + k, k), dtype=object)], axis=2)
    if factor == "rest":
        border = np.diag([ONE] * n + [math.floor(limit * ONE)])
        rest = left @ (opened[0] - border) // ONE + ONE * _unit(n + 1), np.abs(left) @ (opened[1] + 1) // ONE + 2
        return np.block([[opened[:, :n, :n], 0 * opened[:, :n]], [0 * opened[:, :n].swapaxes(1, 2), np.stack(rest)]])
    a, b, c, d = (np.kron(_unit(f.shape[1] // k), opened[:, rows, columns]) for rows in ends for columns in ends)
    e = power = f
    for _ in range(k - 1):
        power = _times(f, _times(d, power))
        e = e + power
    closed, half = a + _times(_times(b, e), c), np.stack([f[0] // 2, 0 * f[0]])
    if factor in ("gain", "phase"):
        return closed
    whole = opened if factor == "peak" else np.block([[closed, _times(b, e)], [_times(e, c), e - half]])
    scale = np.diag([ONE] * n + [int((1 / limit if factor == "peak" else limit) * ONE)] * k)
    return _times(np.stack([scale, _unit(n + k)]), whole)


def _times(left: _Whole, right: _Whole) -> _Whole:
    errors = np.abs(left[0]) @ right[1] + left[1] @ (np.abs(right[0]) + right[1])
    return np.stack([left[0] @ right[0] // ONE, errors // ONE + 2])


def _unit(size: int) -> _Whole:
    return np.eye(size, dtype=int).astype(object)


def _factors(kind: str, ends: tuple[float, float], values: int) -> list[_Whole]:
    """Return factors between which those of the claim lie, as matrices for all values of a wire in a period."""
    (low, high), parts = map(Fraction, ends), 2 if kind == "phase" else 1
    turns = [_turn(at) if parts == 2 else (at if kind == "gain" else Fraction(1), 0) for at in {low, high}]
    _refuse(parts == 2 and not high - low < 3, "has an arc without a triangle about it")
    if parts == 2 and values == 1 and low < high:  # the arc lies in a triangle: its ends, where their tangents cross
        real, imaginary = _turn((low + high) / 2)
        turns.append((real / _turn((high - low) / 2)[0], imaginary / _turn((high - low) / 2)[0]))
    near = [int(x * ONE) * _unit(parts) + int(y * ONE) * _TURN[:parts, :parts] for x, y in turns]
    return [np.kron(np.stack([one, 0 * one + 4]), _unit(values)) for one in near]


def _turn(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Return cosine and sine of an angle below 4, each to far below a whole number, by their series."""
    _refuse(not abs(angle) < 7, "has a phase beyond a turn")
    parts, term = [Fraction(0), Fraction(0)], Fraction(1)
    for order in range(_TERMS):
        parts[order % 2] += term if order % 4 < 2 else -term
        term = Fraction(int(term * angle / (order + 1) * (ONE << 60)), ONE << 60)
    return parts[0], parts[1]


def _whole(rows: Any) -> _Whole:
    """Return doubles as whole numbers, rounded down; raises an error for what is not finite."""
    return np.asarray(np.frompyfunc(lambda value: math.floor(Fraction(value) * ONE), 1, 1)(np.array(rows, dtype=float)))


def _minors(matrix: _Whole) -> Iterator[int]:
    """Yield the leading minors of a matrix of integers: the last is its determinant, where rows were exchanged too."""
    rows, before = matrix.tolist(), 1
    for k, row in enumerate(rows):
        yield row[k]
        other = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if other is None:
            return
        if other > k:  # one of them with another sign: the determinant stays
            rows[k], rows[other] = rows[other], [-value for value in row]
        row = rows[k]
        for below in rows[k + 1 :]:
            rest = zip(below[k + 1 :], row[k + 1 :], strict=True)
            below[k + 1 :] = [(row[k] * value - below[k] * mine) // before for value, mine in rest]
        before = row[k]
