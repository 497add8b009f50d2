"""Checker of certificates of proofs over tolerances. It shares no code with the search that found them.

A certificate says that the poles of a loop lie in a disc, of rates in a half plane, for all parameters and factors
between their ends. Its leaves have the open loop [A B; C D] at the corners of a box, bounds of what lies beyond them by
entries and in the norm, a disc and a matrix T. That these enclose a graph is assumed. In parts of 2^-300 it verifies:

1. the hash of the certificate, that factors and discs are those of its claim, and that the leaves cover all;
2. that all closed loops M less the centre of a disc have a norm below its radius r in coordinates of T: r^2 I - B'B has
   positive leading minors (Bareiss, Math. Comp. 22, 1968, 565); of a half plane Re (1 + j r) (s - c) < 0 instead
   -T' (P F + F' P) T with F = (1 + j r) (M - c), P = X'X and X near T^-1;
3. of a scale factor or bias D + C (I - A)^-1 B that A and I - R M have such norms, M = [I - A, -B; -C, g - D] with the
   limit g. Then det M has the sign of det R, and is a positive number times g less the scale factor;
4. of a peak that [A, B; C / g, D / g] has one, and of a disk [M, B E; a E C, a (E - I / 2)], that leaves inputs and
   outputs as they are (bounded real lemma); of rates these stand in F = [A, B, 0; 0, -I / 2, 0; C, D, -I / 2];
5. of noise that [A; C] has one, outputs left as they are, and that the squares of [X B; D] add up to the limit's;
6. at rest that |R b| + |I - R (I - J)| r < r, entry by entry, for all steps b and slopes J of a box (Krawczyk);
7. where parameters move by d in a period, that m follows k after N = floor(h / d) + 1 of them, h from the leaf k to the
   end of its box towards m, if |T_m^-1 T_k| r_k^N < 1 (dwell time; Morse, 1996), or of noise, peaks, rates T_m is T_k.
"""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from proofmass.runner.verification.box_checker import LeafBox, covered, named_side
from proofmass.runner.verification.digital_checker import check_digital

FORMAT, _PI = "proofmass proof 1", Decimal("3.14159265358979323846264338327950288419716939937511")
_FEWER, ONE = 80, 1 << 300  # half of the bits that are left of numbers to compare; 1.0, with 300 bits after the point
_OF_OUTPUT, _CIRCLE, _OF_LEAF = ("rest", "noise", "peak"), (0.0, 0.0, 1.0), ("beyond", "left", "noise", "shift")
_FACTORS = {"phase margin": "phase", "delay margin": "phase", "disk margin": "disk", "noise": "noise", "peak": "peak"}
_FACTORS |= {"stable": "gain", "gain margin": "gain", "decay rate": "gain", "scale factor": "rest", "bias": "rest"}
_UNITS = {"gain margin": " dB", "phase margin": " deg", "delay margin": " s", "decay rate": " 1/s"}
_Whole = np.ndarray[Any, np.dtype[np.object_]]  # of integers; where it has three sides, a matrix and its errors
_Data = Mapping[str, Any]
_unit: Any = partial(np.eye, dtype=object)


class FalseCertificateError(Exception):
    """A certificate that proves nothing, and why."""


def check_certificate(text: str) -> list[str]:
    """Return what a certificate proves, a line each; raises `FalseCertificateError`."""
    try:
        data = json.loads(text)
        _refuse(data.get("format") != FORMAT, f"is not a {FORMAT}")
        _refuse(data.pop("sha256") != digest_of(data), "was changed: its hash is another")
        digital = [*map(check_digital, data.get("digital", []))]
        _refuse(not data["claims"] + digital or not isinstance(data["graph_sha256"], str), "has no claim about a graph")
        _refuse(not all(holds for _, holds in digital), "has a claim about fixed point that is not shown")
        with localcontext(prec=50):
            return [*(_claim(data, claim) for claim in data["claims"]), *(line for line, _ in digital)]
    except (TypeError, ValueError, AttributeError, LookupError, ArithmeticError, RecursionError) as error:
        raise FalseCertificateError(f"cannot be read: {error}") from None


