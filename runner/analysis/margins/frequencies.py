"""Frequencies of crossovers and peaks on a grid, refined to rounding; for pictures, lifted loops and as a check."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import Pole
from proofmass.runner.analysis.margins.bracketed import RealCurve, lowest_between, zeros_between
from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.host.arrays import Array, Complex

MOST_CROSSOVERS = 64  # that are listed: a wire with many values in a period has a comb of them
_PER_DECADE = 60
_MOST_TURNS = 64  # of the circle that a picture shows in detail
_DENSITIES = (4, 16)  # points for each pole and turn, evenly spaced: of many turns and of few
_BROAD = 0.25  # in a period: modes that decay faster show at points so dense
_TOLD = 1e8  # condition number up to which floating point gives L reliably
_AGREEING = 1e-6  # of a response by columns and by rows
_DISAGREEING = 1e-3  # of L, or of a thousandth where L is smaller
_ROUNDING = 1e-12
_NARROWEST = 1e-4  # radians in a period: half the width of a line beyond the first turn that counts
_MOST_CHECKED = 32  # frequencies
_SPARSE = 64  # states, from which on a matrix is taken as sparse
_BESIDE = np.geomspace(1e-2, 30.0, 24)
ABOUT_A_POLE = np.concatenate([-_BESIDE, [0.0], _BESIDE])
RealFunction = Callable[[Complex], Array]


def sweep(system: OpenLoop) -> Array:
    """Angular frequencies up to half the rate of the wire, denser about open- and closed-loop poles, for pictures."""
    period = 1.0 if system.continuous else system.map.period
    poles = np.concatenate([system.open_poles, system.poles])
    logs: Complex = poles if system.continuous else np.log(poles[np.abs(poles) > 1e-6])
    corners = np.abs(logs)[np.abs(logs) > 1e-12] / period
    last = 1e3 * float(np.max(corners, initial=1.0)) if system.continuous else math.pi / system.sample
    lowest = 1e-3 * min(float(np.min(corners, initial=last)), last)
    turns = min(system.per_period, _MOST_TURNS)
    density = min(max(256 // turns, _DENSITIES[0]), _DENSITIES[1])
    points = [np.geomspace(lowest, last, 2 + int(_PER_DECADE * math.log10(last / lowest)))]
    if not system.continuous:
        points.append(np.linspace(0.0, last, density * (len(poles) + 16) * turns)[1:])
    for log in logs if system.continuous else logs[np.abs(logs.real) < _BROAD]:
        for turn in range(turns):
            centre = abs(log.imag) + 2.0 * math.pi * turn
            width = max(abs(log.real), 1e-9 * abs(log), _NARROWEST if turn else 0.0)
            points.append((centre + width * ABOUT_A_POLE) / period)
    on_boundary = logs[np.abs(logs.real) < 1e-9 * np.abs(logs) + 1e-15].imag
    w = in_order(points, lowest, last, on_boundary / period)
    if system.per_period == 1:
        return w
    turned = 2.0 * math.pi * np.arange(1, system.per_period)
    lines = np.add.outer([*on_boundary, *-on_boundary], turned).ravel()
    far: Array = w[_distances(w, lines / period) > _NARROWEST / period]  # from where rounding couples modes of no loop
    return far


def in_order(points: Sequence[Array], lowest: float, last: float, poles: Array, near: float = 1e-9) -> Array:
    """Return places in order between two, none within a part of itself from a pole, where L is infinite."""
    w = np.unique(np.concatenate(points))
    w = w[(w >= lowest) & (w <= last)]
    apart: Array = w[_distances(w, poles) > near * w]
    return apart


def _distances(w: Array, places: Array) -> Array:
    """Return the distance of each frequency from the nearest place."""
    at = np.concatenate([[-np.inf], np.unique(places), [np.inf]])
    after = np.searchsorted(at, w)
    return np.asarray(np.minimum(w - at[after - 1], at[after] - w))


def check_by_sweep(
    system: OpenLoop, name: str, exact: Callable[[Array], Complex], figures: Figures, hidden: Sequence[Pole] = ()
) -> None:
    """Compare L by the polynomials of a loop, `exact`, with its state space;
    raises `ArithmeticError` if they disagree.

    They are compared between the crossovers, at frequencies where floating point gives L reliably.
    What `hidden` poles and the zeros next to them leave of each other, as far as they are known, is
    allowed for.
    """
    single = system.single()
    if single is None or not len(single[0]):
        return
    a, b, c, d = single
    a, scale = balanced(a)
    b, c = b.ravel() / scale, c * scale
    period = 1.0 if system.continuous else system.map.period
    corners = [2.0 * math.pi * v * period for v in (*figures.gain_crossovers, *figures.phase_crossovers)]
    marks = np.unique([1e-4, *corners, math.pi])
    angles = np.sqrt(marks[:-1] * marks[1:])
    angles = angles[:: 1 + len(angles) // _MOST_CHECKED]
    z = 1j * angles if system.continuous else np.exp(1j * angles)
    values, reliable = (_sparse_response if len(a) > _SPARSE else _dense_response)(a, b, c, z)
    values = values + d
    pairs = zip(values.tolist(), exact(angles[reliable]).tolist(), strict=True)
    for angle, (value, known) in zip(angles[reliable].tolist(), pairs, strict=True):
        place = 1j * angle if system.continuous else np.exp(1j * angle)
        left = sum(4.0 * pole.uncertainty / abs(place - pole.value) for pole in hidden)
        if abs(known - value) > (_DISAGREEING + left) * max(abs(value), abs(known), 1e-3):
            raise ArithmeticError(
                f"margins of {name}: L at {angle / period / (2.0 * math.pi):.6g} Hz is {value:.6g} by its state space, "
                f"{known:.6g} by its polynomials"
            )


_Told = tuple[Complex, npt.NDArray[np.bool_]]


def _dense_response(a: Array, b: Array, c: Array, z: Complex) -> _Told:
    """Return c (z - a)^-1 b at places where floating point gives it reliably, and these places."""
    matrices = z[:, None, None] * np.eye(len(a)) - a
    reliable = np.linalg.cond(matrices, 1) < _TOLD
    solved = np.linalg.solve(matrices[reliable], np.broadcast_to(b.reshape(-1, 1), (int(reliable.sum()), len(a), 1)))
    return np.asarray(solved[:, :, 0] @ c), reliable


def _sparse_response(a: Array, b: Array, c: Array, z: Complex) -> _Told:
    """Return the same of a sparse matrix: places are reliable at which columns and rows, solved apart, agree."""
    # start-up time: this part of SciPy takes 0.1 s
    import scipy.sparse.linalg

    matrix, eye = scipy.sparse.csc_array(a), scipy.sparse.eye_array(len(a), format="csc")
    pairs = []
    for place in z:
        solver = scipy.sparse.linalg.splu(place * eye - matrix)
        pairs.append((c @ solver.solve(b.astype(complex)), b @ solver.solve(c.astype(complex), trans="T")))
    by_columns, by_rows = np.array(pairs).T
    reliable = np.abs(by_columns - by_rows) < _AGREEING * np.abs(by_columns)
    return by_columns[reliable], reliable


@dataclass(frozen=True)
class Samples:
    """The response of a system on a grid of frequencies, with the function between them."""

    answer: Callable[[Array], Complex]
    w: Array
    values: Complex

    @classmethod
    def on(cls, w: Array, answer: Callable[[Array], Complex]) -> "Samples":
        """Return the response on a grid."""
        return cls(answer, w, answer(w))

    def up_to(self, w: float) -> "Samples":
        """Return the part below a frequency."""
        return replace(self, w=self.w[self.w < w], values=self.values[self.w < w])


def crossings(samples: Samples, measure: RealFunction, most: int = MOST_CROSSOVERS) -> list[float]:
    """Return the lowest frequencies at which a measure of the response is zero, dips between two points included."""
    signs = np.sign(measure(samples.values))
    changes = np.flatnonzero(signs[:-1] * signs[1:] < 0.0)
    if len(changes) > most and changes[most] + 2 < len(signs):
        samples = samples.up_to(float(samples.w[changes[most] + 2]))
    w, values = _with_dips(samples, measure)
    size = np.abs(samples.answer(w)) if samples.values.ndim == 1 else 1.0
    told = (np.abs(values) > _ROUNDING * size) & np.isfinite(values)  # the sign of the others is rounding
    w, values = w[told], values[told]
    places = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    return list(zeros_between(_curve(samples, measure), w[places], w[places + 1], 0.0).tolist())[:most]


def highest(samples: Samples, measure: RealFunction) -> tuple[float, float]:
    """Return frequency and value at which a measure of the response is largest."""
    w, values = samples.w, measure(samples.values)
    best = int(np.argmax(values))
    near = values[1:-1] >= np.maximum(0.98 * values[best], np.maximum(values[:-2], values[2:]))
    inner = np.flatnonzero(near) + 1
    curve = _curve(samples, measure)
    at, heights = lowest_between(lambda v: -curve(v), w[inner - 1], w[inner], w[inner + 1])
    peaks = [(float(w[best]), float(values[best])), *zip(at.tolist(), (-heights).tolist(), strict=True)]
    return max(peaks, key=lambda pair: pair[1])


def _with_dips(samples: Samples, measure: RealFunction) -> tuple[Array, Array]:
    """The points, and where the measure comes nearest to zero between points of one sign."""
    w, values, curve = samples.w, measure(samples.values), _curve(samples, measure)
    size = np.abs(values)
    inner = np.flatnonzero((size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])) + 1
    inner = inner[(np.sign(values[inner - 1]) == np.sign(values[inner + 1]))]
    added, _ = lowest_between(lambda v: np.sign(values[inner]) * curve(v), w[inner - 1], w[inner], w[inner + 1])
    joined = np.concatenate([w, added])
    order = np.argsort(joined)
    return joined[order], np.concatenate([values, curve(added)])[order]


def _curve(samples: Samples, measure: RealFunction) -> RealCurve:
    return lambda w: np.asarray(measure(samples.answer(w)))
