"""Checker of certificates of proofs over tolerances. It shares no code with the search that found them.

A certificate says that the poles of a sampled loop lie in a disc for all parameters in a box, with all factors at its
wire between two ends. Its leaves are boxes that cover the whole. Each has the open loop [A B; C D] at its corners,
bounds of how far the closed loop may lie beyond those, a disc and a matrix T. That these enclose what the graph has is
taken for granted. The checker verifies, in whole numbers of 2^-300 with every rounding counted:

1. the hash of the certificate, that the factors and discs are those of its claim, and that the cores of leaves cover it;
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
_CIRCLE, _MOST_PERIODS = (0.0, 0.0, 1.0), 10**9
_BIAS, _NOISE, _PEAK = "bias", "noise", "peak"
_UNITS = {"stable": "", "disk margin": "", "gain margin": "dB", "phase margin": "deg", "delay margin": "s"}
_UNITS |= {"decay rate": "1/s"}
_SETTLED = ("scale factor", _BIAS)
_FACTORS = dict.fromkeys(_SETTLED, "rest") | {"disk margin": "disk", _NOISE: "noise", _PEAK: "peak"}

_Whole = npt.NDArray[np.object_]  # of integers
_Rounded = tuple[_Whole, _Whole]  # a matrix, and bounds of its errors
_Box = tuple[tuple[float, float], ...]
_Kept = tuple[Mapping[str, Any], _Box, _Box]  # a leaf, the box in which its norm serves, and its core


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
    kind, limit = claim["kind"], float(claim["limit"])
    upper, at_rest = kind in (_NOISE, _PEAK), kind == _BIAS or claim.get("at_rest") is True
    of_output, most = upper or kind in _SETTLED, upper or (kind in _SETTLED and claim["most"] is True)
    where = f"{' to '.join(filter(None, [claim['loop'], claim['open_at'] * of_output]))}, {kind}"
    size = repr(limit) if of_output else f"{limit:g} {_UNITS[kind]}".rstrip()
    where += (kind != "stable") * f" of at {'most' if most else 'least'} {size}"
    sides = tuple(_side((one["low"], one["high"])) for one in claim["coordinates"])
    changes = claim.get("any_change") or claim.get("changes")
    where += " at rest" * at_rest + f" under {'any' if claim.get('any_change') else 'slow'} change" * bool(changes)
    _check_ends(claim, where)
    kept = [
        (leaf, *(tuple(map(_side, leaf.get(name, leaf["box"]))) for name in ("box", "core")))
        for leaf in claim["leaves"]
    ]
    covered = _covered((*sides, _side(claim["ends"])), [core for _, _, core in kept])
    _refuse(not covered, f"{where}: its boxes do not cover the tolerances")
    far = [Fraction(high) - Fraction(low) for low, high in sides]
    steps = far if claim.get("any_change") else [*map(Fraction, claim.get("changes", []))]
    stays = at_rest or kind in ("delay margin", *_SETTLED)
    wrong = changes and (stays or any(_too_soon(claim, steps, *pair) for pair in itertools.permutations(kept, 2)))
    _refuse(bool(wrong), f"{where}: no norm serves all of the tolerances, or follows another so soon")
    for number, (leaf, box, core) in enumerate(kept):
        within = all(a <= b and c >= d for (a, c), (b, d) in zip(box, core, strict=True))
        _refuse(not within or not _has_disc(claim, leaf, box[-1]), f"{where}: a disc or core is not that of the claim")
        loop = data["loops"][leaf["loop"]]
        _refuse(at_rest != ("rest" in loop and _rests(loop["rest"])), f"{where}: no point of rest is enclosed")
        contracts = _contracts(loop, leaf, box, claim["factor"], most)
        _refuse(not contracts, f"{where}: box {number} does not contract, or lies on the other side")
    named = [f"{'1 / ' * c['inverse']}{c['name']} from {c['low']:g} to {c['high']:g}" for c in claim["coordinates"]]
    if not claim.get("any_change") and changes:
        named = [f"{one} by at most {float(step):g} a period" for one, step in zip(named, steps, strict=True)]
    return ", ".join([f"{where}: {len(kept)} box{'es' * (len(kept) > 1)}", *named])


def _side(ends: Sequence[float]) -> tuple[float, float]:
    low, high = map(float, ends)
    _refuse(not (math.isfinite(low) and math.isfinite(high) and low <= high), "has a side without ends")
    return low, high


def _check_ends(claim: Mapping[str, Any], where: str) -> None:
    """Raise where the factors are fewer than those of the claim."""
    (low, high), factor, kind = map(Decimal, _side(claim["ends"])), claim["factor"], claim["kind"]
    limit, period = Decimal(float(claim["limit"])), Decimal(float(claim.get("period", 0.0)))
    if kind in ("phase margin", "delay margin"):
        most = limit / 180 if kind == "phase margin" else min(limit / period, Decimal(2)) if period > 0 else -1
        right = factor == "phase" and low <= 0 and high >= _PI * most >= 0
    elif kind in _FACTORS:
        right = factor == _FACTORS[kind] and low == high >= limit and (low == limit or factor == "disk")
    else:
        gain = Decimal(10) ** (limit / 20 if kind == "gain margin" else 0)
        right = factor == "gain" and low * gain <= 1 and high >= gain
        right = right and (kind != "stable" or limit == 0) and (kind != "decay rate" or period > 0)
    _refuse(not right or not (limit >= 0 or kind in _SETTLED), f"{where}: its factors are not those of the claim")


def _has_disc(claim: Mapping[str, Any], leaf: Mapping[str, Any], factors: tuple[float, float]) -> bool:
    """Return whether poles in the disc of a leaf keep its claim: of a delay it leaves out an arc, near at its ends."""
    real, imaginary, radius = map(Fraction, map(float, leaf.get("disc", _CIRCLE)))
    kind, limit, period = claim["kind"], float(claim["limit"]), float(claim.get("period", 0.0))
    if kind == "delay margin" and factors[0] > 0.0:
        least = _turn(Fraction(factors[0]) * Fraction(period) / Fraction(limit))
        ends = (Fraction(-1), Fraction(0)), (least[0], -least[1])
        away = min((x - real) ** 2 + (y - imaginary) ** 2 for x, y in ends)
        return imaginary >= 0 and radius > 0 and radius**2 <= away - _SLACK
    return real == imaginary == 0 and 0 < Decimal(float(radius)) <= _radius(claim)


def _radius(claim: Mapping[str, Any]) -> Decimal:
    """Return that of the disc about zero in which all poles have to lie."""
    rate = Decimal(float(claim["limit"])) * Decimal(float(claim.get("period", 0.0)))
    return (-rate).exp() * (1 - Decimal(10) ** -45) if claim["kind"] == "decay rate" else Decimal(1)


def _too_soon(claim: Mapping[str, Any], steps: Sequence[Fraction], before: _Kept, after: _Kept) -> bool:
    """Return whether a leaf may follow another before that one shortens by more than the norm of the next lengthens."""
    times = list[int]()
    if before[0]["transform"] == after[0]["transform"]:
        return False
    for box, core, there, step in zip(*before[1:], after[2], (*steps, Fraction(0)), strict=True):
        apart = Fraction(max(box[0], there[0])) - Fraction(min(box[1], there[1]))
        if apart > step or (apart == step == 0 and box != there):  # of what stays one side of a common end is enough
            return False
        beyond = (there[0] < box[0], core[0], box[0]), (there[1] > box[1], box[1], core[1])
        times += [(Fraction(high) - Fraction(low)) // step + 1 for leaves, high, low in beyond if leaves and step]
    if not times or claim["kind"] in (_NOISE, _PEAK):
        return bool(times)
    shorter = (Decimal(float(before[0].get("disc", _CIRCLE)[2])) / _radius(claim)) ** min(*times, _MOST_PERIODS)
    t, (x, _, room) = before[0]["transform"], _turned(np.array(after[0]["transform"], dtype=float), ONE)
    mixed = x @ _whole(np.array(t, dtype=float)) // ONE
    return not _is_shorter(
        mixed, np.abs(x) @ (0 * mixed + 1) // ONE + 2, (room << _FEWER) // (int(shorter * (1 << _FEWER)) + 2)
    )


def _is_shorter(matrix: _Whole, unknown: _Whole, room: int) -> bool:
    """Return whether a matrix shortens every vector to below `room`, with entries off by at most what is unknown."""
    r = ((room - _bound(unknown)) >> (_BITS - _FEWER)) - 2 * len(matrix)  # of dropping bits
    b = matrix >> (_BITS - _FEWER)
    return r > 0 and all(minor > 0 for minor in _minors(r * r * _unit(len(b)) - b.T @ b))


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


def _contracts(loop: Mapping[str, Any], leaf: Mapping[str, Any], box: _Box, factor: str, most: bool) -> bool:
    """Return whether all closed loops of a box shorten every vector in the coordinates of its T, on their side."""
    sides, parts, limit = box[:-1], 2 if factor == "phase" else 1, box[-1][1]
    wide = [i for i, (low, high) in enumerate(sides) if low < high]
    same = tuple(map(_side, loop["box"])) == sides and sorted(loop["interpolated"] + loop["bounded"]) == wide
    n, k, inputs = (int(loop.get(name, loop["values"])) for name in ("order", "values", "inputs"))
    middles, radii = (np.array(loop["corners"][name], dtype=float) for name in ("middle", "radius"))
    t, beyond = (np.array(leaf[name], dtype=float) for name in ("transform", "beyond"))
    size = {"disk": n + k, "noise": n + k, "peak": n + k, "rest": 2 * n + k}.get(factor, parts * n)
    left, noise = (_whole(np.array(leaf.get(name, []), dtype=float)) for name in ("left", "noise"))
    right = {"rest": left.shape == (n + 1, n + 1), "noise": noise.shape == (n + k, inputs)}.get(factor, inputs == k)
    right &= n >= 0 and middles.shape == radii.shape == (2 ** len(loop["interpolated"]), n + k, n + inputs)
    right &= t.shape == beyond.shape == (size, size) and not any((part < 0).any() for part in (beyond, radii, noise))
    mixed = factor in ("disk", "noise", "peak") and (t[n:].tolist() != np.eye(size)[n:].tolist() or t[:n, n:].any())
    _refuse(bool(mixed) or not (right and same), "has a loop of another box, or matrices that do not fit")
    real, imaginary, radius = (int(Fraction(part) * ONE) for part in map(float, leaf.get("disc", _CIRCLE)))
    turned = np.array([[real, -imaginary], [imaginary, real]], dtype=object)[:parts, :parts]
    centre, more = np.kron(turned, _unit(size // parts)), _whole(beyond) + 1
    beside = [slice(n)] * (n > 0) + [slice(n, None)] if factor == "rest" else [slice(None)]
    turns = [(part, *_turned(t[part, part], radius)) for part in beside]
    for middle, near in zip(map(_whole, middles), map(_whole, radii), strict=True):
        for f in _factors(factor, box[-1], k):
            opened = middle, near + 1
            closed, off = _closed(opened, f, n, factor, limit, left)
            for part, x, back, room in turns:
                b = x @ (closed - centre)[part, part] @ back // (ONE * ONE)
                unknown = np.abs(x) @ (off + more)[part, part] @ np.abs(back) // (ONE * ONE) + 2
                if not _is_shorter(b, unknown, room):
                    return False
                if factor == "noise":
                    entering = np.abs(x @ middle[:, n:]) + np.abs(x) @ (near[:, n:] + noise + 3)
                    mixed = x[:n, n:].any() or (x[n:] != ONE * _unit(size)[n:]).any()
                    if mixed or ((entering // ONE + 2) ** 2).sum() > (Fraction(limit) * ONE) ** 2:
                        return False
    return factor != "rest" or ([*_minors(left)][-1] > 0) == most


def _rests(rest: Mapping[str, Any]) -> bool:
    """Return whether each sensor of a box has one point of rest within r of a centre."""
    names = "reach", "step", "step_radius", "left", "matrix", "matrix_radius"
    r, b, near, *square = (_whole(np.array(rest[name], dtype=float)) for name in names)
    left, j, off = (part.reshape(len(r), len(r)) for part in square)
    _refuse(not r.shape == b.shape == near.shape or bool((near < 0).any() or (off < 0).any()), "has no point of rest")
    apart = np.abs(ONE * ONE * _unit(len(r)) - left @ (ONE * _unit(len(r)) - j)) + np.abs(left) @ (off + 2)
    return bool(((np.abs(left @ b) + np.abs(left) @ (near + 2)) * ONE + apart @ r < ONE * ONE * r).all())


def _turned(t: npt.NDArray[np.float64], radius: int) -> tuple[_Whole, _Whole, int]:
    """Return a matrix near the inverse of T, T, and what a norm in these coordinates has to be below."""
    scale = np.maximum(np.abs(t).max(axis=1), 1e-300)
    x, whole = _whole(np.linalg.inv(t / scale[:, None]) / scale), _whole(t)
    apart = np.abs(x @ whole - ONE * ONE * _unit(len(t))) // ONE + 1
    return x, whole, radius - _bound(apart) * radius // ONE - 1


def _closed(opened: _Rounded, f: _Rounded, n: int, factor: str, limit: float, left: _Whole) -> _Rounded:
    """Return A + B E C with E = F (I - D F)^-1, a sum of as many powers as the wire has values.

    A disk of size a has [A + B E C, B E; a E C, a (E - I / 2)], a peak of g [A, B; C / g, D / g], noise [A 0; C 0].
    """
    halves = [(slice(n), slice(n)), (slice(n), slice(n, None)), (slice(n, None), slice(n)), (slice(n, None),) * 2]
    a, b, c, d = ([np.kron(_unit(2 if factor == "phase" else 1), part[place]) for part in opened] for place in halves)
    if factor == "rest":
        border = ONE * _unit(n + 1)
        border[n, n] = math.floor(Fraction(limit) * ONE)
        rest = left @ (opened[0] - border) // ONE + ONE * _unit(n + 1), np.abs(left) @ (opened[1] + 1) // ONE + 2
        empty = [0 * part[:n] for part in opened]
        return _joined([[a, empty], [[part.T for part in empty], rest]])
    if factor == "noise":
        return _joined([[a, [0 * part.T for part in c]], [c, [0 * (part @ part.T) for part in c]]])
    if factor == "peak":
        one = int(ONE / Fraction(limit)) * _unit(len(d[0])), 0 * d[0] + 1
        return _joined([[a, b], [_times(one, c), _times(one, d)]])
    e = power = f
    for _ in range(len(opened[0]) - n - 1):
        power = _times(f, _times(d, power))
        e = e[0] + power[0], e[1] + power[1]
    b_e, forward = _times(b, e), _times(_times(b, e), c)
    closed = a[0] + forward[0], a[1] + forward[1]
    if factor != "disk":
        return closed
    scale = int(Fraction(limit) * ONE) * _unit(len(e[0])), 0 * e[0] + 1
    return _joined([[closed, b_e], [_times(scale, _times(e, c)), _times(scale, (e[0] - f[0] // 2, e[1]))]])


def _joined(rows: Sequence[Sequence[Sequence[_Whole]]]) -> _Rounded:
    middle, near = (np.block([[part[i] for part in row] for row in rows]) for i in (0, 1))
    return middle, near


def _times(left: Sequence[_Whole], right: Sequence[_Whole]) -> _Rounded:
    errors = np.abs(left[0]) @ right[1] + left[1] @ (np.abs(right[0]) + right[1])
    return left[0] @ right[0] // ONE, errors // ONE + 2


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
