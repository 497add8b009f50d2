"""Families of matrices that contract in one norm: then every system x[n+1] = A x[n] of the family decays.

All is stable if a matrix T has ||T^-1 A T|| < 1 for all A. The norm is convex: of what lies between
corners, the corners suffice, and errors add their own norm.

T is searched: first as a root of the covariance that noise along the mean and the moves of the
coordinates would have, then by descent of the largest norm at the corners, whose slope by X in T
(I + X) is v v' - u u', of its singular vectors. What is searched is a guess, what is accepted is
proved: with X about T^-1 and ||X T - I|| <= e, the norm of X A X^-1 is at most ||X A T|| / (1 - e).
It is below r if Cholesky's algorithm ends in floating point for r^2 I - B'B, after a shift that
exceeds its errors (Rump, BIT Numerical Mathematics 46, 2006, 433). Rates in continuous time are
taken likewise (`half_plane`).
"""

import itertools
import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.derivatives.ball import UNIT, UP, UndecidedError
from proofmass.runner.design.proof.closed_loop import Disc, Family
from proofmass.runner.design.proof.descent import descended, largest, unknown
from proofmass.runner.design.proof.enclosed import Enclosed, quarters
from proofmass.runner.design.proof.half_plane import PoleRegion
from proofmass.runner.host.arrays import Array

_ROUNDS = 10  # of the fixed point of the covariance
_SHARPNESS = (200.0, 2_000.0, 20_000.0)  # of the smooth maximum that is descended
_ROOMS = (1.1, 1.03, 1.01, 1.003, 1.001, 1.0001)  # sizes of disks, as parts of the claimed one
_RESTS = (1e-2, 1e-3, 1e-4, 1e-6)  # of the Riccati equation, in units of its first solution
_LEAST_PART = 1e-16  # of the first solution, that a state has of it
_DOUBLINGS = 24
_MOST_BENDS = 24  # terms beyond the corners for which a norm is descended
_ROUNDED = 1e-6  # more than the rounding of a fourth power of 128 states, as a part of it
_BEYOND = 1e-12  # by which a pole lies outside for certain


