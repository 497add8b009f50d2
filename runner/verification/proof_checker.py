"""Checker of certificates of proofs over tolerances. It shares no code with the search that found them.

A certificate says that the poles of a sampled loop lie in a disc for all parameters in a box, with all factors at its
wire between two ends. Its leaves are boxes that cover the whole. Each has the open loop [A B; C D] at its corners,
bounds of how far the closed loop may lie beyond those, a disc and a matrix T. That these enclose what the graph has is
taken for granted. The checker verifies, in whole numbers of 2^-300 with every rounding counted:

1. the hash of the certificate, that factors and discs are those of its claim, and that the cores of leaves cover all;
   where parameters change, that a leaf m follows k only after N periods, which shorten more than its norm lengthens:
   |T_m^-1 T_k| r_k^N < 1, N = floor(h / d) + 1, for a way h from a core to the end of its box and steps of at most d;
2. that the closed loops at all corners and factors, with the bounds, less the centre of the disc, have a norm below its
   radius r in the coordinates of T: r^2 I - B'B has positive leading minors (Bareiss, Math. Comp. 22, 1968, 565);
3. of a scale factor or bias D + C (I - A)^-1 B that A and I - R M have such norms, M = [I - A, -B; -C, g - D] with the
   limit g. Then det M has the sign of det R, and is a positive number times g less the scale factor;
4. of a peak that [A, B; C / g, D / g] has one that leaves inputs and outputs as they are (bounded real lemma);
5. of noise that [A; C] has one, outputs left as they are, and that the squares of [T^-1 B; D] add up to the limit's;
6. at rest that |R b| + |I - R (I - J)| r < r, entry by entry, for all steps b and slopes J of a box (Krawczyk).
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
import numpy.typing as npt

FORMAT = "proofmass proof 1"
_BITS, _FEWER, ONE = 300, 80, 1 << 300  # after the point: of matrices, and of those whose norm is below one; 1.0
_PI = Decimal("3.14159265358979323846264338327950288419716939937511")
_DIGITS, _TERMS = 50, 150  # of decimals; of the series of sine and cosine, whose last is below 2^-400
_SLACK = Fraction(1, 1 << 290)  # more than the errors of sine and cosine
_CIRCLE, _MOST_PERIODS = (0.0, 0.0, 1.0), 10**9  # a disc; for which a norm is kept, or more
_BIAS, _NOISE, _PEAK = "bias", "noise", "peak"
_UNITS = {"gain margin": " dB", "phase margin": " deg", "delay margin": " s", "decay rate": " 1/s"}
_SETTLED = ("scale factor", _BIAS)
_FACTORS = dict.fromkeys(_SETTLED, "rest") | {"disk margin": "disk", _NOISE: "noise", _PEAK: "peak"}

_Whole = npt.NDArray[np.object_]  # of integers
_Rounded = Sequence[_Whole]  # a matrix, and bounds of its errors
_Norm = tuple[_Whole, _Whole, int]  # T, a matrix near its inverse, and a bound of how near
_Box = tuple[tuple[float, float], ...]
_Data = Mapping[str, Any]


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
    upper, at_rest = kind in (_NOISE, _PEAK), kind == _BIAS or claim.get("at_rest") is True
    of_output, most = upper or kind in _SETTLED, upper or (kind in _SETTLED and claim["most"] is True)
    where = f"{' to '.join(filter(None, [claim['loop'], claim['open_at'] * of_output]))}, {kind}"
    size = repr(limit) if of_output else f"{limit:g}{_UNITS.get(kind, '')}"
    where += (kind != "stable") * f" of at {'most' if most else 'least'} {size}" + " at rest" * at_rest
    sides = [_side((one["low"], one["high"])) for one in claim["coordinates"]]
    steps = [Fraction(b) - Fraction(a) for a, b in sides] if any_change else [*map(Fraction, claim.get("changes", ()))]
    moves = any_change or bool(steps)
    where += f" under {'any' if any_change else 'slow'} change" * moves
    _check_ends(claim, where)
    leaves = [(tuple(map(_side, leaf["box"])), leaf, data["loops"][leaf["loop"]]) for leaf in claim["leaves"]]
    covered = _covered((*sides, _side(claim["ends"])), [box for box, _, _ in leaves])
    _refuse(not covered, f"{where}: its boxes do not cover the tolerances")
    for number, (box, leaf, loop) in enumerate(leaves):
        _refuse(not _has_disc(claim, leaf, box[-1]), f"{where}: a disc is not that of the claim")
        _refuse(at_rest != ("rest" in loop and _rests(loop["rest"])), f"{where}: no point of rest is enclosed")
        contracts = _contracts(loop, leaf, box, claim["factor"], most)
        _refuse(not contracts, f"{where}: box {number} does not contract, or lies on the other side")
    stays = at_rest or kind in ("delay margin", *_SETTLED)
    wrong = moves and (stays or any(_too_soon(claim, steps, *pair) for pair in itertools.permutations(leaves, 2)))
    _refuse(wrong, f"{where}: no norm serves all of the tolerances, or follows another so soon")
    named = [f"{'1 / ' * c['inverse']}{c['name']} from {c['low']:g} to {c['high']:g}" for c in claim["coordinates"]]
    slow = [f" by at most {float(step):g} a period" for step in steps] if moves else [""] * len(named)
    return ", ".join([f"{where}: {len(leaves)} box{'es' * (len(leaves) > 1)}", *map(str.__add__, named, slow)])


def _side(ends: Sequence[float]) -> tuple[float, float]:
    low, high = map(float, ends)
    _refuse(not (math.isfinite(low) and math.isfinite(high) and low <= high), "has a side without ends")
    return low, high


def _check_ends(claim: _Data, where: str) -> None:
    """Raise where the factors are fewer than those of the claim."""
    (low, high), factor, kind = map(Decimal, _side(claim["ends"])), claim["factor"], claim["kind"]
    limit, period = Decimal(float(claim["limit"])), Decimal(float(claim.get("period", 0.0)))
    if kind in ("phase margin", "delay margin"):
        most = limit / 180 if kind == "phase margin" else min(limit / period, Decimal(2))
        right = factor == "phase" and low <= 0 and high >= _PI * most
    elif kind in _FACTORS:
        right = factor == _FACTORS[kind] and low == high >= limit and (low == limit or factor == "disk")
    else:
        gain = Decimal(10) ** (limit / 20 if kind == "gain margin" else 0)
        right = factor == "gain" and low * gain <= 1 and high >= gain
    right &= (limit >= 0 or kind in _SETTLED) and (period > 0 or kind not in ("delay margin", "decay rate"))
    _refuse(not right, f"{where}: its factors are not those of the claim")


def _has_disc(claim: _Data, leaf: _Data, factors: tuple[float, float]) -> bool:
    """Return whether poles in the disc of a leaf keep its claim: of a delay it leaves out an arc, near at its ends."""
    real, imaginary, radius = map(Fraction, map(float, leaf.get("disc", _CIRCLE)))
    kind, limit, period = claim["kind"], float(claim["limit"]), float(claim.get("period", 0.0))
    if kind == "delay margin" and factors[0] > 0.0:
        least = _turn(Fraction(factors[0]) * Fraction(period) / Fraction(limit))
        ends = (Fraction(-1), Fraction(0)), (least[0], -least[1])
        away = min((x - real) ** 2 + (y - imaginary) ** 2 for x, y in ends)
        return imaginary >= 0 and radius > 0 and radius**2 <= away - _SLACK
    return real == imaginary == 0 and 0 < Decimal(float(radius)) <= _radius(claim)


def _radius(claim: _Data) -> Decimal:
    """Return that of the disc about zero in which all poles have to lie."""
    rate = Decimal(float(claim["limit"])) * Decimal(float(claim.get("period", 0.0)))
    return (-rate).exp() * (1 - Decimal(10) ** -45) if claim["kind"] == "decay rate" else Decimal(1)


def _too_soon(claim: _Data, steps: Sequence[Fraction], one: Sequence[Any], after: Sequence[Any]) -> bool:
    """Return whether a leaf may follow another before that one shortens by more than the norm of the next lengthens."""
    times = list[int]()
    for core, side, there, step in zip(
        one[0], (*one[2]["box"], one[0][-1]), after[0], (*steps, Fraction(0)), strict=True
    ):
        (a, b), (first, last), (low, high) = (map(Fraction, ends) for ends in (core, side, there))
        apart = max(first, low) - min(last, high)
        if apart > step or (apart == step == 0 and core != there):  # of what stays one side of a common end is enough
            return False
        times += [
            way // step + 1 for way, beyond in ((a - first, low < first), (last - b, high > last)) if beyond and step
        ]
    norm, other = (_norm(np.array(leaf["transform"], dtype=float)) for leaf in (one[1], after[1]))
    if not times or np.array_equal(norm[0], other[0]) or claim["kind"] in (_NOISE, _PEAK):
        return bool(times) and not np.array_equal(norm[0], other[0])
    part = Decimal(float(one[1].get("disc", _CIRCLE)[2])) / _radius(claim)
    room = (ONE << _FEWER) // (int(part ** min(*times, _MOST_PERIODS) * (1 << _FEWER)) + 2)
    return not _is_shorter((ONE * _unit(len(norm[0])), 0 * norm[0]), norm, other, room)


def _is_shorter(matrix: _Rounded, norm: _Norm, after: _Norm, room: int) -> bool:
    """Return whether a matrix leaves of every vector less than `room`, in the norms before and after."""
    back, x = norm[0][: matrix[0].shape[1]], after[1]
    b, unknown = x @ matrix[0] @ back // (ONE * ONE), np.abs(x) @ matrix[1] @ np.abs(back) // (ONE * ONE) + 2
    r = (room - after[2] * room // ONE - 1 - _bound(unknown)) >> (_BITS - _FEWER)
    r, b = r - 2 * len(b), b >> (_BITS - _FEWER)  # of dropping bits
    return r > 0 and all(minor > 0 for minor in _minors(r * r * _unit(b.shape[1]) - b.T @ b))


def _covered(whole: _Box, boxes: Sequence[_Box]) -> bool:
    """Return whether boxes that came of halving cover all of a box."""
    for place, (low, high) in enumerate(whole):
        middle = 0.5 * low + 0.5 * high
        below = [box for box in boxes if box[place][1] <= middle]
        above = [box for box in boxes if box[place][0] >= middle]
        if low < middle < high and len(below) + len(above) == len(boxes) and below and above:
            halves = ((low, middle), below), ((middle, high), above)
            return all(_covered((*whole[:place], side, *whole[place + 1 :]), some) for side, some in halves)
    return whole in boxes


def _contracts(loop: _Data, leaf: _Data, box: _Box, factor: str, most: bool) -> bool:
    """Return whether all closed loops of a box shorten every vector in the coordinates of its T, on their side."""
    sides, parts, limit = box[:-1], 2 if factor == "phase" else 1, box[-1][1]
    whole = [*map(_side, loop["box"])]
    holds = all(low <= a and b <= high for (a, b), (low, high) in zip(sides, whole, strict=True))
    holds &= sorted(loop["interpolated"] + loop["bounded"]) == [i for i, (low, high) in enumerate(whole) if low < high]
    n, k, inputs = (int(loop.get(name, loop["values"])) for name in ("order", "values", "inputs"))
    middles, radii = (np.array(loop["corners"][name], dtype=float) for name in ("middle", "radius"))
    t, beyond = (np.array(leaf[name], dtype=float) for name in ("transform", "beyond"))
    size = {"disk": n + k, "noise": n + k, "peak": n + k, "rest": 2 * n + k}.get(factor, parts * n)
    left, noise = (_whole(np.array(leaf.get(name, []), dtype=float)) for name in ("left", "noise"))
    right = {"rest": left.shape == (n + 1, n + 1), "noise": noise.shape == (n + k, inputs)}.get(factor, inputs == k)
    right &= n >= 0 and middles.shape == radii.shape == (2 ** len(loop["interpolated"]), n + k, n + inputs)
    right &= t.shape == beyond.shape == (size, size) and not any((part < 0).any() for part in (beyond, radii, noise))
    mixed = factor in ("disk", "noise", "peak") and (t[n:].tolist() != np.eye(size)[n:].tolist() or t[:n, n:].any())
    _refuse(bool(mixed) or not (right and holds), "has a loop of another box, or matrices that do not fit")
    real, imaginary, radius = (int(Fraction(part) * ONE) for part in map(float, leaf.get("disc", _CIRCLE)))
    turned = np.array([[real, -imaginary], [imaginary, real]], dtype=object)[:parts, :parts]
    centre, more = np.kron(turned, _unit(size // parts)), _whole(beyond) + 1
    beside = [part for part in (slice(n), slice(n, None)) if len(t[part])] if factor == "rest" else [slice(None)]
    norms = [(part, _norm(t[part, part])) for part in beside]
    for middle, near in zip(map(_whole, middles), map(_whole, radii), strict=True):
        for f in _factors(factor, box[-1], k):
            closed = _closed((middle, near + 1), f, n, factor, limit, left)
            for part, norm in norms:
                moved = [(closed[0] - centre)[part, part], (closed[1] + more)[part, part]]
                if not _is_shorter(moved, norm, norm, radius):
                    return False
        if factor == "noise":
            x = norms[0][1][1]
            entering = np.abs(x @ middle[:, n:]) + np.abs(x) @ (near[:, n:] + noise + 3)
            mixed = x[:n, n:].any() or (x[n:] != ONE * _unit(size)[n:]).any()
            if mixed or ((entering // ONE + 2) ** 2).sum() > (Fraction(limit) * ONE) ** 2:
                return False
    return factor != "rest" or ([*_minors(left)][-1] > 0) == most


def _rests(rest: _Data) -> bool:
    """Return whether each sensor of a box has one point of rest within r of a centre."""
    names = "reach", "step", "step_radius", "left", "matrix", "matrix_radius"
    r, b, near, *square = (_whole(np.array(rest[name], dtype=float)) for name in names)
    left, j, off = (part.reshape(len(r), len(r)) for part in square)
    _refuse(not r.shape == b.shape == near.shape or bool((near < 0).any() or (off < 0).any()), "has no point of rest")
    apart = np.abs(ONE * ONE * _unit(len(r)) - left @ (ONE * _unit(len(r)) - j)) + np.abs(left) @ (off + 2)
    return bool(((np.abs(left @ b) + np.abs(left) @ (near + 2)) * ONE + apart @ r < ONE * ONE * r).all())


def _norm(t: npt.NDArray[np.float64]) -> _Norm:
    """Return the norm of a matrix T: how long T^-1 x is."""
    scale = np.maximum(np.abs(t).max(axis=1), 1e-300)
    x, whole = _whole(np.linalg.inv(t / scale[:, None]) / scale), _whole(t)
    return whole, x, _bound(np.abs(x @ whole - ONE * ONE * _unit(len(t))) // ONE + 1)


def _closed(opened: _Rounded, f: _Rounded, n: int, factor: str, limit: float, left: _Whole) -> _Rounded:
    """Return A + B E C with E = F (I - D F)^-1, a sum of as many powers as the wire has values.

    A disk of size a has [A + B E C, B E; a E C, a (E - I / 2)], a peak of g [A, B; C / g, D / g], noise [A 0; C 0].
    """
    parts = [(rows, columns) for rows in (slice(n), slice(n, None)) for columns in (slice(n), slice(n, None))]
    a, b, c, d = ([np.kron(_unit(2 if factor == "phase" else 1), one[part]) for one in opened] for part in parts)
    if factor == "rest":
        border = ONE * _unit(n + 1)
        border[n, n] = math.floor(Fraction(limit) * ONE)
        rest = left @ (opened[0] - border) // ONE + ONE * _unit(n + 1), np.abs(left) @ (opened[1] + 1) // ONE + 2
        return _joined(a, [0 * one[:n] for one in opened], [0 * one[:n].T for one in opened], rest)
    if factor == "noise":
        return _joined(a, [0 * one.T for one in c], c, [0 * (one @ one.T) for one in c])
    if factor == "peak":
        return _joined(a, b, _scaled(1 / Fraction(limit), c), _scaled(1 / Fraction(limit), d))
    e = power = f
    for _ in range(len(opened[0]) - n - 1):
        power = _times(f, _times(d, power))
        e = _sum(e, power)
    closed, size = _sum(a, _times(_times(b, e), c)), Fraction(limit)
    if factor != "disk":
        return closed
    return _joined(closed, _times(b, e), _scaled(size, _times(e, c)), _scaled(size, [e[0] - f[0] // 2, e[1]]))


def _joined(a: _Rounded, b: _Rounded, c: _Rounded, d: _Rounded) -> _Rounded:
    return [np.block([[a[i], b[i]], [c[i], d[i]]]) for i in (0, 1)]


def _sum(left: _Rounded, right: _Rounded) -> _Rounded:
    return [left[0] + right[0], left[1] + right[1]]


def _times(left: _Rounded, right: _Rounded) -> _Rounded:
    errors = np.abs(left[0]) @ right[1] + left[1] @ (np.abs(right[0]) + right[1])
    return [left[0] @ right[0] // ONE, errors // ONE + 2]


def _scaled(by: Fraction, matrix: _Rounded) -> _Rounded:
    return _times([int(by * ONE) * _unit(len(matrix[0])), _unit(len(matrix[0]))], matrix)


def _unit(size: int) -> _Whole:
    return np.eye(size, dtype=int).astype(object)


def _factors(kind: str, ends: tuple[float, float], values: int) -> list[_Rounded]:
    """Return factors between which those of the claim lie, as matrices for all values of a wire in a period.

    The arc of a phase lies in the triangle of its ends and the crossing of the tangents there, if a wire has one value.
    """
    low, high = map(Fraction, ends)
    turns: list[Any] = [_turn(at) if kind == "phase" else (at if kind == "gain" else 1, 0) for at in {low, high}]
    _refuse(kind == "phase" and not high - low < 3, "has an arc without a triangle about it")
    if kind == "phase" and values == 1 and low < high:
        stretch = 1 / _turn((high - low) / 2)[0]
        turns.append([part * stretch for part in _turn((low + high) / 2)])
    pairs = ([int(part * ONE) for part in turn] for turn in turns)
    rows = [np.array([[c, -s], [s, c]] if kind == "phase" else [[c]], dtype=object) for c, s in pairs]
    return [(np.kron(matrix, _unit(values)), np.kron(0 * matrix + 4, _unit(values))) for matrix in rows]


def _turn(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Return cosine and sine of an angle below 4, each to far below a whole number, by their series."""
    _refuse(not abs(angle) < 7, "has a phase beyond a turn")
    parts, term = [Fraction(0), Fraction(0)], Fraction(1)
    for order in range(_TERMS):
        parts[order % 2] += term if order % 4 < 2 else -term
        term = Fraction(int(term * angle / (order + 1) * (ONE << 60)), ONE << 60)
    return parts[0], parts[1]


def _whole(matrix: npt.NDArray[np.float64]) -> _Whole:
    """Return numbers as whole ones, rounded down; raises an error for what is not finite."""
    flat = [math.floor(Fraction(value) * ONE) for value in matrix.ravel().tolist()]
    return np.array(flat, dtype=object).reshape(matrix.shape)


def _bound(sizes: _Whole) -> int:
    """Return at least the spectral norm of all matrices with entries of at most these sizes."""
    return math.isqrt(int(sizes.sum(axis=0).max()) * int(sizes.sum(axis=1).max())) + 1


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
            factor, rest = below[k], zip(below[k + 1 :], row[k + 1 :], strict=True)
            below[k + 1 :] = [(row[k] * value - factor * mine) // before for value, mine in rest]
        before = row[k]
