"""Checker of certificates of proofs over tolerances. It shares no code with the search that found them.

A certificate says that the poles of a sampled loop lie in a disc for all parameters in a box, with all factors at its
wire between two ends. Its leaves are boxes that cover the whole. Each has the open loop [A B; C D] at its corners,
bounds R of how far the closed loop may lie beyond those, a disc and a matrix T. The checker verifies, in whole numbers
of 2^-300 with every rounding counted:

1. the hash of the certificate, and that the factors and discs are those of its claim;
2. that the leaves cover the box;
3. that the closed loops at all corners and factors, with R, less the centre of the disc, have a norm below its radius r
   in the coordinates of T: r^2 I - B'B has positive leading minors, by Bareiss' elimination (Mathematics of
   Computation 22, 1968, 565).

What it takes for granted is in the certificate: that the matrices enclose those of the graph.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

FORMAT = "proofmass proof 1"
_BITS, _FEWER = 300, 80  # after the point: of matrices, and of those whose norm is below one
ONE = 1 << _BITS
_PI = Decimal("3.14159265358979323846264338327950288419716939937511")
_DIGITS = 50
_TERMS = 150  # of the series of sine and cosine: the last is below 2^-400
_SLACK = Fraction(1, 1 << 290)  # more than the errors of sine and cosine
_UNITS = {"gain margin": "dB", "phase margin": "deg", "disk margin": "", "delay margin": "s", "decay rate": "1/s"}
_DEEPEST = 200  # halves of a box

_Whole = npt.NDArray[np.object_]  # of integers
_Box = tuple[tuple[float, float], ...]


class FalseCertificateError(ValueError):
    """A certificate that proves nothing, and why."""


def check_certificate(text: str) -> list[str]:
    """Return what a certificate proves, a line each; raises `FalseCertificateError`."""
    try:
        data = json.loads(text)
        content = {key: value for key, value in data.items() if key != "sha256"}
        if data.get("format") != FORMAT:
            raise FalseCertificateError(f"is not a {FORMAT}")
        if data.get("sha256") != digest_of(content):
            raise FalseCertificateError("was changed: its hash is another")
        if not data["claims"] or not isinstance(data["graph_sha256"], str):
            raise FalseCertificateError("has no claim about a graph")
        return [_claim(data, claim) for claim in data["claims"]]
    except (TypeError, ValueError, AttributeError, LookupError, ArithmeticError, RecursionError) as error:
        if isinstance(error, FalseCertificateError):
            raise
        raise FalseCertificateError(f"cannot be read: {error}") from None


def graph_of_certificate(text: str) -> str:
    """Return the SHA-256 of the graph that a certificate is about."""
    return str(json.loads(text)["graph_sha256"])


def digest_of(content: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the content of a certificate."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def _claim(data: Mapping[str, Any], claim: Mapping[str, Any]) -> str:
    kind, limit = claim["kind"], float(claim["limit"])
    where = f"{claim['loop']}, {kind}" + ("" if kind == "stable" else f" of at least {limit:g} {_UNITS[kind]}").rstrip()
    _check_ends(claim, where)
    sides = [(float(one["low"]), float(one["high"])) for one in claim["coordinates"]]
    whole = (*sides, _side(claim["ends"]))
    boxes = [tuple(map(_side, leaf["box"])) for leaf in claim["leaves"]]
    if not _covered(whole, boxes, 0):
        raise FalseCertificateError(f"{where}: its boxes do not cover the tolerances")
    for number, (leaf, box) in enumerate(zip(claim["leaves"], boxes, strict=True)):
        _check_disc(claim, leaf, box[-1], where)
        if not _contracts(data["loops"][leaf["loop"]], leaf, box, claim["factor"]):
            raise FalseCertificateError(f"{where}: box {number} does not contract")
    sizes = [
        f"{'1 / ' * one['inverse']}{one['name']} from {one['low']:g} to {one['high']:g}" for one in claim["coordinates"]
    ]
    return f"{where}: {len(boxes)} box{'es' if len(boxes) > 1 else ''}" + "".join(f", {size}" for size in sizes)


def _side(ends: Sequence[float]) -> tuple[float, float]:
    low, high = map(float, ends)
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        raise FalseCertificateError("has a side without ends")
    return low, high


def _check_ends(claim: Mapping[str, Any], where: str) -> None:
    """Raise where the factors are fewer than those of the claim."""
    (low, high), limit = _side(claim["ends"]), Decimal(float(claim["limit"]))
    with localcontext() as context:
        context.prec = _DIGITS
        kind, factor = claim["kind"], claim["factor"]
        if not limit >= 0 or (kind in ("delay margin", "decay rate") and not claim["period"] > 0.0):
            right = False
        elif kind == "phase margin":
            right = factor == "phase" and low <= 0.0 and Decimal(high) >= limit * _PI / 180
        elif kind == "delay margin":
            samples = limit / Decimal(float(claim["period"]))
            right = factor == "phase" and low <= 0.0 and Decimal(high) >= _PI * min(samples, Decimal(2))
        elif kind == "disk margin":
            right = factor == "disk" and low == high and Decimal(low) >= limit
        else:
            gain = Decimal(10) ** (limit / 20 if kind == "gain margin" else 0)
            right = factor == "gain" and Decimal(low) * gain <= 1 and Decimal(high) >= gain
            right = right and (kind != "stable" or limit == 0)
    if not right:
        raise FalseCertificateError(f"{where}: its factors are not those of the claim")


def _check_disc(claim: Mapping[str, Any], leaf: Mapping[str, Any], factors: tuple[float, float], where: str) -> None:
    """Raise where poles in the disc of a leaf may break its claim.

    A delay of m samples turns what is at exp(-j w) by p = m w: a pole may not be there where w is above p / m. The
    distance of the arc from a centre above the real axis is least at an end of the arc.
    """
    real, imaginary, radius = map(Fraction, map(float, leaf.get("disc", (0.0, 0.0, 1.0))))
    kind, limit, period = claim["kind"], float(claim["limit"]), float(claim.get("period", 0.0))
    if kind == "delay margin" and factors[0] > 0.0:
        least = _turn(Fraction(factors[0]) * Fraction(period) / Fraction(limit))
        ends = (Fraction(-1), Fraction(0)), (least[0], -least[1])
        away = min((x - real) ** 2 + (y - imaginary) ** 2 for x, y in ends)
        right = imaginary >= 0 and radius > 0 and radius**2 <= away - _SLACK
    else:
        with localcontext() as context:
            context.prec = _DIGITS
            rate = Decimal(limit) * Decimal(period) if kind == "decay rate" else Decimal(0)
            most = (-rate).exp() * (1 - Decimal(10) ** -45) if rate else 1
            right = real == imaginary == 0 and 0 < Decimal(float(radius)) <= most
    if not right:
        raise FalseCertificateError(f"{where}: a disc is not that of the claim")


def _covered(whole: _Box, boxes: Sequence[_Box], depth: int) -> bool:
    """Return whether boxes that came of halving cover all of a box."""
    if whole in boxes:
        return True
    if len(boxes) < 2 or depth > _DEEPEST:
        return False
    for place, (low, high) in enumerate(whole):
        middle = 0.5 * low + 0.5 * high
        below = [box for box in boxes if box[place][1] <= middle]
        above = [box for box in boxes if box[place][0] >= middle]
        if low < middle < high and len(below) + len(above) == len(boxes) and below and above:
            halves = ((low, middle), below), ((middle, high), above)
            return all(_covered((*whole[:place], side, *whole[place + 1 :]), some, depth + 1) for side, some in halves)
    return False


def _contracts(loop: Mapping[str, Any], leaf: Mapping[str, Any], box: _Box, factor: str) -> bool:
    """Return whether all closed loops of a box shorten every vector in the coordinates of its T."""
    sides, parts, disk = box[:-1], 2 if factor == "phase" else 1, factor == "disk"
    wide = [i for i, (low, high) in enumerate(sides) if low < high]
    if tuple(map(_side, loop["box"])) != sides or sorted(loop["interpolated"] + loop["bounded"]) != wide:
        raise FalseCertificateError("has a loop of another box")
    n, k = int(loop["order"]), int(loop["values"])
    middles, radii = (np.array(loop["corners"][name], dtype=float) for name in ("middle", "radius"))
    if middles.shape != (2 ** len(loop["interpolated"]), n + k, n + k) or radii.shape != middles.shape:
        raise FalseCertificateError("lacks corners")
    t, beyond = (np.array(leaf[name], dtype=float) for name in ("transform", "beyond"))
    size = n + k if disk else parts * n
    if t.shape != (size, size) or beyond.shape != t.shape or (beyond < 0.0).any() or (radii < 0.0).any():
        raise FalseCertificateError("has matrices of a wrong size")
    if disk and (t[n:].tolist() != np.eye(size)[n:].tolist() or t[:n, n:].any()):
        raise FalseCertificateError("has coordinates that mix a disk with states")
    real, imaginary, radius = (int(Fraction(part) * ONE) for part in map(float, leaf.get("disc", (0, 0, 1))))
    turned = np.array([[real, -imaginary], [imaginary, real]] if parts == 2 else [[real]], dtype=object)
    centre = np.kron(turned, np.eye(size // parts, dtype=int).astype(object))
    x, t_whole = _whole(np.linalg.inv(t)), _whole(t)
    apart = np.abs(x @ t_whole - ONE * ONE * np.eye(len(t), dtype=object)) // ONE + 1
    room = radius - _bound(apart) * radius // ONE - 1
    beyond_whole = _whole(beyond) + 1
    for middle, near in zip(map(_whole, middles), map(_whole, radii), strict=True):
        for f in _factors(factor, box[-1], k):
            closed, off = _closed((middle, near + 1), f, n, parts, box[-1][1] if disk else None)
            b = x @ (closed - centre) @ t_whole // (ONE * ONE)
            unknown = np.abs(x) @ (off + beyond_whole) @ np.abs(t_whole) // (ONE * ONE) + 2
            r = (room - _bound(unknown)) >> (_BITS - _FEWER)
            b >>= _BITS - _FEWER
            r -= 2 * len(b)  # of dropping bits
            if r <= 0 or not _positive(r * r * np.eye(len(b), dtype=object) - b.T @ b):
                return False
    return True


_Rounded = tuple[_Whole, _Whole]  # a matrix, and bounds of its errors


def _closed(loop: _Rounded, f: _Rounded, n: int, parts: int, disk: float | None) -> _Rounded:
    """Return A + B E C with E = F (I - D F)^-1, a sum of as many powers as the wire has values.

    With a disk of size a it is the matrix [A + B E C, B E; a E C, a (E - I / 2)].
    """
    a, b, c, d = (
        (_repeated(loop[0][rows, columns], parts), _repeated(loop[1][rows, columns], parts))
        for rows in (slice(None, n), slice(n, None))
        for columns in (slice(None, n), slice(n, None))
    )
    e = power = f
    for _ in range(len(loop[0]) - n - 1):
        power = _times(f, _times(d, power))
        e = e[0] + power[0], e[1] + power[1]
    b, forward = _times(b, e), _times(_times(b, e), c)
    closed = a[0] + forward[0], a[1] + forward[1]
    if disk is None:
        return closed
    size = int(Fraction(disk) * ONE) * np.eye(len(e[0]), dtype=int).astype(object), 0 * e[0] + 1
    below = _times(size, _times(e, c)), _times(size, (e[0] - f[0] // 2, e[1]))
    middle, near = (np.block([[part[i] for part in row] for row in ((closed, b), below)]) for i in (0, 1))
    return middle, near


def _times(left: _Rounded, right: _Rounded) -> _Rounded:
    errors = np.abs(left[0]) @ right[1] + left[1] @ (np.abs(right[0]) + right[1])
    return left[0] @ right[0] // ONE, errors // ONE + 2


def _repeated(matrix: _Whole, parts: int) -> _Whole:
    return np.kron(np.eye(parts, dtype=int).astype(object), matrix)


def _factors(kind: str, ends: tuple[float, float], values: int) -> list[_Rounded]:
    """Return factors between which those of the claim lie, as matrices for all values of a wire in a period.

    The arc of a phase lies in the triangle of its ends and the crossing of the tangents there; where the wire has
    several values in a period, the ends alone are corners.
    """
    low, high = map(Fraction, ends)
    if kind != "phase":
        turns = [(place, Fraction(0)) for place in dict.fromkeys((low, high) if kind == "gain" else [Fraction(1)])]
    else:
        turns = [_turn(place) for place in dict.fromkeys((low, high))]
        if not high - low < 3:
            raise FalseCertificateError("has an arc without a triangle about it")
        if values == 1 and low < high:
            cosine, sine = _turn((low + high) / 2)
            stretch = 1 / _turn((high - low) / 2)[0]
            turns.append((cosine * stretch, sine * stretch))
    unit = np.eye(values, dtype=int).astype(object)
    rounded = []
    for cosine, sine in turns:
        c, s = (int(part * ONE) for part in (cosine, sine))
        matrix = np.array([[c, -s], [s, c]] if kind == "phase" else [[c]], dtype=object)
        rounded.append((np.kron(matrix, unit), np.kron(np.abs(matrix) * 0 + 4, unit)))
    return rounded


def _turn(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Return cosine and sine of an angle below 4, each to far below a whole number, by their series."""
    if not abs(angle) < 7:
        raise FalseCertificateError("has a phase beyond a turn")
    parts, term = [Fraction(0), Fraction(0)], Fraction(1)
    for order in range(_TERMS):
        parts[order % 2] += term if order % 4 < 2 else -term
        term = Fraction(int(term * angle / (order + 1) * (ONE << 60)), ONE << 60)
    return parts[0], parts[1]


def _whole(matrix: npt.NDArray[np.float64]) -> _Whole:
    """Return numbers as whole ones, rounded down."""
    if not np.isfinite(matrix).all():
        raise FalseCertificateError("has a number that is not finite")
    flat = [math.floor(Fraction(value) * ONE) for value in matrix.ravel().tolist()]
    whole = np.empty(len(flat), dtype=object)
    whole[:] = flat
    return whole.reshape(matrix.shape)


def _bound(sizes: _Whole) -> int:
    """Return at least the spectral norm of all matrices with entries of at most these sizes."""
    return math.isqrt(int(sizes.sum(axis=0).max()) * int(sizes.sum(axis=1).max())) + 1


def _positive(matrix: _Whole) -> bool:
    """Return whether a symmetric matrix of integers is positive definite: all its leading minors are positive."""
    rows, before = matrix.tolist(), 1
    for k, row in enumerate(rows):
        if row[k] <= 0:
            return False
        for other in rows[k + 1 :]:
            factor = other[k]
            other[k + 1 :] = [
                (row[k] * value - factor * mine) // before
                for value, mine in zip(other[k + 1 :], row[k + 1 :], strict=True)
            ]
        before = row[k]
    return True
