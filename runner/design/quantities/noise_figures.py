"""Rms noise of an output with its exact derivatives by parameters.

The mean square in all frequencies is J = tr(C P C' + D V D') / r with P = A P A' + B V B'. With Q = A' Q A + C' C / r,

    dJ = 2 tr(Q (dA P A' + dB V B')) + 2 tr(dC P C' + dD V D') / r

In a band, and referred to an input, the derivative is a difference along the exact derivatives of the matrices.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.quantities import Noise
from proofmass.runner.analysis.decisions.one_bit import noise_at, with_spectra
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.map_blocks import common_period
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.noise.band import bends, rule
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map, rows_of, summed
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.design.quantities.loop_figures import Reading
from proofmass.runner.host.arrays import Array

_STEP = 1e-5  # of a parameter
_LEAST = 1e-4  # of half the rate: the lowest frequency of a density that is referred to an input


def read_noise(points: OperatingPoints, wanted: Noise, parameters: Mapping[str, float], slopes: bool) -> Reading | None:
    """Return the rms noise, that of `noise`; None if the output grows without end.

    In a map with derivatives converters do not round what moves with parameters: it has the slopes alone.
    """
    planned = points.plan
    target = node_of(planned, wanted.output)
    source = node_of(planned, wanted.input) if wanted.input else None
    inputs = [source] if source else []
    first = common_period(planned, inputs, [target], noise=noise_blocks(planned))

    def ask(about: Linearisation) -> tuple[PeriodMap, PeriodMap]:
        noisy = noise_at(about, [target])
        maps = (about.map(inputs, [target], noise=noisy, by_parameters=by) for by in (False, slopes))
        exact, with_slopes = (with_spectra(one, noisy) for one in maps)
        return exact, with_slopes

    exact, whole = points.answered(ask, first)
    to_output = noise_map(exact, target)
    if not to_output.settles and wanted.band is None:
        return None
    if to_output.grows:
        return None
    value, ends = _mean_square(to_output, source, wanted.band, None)
    if not slopes or value <= 0.0:
        return Reading(math.sqrt(value), {})
    names = [name for name in parameters if name in whole.slopes]
    if wanted.band is None and source is None:
        of_square = _whole_slopes(whole, target, names)
        if of_square is not None:
            return Reading(math.sqrt(value), {name: by / (2.0 * math.sqrt(value)) for name, by in of_square.items()})
    moved = {}
    for name in names:
        step = _STEP * (abs(parameters[name]) or 1.0)
        sides = []
        for side in (1.0, -1.0):
            along = replace(whole, matrix=whole.matrix + side * step * whole.slopes[name])
            sides.append(_mean_square(noise_map(along, target), source, wanted.band, ends)[0])
        moved[name] = (sides[0] - sides[1]) / (4.0 * step * math.sqrt(value))
    return Reading(math.sqrt(value), moved)


def _mean_square(
    to_output: NoiseMap, source: Endpoint | None, band: tuple[float, float] | None, ends: Array | None
) -> tuple[float, Array | None]:
    """Return the mean square, and the frequencies between which a density was integrated."""
    if source is None and band is None:
        return float(np.sum(to_output.mean_squares())), None
    half = 0.5 * to_output.rate
    low, high = band or (_LEAST * half, half)
    high = min(high, half)
    if ends is None:
        ends = bends(to_output, low, high)

    def density(frequencies: Array) -> Array:
        squares = to_output.densities(frequencies).sum(axis=1)
        if source is not None:
            squares = squares / np.abs(to_output.gain(frequencies, source)) ** 2
        return np.asarray(squares[:, None])

    return float(rule(density, ends)[2][0]), ends


def _whole_slopes(whole: PeriodMap, target: Endpoint, names: list[str]) -> dict[str, float] | None:
    """Return derivatives of the mean square; None if modes that last are left out of the map."""
    rows = [i for i, entry in enumerate(whole.outputs) if entry[:2] == target]
    reached = rows_of(whole, rows).between()
    a, b, c, d = reached.parts()
    to_output = noise_map(whole, target)
    if len(to_output.matrices[0]) != len(a):
        return None
    variance, values = to_output.variances, to_output.values
    covariance = summed(a, (b * variance) @ b.T)
    observed = to_output.observed
    slopes = {}
    for name in names:
        da, db, dc, dd = reached.parts(reached.slopes[name])
        moved = da @ covariance @ a.T + (db * variance) @ b.T
        seen = dc @ covariance @ c.T + (dd * variance) @ d.T
        slopes[name] = 2.0 * float(np.sum(observed * moved.T)) + 2.0 * float(np.trace(seen)) / values
    return slopes
