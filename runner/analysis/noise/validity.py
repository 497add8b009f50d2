"""Validity of a noise budget: whether errors of quantisers are white and uniform over one step, and
noise is small.

They are so where what the quantiser is given moves by enough of a step from value to value (Widrow
and Kollar, Quantization Noise, 2008, chapter 7): by half a step, as `off` says. A magnitude that is
cut errs by half a step against its sign. Where Gaussian motion of s steps turns the sign, E[x e] =
-s / sqrt(2 pi): that takes 0.4 / s off the motion, and adds nothing to it. Where no sign turns, the
half step stands still.

Where noise moves the operating point, the map there must do the same to it. A product of two
noises, or the root of a sum of squares of noise alone, has a slope that noise itself sets. The map
is taken again along a run with noise, at several instants where periods are short, and at more
where one of them differs: a converter may be full at some, or at most. All maps are given the same
noise: the rms of what their outputs differ by tells them apart, even where each has the same rms,
as a slope that only turns.
"""

import hashlib
import math
from collections.abc import Hashable, Iterator, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import with_spectra
from proofmass.runner.analysis.linearisation.covariance import summed
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map, variance
from proofmass.runner.derivatives.dual_noise import rounds
from proofmass.runner.host.arrays import Array
from proofmass.runner.reference.interpret import TickError

ENOUGH_CUT = 40.0  # steps rms of a magnitude that is cut, for 1 % of the motion
APART = 0.01  # of the mean square of an error
MULTIPLES = 8  # h, of which the last is 2 % of the mean square
OF_ONE = 12.0 / math.pi**2
_TICKS = 512  # base ticks of a run with noise, or one period
_INSTANTS, _MAPPED = 8, 64  # maps along it, and base ticks of them, or one period
_MORE = 4  # times as many of both where some map is another
_ANOTHER = 1e-3  # part of the mean square that says so
_LARGE = "noise is not small here: along a run with noise"
_SHOWN = "; a study of many runs says what the rms is"
_APART = 0.3  # of the rms: what a converter does that is full in 9 % of the ticks, with an rms that is 8 % off


@dataclass(frozen=True)
class Dither:
    """Movement of the input of a quantiser by noise, in steps: rms, and from value to value."""

    block: str
    part: str  # the quantiser, or which rounding of a block
    rms: float
    change: float
    cut: bool = False  # whether magnitudes are cut
    apart: float = 0.0  # of the mean square of its error, which a grid makes it

    @property
    def enough(self) -> bool:
        """Return whether the error of the quantiser is noise."""
        return self.moves and not self.turns and not self.gridded

    @property
    def moves(self) -> bool:
        """Return whether its input moves by enough of a step."""
        return off(min(self.rms, self.change)) <= APART

    @property
    def gridded(self) -> bool:
        """Return whether its input's grid is too coarse for an error that is white and uniform."""
        return self.apart > APART

    @property
    def turns(self) -> bool:
        """Return whether the error follows the sign of what is cut, by over 1 % of its motion."""
        return self.cut and self.rms < ENOUGH_CUT


def likeness(squares: Array) -> Array:
    """Return the sums over k of exp(-2 pi^2 V), a column for each h: V are `squares` in steps."""
    return np.asarray(np.sum(np.exp(-2.0 * math.pi**2 * squares), axis=1))


def off(motion: float) -> float:
    """Return how far errors are from white and uniform, of their mean square, by an rms motion in steps alone."""
    multiples = np.arange(1.0, MULTIPLES + 1.0)
    return OF_ONE * float(np.sum(likeness((motion * multiples[:, None]) ** 2) / multiples**2))


def dithers(
    whole: PeriodMap, kept: MutableMapping[Hashable, Any], apart: Mapping[Endpoint, float] = MappingProxyType({})
) -> Iterator[Dither]:
    """The motion of each quantiser's input, at its least over the period; infinite where it has no bound.

    Maps to several outputs hold the same maps to their quantisers: what is found of these is
    `kept`, and what is found of their states, which quantisers of a loop share.
    """
    for block, part in dict.fromkeys(entry[:2] for entry in whole.outputs if rounds(entry[1])):
        rows = [i for i, entry in enumerate(whole.outputs) if entry[:2] == (block, part)]
        own = whole.to_outputs(rows).between()
        key = "dither", block, part, own.inputs, _digest(own.matrix)
        if key not in kept:
            kept[key] = _dither(block, part, own, kept)
        yield replace(kept[key], apart=apart.get((block, part), 0.0))


