"""Checker of certificates of proofs over tolerances. It shares no code with the search that found them.

A certificate says that the poles of a loop lie in a disc, in continuous time in a half plane, for all parameters in a
box and all factors at its wire between two ends. Its leaves are boxes that cover the whole. Each has the open loop
[A B; C D] at its corners, bounds of how far the closed loop M may lie beyond those, a disc and a matrix T. That these
enclose what the graph has is taken for granted. Verified is, in whole numbers of 2^-300 with every rounding counted:

1. the hash, that factors and discs are those of the claim, that leaves cover the box, and that under any change of the
   parameters from period to period all leaves of a range of factors have one T;
2. that all M = A + B E C, E = F (I - D F)^-1, less the centre of the disc, have a norm below its radius r in the
   coordinates of T: r^2 I - B'B has positive leading minors (Bareiss, Math. Comp. 22, 1968, 565). Of a half plane
   Re (1 + j r) (s - c) < 0, G + G' is negative there, G = (1 + j r) (M - c);
3. of a scale factor or bias D + C (I - A)^-1 B that A and I - R M have such norms, M = [I - A, -B; -C, g - D] with the
   limit g. Then det M has the sign of det R, and is a positive number times g less the scale factor;
4. of a peak g that [A, B; C / g, D / g], of a disk a that [M, B E; a E C, a (E - I / 2)] has one that leaves the
   last as they are (bounded real lemma); in continuous time G is [A, B, 0; 0, -I / 2, 0; C, D, -I / 2] of these;
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
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

FORMAT = "proofmass proof 1"
_FEWER, ONE = 80, 1 << 300  # bits after the point where numbers are alike, half of them; 1.0
_PI = Decimal("3.14159265358979323846264338327950288419716939937511")
_DIGITS, _TERMS = 50, 150  # of decimals; of the series of sine and cosine, whose last is below 2^-400
_BIAS, _NOISE, _PEAK = "bias", "noise", "peak"
_SETTLED, _MATRICES = ("scale factor", _BIAS), ("transform", "beyond", "left", "noise")
_UNITS: dict[str, str | None] = dict.fromkeys((*_SETTLED, _NOISE, _PEAK)) | {"stable": "", "disk margin": ""}
_UNITS |= {"gain margin": "dB", "phase margin": "deg", "delay margin": "s", "decay rate": "1/s"}
_FACTORS = dict.fromkeys(_SETTLED, "rest") | {"disk margin": "disk", _NOISE: "noise", _PEAK: "peak"}

_Whole = npt.NDArray[np.object_]  # of integers
_Rounded = Sequence[_Whole]  # a matrix, and bounds of its errors
_Box = tuple[tuple[float, float], ...]
_unit: Any = partial(np.eye, dtype=object)


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


def digest_of(content: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the content of a certificate."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def _claim(data: Mapping[str, Any], claim: Mapping[str, Any]) -> str:
    kind, limit, unit = claim["kind"], float(claim["limit"]), _UNITS[claim["kind"]]
    at_rest, changes = kind == _BIAS or claim.get("at_rest") is True, bool(claim.get("any_change"))
    most = kind in (_NOISE, _PEAK) or (kind in _SETTLED and claim["most"] is True)
    where = f"{' to '.join(filter(None, [claim['loop'], claim['open_at'] * (unit is None)]))}, {kind}"
    size = repr(limit) if unit is None else f"{limit:g} {unit}".rstrip()
    where += (kind != "stable") * f" of at {'most' if most else 'least'} {size}" + " at rest" * at_rest
    where += " in continuous time" * (claim.get("continuous") is True) + " under any change" * changes
    _check_ends(claim, where)
    sides = tuple(_side((one["low"], one["high"])) for one in claim["coordinates"])
    boxes = [tuple(map(_side, leaf["box"])) for leaf in claim["leaves"]]
    _refuse(not _covered((*sides, _side(claim["ends"])), boxes), f"{where}: its boxes do not cover the tolerances")
    norms = sorted({(box[-1], str(leaf["transform"])) for box, leaf in zip(boxes, claim["leaves"], strict=True)})
    apart = all(one[0][1] <= other[0][0] and one[0] != other[0] for one, other in itertools.pairwise(norms))
    apart &= not at_rest and kind not in ("delay margin", *_SETTLED)
    _refuse(changes and not apart, f"{where}: no norm serves all of the tolerances")
    for i, (leaf, box) in enumerate(zip(claim["leaves"], boxes, strict=True)):
        _refuse(not _has_disc(claim, leaf, box[-1]), f"{where}: a disc is not that of the claim")
        loop = data["loops"][leaf["loop"]]
        _refuse(at_rest != ("rest" in loop and _rests(loop["rest"])), f"{where}: no point of rest is enclosed")
        proved = _contracts(loop, leaf, box, claim)
        _refuse(not proved, f"{where}: box {i} does not contract, or lies on the other side")
    named = [f"{'1 / ' * c['inverse']}{c['name']} from {c['low']:g} to {c['high']:g}" for c in claim["coordinates"]]
    return ", ".join([f"{where}: {len(boxes)} box{'es' * (len(boxes) > 1)}", *named])


def _side(ends: Sequence[float]) -> tuple[float, float]:
    low, high = map(float, ends)
    _refuse(not (math.isfinite(low) and math.isfinite(high) and low <= high), "has a side without ends")
    return low, high


def _check_ends(claim: Mapping[str, Any], where: str) -> None:
    """Raise where the factors are fewer than those of the claim."""
    (low, high), factor, kind = map(Decimal, _side(claim["ends"])), claim["factor"], claim["kind"]
    limit, period = Decimal(float(claim["limit"])), Decimal(float(claim.get("period", 0.0)))
    samples = Decimal(2) if claim.get("continuous") is True else limit / period if period > 0 else Decimal(-1)
    if kind in ("phase margin", "delay margin"):
        most = limit / 180 if kind == "phase margin" else min(samples, Decimal(2))
        right = factor == "phase" and low <= 0 and high >= _PI * most >= 0
    elif kind in _FACTORS:
        right = factor == _FACTORS[kind] and low == high >= limit and (low == limit or factor == "disk")
    else:
        gain = Decimal(10) ** (limit / 20 if kind == "gain margin" else 0)
        right = factor == "gain" and low * gain <= 1 and high >= gain
        right &= (kind != "stable" or limit == 0) and (kind != "decay rate" or samples >= 0)
    _refuse(not right or not (limit >= 0 or kind in _SETTLED), f"{where}: its factors are not those of the claim")


def _has_disc(claim: Mapping[str, Any], leaf: Mapping[str, Any], factors: tuple[float, float]) -> bool:
    """Return whether poles in the disc of a leaf keep its claim: of a delay it leaves out an arc, near at its ends."""
    continuous, kind = claim.get("continuous") is True, claim["kind"]
    real, imaginary, radius = (Fraction(float(part)) for part in leaf["half_plane" if continuous else "disc"])
    limit, period = (Fraction(float(claim.get(name, 0.0))) for name in ("limit", "period"))
    first = Fraction(factors[0]) / limit if kind == "delay margin" and factors[0] > 0.0 else 0  # 1/s
    if continuous:
        near = real <= (-limit if kind == "decay rate" else 0) and -first <= imaginary <= 0 <= radius
        return _UNITS[kind] is not None and near and (radius == 0 or first > 0)
    if first:
        least = _turn(first * period)
        away = min((x - real) ** 2 + (y - imaginary) ** 2 for x, y in ((-1, 0), (least[0], -least[1])))
        return imaginary >= 0 and radius > 0 and radius**2 <= away - Fraction(1, 1 << 290)  # rounding
    rate = Decimal(float(limit)) * Decimal(float(period)) * (kind == "decay rate")
    return real == imaginary == 0 and 0 < Decimal(float(radius)) <= (-rate).exp() - (rate != 0) * Decimal(10) ** -46


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


def _contracts(loop: Mapping[str, Any], leaf: Mapping[str, Any], box: _Box, claim: Mapping[str, Any]) -> bool:
    """Return whether all closed loops of a box shorten every vector in the coordinates of its T, on their side."""
    factor, falls, sides, limit = claim["factor"], claim.get("continuous") is True, box[:-1], box[-1][1]
    parts, wide = 2 if factor == "phase" else 1, [i for i, (low, high) in enumerate(sides) if low < high]
    same = tuple(map(_side, loop["box"])) == sides and sorted(loop["interpolated"] + loop["bounded"]) == wide
    n, k, inputs = (int(loop.get(name, loop["values"])) for name in ("order", "values", "inputs"))
    middles, radii = (np.array(loop["corners"][name], dtype=float) for name in ("middle", "radius"))
    t, beyond, left, noise = (np.array(leaf.get(name, []), dtype=float) for name in _MATRICES)
    size = {"disk": n + k, "noise": n + k, "peak": n + k, "rest": 2 * n + k}.get(factor, parts * n)
    right = {"rest": left.shape == (n + 1, n + 1), "noise": noise.shape == (n + k, inputs)}.get(factor, inputs == k)
    right &= n >= 0 and middles.shape == radii.shape == (2 ** len(loop["interpolated"]), n + k, n + inputs)
    right &= t.shape == beyond.shape == (size, size) and not any((part < 0).any() for part in (beyond, radii, noise))
    right &= not falls or not (middles[:, n:, n:].any() or radii[:, n:, n:].any())
    _refuse(not (right and same), "has a loop of another box, or matrices that do not fit")
    beside = [slice(n)] * (n > 0) + [slice(n, None)] if factor == "rest" else [slice(None)]
    turns, left, noise, more = [(part, *_turned(t[part, part])) for part in beside], *map(_whole, (left, noise, beyond))
    still = size - n if factor in ("disk", "noise", "peak") else 0  # last coordinates, which T leaves as they are
    mixed = still and any((m[:n, n:] != 0).any() or (m[n:] != ONE * _unit(size)[n:]).any() for m in turns[0][1:3])
    _refuse(bool(mixed), "has a norm that does not leave inputs and outputs as they are")
    real, imaginary, radius = (int(Fraction(float(u)) * ONE) for u in leaf["half_plane" if falls else "disc"])
    pairs = (np.array([[u, -v], [v, u]], dtype=object) for u, v in ((real, imaginary), (ONE, radius * falls)))
    centre, tilt = (np.kron(pair[:parts, :parts], _unit(size // parts)) for pair in pairs)
    for middle, near in zip(map(_whole, middles), map(_whole, radii), strict=True):
        for f in _factors(factor, box[-1], k):
            closed, off = _closed((middle, near + 1), f, n, factor, limit, left)
            closed, off = _times([tilt, 0 * tilt], [closed - centre, off + 1])
            for part, x, back, apart in turns:
                inner = closed[part, part], (off + more + 1)[part, part]
                if not _holds(_times(_times((x, 0 * x), inner), (back, 0 * back)), apart, radius, falls, still):
                    return False
                if factor == "noise":
                    entering = np.abs(x @ middle[:, n:]) + np.abs(x) @ (near[:, n:] + noise + 3)
                    if ((entering // ONE + 2) ** 2).sum() > (Fraction(limit) * ONE) ** 2:
                        return False
    return factor != "rest" or ([*_minors(left)][-1] > 0) == (claim["most"] is True)


def _holds(near: _Rounded, apart: _Whole, radius: int, falls: bool, still: int) -> bool:
    """Return whether all X M T shorten, or fall with two of each that is still, X being `apart` from 1 / T."""
    (m, unknown), n, unit = near, len(apart) - still, _unit(len(apart) + still)
    if falls:
        unknown = unknown + apart.T @ (np.abs(m) + unknown) // ONE + 1
        m, unknown = (np.delete(unit, slice(n, len(m)), 1) @ part @ unit[: len(m)] for part in (m, unknown))
        g, unknown = ONE * unit * (np.arange(len(unit)) >= n) - m - m.T, unknown + unknown.T
    else:
        room = max(radius - _bound(apart) * radius // ONE - 1 - _bound(unknown), 0)
        g, unknown = room * room * _unit(len(m)) - m.T @ m, 0 * m
    alike = np.array([Fraction(2) ** (_FEWER - value.bit_length() // 2) for value in g.diagonal().tolist()])
    g, unknown = (part * alike * alike[:, None] // 1 for part in (g, unknown))
    return all(minor > 0 for minor in _minors(g - (_bound(unknown + 1) + len(g)) * _unit(len(g))))


def _rests(rest: Mapping[str, Any]) -> bool:
    """Return whether each sensor of a box has one point of rest within r of a centre."""
    names = "reach", "step", "step_radius", "left", "matrix", "matrix_radius"
    r, b, near, *square = (_whole(np.array(rest[name], dtype=float)) for name in names)
    left, j, off = (part.reshape(len(r), len(r)) for part in square)
    _refuse(not r.shape == b.shape == near.shape or bool((near < 0).any() or (off < 0).any()), "has no point of rest")
    apart = np.abs(ONE * ONE * _unit(len(r)) - left @ (ONE * _unit(len(r)) - j)) + np.abs(left) @ (off + 2)
    return bool(((np.abs(left @ b) + np.abs(left) @ (near + 2)) * ONE + apart @ r < ONE * ONE * r).all())


def _turned(t: npt.NDArray[np.float64]) -> tuple[_Whole, _Whole, _Whole]:
    """Return a matrix near the inverse of T, T, and bounds of what their product differs by from the unit matrix."""
    scale = np.maximum(np.abs(t).max(axis=1), 1e-300)
    x, whole = _whole(np.linalg.inv(t / scale[:, None]) / scale), _whole(t)
    return x, whole, np.abs(x @ whole - ONE * ONE * _unit(len(t))) // ONE + 1


def _closed(opened: _Rounded, f: _Rounded, n: int, factor: str, limit: float, left: _Whole) -> _Rounded:
    """Return M, or what stands for it: E is a sum of as many powers as the wire has values."""
    halves = [(slice(n), slice(n)), (slice(n), slice(n, None)), (slice(n, None), slice(n)), (slice(n, None),) * 2]
    a, b, c, d = ([np.kron(_unit(2 if factor == "phase" else 1), part[place]) for part in opened] for place in halves)
    if factor == "rest":
        border = np.diag(np.array([ONE] * n + [math.floor(Fraction(limit) * ONE)], dtype=object))
        rest = left @ (opened[0] - border) // ONE + ONE * _unit(n + 1), np.abs(left) @ (opened[1] + 1) // ONE + 2
        empty = [0 * part[:n] for part in opened]
        return _joined([[a, empty], [[part.T for part in empty], rest]])
    if factor == "noise":
        return _joined([[a, [0 * part.T for part in c]], [c, [0 * (part @ part.T) for part in c]]])
    e = power = f
    for _ in range(len(opened[0]) - n - 1):
        power = _times(f, _times(d, power))
        e = e[0] + power[0], e[1] + power[1]
    b_e = _times(b, e)
    closed = [own + forward for own, forward in zip(a, _times(b_e, c), strict=True)]
    if factor not in ("disk", "peak"):
        return closed
    scale = int(Fraction(limit) ** (1 if factor == "disk" else -1) * ONE) * _unit(len(f[0])), 0 * f[0] + 1
    rows = [[a, b], [c, d]] if factor == "peak" else [[closed, b_e], [_times(e, c), (e[0] - f[0] // 2, e[1])]]
    return _joined([rows[0], [_times(scale, part) for part in rows[1]]])


def _joined(rows: Sequence[Sequence[Sequence[_Whole]]]) -> _Rounded:
    return [np.block([[part[i] for part in row] for row in rows]) for i in (0, 1)]


def _times(left: Sequence[_Whole], right: Sequence[_Whole]) -> _Rounded:
    errors = np.abs(left[0]) @ right[1] + left[1] @ (np.abs(right[0]) + right[1])
    return left[0] @ right[0] // ONE, errors // ONE + 2


def _factors(kind: str, ends: tuple[float, float], values: int) -> list[_Rounded]:
    """Return factors between which those of a claim lie: of an arc the ends, and the crossing of its tangents."""
    (low, high), parts = map(Fraction, ends), 2 if kind == "phase" else 1
    turns: list[Any] = [_turn(at) if kind == "phase" else (at if kind == "gain" else 1, 0) for at in {low, high}]
    _refuse(kind == "phase" and not high - low < 3, "has an arc without a triangle about it")
    if kind == "phase" and values == 1 and low < high:
        turns.append([part / _turn((high - low) / 2)[0] for part in _turn((low + high) / 2)])
    pairs = (np.array([[c, -s], [s, c]], dtype=object)[:parts, :parts] * ONE // 1 for c, s in turns)
    return [(row := np.kron(pair, _unit(values)), 0 * row + 4) for pair in pairs]


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
    """Yield the leading minors of a matrix of integers: the last is its determinant, where rows were added too."""
    rows, before = matrix.copy(), 1
    for k in range(len(rows)):
        yield rows[k, k]
        for other in rows[k + 1 :]:
            if not rows[k, k]:  # the determinant stays
                rows[k] += other
        crossed = np.outer(rows[k + 1 :, k], rows[k, k + 1 :])
        rows[k + 1 :, k + 1 :] = (rows[k, k] * rows[k + 1 :, k + 1 :] - crossed) // before
        before = rows[k, k]
