"""Validity of the noise model of a quantiser: its error is white, and uniform over one step.

It is where what the quantiser is given moves by enough of a step from value to value (Widrow and Kollar, Quantization
Noise, 2008, chapter 7): Gaussian motion of half a step leaves a correlation of exp(-2 pi^2 / 4), which is 0.7 %.
"""

import hashlib
import math
from collections.abc import Hashable, Iterator, MutableMapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.noise.noise_map import summed, variance
from proofmass.runner.derivatives.dual_noise import rounds
from proofmass.runner.host.arrays import Array

ENOUGH = 0.5  # steps rms


@dataclass(frozen=True)
class Dither:
    """Movement of the input of a quantiser by noise, in steps: rms, and from value to value."""

    block: str
    part: str  # the quantiser, or which rounding of a block
    rms: float
    change: float

    @property
    def enough(self) -> bool:
        """Return whether the error of the quantiser is noise."""
        return min(self.rms, self.change) >= ENOUGH


def dithers(whole: PeriodMap, kept: MutableMapping[Hashable, Any]) -> Iterator[Dither]:
    """The motion of each quantiser's input, at its least over the period; infinite where it has no bound.

    Maps to several outputs hold the same maps to their quantisers: what is found of these is `kept`, and what is found
    of their states, which quantisers of a loop share.
    """
    for block, part in dict.fromkeys(entry[:2] for entry in whole.outputs if rounds(entry[1])):
        rows = [i for i, entry in enumerate(whole.outputs) if entry[:2] == (block, part)]
        own = whole.to_outputs(rows).between()
        key = "dither", block, part, own.inputs, _digest(own.matrix)
        if key not in kept:
            kept[key] = _dither(block, part, own, kept)
        yield kept[key]


def _dither(block: str, part: str, whole: PeriodMap, kept: MutableMapping[Hashable, Any]) -> Dither:
    a, b, c, d = whole.parts()
    variances = np.array([variance(name) for _, name, _ in whole.inputs])
    of_modes, of_motion = ("modes", _digest(a)), ("motion", _digest(a), _digest(b), whole.inputs)
    if of_modes not in kept:
        kept[of_modes] = Lasting(a)
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
