"""A loop opened at a wire, as a sampled system: frequency response, closed-loop poles, sensitivity.

L is minus the signal from the wire's source over the signal at its readers, as is usual for
negative feedback: the loop is stable if the zeros of det(I + L) lie inside the unit circle. Where
slower blocks lie in the loop, L is lifted: one period of the loop holds `per_period` values of the
wire.
"""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.map_changes import variation
from proofmass.runner.analysis.linearisation.on_circle import OnCircle
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import Variation, parts_of
from proofmass.runner.analysis.linearisation.rational import LARGEST_CERTIFIED, Transfer, roots, transfer
from proofmass.runner.analysis.linearisation.real_roots import Polynomial
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps, maps_of_lifted
from proofmass.runner.host.arrays import Array, Complex

_AT_A_TIME = 1 << 17  # values of a wire at some frequencies, which fit in a cache
_schur: Any = scipy.linalg.schur


@dataclass(frozen=True, eq=False)
class OpenLoop:
    """L(z) = C (z I - A)^-1 B + D, z = exp(j w T) over the common period T; z = j w where it is `continuous`.

    `variation` is that of the closed transition matrix from one period to the next at the operating
    point; None where there is none.
    """

    map: PeriodMap
    continuous: bool = False
    variation: Variation | None = None
    ticks: int = 1  # of a period
    hidden: tuple[complex, ...] = ()  # poles over the period no factor moves and the map leaves out

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone: what follows from them is found again, since exact numbers are not pickled."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def noted(self, *notes: str) -> "OpenLoop":
        """Return the loop with more notes on its operating point."""
        return replace(self, map=replace(self.map, notes=(*self.map.notes, *notes)))

    @property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """A, B, C and D, with the sign of negative feedback."""
        return self._negated(self.map.matrix)

    def slopes(self, parameter: str) -> tuple[Array, Array, Array, Array]:
        """Derivatives of the matrices by a parameter."""
        return self._negated(self.map.slopes[parameter])

    def _negated(self, matrix: Array) -> tuple[Array, Array, Array, Array]:
        a, b, c, d = self.map.parts(matrix)
        return a, b, -c, -d

    @property
    def per_period(self) -> int:
        """Values of the wire in one period."""
        return len(self.map.inputs)

    @property
    def sample(self) -> float:
        """Seconds between two values of the wire."""
        return self.map.period / self.per_period

    def single(self) -> tuple[Array, Array, Array, float] | None:
        """A, b, c and d of the one L that decides on stability, det(I + L) = 1 + L; None where no
        single one does.

        It does where a period has one value of the wire, where one of several values is read or
        given, and where all are read alike, as by an average.
        """
        a, b, c, d = self.matrices
        factors = _factored(np.vstack([b, d]))
        if factors is not None:
            column, row = factors
            return a, column[: len(a)], row @ c, float(row @ column[len(a) :])
        factors = _factored(np.hstack([c, d]).T)
        if factors is not None:
            row, column = factors
            return a, b @ column, row[: len(a)], float(row[len(a) :] @ column)
        return None

    @cached_property
    def quotient(self) -> Transfer | None:
        """The one L as an exact quotient; None where there is none, or where too many states act on each other."""
        single = self.single()
        return None if single is None else transfer(*single)

    def closed(self, factor: complex = 1.0) -> npt.NDArray[Any]:
        """The transition matrix over a period of the loop closed by an extra factor at the wire."""
        if self.map.ticks is not None and not self.hidden:
            return self.map.ticks.closed(self.map.states, factor)
        a, b, c, d = self.matrices
        return a - factor * b @ np.linalg.solve(np.eye(len(d)) + factor * d, c)

    @cached_property
    def by_values(self) -> TickMaps:
        """The maps from one value of the wire to the next."""
        return self.map.ticks or maps_of_lifted(self.map.states, *self.map.parts())

    @cached_property
    def poles(self) -> Complex:
        """Poles of the closed loop over its period, the slowest first."""
        closed = self._sparse and self._sparse.closed
        poles = _roots(closed) if closed else np.linalg.eigvals(self.closed()).astype(complex)
        return poles[np.argsort(-np.abs(poles))]

    @cached_property
    def open_poles(self) -> Complex:
        """Poles of the open loop over its period."""
        if self._sparse:
            return _roots(self._sparse.denominator)
        return np.linalg.eigvals(self.matrices[0]).astype(complex)

    @cached_property
    def _sparse(self) -> Transfer | None:
        """The exact quotient of a loop of many states, its roots found sooner than eigenvalues."""
        return self.quotient if not self.continuous and len(self.map.states) > LARGEST_CERTIFIED else None

    @cached_property
    def _circle(self) -> OnCircle | None:
        """L of many states with one value of the wire in a period."""
        return OnCircle(self._sparse) if self._sparse is not None and self.per_period == 1 else None

    def growths(self, factors: npt.NDArray[Any]) -> Array:
        """Logarithms of the slowest mode's growth in a period, for some factors at the wire."""
        return self.by_values.growths(factors, self.hidden)

    def lifted(self, w: Array) -> Complex:
        """L over the period, a matrix for each angular frequency."""
        return self._open_transfer(self._points(w))

    def response(self, w: Array | float) -> Complex:
        """Return the response at the input's own frequency, as a network analyser measures it; w in rad/s."""
        if self._circle is not None:
            return self._circle.values(np.asarray(w * self.map.period))
        return self._at_own_frequency(self._open_transfer, w)

    def differs(self, other: "OpenLoop", by: float) -> bool:
        """Return whether L is another in a second loop, by more than a part of its size at some frequency."""
        w = np.geomspace(1e-4, 0.9, 24) * math.pi / self.sample if not self.continuous else self._about_poles(other)
        first, second = self.response(w), other.response(w)
        return bool(np.any(np.abs(first - second) > by * np.maximum(np.abs(first), np.abs(second))))

    def _about_poles(self, other: "OpenLoop") -> Array:
        """Return angular frequencies about those of the poles of two loops in continuous time."""
        rates = np.abs(np.concatenate([each for of in (self, other) for each in (of.poles, of.open_poles)]))
        rates = rates[rates > 0.0]
        return np.geomspace(0.01 * rates.min(), 100.0 * rates.max(), 48) if len(rates) else np.ones(1)

    def closed_response(self, w: Array | float) -> Complex:
        """Return the response of T at the input's own frequency; w in rad/s."""
        if self._circle is not None:
            open_response = self.response(w)
            return np.asarray(open_response / (1.0 + open_response))
        return self._at_own_frequency(self._closed_transfer, w)

    def _at_own_frequency(self, transfer: "TransferMatrix", w: Array | float) -> Complex:
        w = np.asarray(w, dtype=float)
        parts = np.array_split(w.ravel(), 1 + w.size * self.per_period // _AT_A_TIME)
        values = [transfer.mean(self._points(part), _turns(part * self.sample, self.per_period)) for part in parts]
        return np.concatenate(values).reshape(w.shape)

    def turn(self, pole: complex) -> float:
        """Return the angle by which a closed-loop mode turns in a period, in radians, as the wire shows it.

        The pole tells it but for whole turns: the mode's strongest line at the wire tells these.
        """
        angle = cmath.phase(pole)
        if self.continuous or self.per_period == 1 or not pole:  # gone after a period
            return angle
        values, vectors = self._modes
        shown = self._shown(vectors[:, int(np.argmin(np.abs(values - pole)))])
        steps = np.arange(self.per_period) / self.per_period
        lines = np.abs(np.fft.fft(shown * np.exp(-steps * complex(math.log(abs(pole)), angle))))
        turns = np.fft.fftfreq(self.per_period, 1.0 / self.per_period)
        return angle + 2.0 * math.pi * float(turns[int(np.argmax(lines))])

    @cached_property
    def _modes(self) -> tuple[Complex, Complex]:
        """Closed-loop poles over the period, with a vector of each."""
        alike, scale = balanced(np.real(self.closed()))
        values, vectors = np.linalg.eig(alike)
        return values.astype(complex), (scale[:, None] * vectors).astype(complex)

    def _shown(self, states: Complex) -> Complex:
        """Return the values of the wire in a period of the closed loop that begins with some states, up to a sign."""
        if self.map.ticks is None or self.hidden:
            _, _, c, d = self.matrices
            return np.asarray(np.linalg.solve(np.eye(len(d)) + d, c @ states), dtype=np.complex128)
        maps, values = self.map.ticks.fed_back(), np.zeros(self.per_period, dtype=complex)
        x = np.zeros(maps.b.shape[1], dtype=complex)
        x[[maps.places[state] for state in self.map.states]] = states
        for k, (a, c) in enumerate(zip(maps.a, maps.c, strict=True)):
            values[k], x = c @ x, a @ x
        return values

    def complementary(self, w: Array) -> Complex:
        """T = L (I + L)^-1 over the period, from the closed loop, so that poles of L on the unit circle do not hurt."""
        return self._closed_transfer(self._points(w))

    def _points(self, w: Array) -> Complex:
        """Return the points on the boundary of stability at these frequencies."""
        s: Complex = 1j * np.asarray(w, dtype=float)
        return s if self.continuous else np.asarray(np.exp(s * self.map.period), dtype=complex)

    @cached_property
    def _open_transfer(self) -> "TransferMatrix":
        return TransferMatrix(*self.matrices)

    @cached_property
    def _closed_transfer(self) -> "TransferMatrix":
        if self.map.ticks is not None and not self.hidden:
            closed, n = self.map.ticks.fed_back().lifted(self.map.states), self.map.order
            return TransferMatrix(closed[:n, :n], closed[:n, n:], -closed[n:, :n], -closed[n:, n:])
        _, b, c, d = self.matrices
        inverse = np.linalg.inv(np.eye(len(d)) + d)
        return TransferMatrix(self.closed(), b @ inverse, inverse @ c, d @ inverse)


def _roots(polynomial: Polynomial) -> Complex:
    return np.array([complex(root) for root in roots(polynomial, sampled=True)], dtype=complex)


def _turns(angles: Array, count: int) -> Complex:
    """exp(j k angle) for k = 0 ... count - 1, a row for each angle: as products of two, since powers take long."""
    step = math.isqrt(count - 1) + 1
    fine = np.exp(1j * np.multiply.outer(angles, np.arange(step)))
    coarse = np.exp(1j * np.multiply.outer(angles, np.arange(0, count, step)))
    products = coarse[:, :, None] * fine[:, None, :]
    return np.asarray(products.reshape(len(angles), step * coarse.shape[1])[:, :count])


def _factored(matrix: Array) -> tuple[Array, Array] | None:
    """A column and a row whose product the matrix is, to rounding; None where there are none."""
    sizes = np.abs(matrix).max(axis=0, initial=0.0)
    column = matrix[:, int(np.argmax(sizes))]
    largest = int(np.argmax(np.abs(column)))
    if column[largest] == 0.0:
        return column, np.zeros(matrix.shape[1])
    row = matrix[largest] / column[largest]
    product = np.outer(column, row)
    return (column, row) if np.all(np.abs(matrix - product) <= 4.0 * np.finfo(float).eps * np.abs(product)) else None


def _weights(row: Complex, first: int) -> tuple[slice | npt.NDArray[np.intp], Complex]:
    """Return where the entries of a row from one on are, and the entries: as a slice, unless most are zero."""
    at = np.flatnonzero(row[first:]) + first
    few = 2 * len(at) < len(row) - first
    return (at, row[at]) if few else (slice(first, None), row[first:].copy())


class TransferMatrix:
    """c (z - a)^-1 b + d for many z, by the Schur form of a: only triangular systems are left to solve.

    States are scaled by powers of two first (`balanced`), since the Schur form is exact to the norm
    of a only. Each set of states that act on each other has a form of its own, and the others have
    zeros there: of a delay line nothing but its cells is left.
    """

    def __init__(self, a: npt.NDArray[Any], b: npt.NDArray[Any], c: npt.NDArray[Any], d: npt.NDArray[Any]) -> None:
        self._direct, scale, alike = d, np.ones(len(a)), a
        if len(a):
            alike, scale = balanced(a, b, c)
        parts = parts_of(alike)[::-1]  # what acts on others comes after them
        order = [state for part in parts for state in part]
        form = alike[np.ix_(order, order)].astype(complex)
        self._into, self._out = (b / scale[:, None])[order].astype(complex), (c * scale)[:, order].astype(complex)
        ends = np.cumsum([len(part) for part in parts]).tolist()
        for part, end in zip(parts, ends, strict=True):
            if len(part) > 1:
                own = slice(end - len(part), end)
                form[own, own], turn = _schur(form[own, own], output="complex")
                form[: own.start, own], form[own, end:] = form[: own.start, own] @ turn, turn.conj().T @ form[own, end:]
                self._into[own], self._out[:, own] = turn.conj().T @ self._into[own], self._out[:, own] @ turn
        self._diagonal = np.diagonal(form).copy()
        self._acting = [_weights(row, i + 1) for i, row in enumerate(form)]

    def _states(self, z: Complex, entered: Complex) -> Complex:
        """Return the states for each z, a column, where a number has entered each of them."""
        x = np.zeros_like(entered)
        for i in range(len(x) - 1, -1, -1):
            at, weights = self._acting[i]
            x[i] = (weights @ x[at] + entered[i]) / (z - self._diagonal[i])
        return x

    def __call__(self, z: Complex) -> Complex:
        height, width = self._direct.shape
        x = self._states(np.repeat(z, width), np.tile(self._into, (1, len(z))))
        value: Complex = (self._out @ x).reshape(height, len(z), width).transpose(1, 0, 2) + self._direct
        return value

    def weighted(self, z: Complex, out: Complex, into: Complex) -> Complex:
        """Return for each z the sum of all outputs, each with a weight, where inputs have some sizes: a row each."""
        x = self._states(z, self._into @ into.T)
        direct = out.real @ self._direct + 1j * (out.imag @ self._direct)  # no complex copy of what is real
        value: Complex = np.sum(out.T * (self._out @ x), axis=0) + np.sum(direct * into, axis=1)
        return value

    def mean(self, z: Complex, turns: Complex) -> Complex:
        """Return the mean output for each z, turned back, of an input that turns from value to value: a row each."""
        x = self._states(z, self._into @ turns.T)
        later = np.sum((turns @ self._out.conj()) * x.T.conj(), axis=1) + turns @ self._later.conj()
        value: Complex = later.conj() / turns.shape[1]
        return value

    @cached_property
    def _later(self) -> npt.NDArray[Any]:
        """Sums of the diagonals: answers within the period, by how many values they are late."""
        return np.array([np.trace(self._direct, -k) for k in range(len(self._direct))])


def of_wires(whole: PeriodMap, tick: float, notes: Sequence[str] = ()) -> OpenLoop:
    """Return the sampled loop of a map that is cut at wires, and by how much it changes; a `tick` is in seconds."""
    between = whole.between()
    between = replace(between, later=(), notes=(*between.notes, *notes))
    ticks = round(between.period / tick)
    alike = all(later.states == whole.states for later in whole.later)
    if not whole.later or not alike or not between.states:
        return OpenLoop(between, ticks=ticks)
    kept = [whole.states.index(state) for state in between.states]
    closed, *after = (
        np.real(OpenLoop(one).closed()) for one in (between, *(later.kept(kept) for later in whole.later))
    )
    moves = any((matrix != closed).any() for matrix in after)
    return OpenLoop(between, variation=variation(closed, after) if moves else None, ticks=ticks)