def _dither(block: str, part: str, whole: PeriodMap, kept: MutableMapping[Hashable, Any]) -> Dither:
    a, b, c, d = whole.parts()
    variances = np.array([variance(name) for _, name, _ in whole.inputs])
    of_modes, of_motion = ((word, _digest(a), _digest(b), whole.inputs) for word in ("modes", "motion"))
    if of_modes not in kept:
        kept[of_modes] = Lasting(a, b * np.sqrt(variances))
    lasting: Lasting = kept[of_modes]
    if lasting.passes(b, c):  # a random walk
        return Dither(block, part, math.inf, math.inf)
    a, b, c = lasting.without(a, b, c)
    if of_motion not in kept:
        kept[of_motion] = summed(a, b * variances @ b.T)
    p: Array = kept[of_motion]
    following = np.vstack([c[1:], c[:1] @ a]), np.vstack([d[1:], c[:1] @ b])
    squares = _squares(c, d, p, variances)
    changes = _squares(following[0] - c, following[1] - d, p, variances)
    if len(c) == 1 or len(d):  # the last change has errors of the next period too
        changes[-1] += float(np.sum(d[0] ** 2 * variances))
    return Dither(block, part, math.sqrt(float(np.min(squares))), math.sqrt(float(np.min(changes))))


def _digest(matrix: Array) -> bytes:
    return hashlib.sha256(matrix.tobytes()).digest()


def _squares(c: Array, d: Array, p: Array, variances: Array) -> Array:
    squares = np.einsum("ij,jk,ik->i", c, p, c) + d**2 @ variances
    return np.asarray(np.maximum(squares, 0.0))  # large p may round below


def strained(about: Linearisation, ends: Ends, target: Endpoint, whole: PeriodMap, to_output: NoiseMap) -> str:
    """Return a note where the noise of an output is another where a run with noise gets, or ""."""
    total = float(sum(to_output.mean_squares))
    if not to_output.settles or not total:
        return ""
    along = _along(about, ends.together, whole)
    if along.map(1) is None:
        along = _along(about, replace(ends, beside=()), whole)
    squares = list[float]()
    for number in range(1, along.most + 1):
        there = along.map(number) if number <= along.few or max(squares, default=0.0) > _ANOTHER * total else None
        if there is None:
            break
        moved = noise_map(with_spectra(ends.part_of(there, about.plan), ends.noise), target)
        if moved.grows:
            return f"{_LARGE} a loop is unstable{_SHOWN}"
        if moved.settles:
            squares.append(difference_squared(to_output, moved))
    apart = math.sqrt(max(0.0, sum(squares)) / max(1, len(squares)) / total)
    if apart < _APART:
        return ""
    return f"{_LARGE} the same noise moves the output otherwise, by {100.0 * apart:.0f} % of this rms{_SHOWN}"


class _Along:
    """Maps of a period along a run with noise, each taken when it is first asked for."""

    def __init__(self, about: Linearisation, ends: Ends, whole: PeriodMap) -> None:
        self._about, self._ends, self._first = about, ends, whole.tick
        self._ticks = round(whole.period / about.plan.period)
        self.few = min(_INSTANTS, max(1, _MAPPED // self._ticks))  # of them
        self.most = max(self.few, min(_MORE * _INSTANTS, _MORE * _MAPPED // self._ticks))
        self._run = about.course.with_noise(about.course.at(whole.tick))
        self._rings = OrbitRun(about.plan, ends, about.course.onward(whole.tick)).rings
        self._maps = dict[int, PeriodMap | None]()

    def map(self, number: int) -> PeriodMap | None:
        """Return one by its number, from 1 on; None without, which refuses no budget."""
        if number not in self._maps:
            self._maps[number] = None
            with suppress(ModelError, TickError):
                apart = max(1, _TICKS // (self._ticks * self.few)) * self._ticks
                options = {"memory": self._run.to(self._first + number * apart), "span": self._ticks, "drawn": True}
                options |= {"rings": self._rings, "slopes": self._about.course.slopes}
                self._maps[number] = self._ends.map(self._about.plan, **options)
        return self._maps[number]


def _along(about: Linearisation, ends: Ends, whole: PeriodMap) -> _Along:
    kept, key = about.course.kept, ("drawn", ends.key, whole.tick, round(whole.period / about.plan.period))
    if key not in kept:
        kept[key] = _Along(about, ends, whole)
    along: _Along = kept[key]
    return along


def difference_squared(first: NoiseMap, second: NoiseMap) -> float:
    """Return the mean square of what the outputs of two maps differ by, where both are given the same noise.

    That is E[y1^2] + E[y2^2] - 2 E[y1 y2]. With X = A1' X A2 + C1' C2 / r the last is a sum over
    the columns of v (B1' X B2 + D1' D2 / r).
    """
    places = [{entry: column for column, entry in enumerate(of.inputs)} for of in (first, second)]
    common = [entry for entry in first.inputs if entry in places[1]]
    columns = [[of[entry] for entry in common] for of in places]
    (a1, b1, c1, d1), (a2, b2, c2, d2) = first.matrices, second.matrices
    x = summed(a1.T, c1.T @ c2 / first.values, a2.T)
    shared = np.einsum("ik,ij,jk->k", b1[:, columns[0]], x, b2[:, columns[1]])
    shared += np.einsum("ik,ik->k", d1[:, columns[0]], d2[:, columns[1]]) / first.values
    squares = float(sum(first.mean_squares) + sum(second.mean_squares))
    return squares - 2.0 * float(first.variances[columns[0]] @ shared)