@dataclass(frozen=True)
class Norm:
    """A transformation T, and a family in its coordinates."""

    transform: Array
    family: Family

    @cached_property
    def inverse(self) -> Array:
        """The inverse of the transformation, as doubles have it: of rows that are made alike, since units are not."""
        scale = np.maximum(np.abs(self.transform).max(axis=1), 1e-300)
        return np.asarray(np.linalg.inv(self.transform / scale[:, None]) / scale, dtype=np.float64)

    @property
    def of_states(self) -> Array:
        """The transformation of the states themselves, whatever the family's coordinates."""
        opened = self.family.opened
        if opened is None or opened.frame is None:
            return self.transform
        return np.asarray(np.kron(np.eye(len(self.transform) // opened.order), opened.frame) @ self.transform)

    @cached_property
    def corners(self) -> Enclosed:
        """The matrices at the corners in these coordinates."""
        return Enclosed.exact(self.inverse) @ self.family.corners @ Enclosed.exact(self.transform)

    @cached_property
    def shares(self) -> Mapping[int, float]:
        """The norm of what each coordinate adds beyond the corners."""
        shares = dict(self.bent)
        for i, share in self.family.shares.items():
            shares[i] = shares.get(i, 0.0) + float(np.linalg.norm(self._turned(share)))
        return shares

    @cached_property
    def bent(self) -> Mapping[int, float]:
        """The sum of the norms of terms that the corners do not have, for each coordinate."""
        return {i: self._norms(terms) for i, terms in self.family.bends.items()}

    @property
    def bend(self) -> float:
        """The sum of these norms, in coordinates of the transformation itself."""
        return sum(self.bent.values()) / (1.0 - bound_of(self.apart)) * UP

    @property
    def beyond(self) -> float:
        """A bound of the norm of what lies beyond the middles of the corners."""
        return (bound_of(self.rest) + sum(self.bent.values())) * UP

    @cached_property
    def rest(self) -> Array:
        """Bounds of what lies beyond the middles of the corners, entry by entry."""
        beyond = sum(map(self._turned, self.family.shares.values()), self.corners.radius.max(axis=0))
        return np.asarray(beyond * UP)

    @cached_property
    def room(self) -> float:
        """The norm that the middles of the corners may have."""
        return (1.0 - bound_of(self.apart)) / UP - self.beyond

    @cached_property
    def apart(self) -> Array:
        """Bounds of what the inverse times the transformation differs by from the unit matrix."""
        n = len(self.transform)
        apart = np.abs(self.inverse @ self.transform - np.eye(n))
        return np.asarray((apart + (n + 4) * UNIT * (np.abs(self.inverse) @ np.abs(self.transform))) * UP)

    def worst(self) -> float:
        """Return the largest norm at a corner, as a double."""
        return float(np.linalg.norm(self.corners.middle, 2, axis=(1, 2)).max())

    def moves(self) -> list[float]:
        """Return how much each coordinate with both ends among the corners moves the matrix."""
        return [float(np.linalg.norm(self.inverse @ move @ self.transform, 2)) for move in self.family.moves()]

    def contracts(self) -> bool:
        """Return whether all matrices of the family shorten every vector: a proof.

        Of matrices side by side each does so alone.
        """
        if self.family.blocks:
            return all(part.contracts() for part in self.parts())
        if self.family.rates is not None:
            return _decay(self.transform, self.family.rates)
        if self.family.noise is not None and not self.rms <= self.family.limit:
            return False
        return self.room > 0.0 and _shorter_than(self.corners.middle, self.room)

    @cached_property
    def rms(self) -> float:
        """A bound of the noise that enters, in these coordinates (`noise_norm`)."""
        noise = self.family.noise
        if noise is None or self.family.beyond_noise is None:
            return 0.0
        turned = Enclosed.exact(self.inverse) @ noise
        sizes = np.abs(turned.middle) + turned.radius + np.abs(self.inverse) @ self.family.beyond_noise
        return float(np.sqrt((sizes**2).sum(axis=(1, 2)).max())) * UP

    def tightened(self, disc: PoleRegion, parts: int) -> "tuple[Norm, PoleRegion]":
        """Return the norm for the least disc about zero that it proves, of one which it proves and is moved into."""
        size = self.worst() + self.beyond + 1e-12
        while size < 1.0:
            least = Norm(self.transform, Disc(0.0, 0.0, size).moved(self.family, parts))
            if least.contracts():
                return least, Disc(0.0, 0.0, disc.radius * size * (1.0 + 2.0**-50))
            size += 0.1 * (1.0 - size) + 1e-12
        return self, disc

    def parts(self) -> "list[Norm]":
        """Return the norms of matrices that lie side by side."""
        families = self.family.parts()
        ends = itertools.accumulate(self.family.blocks)
        pairs = zip(families, ends, self.family.blocks, strict=True)
        return [Norm(self.transform[end - size : end, end - size : end], one) for one, end, size in pairs if size]

    def improved(self) -> "Norm":
        """Return a norm with more room: smaller at the worst corner, and for what lies beyond the corners."""
        matrices, rest, n = self.corners.middle, self.rest, len(self.transform)
        bends = self._large_bends()
        free = np.zeros((n, n))
        free[: n - self.family.still, : n - self.family.still] = 1.0

        def smooth(step: Array, sharpness: float) -> tuple[float, Array]:
            back = np.asarray(np.linalg.inv(step), dtype=np.float64)
            turned = back @ matrices @ step
            squares, vectors = np.linalg.eigh(np.swapaxes(turned, 1, 2) @ turned)
            squares = np.maximum(squares, 1e-300)  # of a matrix that takes all to zero
            value, weights = largest(0.5 * np.log(squares[:, -1]), sharpness)
            v = vectors[:, :, -1]
            u = (turned @ v[:, :, None])[:, :, 0] / np.sqrt(squares[:, -1:])
            slope = back.T @ ((v * weights[:, None]).T @ v - (u * weights[:, None]).T @ u)
            size, by_back, by_step = unknown(back, rest, step)
            size_of_bends, by_bends = _bends(back, bends, step)
            return value + size + size_of_bends, free * (slope + by_step - back.T @ by_back @ back.T + by_bends)

        return Norm(self.transform @ descended(smooth, (n, n), _SHARPNESS), self.family)

    def _large_bends(self) -> Array:
        """Return the terms that make up nearly all of what lies beyond the corners, in these coordinates."""
        empty = np.zeros((0, *self.transform.shape))
        turned = self.inverse @ np.concatenate([empty, *self.family.bends.values()]) @ self.transform
        sizes = np.linalg.norm(turned, axis=(1, 2))
        return np.asarray(turned[np.argsort(-sizes)[:_MOST_BENDS]])

    def _norms(self, matrices: Array) -> float:
        """Return at least the sum of the spectral norms of some matrices in these coordinates."""
        turned, rounding = self.inverse @ matrices @ self.transform, 4.0 * UNIT * (len(self.transform) + 2)
        off = np.linalg.norm(self._turned(np.abs(matrices)), axis=(1, 2)).sum()
        return (_norms(turned) + rounding * float(off)) * UP

    def _turned(self, sizes: Array) -> Array:
        return np.asarray(np.abs(self.inverse) @ sizes @ np.abs(self.transform) * UP)


def first_norm(family: Family) -> Norm | None:
    """Return the norm of the covariance where the mean of the corners decays, None elsewhere."""
    if family.still:
        return _norm_of_disk(family)
    try:
        radius = radius_of(family)
        grown = 1.0 + 0.5 * (max(radius, 0.5) ** -2 - 1.0)
        return covariance_norm(family, family.centre, grown, 1e-6) if radius < 1.0 else None
    except (np.linalg.LinAlgError, ValueError):
        return None


def covariance_norm(family: Family, sizes: Array, grown: float, noise: float) -> Norm:
    """Return the norm of the covariance that noise along the moves makes, with some more in all directions.

    The mean of the corners counts as `grown`; states are scaled by what makes the rows and columns
    of `sizes` alike. Raises `LinAlgError` or `ValueError` where there is none.
    """
    _, scale = balanced(sizes)
    a, directions = (m * scale / scale[:, None] for m in (family.centre, family.moves()))
    w = np.eye(len(a))
    for _ in range(_ROUNDS):
        parts = np.einsum("kij,jl,kml->kim", directions, w, directions)
        shares = np.sqrt(np.maximum(np.einsum("kim,mi->k", parts, np.linalg.inv(w)), 1e-300))
        shares = np.maximum(shares / shares.sum(), 1e-6)
        forced = np.einsum("k,kim->im", 1.0 / shares, parts)
        forced += noise * (np.diag(np.diag(w)) + (np.trace(forced) or 1.0) * np.eye(len(a)))
        with warnings.catch_warnings():  # what proves is the norm, however it was found
            warnings.simplefilter("ignore", scipy.linalg.LinAlgWarning)
            w = scipy.linalg.solve_discrete_lyapunov(math.sqrt(grown) * a, forced)
        w = (w + w.T) / np.trace(w)
    return Norm(np.asarray(scale[:, None] * np.linalg.cholesky(w), dtype=np.float64), family)


def _norm_of_disk(family: Family) -> Norm | None:
    """Return a norm for all factors of a disk or all frequencies, None where there is none for the
    mean of the corners.

    P = A'PA + C'C + (A'PB + C'D) (I - D'D - B'PB)^-1 (B'PA + D'C) has a solution where there is
    one. Of somewhat larger disks and with e I for C'C there is room; the solution for the former
    alone scales the states, for the latter to mean the same for all of them.
    """
    n, still = len(family.centre) - family.still, np.eye(family.still)
    if not n:
        return Norm(still, family)
    _, scale = balanced(family.centre)
    scale = scale[:n] / scale[n:].mean()
    a, b, c, d = quarters(family.centre, n)
    if np.max(np.abs(np.linalg.eigvals(a)), initial=0.0) >= 1.0:
        return None
    norms = []
    for more in _ROOMS:
        try:
            first = _riccati(a * scale / scale[:, None], b / scale[:, None], more * c * scale, more * d, 0.0)
            np.linalg.cholesky(first + _LEAST_PART * np.trace(first) * np.eye(n))
            units = scale / np.sqrt(np.maximum(np.diag(first), _LEAST_PART * np.trace(first)))
        except (np.linalg.LinAlgError, ValueError, FloatingPointError):
            continue
        for rest in _RESTS:
            try:
                p = _riccati(a * units / units[:, None], b / units[:, None], more * c * units, more * d, rest)
                root = units[:, None] * np.linalg.inv(np.linalg.cholesky(p).T)
            except (np.linalg.LinAlgError, ValueError, FloatingPointError):
                continue
            norms.append(Norm(np.asarray(scipy.linalg.block_diag(root, still)), family))
    return min(norms, key=Norm.worst, default=None)


def _riccati(a: Array, b: Array, c: Array, d: Array, rest: float) -> Array:
    """Return the solution P with rest I added to C'C, by doubling (Chu, Fan and Lin, SIAM J. Matrix Anal. 26, 2005)."""
    unit = np.eye(len(a))
    inverse = np.linalg.inv(d.T @ d - np.eye(len(d)))
    with np.errstate(all="raise", under="ignore"):
        through = b @ inverse @ d.T @ c
        a, g, h = a - through, b @ inverse @ b.T, c.T @ c + rest * unit - c.T @ d @ inverse @ d.T @ c
        for _ in range(_DOUBLINGS):
            between = np.linalg.inv(unit + g @ h)
            a, g, h = a @ between @ a, g + a @ between @ g @ a.T, h + a.T @ h @ between @ a
        return np.asarray(0.5 * (h + h.T))


def in_frame(transform: Array, family: Callable[[Array], Family], parts: int) -> Norm:
    """Return the norm of a transformation of states of so many parts, with the family in
    coordinates that are near it.

    Raises `UndecidedError`.
    """
    n, frame = len(transform) // parts, transform
    if parts > 1:
        both = transform @ transform.T
        try:
            own = sum(both[i : i + n, i : i + n] for i in range(0, parts * n, n))
            frame = np.asarray(np.linalg.cholesky(own), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise UndecidedError("coordinates that are not independent") from None
    rest = np.eye(n) if parts == 1 else np.linalg.solve(np.kron(np.eye(parts), frame), transform)
    return Norm(np.asarray(rest, dtype=np.float64), family(frame))


def radius_of(family: Family) -> float:
    """Return the size of the largest pole at the mean of the corners, as a double."""
    return float(max(abs(np.linalg.eigvals(family.centre)), default=0.0))


def growth_of(of: Array, to: Array) -> float:
    """Return at least the largest size, in the norm of a transformation `to`, of what has size one in that `of`."""
    norm = Norm(to, Family(Enclosed.exact(np.zeros_like(to)), 1, {}))
    mixed = Enclosed.exact(norm.inverse) @ Enclosed.exact(of)
    size = float(np.linalg.norm(mixed.middle[0], 2)) * (1.0 + 1e-12)
    if not math.isfinite(size * size):  # the squares of its entries show nothing
        return math.inf
    while not _shorter_than(mixed.middle, size):
        size *= 1.0 + 1e-10
    return (size + bound_of(mixed.radius[0])) / norm.room * UP if norm.room > 0.0 else math.inf


def outer_corner(family: Family) -> int | None:
    """Return the number of the corner whose largest pole lies beyond the disc, with a factor of the claim.

    The crossing of the tangents at the ends of an arc is no such factor.
    """
    if family.still or family.blocks:
        return None
    corners = family.corners.middle if family.sensors is None else family.sensors[:-1]
    radii = np.abs(np.linalg.eigvals(corners)).max(axis=1, initial=0.0).reshape(-1, family.factors)
    largest_of = radii[:, :2].max(axis=1)
    worst = int(np.argmax(largest_of))
    return worst if largest_of[worst] > 1.0 + _BEYOND else None


def bound_of(sizes: Array) -> float:
    """Return at least the spectral norm of all matrices with entries of at most these sizes."""
    return math.sqrt(float(sizes.sum(axis=0).max()) * float(sizes.sum(axis=1).max())) * UP


def _norms(matrices: Array) -> float:
    """Return at least the sum of the spectral norms of some matrices.

    The eighth power of one is at most the Frobenius norm of (M'M)^4.
    """
    sizes = np.linalg.norm(matrices, axis=(1, 2))
    unit = matrices / np.maximum(sizes, 1e-300)[:, None, None]
    square = np.swapaxes(unit, 1, 2) @ unit
    fourth = square @ square
    return float((sizes * np.linalg.norm(fourth @ fourth, axis=(1, 2)) ** 0.125).sum()) * (1.0 + _ROUNDED)


def _bends(back: Array, matrices: Array, step: Array) -> tuple[float, Array]:
    """Return the sum of the Frobenius norms of back M step, where back is the inverse, and its slopes by step."""
    turned = back @ matrices @ step
    sizes = np.linalg.norm(turned, axis=(1, 2)) + 1e-300
    parts = turned / sizes[:, None, None]
    slopes = np.tensordot(turned, parts, ([0, 1], [0, 1])) - np.tensordot(parts, turned, ([0, 2], [0, 2]))
    return float(sizes.sum()), np.asarray(back.T @ slopes, dtype=np.float64)


def _decay(transform: Array, rates: Family) -> bool:
    """Return whether all rates F shorten every vector x' = F x in the coordinates of a transformation: proved.

    For P = X'X, with X about T^-1, E = X T - I and N = X F T, T'(P F + F'P) T is N + E'N and its
    transpose. It is negative if that of the corners is by more than all that is unknown, in any
    units. With an input and an output, [A, B, 0; 0, -I / 2, 0; C, D, -I / 2] stands for F (bounded
    real lemma).
    """
    k = rates.still
    n = len(transform) - k
    lift, unit = np.eye(n + 2 * k), np.eye(k)
    left, right = Enclosed.exact(np.delete(lift, slice(n, n + k), 1)), Enclosed.exact(lift[: n + k])
    corners = (left @ rates.corners @ right).moved(np.diag([0.0] * n + [-0.5] * (2 * k)))
    shares = {i: left.middle[0] @ share @ right.middle[0] for i, share in rates.shares.items()}
    norm = Norm(np.asarray(scipy.linalg.block_diag(transform, unit)), replace(rates, corners=corners, shares=shares))
    turned = norm.corners.middle
    unknown = norm.rest + norm.apart.T @ (np.abs(turned).max(axis=0) + norm.rest)
    falls = -(turned + np.swapaxes(turned, 1, 2))
    diagonal = np.diagonal(falls, axis1=1, axis2=2).mean(axis=0)
    if not (np.isfinite(falls).all() and (diagonal > 0.0).all()):
        return False
    units = np.exp2(np.round(-0.5 * np.log2(diagonal)))  # powers of two: exact
    falls = falls * units * units[:, None]
    room = bound_of((unknown + unknown.T) * UP * units * units[:, None])
    sizes = np.sqrt((falls**2).sum(axis=(1, 2))) + room
    return _positive(falls - (room + 8.0 * (n + 2 * k + 4) * UNIT * sizes)[:, None, None] * np.eye(n + 2 * k))


def _shorter_than(matrices: Array, room: float) -> bool:
    """Return whether all matrices have a spectral norm below `room`: proved, with rounding."""
    n = matrices.shape[-1]
    squares = (matrices**2).sum(axis=(1, 2))
    if not np.isfinite(squares).all():
        return False
    shift = 4.0 * (n + 2) * UNIT * (n + squares) * UP
    gram = np.swapaxes(matrices, 1, 2) @ matrices
    return _positive(((room * room) * (1.0 - 4.0 * UNIT) - shift)[:, None, None] * np.eye(n) - gram)


def _positive(matrices: Array) -> bool:
    """Return whether Cholesky's algorithm ends for all symmetric matrices."""
    try:
        np.linalg.cholesky(matrices)
    except np.linalg.LinAlgError:
        return False
    return True