def _refuse(wrong: bool, why: str) -> None:
    if wrong:
        raise FalseCertificateError(why)


def digest_of(content: _Data) -> str:
    """Return the SHA-256 of the content of a certificate."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def _claim(data: _Data, claim: _Data) -> str:
    kind, limit, factor = claim["kind"], float(claim["limit"]), _FACTORS[claim["kind"]]
    any_change, falls, rests = (claim.get(key) is True for key in ("any_change", "continuous", "at_rest"))
    at_rest, of_output, time = rests or kind == "bias", factor in _OF_OUTPUT, "second" if falls else "period"
    most = of_output and (factor != "rest" or claim["most"] is True)
    sides = [_side((one["low"], one["high"])) for one in claim["coordinates"]]
    steps = [Fraction(b) - Fraction(a) for a, b in sides] if any_change else [*map(Fraction, claim.get("changes", ()))]
    moves = any_change or bool(steps)
    where = f"{' to '.join(filter(None, [claim['loop'], claim['open_at'] * of_output]))}, {kind}"
    size, orbit = repr(limit) if of_output else f"{limit:g}{_UNITS.get(kind, '')}", float(claim.get("orbit", 0.0))
    place = f" on an orbit of {orbit:g} s" if orbit > 0.0 else " at rest"
    where += (kind != "stable") * f" of at {'most' if most else 'least'} {size}" + place * at_rest
    where += " in continuous time" * falls + f" under {'any' if any_change else 'slow'} change" * moves
    _check_ends(claim, where)
    leaves = [(tuple(map(_side, leaf["box"])), leaf, data["loops"][leaf["loop"]]) for leaf in claim["leaves"]]
    _refuse(not covered((*sides, _side(claim["ends"])), [one[0] for one in leaves]), f"{where}: its boxes leave a gap")
    for i, (core, leaf, loop) in enumerate(leaves):
        _refuse(not 0 < _disc(claim, leaf, core[-1]) <= 1, f"{where}: a disc is not that of the claim")
        _refuse(at_rest != ("rest" in loop and _rests(loop["rest"])), f"{where}: no point of rest is enclosed")
        _refuse(not _contracts(loop, leaf, core, claim), f"{where}: box {i} does not contract, or its side is wrong")
    stays = at_rest or factor == "rest" or kind == "delay margin" or min(steps, default=0) < 0
    wrong = moves and (stays or any(_too_soon(claim, steps, one, other) for one in leaves for other in leaves))
    _refuse(wrong, f"{where}: no norm serves all of the tolerances, or follows another so soon")
    varies = [*map(named_side, claim["coordinates"])]
    wrong = (moves or at_rest or of_output) and any("product" in side for side in claim["coordinates"])
    _refuse(wrong or not all(whole for _, whole in varies), f"{where}: a product does not stand for its parameters")
    named = [words for words, _ in varies]
    if moves:
        named = [f"{one} by at most {float(step):g} a {time}" for one, step in zip(named, steps, strict=True)]
    return ", ".join([f"{where}: {len(leaves)} box{'es' * (len(leaves) > 1)}", *named])


def _side(ends: Sequence[float]) -> tuple[float, float]:
    low, high = map(float, ends)
    _refuse(not -math.inf < low <= high < math.inf, "has a side without ends")
    return low, high


def _check_ends(claim: _Data, where: str) -> None:
    """Raise where the factors are fewer than those of the claim."""
    (low, high), kind, factor = map(Decimal, _side(claim["ends"])), claim["kind"], _FACTORS[claim["kind"]]
    limit, period = Decimal(float(claim["limit"])), Decimal(float(claim.get("period", 0.0)))
    samples = Decimal(2) if claim.get("continuous") is True else limit / period if period > 0 else Decimal(-1)
    right = (limit >= 0 or factor == "rest") and (samples >= 0 or kind not in ("delay margin", "decay rate"))
    gain = Decimal(10) ** (limit / 20 if kind == "gain margin" else 0)
    turn = _PI * (limit / 180 if kind == "phase margin" else min(samples, Decimal(2)))
    of = {"phase": low <= 0 and high >= turn, "gain": low * gain <= 1 and high >= gain, "disk": low == high >= limit}
    right &= (kind != "stable" or not limit) and of.get(factor, low == high == limit)
    _refuse(not right or claim["factor"] != factor, f"{where}: its factors are not those of the claim")


def _disc(claim: _Data, leaf: _Data, factors: tuple[float, float]) -> Decimal:
    """Return how large a disc is, of that which its claim needs: of a delay it leaves out an arc, near at its ends."""
    kind, falls = claim["kind"], claim.get("continuous") is True
    real, imaginary, radius = (Fraction(float(part)) for part in leaf.get("half_plane" if falls else "disc", _CIRCLE))
    limit, period = float(claim["limit"]), float(claim.get("period", 0.0))
    first = Fraction(factors[0]) / Fraction(limit) if kind == "delay margin" and factors[0] > 0.0 else Fraction(0)
    if falls:
        beside = -first <= imaginary <= 0 <= radius and (radius == 0 or first > 0) and claim["factor"] not in _OF_OUTPUT
        return Decimal(beside and real == (-limit if kind == "decay rate" else 0))
    if first > 0:
        x, y = _turn(first * Fraction(period))
        away = min((1 + real) ** 2 + imaginary**2, (x - real) ** 2 + (y + imaginary) ** 2)
        return Decimal(imaginary >= 0 and radius > 0 and radius**2 <= away - Fraction(1, 1 << 290))  # errors of both
    most = (-Decimal(limit) * Decimal(period)).exp() * (1 - Decimal(10) ** -45) if kind == "decay rate" else 1
    return Decimal(float(radius)) / most if real == imaginary == 0 else Decimal(0)


def _too_soon(claim: _Data, steps: Sequence[Fraction], one: Sequence[Any], after: Sequence[Any]) -> bool:
    """Return whether a leaf may follow another before that one shortens by more than the norm of the next lengthens."""
    (cores, leaf, loop), (others, following, _), times = one, after, list[int]()
    for core, box, there, step in zip(cores, (*loop["box"], cores[-1]), others, (*steps, Fraction(0)), strict=True):
        (a, b), (first, last), (low, high) = (map(Fraction, ends) for ends in (core, box, there))
        apart = max(first, low) - min(last, high)
        if apart > step or (apart == step == 0 and core != there):  # of what stays one side of a common end is enough
            return False
        times += [way // step + 1 for way in [a - first] * (low < first) + [last - b] * (high > last) if step]
    same = leaf["transform"] == following["transform"]
    if same or not times or claim.get("continuous") is True or claim["kind"] in ("noise", "peak"):
        return bool(times) and not same
    t, norm = _whole(leaf["transform"]), _norm(_whole(following["transform"]))
    room = (ONE << _FEWER) // (int(_disc(claim, leaf, cores[-1]) ** min(*times, 10**9) * (1 << _FEWER)) + 2)
    return not _holds(np.stack([ONE * _unit(len(t)), 0 * t]), t, norm, room, False, len(t))


def _holds(matrix: _Whole, t: _Whole, after: tuple[_Whole, _Whole], room: int, falls: bool, n: int) -> bool:
    """Return whether a matrix leaves less than `room`, in the norms before, of T, and after, or makes n states fall."""
    (x, own), k = after, len(t) - n
    b, off = x @ matrix[0] @ t // (ONE * ONE), np.abs(x) @ matrix[1] @ np.abs(t) // (ONE * ONE) + 2
    if falls:
        rows, (g, unknown) = [*range(n), *range(n + k, n + 2 * k)], np.zeros((2, n + 2 * k, n + 2 * k), dtype=object)
        g[rows, : n + k], unknown[rows, : n + k] = own.T @ b // (ONE * ONE), np.abs(own.T) @ off // (ONE * ONE) + 2
        g, unknown = np.diag([0] * n + [ONE] * (2 * k)) - g - g.T, unknown + unknown.T
    else:
        r = room - _size(np.abs(own - ONE * ONE * _unit(len(t))) // ONE + 1) * room // ONE - 1 - _size(off)
        g, unknown = r * max(r, 0) * _unit(len(t)) - b.T @ b, 0 * b
    fewer = [max(value.bit_length() // 2 - _FEWER, 0) for value in g.diagonal().tolist()]  # units alike
    drop = np.add.outer(fewer, fewer)
    return all(minor > 0 for minor in _minors((g >> drop) - _size((unknown >> drop) + 2) * _unit(len(g))))


def _size(errors: Any) -> int:
    """Return at least the spectral norm of all matrices with entries of at most these sizes."""
    return math.isqrt(int(errors.sum(axis=0).max()) * int(errors.sum(axis=1).max())) + 1


def _contracts(loop: _Data, leaf: _Data, box: LeafBox, claim: _Data) -> bool:
    """Return whether all closed loops of a box shorten every vector in the coordinates of its T, on their side."""
    factor, falls, whole = claim["factor"], claim.get("continuous") is True, [*map(_side, loop["box"])]
    parts, limit, bends = 2 if factor == "phase" else 1, Fraction(box[-1][1]), Fraction(leaf.get("bends", 0))
    holds = all(low <= a and b <= high for (a, b), (low, high) in zip(box[:-1], whole, strict=True))
    holds &= sorted(loop["interpolated"] + loop["bounded"]) == [i for i, (low, high) in enumerate(whole) if low < high]
    n, k, inputs = (int(loop.get(name, loop["values"])) for name in ("order", "values", "inputs"))
    middles, radii = (_whole(loop["corners"][name]) for name in ("middle", "radius"))
    t, beyond, left, noise, shift = (_whole(leaf.get(name, [0.0])) for name in ("transform", *_OF_LEAF))
    size = {"disk": n + k, "noise": n + k, "peak": n + k, "rest": 2 * n + k}.get(factor, parts * n)
    holds &= {"rest": left.shape == (n + 1, n + 1), "noise": noise.shape == (n + k, inputs)}.get(factor, inputs == k)
    holds &= n >= 0 and middles.shape == radii.shape == (2 ** len(loop["interpolated"]), n + k, n + inputs)
    holds &= t.shape == beyond.shape == (size, size) and not any((part < 0).any() for part in (beyond, radii, noise))
    places = [slice(n), slice(n, None)][n == 0 :] if factor == "rest" else [slice(size)]
    norms, states = [(i, _norm(t[i, i])) for i in places], n if factor in ("disk", "noise", "peak") else size
    x = norms[0][1][0]  # which leaves inputs and outputs as they are, as T does
    zeros = [part for m in (t, x) for part in ((m - ONE * _unit(len(m)))[states:], m[:states, states:])]
    zeros += [np.triu(m[:, n:, n:]) for m in (middles, radii) if factor not in _OF_OUTPUT]  # not through at once
    wrong = not holds or bends < 0 or (falls and bends > 0) or shift.shape not in ((1,), t.shape)
    _refuse(wrong or any(part.any() for part in zeros), "has a loop of another box, or matrices that do not fit")
    real, imaginary, radius = (Fraction(float(part)) for part in leaf.get("half_plane" if falls else "disc", _CIRCLE))
    pairs = (np.array([[u, -v], [v, u]])[:parts, :parts] * ONE // 1 for u, v in ((-real, -imaginary), (1, radius)))
    away, turn = (np.stack([m := np.kron(pair, _unit(size // parts)), 0 * m + 1]) for pair in pairs)
    for corner, f in product(np.stack([middles, radii + 1], axis=1), _factors(factor, box[-1], k)):
        moved = _closed(corner, f, n, factor, limit, left) + away
        moved = (_times(turn, moved) if falls else moved) + np.stack([0 * t + shift, beyond + 1])
        if not all(_holds(moved[:, i, i], t[i, i], m, int((radius - bends) * ONE), falls, states) for i, m in norms):
            return False
    if factor == "noise":
        entering = (np.abs(x @ middles[:, :, n:]) + np.abs(x) @ (radii[:, :, n:] + noise + 3)) // ONE + 2
        return all(squares.sum() <= (limit * ONE) ** 2 for squares in entering**2)
    return factor != "rest" or ([*_minors(left)][-1] > 0) == (claim["most"] is True)


def _rests(rest: _Data) -> bool:
    """Return whether each sensor of a box has one point of rest within r of a centre."""
    r, b, near = (_whole(rest[key]) for key in ("reach", "step", "step_radius"))
    left, j, off = (_whole(rest[key]) for key in ("left", "matrix", "matrix_radius"))
    fits = r.shape == b.shape == near.shape and left.shape == j.shape == off.shape == 2 * r.shape
    apart = np.abs(ONE * ONE * _unit(len(r)) - left @ (ONE * _unit(len(r)) - j)) + np.abs(left) @ (np.abs(off) + 2)
    needed = (np.abs(left @ b) + np.abs(left) @ (np.abs(near) + 2)) * ONE + apart @ r
    return fits and bool((needed < ONE * ONE * r).all())


def _norm(t: _Whole) -> tuple[_Whole, _Whole]:
    """Return a matrix X near the inverse of T, and X T: the norm is the length of T^-1 x, or of X x."""
    near = (t / ONE).astype(float)
    scale = np.maximum(np.abs(near).max(axis=1), 1e-300)
    x = _whole(np.linalg.inv(near / scale[:, None]) / scale)
    return x, x @ t


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
    e, power = f, _times(f, d)
    for _ in range((k - 1).bit_length()):  # D has no power of order k
        e, power = e + _times(power, e), _times(power, power)
    closed, half = a + _times(_times(b, e), c), np.stack([f[0] // 2, 0 * f[0]])
    if factor in ("gain", "phase"):
        return closed
    whole = opened if factor == "peak" else np.block([[closed, _times(b, e)], [_times(e, c), e - half]])
    scale = np.diag([ONE] * n + [int((1 / limit if factor == "peak" else limit) * ONE)] * k)
    return _times(np.stack([scale, _unit(n + k)]), whole)


def _times(left: _Whole, right: _Whole) -> _Whole:
    errors = np.abs(left[0]) @ right[1] + left[1] @ (np.abs(right[0]) + right[1])
    return np.stack([left[0] @ right[0] // ONE, errors // ONE + 2])


def _factors(kind: str, ends: tuple[float, float], values: int) -> list[_Whole]:
    """Return factors between which those of the claim lie, as matrices for all values of a wire in a period."""
    (low, high), parts = map(Fraction, ends), 2 if kind == "phase" else 1
    turns: list[Any] = [_turn(at) if parts == 2 else (at if kind == "gain" else 1, 0) for at in {low, high}]
    _refuse(parts == 2 and not high - low < 3, "has an arc without a triangle about it")
    if parts == 2 and values == 1 and low < high:  # the arc lies in a triangle: its ends, where their tangents cross
        turns.append([part / _turn((high - low) / 2)[0] for part in _turn((low + high) / 2)])
    pairs = (np.array([[c, -s], [s, c]], dtype=object)[:parts, :parts] * ONE // 1 for c, s in turns)
    return [np.stack([m := np.kron(pair, _unit(values)), 0 * m + 4]) for pair in pairs]


def _turn(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Return cosine and sine of an angle below 4, to far below a whole number, by their series."""
    _refuse(not abs(angle) < 7, "has a phase beyond a turn")
    parts, term = [Fraction(0), Fraction(0)], Fraction(1)
    for order in range(150):  # whose last is below 2^-400
        parts[order % 2] += term if order % 4 < 2 else -term
        term = Fraction(int(term * angle / (order + 1) * (ONE << 60)), ONE << 60)
    return parts[0], parts[1]


def _whole(rows: Any) -> _Whole:
    """Return doubles as whole numbers, rounded down; raises an error for what is not finite."""
    return np.asarray(np.frompyfunc(lambda value: math.floor(Fraction(value) * ONE), 1, 1)(np.array(rows, dtype=float)))


def _minors(matrix: _Whole) -> Iterator[int]:
    """Yield the leading minors of a matrix of integers: the last is its determinant, where rows were added too."""
    rows, before = matrix, 1
    while len(rows):
        yield rows[0, 0]
        first = rows[0] + (rows[0, 0] == 0) * next((row for row in rows[1:] if row[0]), 0)  # the determinant stays
        rows, before = (first[0] * rows[1:, 1:] - np.outer(rows[1:, 0], first[1:])) // before, first[0]
